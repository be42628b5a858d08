//! Recursive estimators of a model linear in its parameters, y = φᵀθ, and a monitor that detects misfit.

mod covariance;
mod error;
mod monitor;
mod nlms;
mod rls;

pub use error::SampleError;
pub use monitor::{FitMonitor, Misfit, MonitorSettings};
pub use nlms::{Nlms, NlmsSettings};
pub use rls::{Residual, Rls, RlsSettings, Unexcited};

use crate::ParameterError;
use crate::real::Real;

/// Σ aᵢ bᵢ.
#[inline(always)]
fn dot<T: Real, const N: usize>(a: &[T; N], b: &[T; N]) -> T {
    a.iter().zip(b).fold(T::of(0.0), |sum, (&a, &b)| sum + a * b)
}

#[inline(always)]
fn all_finite<T: Real>(numbers: &[T]) -> bool {
    numbers.iter().all(|number| number.is_finite())
}

/// `value` clamped to the bounds.
#[inline(always)]
fn clamp<T: Real>(value: T, (low, high): (T, T)) -> T {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}

/// Start values, their deviations and their bounds, common to the estimators.
fn check<T: Real, const N: usize>(
    start: &[T; N],
    deviations: &[T; N],
    bounds: Option<&[(T, T); N]>,
) -> Result<(), ParameterError<T>> {
    let zero = T::of(0.0);
    let error = |name, index, value, must| Err(ParameterError::Parameter { name, index, value, must });
    for (index, (&value, &deviation)) in start.iter().zip(deviations).enumerate() {
        if !value.is_finite() {
            return error("the start value", index, value, "finite");
        }
        let variance = deviation * deviation;
        if !(deviation > zero && variance > zero && variance.is_finite()) {
            return error("the deviation", index, deviation, "positive and finite, its square too");
        }
    }
    for (index, (&value, &(low, high))) in start.iter().zip(bounds.into_iter().flatten()).enumerate() {
        if !(low <= value && value <= high) {
            return error("the start value", index, value, "between its bounds");
        }
    }
    Ok(())
}
