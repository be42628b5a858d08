//! Promise: the samples of the response to a staircase or a polygon are exact on a uniform record, behind any
//! delay, and so are their derivatives.

#![allow(clippy::unwrap_used)]

use std::f64::consts::{PI, TAU};

use hysteron_model::dynamics::{
    Creep, DynamicForm, InterSample, Linearised, Modes, Sampling, Scheme, SimulationPlan, StampedPlan,
    StampedWorkspace, TransferFunction,
};
use hysteron_model::{LinearStart, Start};
use hysteron_numeric::Complex64;
use proptest::prelude::*;

const FS: f64 = 1000.0;
const FRACTIONAL: DynamicForm = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
const HELD: Sampling = Sampling { delay: InterSample::BandLimited, reconstruction: InterSample::Hold };
const STRAIGHT: Sampling = Sampling { delay: InterSample::BandLimited, reconstruction: InterSample::Linear };

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| m.max(x.abs()))
}

fn error(found: &[f64], reference: &[f64]) -> f64 {
    let difference: Vec<f64> = found.iter().zip(reference).map(|(a, b)| a - b).collect();
    largest(&difference) / largest(reference)
}

/// A sweep over all of the band, with a jump at its start and in its middle.
fn input(samples: usize) -> Vec<f64> {
    (0..samples)
        .map(|k| {
            let t = k as f64 / samples as f64;
            0.5 + (0.45 * TAU * t * k as f64).sin() + f64::from(u8::from(2 * k > samples))
        })
        .collect()
}

fn plan(samples: usize, start: LinearStart) -> SimulationPlan {
    SimulationPlan::new(samples, FS, Scheme::BandLimited, start).unwrap()
}

fn apply(
    plan: &SimulationPlan,
    tf: &TransferFunction,
    delay_s: f64,
    sampling: Sampling,
    input: &[f64],
) -> Vec<f64> {
    let mut response = plan.empty_response(0);
    plan.response(tf, delay_s, sampling, &mut response).unwrap();
    let mut output = vec![0.0; input.len()];
    let spectrum = plan.transform(input).unwrap();
    plan.apply(&response, &spectrum, &mut plan.workspace(), &mut output).unwrap();
    output
}

/// A transfer function with one pair of poles, as poles and branch cut: G = 2 Re R/(s − p) + ∫ ρ(x)/(s + x)
/// dx.
struct Cut {
    pole: Complex64,
    residue: Complex64,
    dc: f64,
    /// x and ρ(x) x times the step in ln x.
    cut: Vec<(f64, f64)>,
}

impl Cut {
    fn new(tf: &TransferFunction, near_rad_s: f64) -> Self {
        let sum = |terms: &[hysteron_model::dynamics::Term], log: Complex64, lower: f64| -> Complex64 {
            let of = |t: &hysteron_model::dynamics::Term| {
                let slope = if lower > 0.0 { t.order } else { 1.0 };
                (log * (t.order - lower)).exp() * t.coefficient * slope
            };
            terms.iter().map(of).sum()
        };
        let mut pole = Complex64::new(-0.1, 1.0) * near_rad_s;
        for _ in 0..100 {
            pole -= sum(&tf.denominator, pole.ln(), 0.0) / sum(&tf.denominator, pole.ln(), 1.0);
        }
        let residue = sum(&tf.numerator, pole.ln(), 0.0) / sum(&tf.denominator, pole.ln(), 1.0);
        let step = 0.15;
        let cut = (-270..270).map(|j| {
            let log = near_rad_s.ln() + step * f64::from(j);
            let at = Complex64::new(log, PI);
            let g = sum(&tf.numerator, at, 0.0) / sum(&tf.denominator, at, 0.0);
            (log.exp(), -g.im / PI * log.exp() * step)
        });
        Self { pole, residue, dc: tf.dc_gain(), cut: cut.collect() }
    }

    /// Response to a unit step.
    fn step(&self, t: f64) -> f64 {
        if t < 0.0 {
            return 0.0;
        }
        let pair = 2.0 * (self.residue * (self.pole * t).exp() / self.pole).re;
        let cut: f64 = self.cut.iter().map(|(x, weight)| weight * (-x * t).exp() / x).sum();
        self.dc + pair - cut
    }

