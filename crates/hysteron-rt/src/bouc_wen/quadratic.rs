//! n = 2: dw/d|u| = a − κ w², w = |z| ≥ 0: w = (w₀ + aT)/(1 + κ w₀ T), T = tanh(√(aκ) h)/√(aκ).

use super::{Leg, StepError};
use crate::real::{Real, Scalar};
use crate::series::{Tangent, inverse_tangent, tangent};

/// Moves w ≥ 0 by the distance h ≥ 0, or to 0 if that comes first.
///
/// # Errors
/// [`StepError::BlowUp`] where w becomes infinite within h (κ < 0).
#[inline]
pub(super) fn leg<S: Scalar>(a: S, kappa: S, w: S, h: S) -> Result<Leg<S>, StepError<S::Real>> {
    let zero = S::Real::of(0.0);
    let one = S::Real::of(1.0);
    let mut top = S::constant(zero);
    let mut bottom = S::constant(zero);
    match tangent(a, kappa, h) {
        Tangent::Finite(t) if !t.value().is_finite() => return Err(StepError::Overflow),
        Tangent::Finite(t) => {
            top = w + a * t;
            bottom = (kappa * w * t).shift(one);
            if bottom.value() > zero && (top.value() >= zero || w.value() <= zero) {
                return Ok(Leg::End(top / bottom));
            }
        }
        Tangent::PastPole if a.value() < zero => bottom = S::constant(one),
        Tangent::PastPole => top = S::constant(one),
    }
    // Either w came down to 0 or went up to infinity; where rounding says both, the slope decides.
    let slope = a.value() - kappa.value() * w.value() * w.value();
    if bottom.value() <= zero && (top.value() > zero || slope > zero) {
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
