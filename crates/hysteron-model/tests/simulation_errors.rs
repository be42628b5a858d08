//! Promise: what cannot be simulated is refused with a typed error that says why; nothing panics.

#![allow(clippy::unwrap_used)]

use hysteron_model::dynamics::{DynamicsError, Scheme, SecondOrder, SimulationPlan, Term, TransferFunction};
use hysteron_model::{LinearStart, Start};
use proptest::prelude::*;

fn plan(samples: usize, scheme: Scheme, initial: LinearStart) -> SimulationPlan {
    SimulationPlan::new(samples, 1e4, scheme, initial).unwrap()
}

fn simulate(tf: &TransferFunction, scheme: Scheme, initial: LinearStart) -> Result<Vec<f64>, DynamicsError> {
    let plan = plan(100, scheme, initial);
    let input: Vec<f64> = (0..100).map(|k| (f64::from(k) * 0.1).cos()).collect();
    let mut output = vec![0.0; 100];
    plan.simulate(tf, &input, &mut plan.workspace(), &mut output).map(|()| output)
}

fn tf(numerator: &[(f64, f64)], denominator: &[(f64, f64)]) -> TransferFunction {
    let terms = |list: &[(f64, f64)]| list.iter().map(|&(a, order)| Term::new(a, order)).collect();
    TransferFunction::new(terms(numerator), terms(denominator)).unwrap()
}

#[test]
fn records_and_buffers() {
    let new = |n, fs| SimulationPlan::new(n, fs, Scheme::Tustin, Start::AsIdentified);
    assert!(matches!(new(0, 1e4), Err(DynamicsError::TooFewSamples { need: 1, found: 0 })));
    for fs in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(new(10, fs), Err(DynamicsError::SampleRate { .. })));
    }
    let eq13 = TransferFunction::article_eq13();
    let ten = plan(10, Scheme::Tustin, Start::AsIdentified);
    let (mut workspace, mut output) = (ten.workspace(), [0.0; 10]);
    let short = ten.simulate(&eq13, &[0.0; 9], &mut workspace, &mut output);
    assert_eq!(short, Err(DynamicsError::Length { what: "input", expected: 10, found: 9 }));
    let short = ten.simulate(&eq13, &[0.0; 10], &mut workspace, &mut output[..9]);
    assert_eq!(short, Err(DynamicsError::Length { what: "output", expected: 10, found: 9 }));
    let mut hole = [0.0; 10];
    hole[3] = f64::NAN;
    let refused = ten.simulate(&eq13, &hole, &mut workspace, &mut output);
    assert!(matches!(refused, Err(DynamicsError::InputNotFinite { index: 3, .. })));
    let mut other = plan(1000, Scheme::Tustin, Start::AsIdentified).workspace();
    let refused = ten.simulate(&eq13, &[0.0; 10], &mut other, &mut output);
    assert!(matches!(refused, Err(DynamicsError::Length { what: "workspace", .. })));
    // A refusal leaves the workspace usable.
    assert!(ten.simulate(&eq13, &[1.0; 10], &mut workspace, &mut output).is_ok());
}

#[test]
fn improper_under_tustin_only() {
    let lead = tf(&[(1.0, 0.0), (1e-6, 1.5)], &[(1.0, 0.0), (1e-3, 1.0)]);
    for initial in [Start::AsIdentified, Start::ZERO, Start::PERIODIC] {
        let refused = simulate(&lead, Scheme::Tustin, initial);
        assert_eq!(refused, Err(DynamicsError::Improper { numerator: 1.5, denominator: 1.0 }));
        for scheme in [Scheme::GrunwaldLetnikov, Scheme::Bdf2] {
            assert!(simulate(&lead, scheme, initial).is_ok());
        }
    }
}

#[test]
fn infinite_gain_at_zero_frequency() {
    let creeping = tf(&[(1.0, 0.0)], &[(5.0, 0.04), (1e-3, 1.0)]);
    for scheme in Scheme::ALL {
        for initial in [Start::AsIdentified, Start::PERIODIC] {
            let refused = simulate(&creeping, scheme, initial);
            assert_eq!(refused, Err(DynamicsError::InfiniteDcGain { numerator: 0.0, denominator: 0.04 }));
        }
        assert!(simulate(&creeping, scheme, Start::ZERO).is_ok());
    }
}

#[test]
fn no_steady_state_of_an_undamped_plant() {
    let undamped = tf(&[(4e4, 0.0)], &[(4e4, 0.0), (1.0, 2.0)]);
    for scheme in Scheme::ALL {
        let refused = simulate(&undamped, scheme, Start::PERIODIC);
        match refused {
            Err(DynamicsError::Undamped { frequency_hz }) => {
                assert!((frequency_hz * std::f64::consts::TAU - 200.0).abs() < 1e-6);
            }
            other => panic!("{other:?}"),
        }
        assert!(simulate(&undamped, scheme, Start::ZERO).is_ok());
    }
}

#[test]
fn sizes_out_of_range() {
    // s^80 at 10 kHz is 1e344.
    let huge = tf(&[(1.0, 0.0)], &[(1.0, 0.0), (1.0, 80.0)]);
    assert!(matches!(
        simulate(&huge, Scheme::Tustin, Start::ZERO),
        Err(DynamicsError::OutputNotFinite | DynamicsError::Unstable { .. })
    ));
    let tiny = tf(&[(1e-300, 0.0)], &[(1e-300, 0.0), (1e-303, 1.0)]);
    assert_eq!(simulate(&tiny, Scheme::Tustin, Start::ZERO), Err(DynamicsError::OutputNotFinite));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    /// Whatever a search proposes: finite numbers or a typed error.
    #[test]
    fn any_candidate_is_simulated_or_refused(
        gain in any::<f64>(),
        natural_frequency_hz in any::<f64>(),
        damping in any::<f64>(),
        orders in [0.0f64..5.0, 0.0f64..5.0, 0.0f64..5.0],
        scheme in 0usize..4,
    ) {
        let words = SecondOrder {
            gain, natural_frequency_hz, damping, alpha2: orders[2], alpha1: orders[1], alpha0: orders[0],
        };
        if let Ok(tf) = words.to_transfer_function() {
            for initial in [Start::AsIdentified, Start::ZERO, Start::PERIODIC] {
                if let Ok(output) = simulate(&tf, Scheme::ALL[scheme], initial) {
                    prop_assert!(output.iter().all(|y| y.is_finite()));
                }
            }
            let _ = tf.poles();
        }
    }

    #[test]
    fn reasonable_candidates_are_simulated_or_refused(
        gain in -10.0f64..10.0,
        natural_frequency_hz in 0.1f64..1e5,
        damping in -1.0f64..3.0,
        alpha2 in 1.1f64..4.0,
        alpha1 in 0.1f64..2.0,
        scheme in 0usize..4,
    ) {
        let words = SecondOrder { gain, natural_frequency_hz, damping, alpha2, alpha1, alpha0: 0.0 };
        if let Ok(tf) = words.to_transfer_function() {
            for initial in [Start::AsIdentified, Start::ZERO, Start::PERIODIC] {
                match simulate(&tf, Scheme::ALL[scheme], initial) {
                    Ok(output) => prop_assert!(output.iter().all(|y| y.is_finite())),
                    Err(error) => prop_assert!(matches!(error, DynamicsError::Unstable { .. }), "{error}"),
                }
            }
        }
    }
}
