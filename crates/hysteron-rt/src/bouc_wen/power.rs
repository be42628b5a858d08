//! Any n ≥ 1: dw/dh = a − κ wⁿ, w = |z| ≥ 0, by Taylor series in h with the sub-step chosen from the last
//! terms, and by the series of the inverse function h(w) next to w = 0, where wⁿ is not smooth.
//!
//! Taylor coefficients of wⁿ by J. C. P. Miller's recurrence (E. Hairer, S. P. Nørsett, G. Wanner, *Solving
//! Ordinary Differential Equations I*, 2nd ed. 1993, §I.8, doi:10.1007/978-3-540-78862-1); sub-step from the
//! last two terms as in À. Jorba, M. Zou, *Exp. Math.* 14 (2005) 99–117, doi:10.1080/10586458.2005.10128904.

use super::{Leg, StepError};
use crate::real::{Real, Scalar};
use crate::series::{absolute, reciprocal};

/// Degree of the Taylor polynomial.
const DEGREE: usize = 16;
/// Sub-steps allowed within one step; a step between neighbouring samples takes one.
pub(super) const SUB_STEPS: u16 = 2000;

/// Moves w ≥ 0 by the distance h ≥ 0, or to 0 if that comes first.
///
/// Tolerance: the last two Taylor terms of a sub-step add up to at most half a unit in the last place of w.
///
/// # Errors
/// [`StepError::BlowUp`] where w becomes infinite within h (κ < 0), [`StepError::Overflow`] where it leaves
/// the range of the number type, [`StepError::SubSteps`] where [`SUB_STEPS`] do not suffice.
pub(super) fn leg<S: Scalar>(a: S, kappa: S, n: S, w: S, h: S) -> Result<Leg<S>, StepError<S::Real>> {
    let of = S::Real::of;
    let zero = of(0.0);
    let epsilon = S::Real::EPSILON;
    let size_a = a.value().abs();
    let (mut w, mut left) = (w, h);
    for _ in 0..SUB_STEPS {
        if w.value() <= zero && a.value() <= zero {
            return Ok(Leg::End(w));
        }
        // At w = 0 the derivatives of w shift the start by w/a.
        let (p, elapsed) =
            if w.value() > zero { (w.powf(n), None) } else { (S::constant(zero), Some(w / a)) };
        let pull = kappa * p;
        let slope = a - pull;
        if !slope.value().is_finite() {
            return Err(StepError::Overflow);
        }
        let noise = epsilon * (n.value() + of(4.0));
        if slope.magnitude() <= noise * (size_a + pull.magnitude()) {
            return Ok(Leg::End(w));
        }
        let small_change = w.value() > zero && (slope.value() * left.value()).abs() <= of(0.25) * w.value();
        if !small_change && pull.value().abs() <= of(0.5) * size_a {
            let origin = Origin::new(a, kappa, n);
            let start = elapsed.unwrap_or_else(|| origin.distance(w, p));
            if a.value() < zero {
                let rest = left - start;
                return Ok(if rest.value() >= zero {
                    Leg::Zero { rest }
                } else {
                    Leg::End(origin.solve(-rest, w.value()))
                });
            }
            let end = start + left;
            let furthest = origin.furthest();
            if end.value() <= furthest {
                return Ok(Leg::End(origin.solve(end, origin.b.value() * end.value())));
            }
            if furthest > of(1.1) * start.value() {
                let stop = S::constant(furthest);
                w = origin.solve(stop, origin.b.value() * furthest);
                left = end - stop;
                continue;
            }
        }
        let (next, fraction) = taylor(a, kappa, n, w, p, left);
        if fraction >= of(1.0) {
            return Ok(Leg::End(next));
        }
        let advance = fraction * left.value();
        if kappa.value() < zero && slope.value() > zero && advance <= epsilon * h.value() {
            return Err(StepError::BlowUp { after: (h - left).value() });
        }
        w = next;
        left = left.scale(of(1.0) - fraction);
    }
    Err(StepError::SubSteps { limit: SUB_STEPS })
}

/// The solution through w = 0 at h = 0: dw/dh = b − k wⁿ with b > 0, for |k wⁿ| ≤ b/2.
struct Origin<S> {
    b: S,
    k: S,
    n: S,
}

impl<S: Scalar> Origin<S> {
    /// A leg towards 0 (a < 0) is one away from it, traversed backwards.
    fn new(a: S, kappa: S, n: S) -> Self {
        let away = a.value() > S::Real::of(0.0);
        Origin { b: absolute(a), k: if away { kappa } else { -kappa }, n }
    }

