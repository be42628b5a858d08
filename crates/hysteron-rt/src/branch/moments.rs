//! The moments of a relaxation.

use crate::real::{Real, Scalar};

/// Maximum number of moments and of states.
pub const MOST_MOMENTS: usize = 10;
/// Beyond this x the forward recurrence loses less than two digits over all moments.
const LARGE: f64 = 30.0;
/// Terms of the series at most; below [`LARGE`] a hundred are enough.
const TERMS: u8 = 200;

/// mₖ(x) = ∫₀¹ θᵏ e^(−x(1−θ)) dθ, x ≥ 0, for k < `count`; their derivatives are mₖ₊₁ − mₖ.
///
/// e^(−x) Σᵢ xⁱ/(i! (i + k + 1)) has positive terms only; for large x, mₖ = (1 − k mₖ₋₁)/x.
#[inline]
pub(super) fn moments<S: Scalar>(x: S, count: usize) -> [S; MOST_MOMENTS] {
    let of = |x: f64| S::Real::of(x);
    let mut m = [S::constant(of(0.0)); MOST_MOMENTS];
    if x.value() > of(LARGE) {
        let mut last = (-(-x).exp()).shift(of(1.0)) / x;
        let mut power = of(0.0);
        for m in m.iter_mut().take(count) {
            if power > of(0.0) {
                last = (-(last.scale(power))).shift(of(1.0)) / x;
            }
            *m = last;
            power = power + of(1.0);
        }
        return m;
    }
    // One more gives the derivative of the last.
    let values = series(x.value(), count + usize::from(S::HAS_DERIVATIVES));
    for ((m, value), next) in m.iter_mut().zip(&values).zip(values.iter().skip(1)).take(count) {
        *m = x.chain(*value, *next - *value);
    }
    m
}

/// The moments by the series, for x at which it converges fast.
#[inline]
fn series<T: Real>(x: T, count: usize) -> [T; MOST_MOMENTS + 1] {
    let of = T::of;
    let mut m = [of(0.0); MOST_MOMENTS + 1];
    let mut term = of(1.0);
    for i in 0..TERMS {
        for (m, k) in m.iter_mut().take(count).zip(1_u8..) {
            *m = *m + term * (of(1.0) / of(f64::from(i) + f64::from(k)));
        }
        term = term * (x * (of(1.0) / of(f64::from(i) + 1.0)));
        let sum = m.get(count.saturating_sub(1)).copied().unwrap_or(of(0.0));
        if term <= of(0.0625) * T::EPSILON * sum {
            break;
        }
    }
    let decay = (-x).exp();
    for m in m.iter_mut().take(count) {
        *m = decay * *m;
    }
    m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::Dual;

    #[test]
    fn moments_by_quadrature_on_both_sides_of_the_seam() {
        for x in [0.0, 1e-9, 1e-3, 0.3, 1.0, 7.0, 29.999, 30.001, 80.0] {
            let got = moments::<f64>(x, MOST_MOMENTS);
            for (k, got) in got.iter().enumerate() {
                // Simpson's rule on 4000 intervals: (x + k)⁴/(2880 · 4000⁴).
                let f = |i: u32| {
                    let theta = f64::from(i) / 8000.0;
                    libm::pow(theta, k as f64) * libm::exp(-x * (1.0 - theta))
                };
                let want: f64 =
                    (0..4000).map(|i| (f(2 * i) + 4.0 * f(2 * i + 1) + f(2 * i + 2)) / 24000.0).sum();
                assert!(
                    (got - want).abs() < 1e-12 + 1e-10 * want * f64::from(x > 20.0),
                    "x {x} k {k}: {got} {want}"
                );
            }
        }
    }

    #[test]
    fn moments_in_single_precision() {
        for x in [0.0, 1e-3, 0.3, 7.0, 29.9, 30.1, 80.0] {
            let (double, single) = (moments(x, 10), moments(x as f32, 10));
            for (k, (a, b)) in double.iter().zip(single).enumerate() {
                // The forward recurrence loses up to two digits.
                let lost = if x > 30.0 { 100.0 } else { 8.0 };
                assert!(
                    (a - f64::from(b)).abs() < lost * f64::from(f32::EPSILON) * a,
                    "x {x} k {k}: {a} {b}"
                );
            }
        }
    }

    /// mₖ' = −∫₀¹ θᵏ (1 − θ) e^(−x(1−θ)) dθ; by Simpson's rule on 4000 intervals.
    #[test]
    fn derivatives_of_moments_by_quadrature_on_both_sides_of_the_seam() {
        for x in [0.0, 1e-9, 1e-3, 0.3, 1.0, 7.0, 29.999, 30.001, 80.0] {
            for (k, got) in moments(Dual::<f64, 1>::variable(x, 0), MOST_MOMENTS).iter().enumerate() {
                let f = |i: u32| {
                    let theta = f64::from(i) / 8000.0;
                    -libm::pow(theta, k as f64) * (1.0 - theta) * libm::exp(-x * (1.0 - theta))
                };
                let want: f64 =
                    (0..4000).map(|i| (f(2 * i) + 4.0 * f(2 * i + 1) + f(2 * i + 2)) / 24000.0).sum();
                let [derivative] = got.partials;
                assert!((derivative - want).abs() < 1e-12, "x {x} k {k}: {derivative} {want}");
                assert!((got.value - moments(x, MOST_MOMENTS)[k]).abs() < 1e-15, "x {x} k {k}");
            }
        }
    }
}
