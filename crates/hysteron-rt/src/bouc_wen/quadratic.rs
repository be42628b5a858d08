//! n = 2: dw/d|u| = a − κ w², w = |z| ≥ 0: w = (w₀ + aT)/(1 + κ w₀ T), T = tanh(√(aκ) h)/√(aκ).

use super::{Leg, StepError};
use crate::real::{Real, Scalar};
use crate::series::{Tangent, inverse_tangent, tangent};

/// w(h) − w without the cancellation of a difference, T (a − κ w²)/(1 + κ w T); `None` where w comes to 0 or
/// becomes infinite within h.
#[inline]
pub(super) fn change<S: Scalar>(a: S, kappa: S, w: S, h: S) -> Option<S> {
    let zero = S::Real::of(0.0);
    let Tangent::Finite(t) = tangent(a, kappa, h) else { return None };
    let below = (kappa * w * t).shift(S::Real::of(1.0));
    let change = t * (a - kappa * w * w) / below;
    let stays = w.value() + change.value() >= zero || w.value() <= zero;
    (below.value() > zero && stays && change.value().is_finite()).then_some(change)
}

/// Moves w ≥ 0 by the distance h ≥ 0, or to 0 if that comes first.
///
/// # Errors
/// [`StepError::BlowUp`] where w becomes infinite within h (κ < 0).
#[inline]
pub(super) fn leg<S: Scalar>(a: S, kappa: S, w: S, h: S) -> Result<Leg<S>, StepError<S::Real>> {
    match change(a, kappa, w, h) {
        Some(change) => Ok(Leg::End(w + change)),
        None => leg_to_the_end_of_a_branch(a, kappa, w, h),
    }
}

/// [`leg`] where w comes to 0 or has no bound.
#[inline(never)]
fn leg_to_the_end_of_a_branch<S: Scalar>(a: S, kappa: S, w: S, h: S) -> Result<Leg<S>, StepError<S::Real>> {
    let [zero, one] = [0.0, 1.0].map(S::Real::of);
    let (top, bottom) = match tangent(a.value(), kappa.value(), h.value()) {
        Tangent::Finite(t) if !t.is_finite() => return Err(StepError::Overflow),
        Tangent::Finite(t) => (w.value() + a.value() * t, one + kappa.value() * w.value() * t),
        Tangent::PastPole if a.value() < zero => (zero, one),
        Tangent::PastPole => (one, zero),
    };
    // Either w came down to 0 or went up to infinity; where rounding says both, the slope decides.
    let slope = a.value() - kappa.value() * w.value() * w.value();
    if bottom <= zero && (top > zero || slope > zero) {
        return Err(StepError::BlowUp { after: blow_up_distance(a.value(), kappa.value(), w.value()) });
    }
    if slope == zero {
        return Ok(Leg::End(w));
    }
    Ok(Leg::Zero { rest: h - inverse_tangent(a, kappa, -(w / a)) })
}

/// Distance to the pole: 1 + κ w T = 0.
fn blow_up_distance<T: Real>(a: T, kappa: T, w: T) -> T {
    let zero = T::of(0.0);
    if w > zero {
        inverse_tangent(a, kappa, T::of(-1.0) / (kappa * w))
    } else {
        T::of(core::f64::consts::FRAC_PI_2) / (a.abs().sqrt() * kappa.abs().sqrt())
    }
}
