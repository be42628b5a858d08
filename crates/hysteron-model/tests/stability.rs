//! Promise: the stability verdict is exact for real orders, commensurate or not, without rounding them.

#![allow(clippy::unwrap_used)]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use hysteron_model::dynamics::{Stability, Term, TransferFunction, stability};
use proptest::prelude::*;

fn plant(denominator: &[(f64, f64)]) -> TransferFunction {
    let terms = denominator.iter().map(|&(a, order)| Term::new(a, order)).collect();
    TransferFunction::new(vec![Term::new(1.0, 0.0)], terms).unwrap()
}

#[test]
fn known_cases() {
    assert_eq!(stability(&TransferFunction::article_eq13()), Stability::Stable);
    // s − 1; s² + 1; s³ + 1 (two in the right half-plane); √s − 2 (s = 4); √s + 2; s^2.5 + 1.
    assert_eq!(stability(&plant(&[(-1.0, 0.0), (1.0, 1.0)])), Stability::Unstable { poles: 1 });
    assert_eq!(stability(&plant(&[(1.0, 0.0), (1.0, 3.0)])), Stability::Unstable { poles: 2 });
    assert_eq!(stability(&plant(&[(-2.0, 0.0), (1.0, 0.5)])), Stability::Unstable { poles: 1 });
    assert_eq!(stability(&plant(&[(2.0, 0.0), (1.0, 0.5)])), Stability::Stable);
    assert_eq!(stability(&plant(&[(1.0, 0.0), (1.0, 2.5)])), Stability::Unstable { poles: 2 });
    assert_eq!(stability(&plant(&[(1.0, 0.0), (1.0, 1.999)])), Stability::Stable);
    match stability(&plant(&[(1.0, 0.0), (1.0, 2.0)])) {
        Stability::Marginal { frequency_hz } => assert!((frequency_hz * TAU - 1.0).abs() < 1e-9),
        other => panic!("{other:?}"),
    }
    assert_eq!(stability(&plant(&[(1.0, 0.3), (1.0, 1.0)])), Stability::Integrating { order: 0.3 });
    assert_eq!(stability(&plant(&[(4.0, 0.0)])), Stability::Stable);
    // A common factor of s cancels.
    let cancelled =
        TransferFunction::new(vec![Term::new(1.0, 0.5)], vec![Term::new(1.0, 0.5), Term::new(1.0, 1.5)]);
    assert_eq!(stability(&cancelled.unwrap()), Stability::Stable);
    // Zero coefficients do not count; very large and small ones do not overflow.
    assert_eq!(stability(&plant(&[(1.0, 0.0), (0.0, 0.7), (1.0, 1.0), (0.0, 5.0)])), Stability::Stable);
    assert_eq!(stability(&plant(&[(1e200, 0.0), (1e-20, 1.1), (1e-200, 2.0)])), Stability::Stable);
}

/// The damping at which a plant with α₂ > 2 turns stable, from D(iω) = 0: exact, incommensurate, and resolved
/// to a part in a million on both sides.
#[test]
fn the_limit_of_stability_of_an_incommensurate_plant() {
    let (alpha1, alpha2, omega) = (1.0523, 2.0384, 2000f64);
    let sine = |order: f64| (order * FRAC_PI_2).sin();
    let cosine = |order: f64| (order * FRAC_PI_2).cos();
    let c1 = -omega.powf(alpha2 - alpha1) * sine(alpha2) / sine(alpha1);
    let c0 = -omega.powf(alpha2) * cosine(alpha2) - c1 * omega.powf(alpha1) * cosine(alpha1);
    assert!(c1 > 0.0 && c0 > 0.0);
    let verdict = |factor: f64| stability(&plant(&[(c0, 0.0), (c1 * factor, alpha1), (1.0, alpha2)]));
    assert_eq!(verdict(1.0 + 1e-6), Stability::Stable);
    assert_eq!(verdict(1.0 - 1e-6), Stability::Unstable { poles: 2 });
    match verdict(1.0) {
        Stability::Marginal { frequency_hz } => assert!((frequency_hz * TAU / omega - 1.0).abs() < 1e-9),
        other => panic!("{other:?}"),
    }
    // Orders cut to a hundredth, as older tools do, give another verdict near the limit.
    let (cut1, cut2) = (1.05, 2.03);
    let rounded = plant(&[(c0, 0.0), (c1 * 0.9, cut1), (1.0, cut2)]);
    assert_eq!(stability(&rounded), Stability::Stable);
    assert_eq!(verdict(0.9), Stability::Unstable { poles: 2 });
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Matignon: with w = s^q the poles are the zeros w = ρ e^(±iφ) of a polynomial, unstable where |φ| <
    /// qπ/2.
    #[test]
    fn commensurate_orders_agree_with_matignon(
        q in 0.2f64..1.6,
        zeros in prop::collection::vec((0.01f64..100.0, 0.0f64..PI), 1..4),
    ) {
        prop_assume!(zeros.iter().all(|(_, phi)| (phi - q * FRAC_PI_2).abs() > 1e-3));
        let mut product = vec![1.0];
        for (rho, phi) in &zeros {
            let factor = [rho * rho, -2.0 * rho * phi.cos(), 1.0];
            let mut next = vec![0.0; product.len() + 2];
            for (i, p) in product.iter().enumerate() {
                for (j, f) in factor.iter().enumerate() {
                    next[i + j] += p * f;
                }
            }
            product = next;
        }
        let terms: Vec<(f64, f64)> = product.iter().enumerate().map(|(k, a)| (*a, q * k as f64)).collect();
        let unstable = 2 * zeros.iter().filter(|(_, phi)| *phi < q * FRAC_PI_2).count();
        let expected = if unstable > 0 { Stability::Unstable { poles: unstable } } else { Stability::Stable };
        prop_assert_eq!(stability(&plant(&terms)), expected);
        // On the main sheet |arg s| < π, that is |arg w| < qπ, which with q > 1 goes past the half turn: both
        // φ and 2π − φ may lie on it.
        let arguments = || zeros.iter().flat_map(|(_, phi)| [*phi, TAU - phi]);
        let near_cut = arguments().any(|argument| (argument - q * PI).abs() < 1e-3);
        let distinct = zeros.iter().enumerate().all(|(i, a)| {
            zeros[..i].iter().all(|b| (a.0.ln() - b.0.ln()).hypot(a.1 - b.1) > 1e-2)
        });
        if !near_cut && distinct && zeros.iter().all(|(_, phi)| *phi > 1e-2 && *phi < PI - 1e-2) {
            let expected = 2 * arguments().filter(|argument| *argument < q * PI).count();
            prop_assert_eq!(plant(&terms).poles().unwrap().len(), expected);
        }
    }
}
