//! Promise: a frequency response applied to a spectrum is what the simulation does, with an exact delay, and
//! its derivatives are those of the simulated output.

#![allow(clippy::unwrap_used)]

use hysteron_model::{LinearStart, Start};
use std::f64::consts::TAU;

use hysteron_model::dynamics::delay::{delay_linear, delayed};
use hysteron_model::dynamics::{
    Creep, DynamicForm, DynamicsError, InterSample, Linearised, Modes, Sampling, Scheme, SimulationPlan,
    TransferFunction,
};
use proptest::prelude::*;

const FS: f64 = 10_000.0;
const INITIAL: [LinearStart; 3] = [Start::AsIdentified, Start::ZERO, Start::PERIODIC];
const LINEAR: Sampling = Sampling { delay: InterSample::Linear, reconstruction: InterSample::BandLimited };
const EXACT: Sampling =
    Sampling { delay: InterSample::BandLimited, reconstruction: InterSample::BandLimited };
const WHOLE: Sampling = Sampling { delay: InterSample::Hold, reconstruction: InterSample::BandLimited };

/// Rounding of values near 1, raised by r^−N = 1e5 towards the end of a record.
const ROUNDING: f64 = 2e-11;

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| m.max(x.abs()))
}

/// Largest difference over the largest of `reference`.
fn error(found: &[f64], reference: &[f64]) -> f64 {
    let difference: Vec<f64> = found.iter().zip(reference).map(|(a, b)| a - b).collect();
    largest(&difference) / largest(reference)
}

fn sweep(samples: usize) -> Vec<f64> {
    let phase = |t: f64| TAU * (20.0 * t + 0.5 * 4000.0 * t * t);
    (0..samples).map(|k| 0.4 + phase(k as f64 / FS + 0.01).sin()).collect()
}

