//! Promise: on stamps of any spacing the dynamics, and every hysteresis in front of them, put out what they
//! do on a fine common grid, and the derivatives are those of that output.

#![allow(clippy::unwrap_used)]

use std::f64::consts::TAU;

use hysteron_model::Start;
use hysteron_model::dynamics::{
    Creep, DynamicForm, Dynamics, InterSample, Linearised, Modes, Sampling, Scheme, SimulationPlan,
    StampedPlan, StampedWorkspace,
};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{Columns, DriveGrid, Hysteresis, HysteresisForm, examples};
use hysteron_model::record::{Timing, paces_on};

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

/// Steps of the common grid at which the input is known: three rates, a gap, and a stretch of irregular
/// stamps.
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
            // Smaller steps would show the rounding of the relaxations' weights.
            let step = 1e-3 * size;
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

/// Every form of hysteresis with numbers of a plausible stage over ±1.1 V.
fn hystereses() -> Vec<Hysteresis> {
    examples([-1.15, 1.15], 330.0, 1.0).unwrap()
}

fn model(hysteresis: Hysteresis, dynamics: Dynamics, delay_s: f64) -> Model {
    Model {
        hysteresis,
        dynamics,
        offset: 0.4,
        delay_s,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    }
}

fn plays_that_see_the_rate() -> HysteresisForm {
    "rate-dependent-plays".parse::<HysteresisForm>().unwrap().with_elements(4).unwrap()
}

fn rate_dependent_plays(rate_gain: f64) -> Hysteresis {
    let form = plays_that_see_the_rate();
    form.operator(vec![0.9], &[0.2, 0.1, 0.1, 0.05], &[0.6, rate_gain]).unwrap()
}

const REST: Start = Start::Rest { voltage_v: 0.0 };

fn range(y: &[f64]) -> f64 {
    let (low, high) = y.iter().fold((f64::MAX, f64::MIN), |(l, h), y| (l.min(*y), h.max(*y)));
    high - low
}

/// Largest difference at the knots between stamps and the common grid, made finer by a factor, as a share of
/// the range.
fn off_the_common_grid(model: &Model, finer: usize) -> f64 {
    let knots = knots();
    let times = seconds(&knots);
    let input: Vec<f64> = times.iter().map(|t| drive(*t)).collect();
    let found = model.simulate(&input, Timing::Stamps(&times), &REST).unwrap();
    let knots: Vec<usize> = knots.iter().map(|k| k * finer).collect();
    let fine = filled(&knots, &input);
    let expected = model.simulate(&fine, Timing::Rate(FINE_HZ * finer as f64), &REST).unwrap();
    let error = knots.iter().zip(&found).map(|(k, y)| (y - expected[*k]).abs()).fold(0.0, f64::max);
    error / range(&found)
}

fn creeping_resonance() -> Dynamics {
    let form = DynamicForm { modes: Modes::Fractional, creep: Creep::Fractional };
    Dynamics::Fractional(form.transfer_function(&[320.0, 0.62, 1.94, 1.05, 0.08, 0.12]).unwrap())
}

fn creep_alone() -> Dynamics {
    let form = DynamicForm { modes: Modes::None, creep: Creep::Fractional };
    Dynamics::Fractional(form.transfer_function(&[0.08, 0.12]).unwrap())
}

fn lag() -> Dynamics {
    let form = DynamicForm { modes: Modes::Integer { order: 1 }, creep: Creep::None };
    Dynamics::Integer(form.transfer_function(&[4e-4]).unwrap())
}

#[test]
fn every_hysteresis_on_stamps_is_that_on_a_fine_common_grid() {
    for hysteresis in hystereses() {
        let name = hysteresis.form().name();
        let error = off_the_common_grid(&model(hysteresis, creeping_resonance(), 3.7e-4), 1);
        println!("{name}: {error:.1e}");
        assert!(error < TOLERANCE, "{name}: {error:e}");
    }
}

