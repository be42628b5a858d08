//! Promise: on stamps of any spacing the dynamics put out what they do on a fine common grid, and the derivatives are those of
//! that output.

#![allow(clippy::unwrap_used)]

use std::f64::consts::TAU;

use hysteron_model::Start;
use hysteron_model::dynamics::{
    Creep, DynamicForm, InterSample, Linearised, Modes, Sampling, Scheme, SimulationPlan, StampedPlan,
    StampedWorkspace,
};

/// Rate of the common grid \[Hz\].
const FINE_HZ: f64 = 320_000.0;
/// Against the common grid, as a share of the range.
const TOLERANCE: f64 = 1e-5;

/// Every form with parameters of a plausible stage.
fn forms() -> Vec<(DynamicForm, Vec<f64>)> {
    let modes: [(Modes, &[f64]); 8] = [
        (Modes::Integer { order: 1 }, &[4e-4]),
        (Modes::Integer { order: 2 }, &[320.0, 0.62]),
        (Modes::Integer { order: 3 }, &[320.0, 0.02, 4e-4]),
        (Modes::Integer { order: 4 }, &[320.0, 0.62, 710.0, 0.21]),
        (Modes::Fractional, &[320.0, 0.62, 1.94, 1.05]),
        (Modes::FractionalFreeLowest, &[320.0, 0.62, 1.94, 1.05, 0.03]),
        (Modes::TwoFractional, &[320.0, 0.62, 1.94, 1.05, 710.0, 0.21, 1.87, 0.93, 0.7]),
        (
            Modes::Resonances { count: 3, lag: true },
            &[320.0, 0.32, 710.0, 0.21, 950.0, 0.24, 0.7, -0.2, 4e-4],
        ),
    ];
    let with = |(modes, p): (Modes, &[f64])| {
        let plain = (DynamicForm { modes, creep: Creep::None }, p.to_vec());
        let creeps: [(Creep, &[f64]); 3] = [
            (Creep::Fractional, &[0.08, 0.12]),
            (Creep::Logarithmic, &[0.05, 0.004]),
            (Creep::KelvinVoigt { elements: 2 }, &[0.08, 0.01, 0.05, 0.09]),
        ];
        let creeping = creeps.map(|(creep, own)| (DynamicForm { modes, creep }, [p, own].concat()));
        std::iter::once(plain).chain(creeping)
    };
    modes.into_iter().flat_map(with).collect()
}

/// Steps of the common grid at which the input is known: three rates, a gap, and a stretch of irregular stamps.
fn knots() -> Vec<usize> {
    let segments = [(0, 32, 300), (10_000, 160, 60), (40_000, 16, 400)];
    let mut knots: Vec<usize> = segments
        .into_iter()
        .flat_map(|(from, step, count)| (0..count).map(move |k| from + step * k))
        .collect();
    let mut last = 50_000;
    for k in 0_usize..200 {
        knots.push(last);
        last += 40 + 37 * ((7 * k) % 5);
    }
    knots
}

fn seconds(steps: &[usize]) -> Vec<f64> {
    steps.iter().map(|k| *k as f64 / FINE_HZ).collect()
}

/// Starts at 0 with a slope and holds slow and fast parts.
fn drive(t: f64) -> f64 {
    (TAU * 7.0 * t).sin() + 0.1 * (TAU * 90.0 * t).sin()
}

/// Straight lines through the knots on the common grid.
fn filled(knots: &[usize], input: &[f64]) -> Vec<f64> {
    let last = knots[knots.len() - 1];
    let mut at = 0;
    (0..=last)
        .map(|k| {
            while at + 2 < knots.len() && knots[at + 1] <= k {
                at += 1;
            }
            let share = (k - knots[at]) as f64 / (knots[at + 1] - knots[at]) as f64;
            input[at] + share * (input[at + 1] - input[at])
        })
        .collect()
}