    /// Response to a unit ramp.
    fn ramp(&self, t: f64) -> f64 {
        if t < 0.0 {
            return 0.0;
        }
        let pair =
            2.0 * (self.residue * ((self.pole * t).exp() - 1.0 - self.pole * t) / self.pole.powi(2)).re;
        let cut = |(x, weight): &(f64, f64)| weight * (x * t + (-x * t).exp_m1()) / (x * x);
        pair + self.cut.iter().map(cut).sum::<f64>()
    }

    /// Samples of the response to the staircase, or to the polygon that starts from 0 a sample before the
    /// first.
    fn simulate(&self, input: &[f64], delay_s: f64, held: bool) -> Vec<f64> {
        let at = |k: usize| k as f64 / FS - delay_s;
        let kernel: Vec<f64> = if held {
            (0..input.len()).map(|k| self.step(at(k)) - self.step(at(k) - 1.0 / FS)).collect()
        } else {
            let second = |t: f64| self.ramp(t + 1.0 / FS) - 2.0 * self.ramp(t) + self.ramp(t - 1.0 / FS);
            (0..input.len()).map(|k| FS * second(at(k))).collect()
        };
        (0..input.len()).map(|n| (0..=n).map(|m| kernel[n - m] * input[m]).sum()).collect()
    }
}

#[test]
fn a_fractional_resonance_follows_staircase_and_polygon_behind_any_delay() {
    let samples = 600;
    let input = input(samples);
    let plan = plan(samples, Start::ZERO);
    let mut worst = [0.0_f64; 2];
    for share in [0.1, 0.2, 0.3, 0.373, 0.4, 0.45, 0.6, 1.0, 1.7] {
        for p in [[share * FS, 0.05, 2.0, 1.0], [share * FS, 0.2, 1.94, 1.05], [share * FS, 0.62, 1.85, 0.95]]
        {
            let tf = FRACTIONAL.transfer_function(&p).unwrap();
            let cut = Cut::new(&tf, TAU * p[0]);
            for shift in [0.0, 0.003, 0.3, 0.5, 1.0, 1.7, 1.9999] {
                for (worst, (sampling, held)) in worst.iter_mut().zip([(HELD, true), (STRAIGHT, false)]) {
                    let expected = cut.simulate(&input, shift / FS, held);
                    let found = apply(&plan, &tf, shift / FS, sampling, &input);
                    *worst = worst.max(error(&found, &expected));
                }
            }
        }
    }
    println!("held {:.1e}, straight {:.1e}", worst[0], worst[1]);
    assert!(worst[0] < 1e-7 && worst[1] < 1e-8, "{worst:?}");
}

#[test]
fn a_response_that_does_not_fall_off_jumps_with_the_staircase() {
    let samples = 600;
    let input = input(samples);
    let (k, order) = (0.08, 0.12);
    let form = DynamicForm { modes: Modes::None, creep: Creep::Fractional };
    let creeping = form.transfer_function(&[k, order]).unwrap();
    let form = DynamicForm { modes: Modes::None, creep: Creep::None };
    let constant = form.transfer_function(&[]).unwrap();
    let plan = plan(samples, Start::ZERO);
    for shift in [0.0, 1e-4, 0.3, 1.0, 1.7] {
        for (tf, k) in [(&creeping, k), (&constant, 0.0)] {
            let step =
                |t: f64| if t < 0.0 { 0.0 } else { 1.0 + k * t.powf(order) / libm::tgamma(1.0 + order) };
            let at = |n: usize| (n as f64 - shift) / FS;
            let kernel: Vec<f64> = (0..samples).map(|n| step(at(n)) - step(at(n) - 1.0 / FS)).collect();
            let expected: Vec<f64> =
                (0..samples).map(|n| (0..=n).map(|m| kernel[n - m] * input[m]).sum()).collect();
            let off = error(&apply(&plan, tf, shift / FS, HELD, &input), &expected);
            println!("creep {k} {shift}: {off:.1e}");
            assert!(off < 1e-9, "creep {k} {shift}: {off:e}");
        }
        // In the order, in which the slowest images fall less fast.
        let form = DynamicForm { modes: Modes::None, creep: Creep::Fractional };
        let expected = difference(
            |order| apply(&plan, &form.transfer_function(&[k, order]).unwrap(), shift / FS, HELD, &input),
            order,
            0.03 * order,
        );
        let mut linearised = Linearised::new();
        form.linearise(&[k, order], &mut linearised).unwrap();
        let mut response = plan.empty_response(2);
        plan.response_with_tangents(&linearised, shift / FS, HELD, &mut response).unwrap();
        let mut found = vec![0.0; samples];
        let spectrum = plan.transform(&input).unwrap();
        plan.apply_tangent(&response, 1, &spectrum, &mut plan.workspace(), &mut found).unwrap();
        assert!(error(&found, &expected) < 1e-6, "{shift}: {:e}", error(&found, &expected));
    }
}