#[test]
fn plays_that_see_the_rate_put_out_on_stamps_what_they_do_on_the_common_grid() {
    for rate_gain in [1e-4, 3e-4] {
        for (name, dynamics) in [("resonance and creep", creeping_resonance()), ("lag", lag())] {
            for delay_s in [0.0, 3.7e-4] {
                let model = model(rate_dependent_plays(rate_gain), dynamics.clone(), delay_s);
                let error = off_the_common_grid(&model, 1);
                println!("{rate_gain} s, {name}, delay {delay_s} s: {error:.1e}");
                assert!(error < TOLERANCE, "{rate_gain} {name} {delay_s}: {error:e}");
            }
        }
    }
}

/// Where nothing smooths the jumps of plays that slow down, a grid is no oracle: it puts a jump somewhere
/// within a step. Samples added on the straight lines of the drive must change nothing.
#[test]
fn samples_added_on_straight_lines_change_nothing() {
    let knots = knots();
    let times = seconds(&knots);
    let input: Vec<f64> = times.iter().map(|t| drive(*t)).collect();
    let (mut more_times, mut more_input, mut kept) = (Vec::new(), Vec::new(), Vec::new());
    for (index, (times, input)) in times.windows(2).zip(input.windows(2)).enumerate() {
        kept.push(more_times.len());
        for share in [0.0, 0.21, 0.74].into_iter().take(1 + index % 3) {
            more_times.push(times[0] + share * (times[1] - times[0]));
            more_input.push(input[0] + share * (input[1] - input[0]));
        }
    }
    kept.push(more_times.len());
    more_times.extend(times.last());
    more_input.extend(input.last());
    let forms = [
        ("static", Dynamics::None),
        ("lag", lag()),
        ("creep", creep_alone()),
        ("resonance", creeping_resonance()),
    ];
    for (name, dynamics) in forms {
        for delay_s in [0.0, 3.7e-4] {
            if name == "static" && delay_s == 0.0 {
                continue;
            }
            let model = model(rate_dependent_plays(3e-4), dynamics.clone(), delay_s);
            let few = model.simulate(&input, Timing::Stamps(&times), &REST).unwrap();
            let more = model.simulate(&more_input, Timing::Stamps(&more_times), &REST).unwrap();
            let error =
                few.iter().zip(&kept).map(|(y, k)| (y - more[*k]).abs()).fold(0.0, f64::max) / range(&few);
            println!("{name}, delay {delay_s} s: {error:.1e}");
            let tolerance = match name {
                // Read at knots.
                "static" => 1e-12,
                // Nothing smooths the corner at which a play begins to move, and between knots it is read
                // from a parabola.
                "creep" => 5.0 * TOLERANCE,
                _ => TOLERANCE,
            };
            assert!(error < tolerance, "{name} {delay_s}: {error:e}");
        }
    }
}

#[test]
fn stamps_that_happen_to_be_even_are_the_rate() {
    let count = 4000;
    let rate_hz = 8000.0;
    let times: Vec<f64> = (0..count).map(|k| 3.0 + f64::from(k) / rate_hz).collect();
    let input: Vec<f64> = times.iter().map(|t| drive(*t)).collect();
    let starts = [REST, Start::Rest { voltage_v: input[0] }, Start::settled(1000)];
    for inter_sample in [InterSample::Linear, InterSample::Hold, InterSample::BandLimited] {
        for start in starts {
            let model = Model { inter_sample, ..model(rate_dependent_plays(3e-4), Dynamics::None, 0.0) };
            let even = model.simulate(&input, Timing::Rate(rate_hz), &start).unwrap();
            let stamped = model.simulate(&input, Timing::Stamps(&times), &start).unwrap();
            let error =
                even.iter().zip(&stamped).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / range(&even);
            println!("{inter_sample} {start:?}: {error:.1e}");
            assert!(error < 1e-12, "{inter_sample} {start:?}: {error:e}");
        }
    }
}