fn stamped(plan: &StampedPlan, form: DynamicForm, p: &[f64], delay_s: f64, input: &[f64]) -> Vec<f64> {
    let mut response = plan.empty_response();
    plan.response(&form.transfer_function(p).unwrap(), None, delay_s, &mut response).unwrap();
    let mut output = vec![0.0; plan.samples()];
    plan.apply(&response, input, &mut StampedWorkspace::default(), &mut output).unwrap();
    output
}

#[test]
fn stamps_of_any_spacing_give_what_a_fine_common_grid_gives() {
    let knots = knots();
    let times = seconds(&knots);
    let input: Vec<f64> = times.iter().map(|t| drive(*t)).collect();
    let fine = filled(&knots, &input);
    let plan = SimulationPlan::new(fine.len(), FINE_HZ, Scheme::BandLimited, Start::ZERO).unwrap();
    let spectrum = plan.transform(&fine).unwrap();
    let stamps = StampedPlan::new(times.clone(), times, false).unwrap();
    let mut worst: f64 = 0.0;
    for (form, p) in forms() {
        for delay_s in [0.0, 3.7e-4] {
            let found = stamped(&stamps, form, &p, delay_s, &input);
            let mut response = plan.empty_response(0);
            let sampling =
                Sampling { reconstruction: InterSample::Linear, ..Sampling::of(Scheme::BandLimited) };
            plan.response(&form.transfer_function(&p).unwrap(), delay_s, sampling, &mut response).unwrap();
            let mut expected = vec![0.0; fine.len()];
            plan.apply(&response, &spectrum, &mut plan.workspace(), &mut expected).unwrap();
            let range = expected.iter().fold(0.0, |m: f64, y| m.max(y.abs()));
            let error = knots.iter().zip(&found).map(|(k, y)| (y - expected[*k]).abs()).fold(0.0, f64::max);
            println!("{form:?} delay {delay_s}: {:.1e}", error / range);
            worst = worst.max(error / range);
        }
    }
    println!("worst {worst:.1e}");
    assert!(worst < TOLERANCE, "{worst}");
}

#[test]
fn derivatives_are_those_of_the_output() {
    let times = seconds(&knots());
    let input: Vec<f64> = times.iter().map(|t| drive(*t)).collect();
    let plan = StampedPlan::new(times.clone(), times, false).unwrap();
    let mut worst: f64 = 0.0;
    for (form, p) in forms() {
        let delay_s = 3.7e-4;
        let mut linearised = Linearised::new();
        form.linearise(&p, &mut linearised).unwrap();
        let mut response = plan.empty_response();
        plan.response(&linearised.transfer_function, Some(&linearised), delay_s, &mut response).unwrap();
        for which in 0..=p.len() {
            let mut found = vec![0.0; plan.samples()];
            plan.apply_tangent(&response, which, &input, &mut StampedWorkspace::default(), &mut found)
                .unwrap();
            let at = |change: f64| {
                let mut p = p.clone();
                let mut delay_s = delay_s;
                match p.get_mut(which) {
                    Some(p) => *p += change,
                    None => delay_s += change,
                }
                stamped(&plan, form, &p, delay_s, &input)
            };
            let size = p.get(which).copied().unwrap_or(delay_s).abs();
            let step = 1e-4 * size;
            let difference =
                |h: f64| -> Vec<f64> { at(h).iter().zip(at(-h)).map(|(a, b)| (a - b) / (2.0 * h)).collect() };
            let (near, far) = (difference(step), difference(2.0 * step));
            let expected: Vec<f64> = near.iter().zip(far).map(|(n, f)| (4.0 * n - f) / 3.0).collect();
            let largest = expected.iter().fold(0.0, |m: f64, y| m.max(y.abs()));
            let error = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // What moves the output by less than 1e-4 of its size moves it by the error of the fit.
            let share = error / largest.max(1e-2 / size);
            println!("{form:?} {which}: {share:.1e} of {largest:.1e}");
            worst = worst.max(share);
        }
    }
    println!("worst {worst:.1e}");
    assert!(worst < 1e-4, "{worst}");
}
