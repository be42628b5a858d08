//! Zeros of a sum of real powers, Σ aᵢ s^αᵢ, on the sheet |arg s| ≤ π: the poles of the true plant.

use std::f64::consts::PI;

use rustfft::num_complex::Complex64;

use super::PowerTerm;

/// Value of Σ aᵢ s^αᵢ and of its derivative with respect to L, at L = ln s.
pub(super) fn power_sum(terms: &[PowerTerm], log_s: Complex64) -> (Complex64, Complex64) {
    let mut value = Complex64::ZERO;
    let mut slope = Complex64::ZERO;
    for term in terms {
        let t = (log_s * term.order).exp() * term.coefficient;
        value += t;
        slope += t * term.order;
    }
    (value, slope)
}

/// Starts per unit of ln|s| and over the half circle of arg s.
const STARTS_PER_E_FOLD: f64 = 2.0;
const STARTS_IN_ANGLE: usize = 12;

/// ln s of the zeros with 0 ≤ arg s ≤ π, by Newton's method in L = ln s from a grid around the magnitudes at
/// which two terms balance. Completeness is not proved here: the caller checks the resulting partial
/// fractions.
pub(super) fn upper_zeros(terms: &[PowerTerm]) -> Vec<Complex64> {
    let mut lowest = f64::INFINITY;
    let mut highest = f64::NEG_INFINITY;
    for (i, a) in terms.iter().enumerate() {
        for b in &terms[i + 1..] {
            if a.order != b.order && a.coefficient != 0.0 && b.coefficient != 0.0 {
                let balance = (a.coefficient / b.coefficient).abs().ln() / (b.order - a.order);
                lowest = lowest.min(balance);
                highest = highest.max(balance);
            }
        }
    }
    let mut zeros: Vec<Complex64> = Vec::new();
    if !(lowest.is_finite() && highest.is_finite()) {
        return zeros;
    }
    let (lowest, highest) = (lowest - 2.0, highest + 2.0);
    let steps = ((highest - lowest) * STARTS_PER_E_FOLD).ceil().min(1000.0) as usize;
    for i in 0..=steps {
        for j in 0..=STARTS_IN_ANGLE {
            let start = Complex64::new(
                lowest + (highest - lowest) * i as f64 / steps as f64,
                PI * j as f64 / STARTS_IN_ANGLE as f64,
            );
            let Some(zero) = newton(terms, start) else { continue };
            // Real coefficients: a zero below the real axis is the mirror of one above.
            let zero = if zero.im < -1e-9 { zero.conj() } else { zero };
            if zero.im > PI + 1e-9 || zeros.iter().any(|z| (z - zero).norm() < 1e-7) {
                continue;
            }
            zeros.push(zero);
        }
    }
    zeros.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
    zeros
}

fn newton(terms: &[PowerTerm], start: Complex64) -> Option<Complex64> {
    let mut log_s = start;
    for _ in 0..60 {
        let (value, slope) = power_sum(terms, log_s);
        let step = value / slope;
        if !step.is_finite() {
            return None;
        }
        log_s -= step * (0.5 / step.norm()).min(1.0);
        if log_s.im.abs() > PI + 0.5 {
            return None;
        }
        if step.norm() < 1e-14 * (1.0 + log_s.norm()) {
            return Some(log_s);
        }
    }
    // Converged to rounding level without passing the last-digit test: accept if the terms cancel.
    let (value, _) = power_sum(terms, log_s);
    let size: f64 = terms.iter().map(|t| (t.coefficient * (t.order * log_s.re).exp()).abs()).sum();
    (value.norm() < 1e-12 * size).then_some(log_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn terms(list: &[(f64, f64)]) -> Vec<PowerTerm> {
        list.iter().map(|&(coefficient, order)| PowerTerm { coefficient, order }).collect()
    }

    #[test]
    fn article_plant_has_the_pole_pair_of_the_specification() {
        let zeros = upper_zeros(&terms(&[(5.4955e6, 0.0), (3081.0, 1.0523), (1.0, 2.0384)]));
        assert_eq!(zeros.len(), 1);
        let s = zeros[0].exp();
        assert!((s.re + 1441.298).abs() < 1e-3 && (s.im - 1062.396).abs() < 1e-3, "{s}");
    }

    #[test]
    fn integer_polynomial_zeros_are_found_including_real_ones() {
        // (s + 3)(s + 50)(s² + 2s + 100)
        let zeros =
            upper_zeros(&terms(&[(15000.0, 0.0), (5600.0, 1.0), (356.0, 2.0), (55.0, 3.0), (1.0, 4.0)]));
        let s: Vec<Complex64> = zeros.iter().map(|z| z.exp()).collect();
        assert_eq!(s.len(), 3, "{s:?}");
        let expected =
            [Complex64::new(-3.0, 0.0), Complex64::new(-1.0, 99f64.sqrt()), Complex64::new(-50.0, 0.0)];
        for e in expected {
            assert!(s.iter().any(|z| (z - e).norm() < 1e-9 * e.norm()), "{e} not in {s:?}");
        }
    }

    #[test]
    fn half_order_relaxation_has_no_zero_on_the_main_sheet() {
        assert!(upper_zeros(&terms(&[(1.0, 0.0), (1.0, 0.5)])).is_empty());
    }
}