#[test]
fn the_path_on_stamps_says_the_same() {
    let samples = 600;
    let input = input(samples);
    let plan = plan(samples, Start::ZERO);
    let times: Vec<f64> = (0..samples).map(|k| k as f64 / FS).collect();
    // What relaxations at fixed rates do not follow.
    const STAMPED: f64 = 1e-5;
    for (sampling, held) in [(HELD, true), (STRAIGHT, false)] {
        let stamped = StampedPlan::new(times.clone(), times.clone(), held).unwrap();
        for creep in [Creep::None, Creep::Fractional] {
            let form = DynamicForm { modes: Modes::Fractional, creep };
            let p = [373.0, 0.3, 1.94, 1.05, 0.08, 0.12];
            let tf = form.transfer_function(&p[..form.parameters().len()]).unwrap();
            for shift in [0.0, 0.3, 1.7] {
                let mut response = stamped.empty_response();
                stamped.response(&tf, None, shift / FS, &mut response).unwrap();
                let mut expected = vec![0.0; samples];
                stamped.apply(&response, &input, &mut StampedWorkspace::default(), &mut expected).unwrap();
                let found = apply(&plan, &tf, shift / FS, sampling, &input);
                // Stamps begin with their first knot, a polygon a sample before it.
                let from = if held { 0 } else { 300 };
                let off = error(&found[from..], &expected[from..]);
                println!("{sampling:?} {creep:?} {shift}: {off:.1e}");
                assert!(!held || off < STAMPED, "{sampling:?} {creep:?} {shift}: {off:e}");
            }
        }
    }
}

#[test]
fn a_plan_of_thinned_inputs_has_the_images_of_the_drive() {
    let (samples, factor) = (4000, 5);
    let pulse = |k: f64| (-((k - 1500.0) / 60.0).powi(2)).exp() * (0.45 * k).sin();
    let input: Vec<f64> = (0..samples).map(|k| pulse(k as f64)).collect();
    let thinned: Vec<f64> = input.iter().step_by(factor).copied().collect();
    let whole = plan(samples, Start::ZERO);
    let rate = FS / factor as f64;
    let reduced = SimulationPlan::new(thinned.len(), rate, Scheme::BandLimited, Start::ZERO).unwrap();
    let reduced = reduced.of_thinned_inputs(factor);
    for share in [0.05, 0.3] {
        let tf = FRACTIONAL.transfer_function(&[share * FS, 0.2, 1.94, 1.05]).unwrap();
        for (sampling, shift) in [(HELD, 0.3), (HELD, 1.7), (STRAIGHT, 0.3)] {
            let expected = apply(&whole, &tf, shift / FS, sampling, &input);
            let expected: Vec<f64> = expected.into_iter().step_by(factor).collect();
            let off = error(&apply(&reduced, &tf, shift / FS, sampling, &thinned), &expected);
            println!("{share} {sampling:?} {shift}: {off:.1e}");
            assert!(off < 1e-8, "{share} {sampling:?} {shift}: {off:e}");
        }
    }
}

#[test]
fn a_settled_drive_gives_what_many_cycles_give() {
    let (samples, cycles) = (250, 12);
    let cycle = input(samples);
    let many: Vec<f64> = cycle.iter().cycle().take(samples * cycles).copied().collect();
    let tf = FRACTIONAL.transfer_function(&[280.0, 0.2, 2.0, 1.0]).unwrap();
    for length in [samples, samples - 1] {
        let cycle = &cycle[..length];
        let many: Vec<f64> = many.iter().enumerate().map(|(k, _)| cycle[k % length]).collect();
        for (sampling, shift) in [(HELD, 0.3), (HELD, 1.7), (STRAIGHT, 0.3)] {
            let all = apply(&plan(many.len(), Start::ZERO), &tf, shift / FS, sampling, &many);
            let found = apply(&plan(length, Start::PERIODIC), &tf, shift / FS, sampling, cycle);
            let last = &all[10 * length..11 * length];
            assert!(error(&found, last) < 1e-8, "{sampling:?} {length}: {:e}", error(&found, last));
        }
    }
}