#[test]
fn plays_that_see_the_rate_are_differentiated_on_stamps() {
    let times = seconds(&knots());
    let input: Vec<f64> = times.iter().map(|t| drive(*t)).collect();
    let paces = paces_on(&times, &input);
    let form = plays_that_see_the_rate();
    let start = Start::Remembering { voltage_v: input[0], memory: -0.3 };
    let run = |shape: &[f64], memory: f64, wanted: Option<&[bool]>| {
        let mut columns = Columns::default();
        let start = Start::Remembering { voltage_v: input[0], memory };
        form.run(shape, DriveGrid::of_paces(&paces, 1), &input, start, wanted, &mut columns).unwrap();
        columns
    };
    let Start::Remembering { memory, .. } = start else { unreachable!() };
    let shape = [0.6, 3e-4];
    let exact = run(&shape, memory, Some(&[true, true]));
    assert_eq!(exact.values, run(&shape, memory, None).values);
    for which in 0..3 {
        let size = [0.6, 3e-4, 0.3][which];
        let step = 1e-6 * size;
        let at = |change: f64| {
            let mut moved = [shape[0], shape[1], memory];
            moved[which] += change;
            run(&moved[..2], moved[2], None).values
        };
        let (up, down) = (at(step), at(-step));
        let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
        for (column, (up, down)) in up.iter().zip(&down).enumerate() {
            let exact = match which {
                2 => &exact.by_memory[column],
                _ => &exact.partials.iter().find(|p| (p.shape, p.column) == (which, column)).unwrap().values,
            };
            for ((up, down), exact) in up.iter().zip(down).zip(exact) {
                worst = worst.max(((up - down) / (2.0 * step) - exact).abs());
                largest = largest.max(exact.abs());
            }
        }
        println!("{which}: {:.1e} of {largest:.1e}", worst / largest);
        assert!(largest > 0.0 && worst < 1e-6 * largest, "{which}: {worst:e} of {largest:e}");
    }
}

/// Three drives one after another with pauses at 0 V between them; the second at another rate changes nothing
/// of the first, and of the third nothing once a swing beyond all before has wiped out what the plays
/// remember.
#[test]
fn the_rate_of_one_segment_is_its_own() {
    let swings = |size: f64, count: usize, times: &mut Vec<f64>, input: &mut Vec<f64>, period_s: f64| {
        let first = times.last().copied().unwrap_or(0.0) + 0.5;
        for k in 0..count {
            times.push(first + period_s * k as f64);
            input.push(size * (TAU * k as f64 / 100.0).sin());
        }
    };
    let record = |middle_s: f64| {
        let (mut times, mut input) = (Vec::new(), Vec::new());
        swings(1.0, 301, &mut times, &mut input, 1e-4);
        swings(1.0, 301, &mut times, &mut input, middle_s);
        // Begins 1 s behind the first whatever the second was.
        times.push(1.5);
        input.push(0.0);
        swings(1.3, 301, &mut times, &mut input, 2e-4);
        (times, input)
    };
    for (name, dynamics) in [("static", Dynamics::None), ("lag", lag())] {
        let model = model(rate_dependent_plays(3e-4), dynamics, 0.0);
        let of = |middle_s: f64| {
            let (times, input) = record(middle_s);
            model.simulate(&input, Timing::Stamps(&times), &REST).unwrap()
        };
        let (slow, fast) = (of(1e-3), of(3e-4));
        let change = |from: usize, to: usize| {
            let two = slow[from..to].iter().zip(&fast[from..to]);
            two.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / range(&slow)
        };
        let (first, second, third) = (change(0, 301), change(301, 602), change(603 + 75, 904));
        println!("{name}: first {first:.1e}, second {second:.1e}, third {third:.1e}");
        assert!(first < 1e-12 && third < 1e-12, "{name}: {first:e} {third:e}");
        assert!(second > 1e-3, "{name}: {second:e}");
    }
}