    /// h(w) = ∫₀ʷ dω/(b − k ωⁿ) = (w/b) Σ yᵏ/(1 + nk), y = k wⁿ/b; `p` = wⁿ.
    fn distance(&self, w: S, p: S) -> S {
        let y = self.k * p / self.b;
        let one = S::constant(S::Real::of(1.0));
        let (mut power, mut sum, mut divisor) = (one, one, one);
        // |y| ≤ ½: 64 terms reach the last place of f64 with its derivatives.
        for _ in 0..64 {
            power = power * y;
            divisor = divisor + self.n;
            sum = sum + power / divisor;
            if power.magnitude() <= S::Real::of(0.25) * S::Real::EPSILON {
                break;
            }
        }
        w / self.b * sum
    }

    /// w(h) by Newton's iteration on [`Self::distance`], from the right side (no overshoot) because it starts
    /// at b h, or at `cap` where w is known to be below that.
    fn solve(&self, h: S, cap: S::Real) -> S {
        let of = S::Real::of;
        let start = self.b * h;
        if start.value() <= of(0.0) {
            return start;
        }
        let mut w = if start.value() > cap { S::constant(cap) } else { start };
        let mut settled = false;
        for _ in 0..16 {
            let p = w.powf(self.n);
            let correction = (self.distance(w, p) - h) * (self.b - self.k * p);
            w = w - correction;
            // One more iteration after the value has converged: the derivatives lag by one.
            if settled {
                break;
            }
            settled = correction.magnitude() <= of(1e-6) * w.value();
        }
        w
    }

    /// A distance within which |k wⁿ| stays below b/4.
    fn furthest(&self) -> S::Real {
        let of = S::Real::of;
        let b = self.b.value();
        let top = (b / (of(4.0) * self.k.value().abs())).powf(of(1.0) / self.n.value());
        top / (of(1.5) * b)
    }
}

/// One Taylor sub-step from w > 0, `p` = wⁿ, over the largest fraction 2⁻ᵐ of `h` that meets the tolerance
/// and keeps w > 0: (w, fraction); fraction 0 where there is none.
///
/// With w(θh) = w Σ x_k θᵏ and wⁿ(θh) = p Σ q_k θᵏ: x₁ = (a − κp) h/w, x_{k+1} = −(κ p h/w) q_k/(k + 1),
/// q_k = (1/k) Σ_{j=1…k} (n j − k + j) x_j q_{k−j}.
fn taylor<S: Scalar>(a: S, kappa: S, n: S, w: S, p: S, h: S) -> (S, S::Real) {
    let of = S::Real::of;
    let tolerance = of(0.5) * S::Real::EPSILON;
    let per_w = h / w;
    let pull = kappa * p * per_w;
    let null = S::constant(of(0.0));
    // x[k − 1] holds x_k; q[k] holds q_k.
    let mut x = [null; DEGREE];
    let mut q = [null; DEGREE];
    let mut term = a * per_w - pull;
    let mut q_k = S::constant(of(1.0));
    let (mut last, mut before) = (term.magnitude(), of(1.0));
    let mut k = 0_u8;
    for index in 0..DEGREE {
        if let (Some(x_slot), Some(q_slot)) = (x.get_mut(index), q.get_mut(index)) {
            *x_slot = term;
            *q_slot = q_k;
        }
        last = term.magnitude();
        if last + before <= tolerance {
            break;
        }
        if index + 1 == DEGREE {
            break;
        }
        before = last;
        k += 1;
        let order = of(f64::from(k));
        let mut sum = null;
        let mut j = of(0.0);
        for (&x_j, &q_rest) in x.iter().take(index + 1).zip(q.iter().take(index + 1).rev()) {
            j = j + of(1.0);
            sum = sum + n.scale(j).shift(j - order) * (x_j * q_rest);
        }
        q_k = sum * reciprocal::<S>(k);
        term = -(pull * q_k) * reciprocal::<S>(k + 1);
    }
    let shrink_last = of(1.0 / 65536.0);
    let shrink_before = of(1.0 / 32768.0);
    let mut fraction = of(1.0);
    for _ in 0..64 {
        if last + before <= tolerance {
            let change = x.iter().rev().fold(null, |sum, &x_k| (sum + x_k).scale(fraction));
            let next = w + w * change;
            if next.value() > of(0.0) {
                return (next, fraction);
            }
        }
        fraction = of(0.5) * fraction;
        last = last * shrink_last;
        before = before * shrink_before;
    }
    (w, of(0.0))
}