/// Sixth-order central difference.
fn difference(f: impl Fn(f64) -> Vec<f64>, x: f64, h: f64) -> Vec<f64> {
    let at = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0].map(|k| f(x + k * h));
    let weights = [-1.0, 9.0, -45.0, 45.0, -9.0, 1.0];
    (0..at[0].len())
        .map(|k| at.iter().zip(weights).map(|(y, w)| w * y[k]).sum::<f64>() / (60.0 * h))
        .collect()
}

#[test]
fn derivatives_are_those_of_the_output() {
    let samples = 600;
    let input = input(samples);
    let plan = plan(samples, Start::ZERO);
    let spectrum = plan.transform(&input).unwrap();
    let mut worst = [0.0_f64; 2];
    // Interpolated, and with the nearest images at every frequency.
    for frequency in [100.0, 373.0, 450.0, 800.0] {
        let p = [frequency, 0.3, 1.94, 1.05];
        for shift in [0.3, 0.97, 1.7] {
            for (worst, sampling) in worst.iter_mut().zip([HELD, STRAIGHT]) {
                let mut linearised = Linearised::new();
                FRACTIONAL.linearise(&p, &mut linearised).unwrap();
                let mut response = plan.empty_response(p.len());
                plan.response_with_tangents(&linearised, shift / FS, sampling, &mut response).unwrap();
                let (mut workspace, mut found) = (plan.workspace(), vec![0.0; samples]);
                plan.apply(&response, &spectrum, &mut workspace, &mut found).unwrap();
                let tf = FRACTIONAL.transfer_function(&p).unwrap();
                assert_eq!(found, apply(&plan, &tf, shift / FS, sampling, &input));
                for which in 0..=p.len() {
                    plan.apply_tangent(&response, which, &spectrum, &mut workspace, &mut found).unwrap();
                    let at = |x: f64| {
                        let (mut p, mut delay) = (p, shift / FS);
                        if which == 4 {
                            delay = x
                        } else {
                            p[which] = x
                        }
                        let tf = FRACTIONAL.transfer_function(&p).unwrap();
                        Cut::new(&tf, TAU * p[0]).simulate(&input, delay, sampling == HELD)
                    };
                    let (x, h) =
                        if which == 4 { (shift / FS, 5e-3 / FS) } else { (p[which], 5e-3 * p[which]) };
                    let off = error(&found, &difference(at, x, h));
                    if off > 3e-8 {
                        println!("{frequency} {shift} {sampling:?} {which}: {off:.1e}");
                    }
                    *worst = worst.max(off);
                }
            }
        }
    }
    println!("held {:.1e}, straight {:.1e}", worst[0], worst[1]);
    assert!(worst[0] < 1e-6 && worst[1] < 1e-6, "{worst:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]

    #[test]
    fn nothing_comes_out_before_it_went_in(
        input in prop::collection::vec(-1.0f64..1.0, 20..300),
        share in 0.0f64..1.0,
        frequency in 20.0f64..700.0,
        damping in 0.1f64..1.5,
        order2 in 1.6f64..2.0,
        shift in 0.0f64..3.0,
        other in -2.0f64..2.0,
    ) {
        let tf = FRACTIONAL.transfer_function(&[frequency, damping, order2, 1.0]).unwrap();
        let from = (share * input.len() as f64) as usize;
        let plan = plan(input.len(), Start::ZERO);
        let mut late = vec![0.0; input.len()];
        late[from..].copy_from_slice(&input[from..]);
        let mixed: Vec<f64> = input.iter().zip(&late).map(|(x, late)| x + other * late).collect();
        for sampling in [HELD, STRAIGHT] {
            let of = |input: &[f64]| apply(&plan, &tf, shift / FS, sampling, input);
            let (all, late, mixed) = (of(&input), of(&late), of(&mixed));
            let size = largest(&all) + largest(&late);
            for k in 0..input.len() {
                prop_assert!(k >= from + shift as usize || late[k].abs() < 1e-7 * size, "{sampling:?} {k}");
                prop_assert!((mixed[k] - all[k] - other * late[k]).abs() < 1e-9 * size, "{sampling:?} {k}");
            }
        }
    }
}
