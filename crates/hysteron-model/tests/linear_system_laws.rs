//! Promise: what is simulated is a causal linear time-invariant system, for any stable transfer function.

#![allow(clippy::unwrap_used)]

use hysteron_model::dynamics::{
    DynamicsError, Scheme, SecondOrder, SimulationPlan, Stability, TransferFunction, stability,
};
use hysteron_model::{LinearStart, Start};
use proptest::prelude::*;

const FS: f64 = 10_000.0;
const CAUSAL: [Scheme; 3] = [Scheme::GrunwaldLetnikov, Scheme::Bdf2, Scheme::Tustin];

fn simulate(tf: &TransferFunction, input: &[f64], scheme: Scheme, initial: LinearStart) -> Vec<f64> {
    let plan = SimulationPlan::new(input.len(), FS, scheme, initial).unwrap();
    let mut output = vec![0.0; input.len()];
    plan.simulate(tf, input, &mut plan.workspace(), &mut output).unwrap();
    output
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| m.max(x.abs()))
}

prop_compose! {
    /// Stable for certain: damped, and the highest order below 2.
    fn stage()(
        gain in 0.1f64..10.0,
        natural_frequency_hz in 20.0f64..1500.0,
        damping in 0.05f64..1.5,
        alpha2 in 1.5f64..2.0,
        alpha1 in 0.3f64..1.2,
    ) -> TransferFunction {
        SecondOrder { gain, natural_frequency_hz, damping, alpha2, alpha1, alpha0: 0.0 }
            .to_transfer_function()
            .unwrap()
    }
}

fn signal() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-1.0f64..1.0, 2..300)
}

