//! The moments of a relaxation.

use crate::real::{Real, Scalar};

/// Most moments, and states.
pub const MOST_MOMENTS: usize = 10;
/// Beyond this x the recurrence upwards loses less than two digits over all moments.
const LARGE: f64 = 30.0;
/// Terms of the series at most; below [`LARGE`] a hundred are enough.
const TERMS: u8 = 200;

/// mₖ(x) = ∫₀¹ θᵏ e^(−x(1−θ)) dθ, x ≥ 0, for k < `count`.
///
/// e^(−x) Σᵢ xⁱ/(i! (i + k + 1)) has positive terms only; far out, mₖ = (1 − k mₖ₋₁)/x.
#[inline]
pub fn moments<S: Scalar>(x: S, count: usize) -> [S; MOST_MOMENTS] {
    let of = |x: f64| S::Real::of(x);
    let mut m = [S::constant(of(0.0)); MOST_MOMENTS];
    let decay = (-x).exp();
    if x.value() > of(LARGE) {
        let mut last = (-decay).shift(of(1.0)) / x;
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
    let mut term = S::constant(of(1.0));
    for i in 0..TERMS {
        for (m, k) in m.iter_mut().take(count).zip(1_u8..) {
            *m = *m + term.scale(of(1.0) / of(f64::from(i) + f64::from(k)));
        }
        term = term * x.scale(of(1.0) / of(f64::from(i) + 1.0));
        let sum = m.get(count.saturating_sub(1)).map_or(of(0.0), |m| m.value());
        if term.magnitude() <= of(0.0625) * S::Real::EPSILON * sum {
            break;
        }
    }
    for m in m.iter_mut().take(count) {
        *m = decay * *m;
    }
    m
}
