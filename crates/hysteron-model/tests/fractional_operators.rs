//! Promise: fractional derivatives and integrals of sampled data against known answers, and the laws they
//! obey.

#![allow(clippy::unwrap_used)]

use std::f64::consts::{FRAC_PI_2, PI};

use hysteron_model::dynamics::{DynamicsError, Scheme, Term, TransferFunction};
use hysteron_model::fractional::{
    convolution_weights, differintegral, differintegral_direct, simulate_causal, simulate_recursion, weights,
};
use hysteron_numeric::Complex64;
use proptest::prelude::*;

/// f at k/n, k = 0 … n·end.
fn samples(n: usize, end: f64, f: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..=(n as f64 * end) as usize).map(|k| f(k as f64 / n as f64)).collect()
}

fn last(alpha: f64, n: usize, end: f64, scheme: Scheme, f: impl Fn(f64) -> f64) -> f64 {
    *differintegral(alpha, &samples(n, end, f), n as f64, scheme).unwrap().last().unwrap()
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| m.max(x.abs()))
}

#[test]
fn half_derivative_of_the_square_root_is_constant() {
    // Γ(3/2); the error of Grünwald–Letnikov falls as h^1.5 here.
    let expected = PI.sqrt() / 2.0;
    assert!((expected - 0.886_226_925).abs() < 1e-9);
    let error = |n| last(0.5, n, 1.0, Scheme::GrunwaldLetnikov, f64::sqrt) - expected;
    let (coarse, fine) = (error(10_000), error(20_000));
    println!("{coarse:e} {fine:e}");
    assert!(fine.abs() < 1e-7);
    assert!(((coarse / fine).log2() - 1.5).abs() < 0.02);
}

#[test]
fn half_derivative_of_a_parabola_with_a_jump() {
    // Riemann–Liouville: Γ(3)/Γ(5/2) − 1/Γ(1/2). Romberg on three halvings of a first-order rule.
    let mut column: Vec<f64> = [500, 1000, 2000, 4000]
        .iter()
        .map(|n| last(0.5, *n, 1.0, Scheme::GrunwaldLetnikov, |x| x * x - 1.0))
        .collect();
    assert!((column[3] - 0.940_315_972_58).abs() < 2e-4);
    for power in 1..=3 {
        let factor = f64::from(1 << power);
        column = column.windows(2).map(|w| (factor * w[1] - w[0]) / (factor - 1.0)).collect();
    }
    assert!((column[0] - 0.940_315_972_58).abs() < 1e-10, "{}", column[0]);
}

#[test]
fn half_derivative_of_the_sine_by_fresnel_integrals() {
    // C and S by their series.
    let fresnel = |x: f64| {
        let (mut c, mut s, mut term) = (0.0, 0.0, x);
        for k in 0..60 {
            let part = term / f64::from(2 * k + 1);
            match k % 4 {
                0 => c += part,
                1 => s += part,
                2 => c -= part,
                _ => s -= part,
            }
            term *= FRAC_PI_2 * x * x / f64::from(k + 1);
        }
        (c, s)
    };
    // Published: C(1) = 0.7798934004, S(1) = 0.4382591474.
    assert!(
        (fresnel(1.0).0 - 0.779_893_400_4).abs() < 1e-10 && (fresnel(1.0).1 - 0.438_259_147_4).abs() < 1e-10
    );
    for t in [0.5, 1.0, 3.0, 6.0] {
        let (c, s) = fresnel((2.0 * t / PI).sqrt());
        let expected = 2f64.sqrt() * (t.cos() * c + t.sin() * s);
        let error = |scheme, n| last(0.5, n, t, scheme, f64::sin) - expected;
        let (coarse, fine) = (error(Scheme::Bdf2, 2000), error(Scheme::Bdf2, 4000));
        println!("t = {t}: bdf2 {fine:e}, ratio {}", coarse / fine);
        assert!(fine.abs() < 3e-7, "{fine:e}");
        assert!(error(Scheme::GrunwaldLetnikov, 4000).abs() < 1e-4);
    }
}

#[test]
fn relaxation_of_order_1_8_is_a_mittag_leffler_function() {
    let tf = TransferFunction::new(vec![Term::new(1.0, 0.0)], vec![Term::new(1.0, 0.0), Term::new(1.0, 1.8)])
        .unwrap();
    // y = t^1.8 E_{1.8, 2.8}(−t^1.8).
    let exact = |t: f64| -> f64 {
        let term = |k: i32| {
            let order = 1.8 * f64::from(k + 1);
            (-1f64).powi(k) * (order * t.ln() - libm::lgamma(order + 1.0)).exp()
        };
        (0..80).map(term).sum()
    };
    for (scheme, order, bound) in
        [(Scheme::Tustin, 2.0, 1e-6), (Scheme::Bdf2, 2.0, 3e-6), (Scheme::GrunwaldLetnikov, 1.0, 3e-3)]
    {
        let errors = |n: usize| -> Vec<f64> {
            let y = tf.step_response(8 * n + 1, n as f64, scheme).unwrap();
            [1, 2, 5, 8].iter().map(|t| y[t * n] - exact(*t as f64)).collect()
        };
        let (coarse, fine) = (errors(500), errors(1000));
        println!("{scheme}: {fine:?}");
        assert!(largest(&fine) < bound, "{scheme}: {fine:?}");
        let observed = (largest(&coarse) / largest(&fine)).log2();
        assert!((observed - order).abs() < 0.02, "{scheme}: order {observed}");
    }
}