#[test]
fn a_steady_state_is_that_of_the_whole_record() {
    let plan = |period| SimulationPlan::new(100, FS, Scheme::Tustin, Start::settled(period)).map(|_| ());
    assert_eq!(plan(100), Ok(()));
    assert_eq!(plan(50), Err(DynamicsError::Length { what: "period", expected: 100, found: 50 }));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]

    #[test]
    fn linear(tf in stage(), u in signal(), c in -3.0f64..3.0) {
        let v: Vec<f64> = u.iter().rev().map(|x| x * x - 0.2).collect();
        let mixed: Vec<f64> = u.iter().zip(&v).map(|(u, v)| u + c * v).collect();
        for scheme in Scheme::ALL {
            for initial in [Start::ZERO, Start::AsIdentified, Start::PERIODIC] {
                let (yu, yv) = (simulate(&tf, &u, scheme, initial), simulate(&tf, &v, scheme, initial));
                let ym = simulate(&tf, &mixed, scheme, initial);
                let scale = largest(&yu) + 3.0 * largest(&yv);
                // Rounding, raised by r^−N ≤ 1e5.
                for k in 0..u.len() {
                    prop_assert!((ym[k] - yu[k] - c * yv[k]).abs() < 1e-10 * scale, "{scheme} {initial:?}");
                }
            }
        }
    }

    #[test]
    fn causal(tf in stage(), u in signal(), cut in 0.0f64..1.0) {
        let cut = (cut * u.len() as f64) as usize;
        let other: Vec<f64> =
            u.iter().enumerate().map(|(k, x)| if k < cut { *x } else { 0.7 - x }).collect();
        for scheme in CAUSAL {
            let y = simulate(&tf, &u, scheme, Start::ZERO);
            let z = simulate(&tf, &other, scheme, Start::ZERO);
            let scale = largest(&y).max(largest(&z));
            for k in 0..cut {
                prop_assert!((y[k] - z[k]).abs() < 1e-9 * scale, "{scheme} {k}");
            }
        }
    }

    #[test]
    fn time_invariant(tf in stage(), u in signal(), shift in 1usize..50) {
        let late = [vec![0.0; shift], u.clone()].concat();
        for scheme in CAUSAL {
            let y = simulate(&tf, &u, scheme, Start::ZERO);
            let z = simulate(&tf, &late, scheme, Start::ZERO);
            let scale = largest(&y);
            prop_assert!(largest(&z[..shift]) < 1e-9 * scale);
            for k in 0..u.len() {
                prop_assert!((y[k] - z[k + shift]).abs() < 1e-9 * scale, "{scheme} {k}");
            }
        }
    }

    #[test]
    fn a_constant_input_at_rest_gives_the_gain(tf in stage(), level in -5.0f64..5.0, n in 1usize..200) {
        for scheme in Scheme::ALL {
            for initial in [Start::AsIdentified, Start::PERIODIC] {
                for y in simulate(&tf, &vec![level; n], scheme, initial) {
                    prop_assert!((y - tf.dc_gain() * level).abs() < 1e-12 * (tf.dc_gain() * level).abs());
                }
            }
        }
    }

    /// A harmonic in the steady state is multiplied by the frequency response (band-limited: of G itself).
    /// By linearity: deviations from the input at rest, and the gain times that input.
    #[test]
    fn a_rest_at_any_input_is_a_start_from_zero_and_a_constant(
        tf in stage(),
        u in signal(),
        rest in -5.0f64..5.0,
    ) {
        let start = Start::Rest { voltage_v: rest };
        let moved: Vec<f64> = u.iter().map(|u| u - rest).collect();
        for scheme in Scheme::ALL {
            let expected: Vec<f64> =
                simulate(&tf, &moved, scheme, Start::ZERO).iter().map(|y| y + tf.dc_gain() * rest).collect();
            let scale = largest(&expected) + (tf.dc_gain() * rest).abs();
            for (y, expected) in simulate(&tf, &u, scheme, start).iter().zip(&expected) {
                prop_assert!((y - expected).abs() < 1e-10 * scale, "{scheme}: {y} {expected}");
            }
        }
        for scheme in CAUSAL {
            let y = tf.simulate_causal(&u, FS, scheme, start).unwrap();
            let from_zero = tf.simulate_causal(&moved, FS, scheme, Start::ZERO).unwrap();
            for (y, z) in y.iter().zip(&from_zero) {
                prop_assert!(
                    (y - z - tf.dc_gain() * rest).abs()
                        < 1e-10 * (largest(&from_zero) + tf.dc_gain().abs() * 5.0)
                );
            }
        }
    }

    #[test]
    fn a_periodic_sine_is_multiplied_by_the_frequency_response(tf in stage(), bin in 1usize..40) {
        let n = 200;
        let phase = |k: usize| std::f64::consts::TAU * (bin * k) as f64 / n as f64;
        let input: Vec<f64> = (0..n).map(|k| phase(k).sin()).collect();
        let frequencies: Vec<f64> = (0..=n / 2).map(|bin| bin as f64 * FS / n as f64).collect();
        let response = tf.frequency_response(&frequencies, 0.0);
        let g = response[bin];
        // Rounding of the input's transform reaches every bin, also the one where the gain is largest.
        let peak = response.iter().fold(0.0f64, |m, g| m.max(g.norm()));
        let y = simulate(&tf, &input, Scheme::BandLimited, Start::PERIODIC);
        for (k, y) in y.iter().enumerate() {
            let expected = g.re * phase(k).sin() + g.im * phase(k).cos();
            prop_assert!((y - expected).abs() < 1e-13 * peak, "{}", (y - expected) / peak);
        }
    }

    /// The verdict on the sampled system and the exact one agree for Tustin, whose δ maps half-plane to disc.
    #[test]
    fn verdicts_agree(
        damping in -0.5f64..0.5,
        alpha2 in 1.6f64..2.4,
        alpha1 in 0.4f64..1.4,
        natural_frequency_hz in 50.0f64..2000.0,
    ) {
        let words = SecondOrder { gain: 1.0, natural_frequency_hz, damping, alpha2, alpha1, alpha0: 0.0 };
        let tf = words.to_transfer_function().unwrap();
        let n = 4000;
        let plan = SimulationPlan::new(n, FS, Scheme::Tustin, Start::ZERO).unwrap();
        let simulated = plan.simulate(&tf, &vec![1.0; n], &mut plan.workspace(), &mut vec![0.0; n]);
        let poles = tf.poles().unwrap();
        let unstable = poles.iter().filter(|p| p.re > 0.0).count();
        let expected = if unstable > 0 { Stability::Unstable { poles: unstable } } else { Stability::Stable };
        prop_assert_eq!(stability(&tf), expected);
        prop_assert_eq!(simulated.is_err(), unstable > 0, "{}: {:?}", tf, simulated);
        // Schemes that damp are judged by their own poles, δ(z) = s h: z = 1 − s h, and 2 − √(1 + 2 s h) for
        // BDF2.
        for scheme in [Scheme::GrunwaldLetnikov, Scheme::Bdf2] {
            let moduli: Vec<f64> = poles
                .iter()
                .map(|s| s / FS)
                .map(|sh| match scheme {
                    Scheme::Bdf2 => (2.0 - (1.0 + 2.0 * sh).sqrt()).norm(),
                    _ => (1.0 - sh).norm(),
                })
                .collect();
            // The verdict tolerates a growth by e^0.01 within the record.
            prop_assume!(moduli.iter().all(|modulus| (modulus - 1.0).abs() > 1e-5));
            let unstable = moduli.iter().filter(|modulus| **modulus < 1.0).count();
            let plan = SimulationPlan::new(n, FS, scheme, Start::ZERO).unwrap();
            let verdict = plan.simulate(&tf, &vec![1.0; n], &mut plan.workspace(), &mut vec![0.0; n]);
            let expected =
                if unstable > 0 { Err(DynamicsError::Unstable { poles: unstable }) } else { Ok(()) };
            prop_assert_eq!(verdict, expected, "{} {}", tf, scheme);
        }
    }
}