/// Every form with parameters of a plausible stage.
fn forms() -> Vec<(DynamicForm, Vec<f64>)> {
    let modes: [(Modes, &[f64]); 10] = [
        (Modes::None, &[]),
        (Modes::Integer { order: 1 }, &[4e-4]),
        (Modes::Integer { order: 2 }, &[320.0, 0.62]),
        (Modes::Integer { order: 3 }, &[320.0, 0.62, 4e-4]),
        (Modes::Integer { order: 4 }, &[320.0, 0.62, 710.0, 0.21]),
        (Modes::Fractional, &[320.0, 0.62, 1.94, 1.05]),
        (Modes::FractionalFreeLowest, &[320.0, 0.62, 1.94, 1.05, 0.03]),
        (Modes::TwoFractional, &[320.0, 0.62, 1.94, 1.05, 710.0, 0.21, 1.87, 0.93, 0.7]),
        (Modes::Integer { order: 7 }, &[320.0, 0.62, 710.0, 0.21, 950.0, 0.11, 4e-4]),
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

#[test]
fn the_value_is_the_simulation() {
    let mut worst = (0.0, 0.0);
    for samples in [1, 2, 601, 1000] {
        let input = sweep(samples);
        for (form, p) in forms() {
            let tf = form.transfer_function(&p).unwrap();
            for (scheme, initial) in Scheme::ALL.into_iter().flat_map(|s| INITIAL.map(|i| (s, i))) {
                let plan = SimulationPlan::new(samples, FS, scheme, initial).unwrap();
                let mut expected = vec![0.0; samples];
                let simulated = plan.simulate(&tf, &input, &mut plan.workspace(), &mut expected);
                let mut response = plan.empty_response(0);
                let responded = plan.response(&tf, 0.0, LINEAR, &mut response);
                assert_eq!(simulated, responded, "{form:?} {initial:?}");
                if simulated.is_ok() {
                    let rest = initial == Start::AsIdentified;
                    let offset =
                        if rest { tf.dc_gain() * plan.transform(&input).unwrap().level() } else { 0.0 };
                    for sampling in [LINEAR, EXACT, WHOLE] {
                        let mut found = apply(&plan, &tf, 0.0, sampling, &input);
                        found.iter_mut().for_each(|y| *y += offset);
                        // Rounding is raised towards the end of the record.
                        let half = samples.div_ceil(2);
                        let early = error(&found[..half], &expected[..half]);
                        let all = error(&found, &expected);
                        worst = (f64::max(worst.0, early), f64::max(worst.1, all));
                    }
                }
            }
        }
    }
    println!("against simulate: first half {:.1e}, all {:.1e}", worst.0, worst.1);
    assert!(worst.0 < 1e-12 && worst.1 < ROUNDING, "{worst:?}");
}

#[test]
fn the_linear_delay_is_the_one_in_time() {
    let tf = TransferFunction::article_eq13();
    for samples in [7, 600] {
        let input = sweep(samples);
        for scheme in [Scheme::Tustin, Scheme::GrunwaldLetnikov, Scheme::Bdf2] {
            for initial in [Start::AsIdentified, Start::ZERO] {
                let plan = SimulationPlan::new(samples, FS, scheme, initial).unwrap();
                let before = if initial == Start::AsIdentified { input[0] } else { 0.0 };
                for shift in [0.0, 0.25, 1.0, 5.75, 300.5, 1e4] {
                    let mut late = vec![0.0; samples];
                    delay_linear(&input, shift / FS, FS, before, &mut late).unwrap();
                    let mut expected = vec![0.0; samples];
                    plan.simulate(&tf, &late, &mut plan.workspace(), &mut expected).unwrap();
                    let mut found = apply(&plan, &tf, shift / FS, LINEAR, &input);
                    found.iter_mut().for_each(|y| *y += tf.dc_gain() * before);
                    let difference =
                        found.iter().zip(&expected).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
                    // What is aliased, 1e-10 of the response, is all there is where the delay exceeds the
                    // record.
                    assert!(
                        difference < ROUNDING || shift > samples as f64,
                        "{scheme} {shift}: {difference:e}"
                    );
                    assert!(difference < 2e-10, "{scheme} {shift}: {difference:e}");
                }
            }
        }
    }
}

#[test]
fn the_band_limited_delay_is_exact_for_a_smooth_pulse_under_every_scheme() {
    let pulse = |k: f64| (-((k - 250.0) / 12.0f64).powi(2)).exp() * (0.9 * k).sin();
    let input: Vec<f64> = (0..600).map(|k| pulse(f64::from(k))).collect();
    let one = DynamicForm { modes: Modes::None, creep: Creep::None }.transfer_function(&[]).unwrap();
    for scheme in Scheme::ALL {
        let plan = SimulationPlan::new(input.len(), FS, scheme, Start::ZERO).unwrap();
        for shift in [0.37, 2.5, 41.25] {
            let found = apply(&plan, &one, shift / FS, EXACT, &input);
            let expected: Vec<f64> = (0..600).map(|k| pulse(f64::from(k) - shift)).collect();
            // Rounding, raised by r^−N ≤ 1e5.
            assert!(error(&found, &expected) < 1e-10, "{scheme} {shift}: {:e}", error(&found, &expected));
            let in_time = delayed(&input, shift / FS, FS, InterSample::BandLimited, 0.0).unwrap();
            assert!(error(&found, &in_time) < 1e-10);
        }
    }
}

/// A start with a corner is not band-limited: it rings, alternating, and by r^−k the ringing does not die
/// away. A G that falls off towards half the sample rate takes it away but for the first samples.
#[test]
fn what_the_band_limited_delay_makes_of_a_corner() {
    let samples = 10_000usize;
    let sine = |t: f64| if t > 0.0 { (TAU * 20.0 * t).sin() } else { 0.0 };
    let input: Vec<f64> = (0..samples).map(|k| sine(k as f64 / FS)).collect();
    let expected: Vec<f64> = (0..samples).map(|k| sine((k as f64 - 2.5) / FS)).collect();
    let one = DynamicForm { modes: Modes::None, creep: Creep::None }.transfer_function(&[]).unwrap();
    let plan = SimulationPlan::new(input.len(), FS, Scheme::Tustin, Start::ZERO).unwrap();
    let found = apply(&plan, &one, 2.5 / FS, EXACT, &input);
    let linear = apply(&plan, &one, 2.5 / FS, LINEAR, &input);
    let (exact, straight) = (error(&found, &expected), error(&linear, &expected));
    let eq13 = TransferFunction::article_eq13();
    let (found, linear) =
        (apply(&plan, &eq13, 2.5 / FS, EXACT, &input), apply(&plan, &eq13, 2.5 / FS, LINEAR, &input));
    let differ = |range: std::ops::Range<usize>| error(&found[range.clone()], &linear[range]);
    let (start, rest) = (differ(0..100), differ(100..samples));
    println!(
        "corner: {exact:.1e}, on lines {straight:.1e}; behind Eq. 13 they differ by {start:.1e} in the first \
         10 ms, then {rest:.1e}"
    );
    assert!(exact < 2e-3 && start < 3e-4 && rest < 1.1 * straight);
}

/// Sixth-order central difference.
fn difference(f: impl Fn(f64) -> Vec<f64>, x: f64, h: f64) -> Vec<f64> {
    let at = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0].map(|k| f(x + k * h));
    let weights = [-1.0, 9.0, -45.0, 45.0, -9.0, 1.0];
    (0..at[0].len())
        .map(|k| at.iter().zip(weights).map(|(y, w)| w * y[k]).sum::<f64>() / (60.0 * h))
        .collect()
}

fn check_tangents(plan: &SimulationPlan, form: DynamicForm, p: &[f64], delay_s: f64, sampling: Sampling) {
    let input = sweep(plan.samples());
    let mut linearised = Linearised::new();
    form.linearise(p, &mut linearised).unwrap();
    let mut response = plan.empty_response(p.len());
    plan.response_with_tangents(&linearised, delay_s, sampling, &mut response).unwrap();
    let spectrum = plan.transform(&input).unwrap();
    let (mut workspace, mut found) = (plan.workspace(), vec![0.0; input.len()]);
    plan.apply(&response, &spectrum, &mut workspace, &mut found).unwrap();
    let tf = form.transfer_function(p).unwrap();
    assert_eq!(found, apply(plan, &tf, delay_s, sampling, &input), "values with and without tangents");
    for which in 0..=p.len() {
        plan.apply_tangent(&response, which, &spectrum, &mut workspace, &mut found).unwrap();
        let name = form.parameters().get(which).map_or("delay", |parameter| parameter.name);
        // As wide as the sixth order allows, for rounding is divided by the step.
        let (x, h) = match name {
            "delay" => (delay_s, 0.02 / FS),
            name if name.starts_with("creep") || name == "order0" => (p[which], 0.03 * p[which]),
            _ => (p[which], 5e-3 * p[which]),
        };
        let at = |x: f64| {
            let (mut p, mut delay_s) = (p.to_vec(), delay_s);
            if which == p.len() {
                delay_s = x
            } else {
                p[which] = x
            }
            apply(plan, &form.transfer_function(&p).unwrap(), delay_s, sampling, &input)
        };
        let expected = difference(at, x, h);
        let worst = expected.iter().zip(&found).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        // A staircase that nothing smooths only rounds with the delay.
        let rounding = if name == "delay" { ROUNDING / h } else { 0.0 };
        assert!(
            worst <= 1e-7 * largest(&expected) + rounding,
            "{form:?} {name} {}: {worst:e} {:e}",
            plan.scheme(),
            largest(&expected)
        );
        assert_eq!(response.tangent_is_zero(which), largest(&expected) == 0.0, "{form:?} {name}");
    }
}

#[test]
fn tangents_are_the_derivatives_of_the_output() {
    for (form, p) in forms() {
        for (scheme, sampling) in [
            (Scheme::Tustin, LINEAR),
            (Scheme::Tustin, EXACT),
            (Scheme::BandLimited, EXACT),
            (Scheme::BandLimited, LINEAR),
            (Scheme::BandLimited, Sampling { reconstruction: InterSample::Hold, ..EXACT }),
            (Scheme::BandLimited, Sampling { reconstruction: InterSample::Linear, ..LINEAR }),
            (Scheme::Bdf2, LINEAR),
            (Scheme::GrunwaldLetnikov, LINEAR),
        ] {
            let plan = SimulationPlan::new(600, FS, scheme, Start::ZERO).unwrap();
            check_tangents(&plan, form, &p, 2.3 / FS, sampling);
        }
        let finite = form.creep != Creep::Fractional && form.modes != Modes::FractionalFreeLowest;
        for scheme in [Scheme::Tustin, Scheme::BandLimited] {
            for samples in [600, 601] {
                for initial in [Start::AsIdentified, Start::PERIODIC] {
                    let plan = SimulationPlan::new(samples, FS, scheme, initial).unwrap();
                    if finite {
                        check_tangents(&plan, form, &p, 2.3 / FS, EXACT);
                    } else {
                        let tf = form.transfer_function(&p).unwrap();
                        let refused = plan.response(&tf, 0.0, EXACT, &mut plan.empty_response(0));
                        assert!(matches!(refused, Err(DynamicsError::InfiniteDcGain { .. })));
                    }
                }
            }
        }
    }
}

#[test]
fn the_linear_delay_at_a_whole_sample_has_the_derivative_from_the_right() {
    // A rate at which whole samples are exact.
    const RATE: f64 = 8192.0;
    let form = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
    let p = [320.0, 0.62, 1.94, 1.05];
    let input = sweep(500);
    let plan = SimulationPlan::new(500, RATE, Scheme::Tustin, Start::ZERO).unwrap();
    let mut linearised = Linearised::new();
    form.linearise(&p, &mut linearised).unwrap();
    let mut response = plan.empty_response(4);
    plan.response_with_tangents(&linearised, 3.0 / RATE, LINEAR, &mut response).unwrap();
    let mut found = vec![0.0; 500];
    let spectrum = plan.transform(&input).unwrap();
    plan.apply_tangent(&response, 4, &spectrum, &mut plan.workspace(), &mut found).unwrap();
    let tf = form.transfer_function(&p).unwrap();
    let at = |samples: f64| apply(&plan, &tf, samples / RATE, LINEAR, &input);
    let expected: Vec<f64> = at(3.5).iter().zip(at(3.0)).map(|(b, a)| (b - a) / (0.5 / RATE)).collect();
    // Differences of neighbouring samples are smaller than the output.
    assert!(error(&found, &expected) < 10.0 * ROUNDING);
    // By whole samples it has none.
    plan.response_with_tangents(&linearised, 3.2 / RATE, WHOLE, &mut response).unwrap();
    plan.apply_tangent(&response, 4, &spectrum, &mut plan.workspace(), &mut found).unwrap();
    assert!(response.tangent_is_zero(4) && found.iter().all(|y| *y == 0.0));
}

/// Unit step after 1 + k s^−μ: 1 + k t^μ/Γ(1 + μ).
#[test]
fn creep_after_a_step_is_a_power_law() {
    let (k, order) = (0.08, 0.12);
    let tf =
        DynamicForm { modes: Modes::None, creep: Creep::Fractional }.transfer_function(&[k, order]).unwrap();
    for scheme in [Scheme::Tustin, Scheme::Bdf2] {
        let y = tf.step_response(10_000, 1000.0, scheme).unwrap();
        for sample in [200, 1000, 9999] {
            let t = sample as f64 / 1000.0;
            let expected = 1.0 + k * t.powf(order) / libm::tgamma(1.0 + order);
            // Second order in 1/sample times the slope of the creep.
            assert!((y[sample] - expected).abs() < 1e-6, "{scheme} {t}: {} {expected}", y[sample]);
        }
    }
}

/// A first-order lag driven by a staircase or a polygon has a closed form.
#[test]
fn reconstruction_of_the_input_between_samples() {
    let lag = |periods: f64| {
        let form = DynamicForm { modes: Modes::Integer { order: 1 }, creep: Creep::None };
        (periods / FS, form.transfer_function(&[periods / FS]).unwrap())
    };
    let samples = 4000;
    // Slow against the sample rate, smooth at its start.
    let input: Vec<f64> = (0..samples).map(|k| 1.0 - (TAU * f64::from(k) / 200.0).cos()).collect();
    let plan = SimulationPlan::new(input.len(), FS, Scheme::BandLimited, Start::ZERO).unwrap();
    let run = |tf: &TransferFunction, reconstruction| {
        let found = apply(&plan, tf, 0.0, Sampling { reconstruction, ..EXACT }, &input);
        found[..samples as usize - 300].to_vec()
    };
    for periods in [2.0, 20.0] {
        let (lag_s, tf) = lag(periods);
        let a = (-1.0 / (lag_s * FS)).exp();
        let (mut held, mut straight) = (vec![0.0], vec![0.0]);
        for pair in input.windows(2) {
            let (y, slope) = (held[held.len() - 1], (pair[1] - pair[0]) * FS);
            held.push(a * y + (1.0 - a) * pair[0]);
            let y = straight[straight.len() - 1];
            // Lag behind a ramp: u − slope·T, plus what is left of the start.
            straight.push(pair[1] - slope * lag_s + a * (y - pair[0] + slope * lag_s));
        }
        let band_limited = run(&tf, InterSample::BandLimited);
        for (rule, exact) in [(InterSample::Hold, &held), (InterSample::Linear, &straight)] {
            let exact = &exact[..band_limited.len()];
            let (found, without) = (error(&run(&tf, rule), exact), error(&band_limited, exact));
            println!("lag of {periods} samples, {rule}: {found:.1e}, without {without:.1e}");
            assert!(found < 1e-10 && without > 1e-5, "{rule}: {found:e} {without:e}");
        }
    }
}

#[test]
fn refusals() {
    let plan = SimulationPlan::new(100, FS, Scheme::Tustin, Start::ZERO).unwrap();
    let other = SimulationPlan::new(1000, FS, Scheme::Tustin, Start::ZERO).unwrap();
    let tf = TransferFunction::article_eq13();
    let mut response = plan.empty_response(4);
    for delay_s in [-1e-3, f64::NAN, f64::INFINITY] {
        let refused = plan.response(&tf, delay_s, EXACT, &mut response);
        assert!(matches!(refused, Err(DynamicsError::Parameter { name: "delay_s", .. })));
    }
    assert!(matches!(
        plan.response(&tf, 0.0, EXACT, &mut other.empty_response(0)),
        Err(DynamicsError::Length { .. })
    ));
    let form = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
    let mut linearised = Linearised::new();
    form.linearise(&[300.0, 0.5, 1.9, 1.0], &mut linearised).unwrap();
    let refused = plan.response_with_tangents(&linearised, 0.0, EXACT, &mut plan.empty_response(3));
    assert_eq!(refused, Err(DynamicsError::Tangents { expected: 5, found: 4 }));
    let spectrum = plan.transform(&[1.0; 100]).unwrap();
    let (mut workspace, mut output) = (plan.workspace(), vec![0.0; 100]);
    plan.response_with_tangents(&linearised, 0.0, EXACT, &mut response).unwrap();
    let beyond = plan.apply_tangent(&response, 5, &spectrum, &mut workspace, &mut output);
    assert_eq!(beyond, Err(DynamicsError::NoTangent { which: 5, found: 5 }));
    // Values alone leave no tangents that might be of another candidate; nor does a refused candidate.
    plan.response(&tf, 0.0, EXACT, &mut response).unwrap();
    let stale = plan.apply_tangent(&response, 0, &spectrum, &mut workspace, &mut output);
    assert_eq!(stale, Err(DynamicsError::NoTangent { which: 0, found: 0 }));
    assert!(plan.apply(&response, &spectrum, &mut workspace, &mut output[..99]).is_err());
    form.linearise(&[300.0, -0.5, 2.1, 1.0], &mut linearised).unwrap();
    let unstable = plan.response_with_tangents(&linearised, 0.0, EXACT, &mut response);
    assert!(matches!(unstable, Err(DynamicsError::Unstable { .. })));
}

#[test]
fn spectra_add_up() {
    let plan = SimulationPlan::new(300, FS, Scheme::Tustin, Start::AsIdentified).unwrap();
    let (u, v) = (sweep(300), (0..300).map(f64::from).map(|k| 2.0 + k.cos()).collect::<Vec<_>>());
    let mixed: Vec<f64> = u.iter().zip(&v).map(|(u, v)| 2.0 * u - 0.5 * v).collect();
    let mut sum = plan.transform(&mixed).unwrap();
    sum.set_sum([]);
    assert_eq!(sum.level(), 0.0);
    sum.set_sum([(2.0, &plan.transform(&u).unwrap()), (-0.5, &plan.transform(&v).unwrap())]);
    assert!((sum.level() - mixed[0]).abs() < 1e-15);
    let tf = TransferFunction::article_eq13();
    let mut response = plan.empty_response(0);
    plan.response(&tf, 0.0, LINEAR, &mut response).unwrap();
    let mut found = vec![0.0; 300];
    plan.apply(&response, &sum, &mut plan.workspace(), &mut found).unwrap();
    assert!(error(&found, &apply(&plan, &tf, 0.0, LINEAR, &mixed)) < ROUNDING);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]

    #[test]
    fn a_delay_by_whole_samples_shifts(
        input in prop::collection::vec(-1.0f64..1.0, 2..300),
        shift in 0usize..50,
        damping in 0.1f64..1.5,
        alpha2 in 1.5f64..2.0,
    ) {
        let form = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
        let tf = form.transfer_function(&[400.0, damping, alpha2, 1.0]).unwrap();
        let n = input.len();
        for scheme in [Scheme::Tustin, Scheme::GrunwaldLetnikov, Scheme::Bdf2] {
            for initial in [Start::ZERO, Start::PERIODIC] {
                let plan = SimulationPlan::new(n, FS, scheme, initial).unwrap();
                let y = apply(&plan, &tf, 0.0, EXACT, &input);
                for sampling in [LINEAR, EXACT, WHOLE] {
                    let z = apply(&plan, &tf, shift as f64 / FS, sampling, &input);
                    for k in 0..n {
                        let expected = match initial {
                            Start::PERIODIC => y[(k + 50 * n - shift) % n],
                            _ => if k < shift { 0.0 } else { y[k - shift] },
                        };
                        prop_assert!(
                            (z[k] - expected).abs() < 1e-9 * largest(&y),
                            "{scheme} {initial:?} {k}"
                        );
                    }
                }
            }
        }
    }
}