#[test]
fn what_has_no_meaning_is_a_typed_error() {
    let x = [1.0, 2.0];
    let refuse = |alpha, fs, scheme| differintegral(alpha, &x, fs, scheme).unwrap_err();
    assert!(matches!(refuse(0.5, 10.0, Scheme::Tustin), DynamicsError::ImproperOperator { .. }));
    assert!(matches!(refuse(0.5, 10.0, Scheme::BandLimited), DynamicsError::NoWeights { .. }));
    assert!(matches!(refuse(f64::NAN, 10.0, Scheme::Bdf2), DynamicsError::OperatorOrder { .. }));
    assert!(matches!(refuse(0.5, 0.0, Scheme::Bdf2), DynamicsError::SampleRate { .. }));
    assert!(differintegral(-0.5, &x, 10.0, Scheme::Tustin).is_ok());
    let differentiator = [Term::new(1.0, 1.5)];
    let one = [Term::new(1.0, 0.0)];
    let result = simulate_recursion(&differentiator, &one, &x, 10.0, Scheme::Tustin);
    assert!(matches!(result, Err(DynamicsError::ImproperOperator { .. })));
    let none = simulate_recursion(&one, &[], &x, 10.0, Scheme::Bdf2);
    assert!(matches!(none, Err(DynamicsError::NoOperatorTerms { part: "denominator" })));
    assert_eq!(differintegral(0.5, &[], 10.0, Scheme::Bdf2), Ok(vec![]));
    assert_eq!(simulate_causal(&one, &one, &[], 10.0, Scheme::Bdf2), Ok(vec![]));
}

#[test]
fn quadrature_weights_of_a_power_are_its_series() {
    for scheme in [Scheme::GrunwaldLetnikov, Scheme::Bdf2, Scheme::Tustin] {
        let found = convolution_weights(|s: Complex64| s.powf(-0.7), 300, 50.0, scheme).unwrap();
        let series = weights(scheme, -0.7, 300).unwrap();
        for (a, b) in found.iter().zip(series) {
            assert!((a - b * 50f64.powf(-0.7)).abs() < 1e-9 * largest(&found));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn fast_and_direct_sums_agree(
        alpha in -2.5f64..2.5,
        x in prop::collection::vec(-1.0f64..1.0, 1..300),
        bdf2 in any::<bool>(),
    ) {
        let scheme = if bdf2 { Scheme::Bdf2 } else { Scheme::GrunwaldLetnikov };
        let fast = differintegral(alpha, &x, 100.0, scheme).unwrap();
        let direct = differintegral_direct(alpha, &x, 100.0, scheme).unwrap();
        let difference: Vec<f64> = fast.iter().zip(&direct).map(|(a, b)| a - b).collect();
        prop_assert!(largest(&difference) <= 1e-12 * largest(&direct).max(1e-300));
    }

    /// D^α D^β = D^(α+β) from a zero start holds for the sums themselves, not only in the limit.
    #[test]
    fn orders_add(
        alpha in -1.5f64..1.5,
        beta in -1.5f64..1.5,
        x in prop::collection::vec(-1.0f64..1.0, 1..200),
    ) {
        for scheme in [Scheme::GrunwaldLetnikov, Scheme::Bdf2] {
            let inner = differintegral(beta, &x, 1.0, scheme).unwrap();
            let twice = differintegral(alpha, &inner, 1.0, scheme).unwrap();
            let once = differintegral(alpha + beta, &x, 1.0, scheme).unwrap();
            let scale = largest(&inner).max(largest(&once)).max(1.0);
            let difference: Vec<f64> = twice.iter().zip(&once).map(|(a, b)| a - b).collect();
            prop_assert!(largest(&difference) < 1e-10 * scale);
        }
    }

    #[test]
    fn an_integral_undoes_a_derivative(
        alpha in 0.1f64..2.0,
        x in prop::collection::vec(-1.0f64..1.0, 1..100),
    ) {
        let derivative = differintegral(alpha, &x, 20.0, Scheme::GrunwaldLetnikov).unwrap();
        let back = differintegral(-alpha, &derivative, 20.0, Scheme::GrunwaldLetnikov).unwrap();
        for (a, b) in back.iter().zip(&x) {
            prop_assert!((a - b).abs() < 1e-9);
        }
    }
}
