//! Inverse of a model of several axes: the drives of all actuators that make all axes follow references.
//!
//! Decoupling is part of it: the inverse of the matrix of responses moves every actuator for every axis. The
//! references known as a whole, [`decouple`] and [`decouple_branches`] compute held drives in the sense of
//! [`crate::invert`]; sample by sample, with a preview or without, a [`DecouplingLaw`] does, run by a
//! [`DecouplingController`].
//!
//! [`decouple`] takes [`crate::axes::ScheduledModes`]. The hysteresis is in feedback with the modes and cannot be inverted
//! in one step: it counts as a disturbance d(u) = y(u) − P u of the linear response P, which depends on the
//! drive u, and u = W (r − d(u)) is iterated, W the regularised inverse of P
//! ([`SimulationPlan::inverse_matrix`]). A round contracts the error by about the share of the hysteresis in
//! the motion. Drives are limited in every round, actuator by actuator.
//!
//! [`decouple_branches`] takes a [`CoupledHammerstein`]: W gives the outputs v of all hystereses, each is
//! inverted exactly by itself. Of a diagonal model it is the inverse of each axis.
//!
//! [`track_axes`] compares controllers on a stage.
//!
//! [`CoupledHammerstein`]: crate::axes::CoupledHammerstein
//! [`SimulationPlan::inverse_matrix`]: crate::dynamics::SimulationPlan::inverse_matrix

mod branches;
mod controller;
mod error;
mod law;
mod linear;
mod modes;
mod stage;
#[cfg(test)]
mod tests;
mod tracking;

pub use branches::decouple_branches;
pub use controller::DecouplingController;
pub use error::DecouplingError;
pub use law::{DecouplingLaw, LawOptions};
pub use modes::decouple;
pub use stage::{AxesStage, AxesStageRun};
pub use tracking::{
    AxesController, AxesControllerRun, AxesTrackOptions, AxesTracking, CrossCoupling, track_axes,
};

use crate::axes::{ScheduledModes, level};
use crate::compensator::Limits;
use crate::invert::ERROR_AT_BANDWIDTH;

/// Options of the inverse of several axes, the references known.
#[derive(Clone, Debug, PartialEq)]
pub struct DecouplingOptions {
    /// Tracking bandwidth \[Hz\]; `None`: [`own_bandwidth`], for branches
    /// [`crate::invert::BANDWIDTH_SHARE`] of the sample rate.
    pub bandwidth_hz: Option<f64>,
    /// Relative error there.
    pub error_at_bandwidth: f64,
    /// Limits of every actuator.
    pub limits: Vec<Limits>,
    /// The references are one period of a periodic motion: the drives are those of its steady state.
    pub periodic: bool,
    /// Level of the drive \[V rms\] before the references begin, for modes that move with it; `None`: that of
    /// the drives themselves.
    pub level: Option<f64>,
}

impl DecouplingOptions {
    /// Default options within these limits.
    pub fn within(limits: Vec<Limits>) -> Self {
        Self {
            bandwidth_hz: None,
            error_at_bandwidth: ERROR_AT_BANDWIDTH,
            limits,
            periodic: false,
            level: None,
        }
    }
}

/// Drives of all actuators, and the model's response to them.
#[derive(Clone, Debug, PartialEq)]
pub struct AxesDrive {
    /// Held drives \[V\], one list per actuator.
    pub drive: Vec<Vec<f64>>,
    /// Outputs of the model for them \[µm\], one list per axis.
    pub predicted: Vec<Vec<f64>>,
    /// Voltages at rest before the first sample; `None` where the references repeat.
    pub rest: Option<Vec<f64>>,
    /// Level of the drive before the first sample \[V rms\].
    pub level: f64,
    /// Samples limited by the range, of every actuator.
    pub at_range: Vec<usize>,
    /// Samples limited by the slew rate, of every actuator.
    pub at_slew: Vec<usize>,
    /// Rounds of the iteration; 1 where the inverse is exact in one.
    pub rounds: usize,
    /// Bandwidth \[Hz\].
    pub bandwidth_hz: f64,
    /// Relative rms error of the linear response of the model at this rate; 0 where it is exact.
    pub rate_error: f64,
}

impl AxesDrive {
    /// rms of reference less prediction, of every axis \[µm\].
    pub fn rms_errors(&self, references: &[Vec<f64>]) -> Vec<f64> {
        let rms = |(r, y): (&Vec<f64>, &Vec<f64>)| {
            let sum: f64 = r.iter().zip(y).map(|(r, y)| (r - y).powi(2)).sum();
            (sum / r.len().max(1) as f64).sqrt()
        };
        references.iter().zip(&self.predicted).map(rms).collect()
    }
}

/// Tracking bandwidth of modes without another one \[Hz\]: [`crate::invert::BANDWIDTH_SHARE`] of the sample rate,
/// or of the rate of the model's steps where that is lower. What the model does above is not known.
pub fn own_bandwidth(model: &ScheduledModes, sample_rate_hz: f64) -> f64 {
    crate::invert::BANDWIDTH_SHARE * sample_rate_hz.min(model.step_rate_hz())
}

/// Level of drives, rms about their means.
pub(crate) fn level_of(drives: &[Vec<f64>]) -> f64 {
    let samples = drives.first().map_or(0, Vec::len);
    let rows: Vec<f64> = (0..samples).flat_map(|k| drives.iter().map(move |u| u[k])).collect();
    level(&rows, drives.len())
}

/// Checks references and limits against the numbers of inputs and outputs of a model.
fn check(
    references: &[Vec<f64>],
    limits: &[Limits],
    (inputs, outputs): (usize, usize),
) -> Result<(), DecouplingError> {
    if references.len() != outputs {
        return Err(DecouplingError::References { outputs, references: references.len() });
    }
    check_limits(limits, inputs)?;
    let samples = references.first().map_or(0, Vec::len);
    for (m, reference) in references.iter().enumerate() {
        if reference.len() < 2 || reference.len() != samples {
            return Err(DecouplingError::Samples { axis: m + 1, samples: reference.len() });
        }
        if let Some(index) = reference.iter().position(|r| !r.is_finite()) {
            return Err(DecouplingError::NotFinite { axis: m + 1, index });
        }
    }
    if inputs < outputs {
        return Err(DecouplingError::TooFewActuators { inputs, outputs });
    }
    Ok(())
}

fn check_limits(limits: &[Limits], inputs: usize) -> Result<(), DecouplingError> {
    if limits.len() != inputs {
        return Err(DecouplingError::Limits { inputs, limits: limits.len() });
    }
    for limit in limits {
        if !(limit.low < limit.high && (limit.high - limit.low).is_finite()) {
            let (low, high) = (limit.low, limit.high);
            return Err(crate::hysteresis::HysteresisError::Range { low, high }.into());
        }
        if limit.slew_v_per_s.is_nan() || limit.slew_v_per_s <= 0.0 {
            return Err(crate::hysteresis::HysteresisError::Step { step: limit.slew_v_per_s }.into());
        }
    }
    Ok(())
}

/// The voltage nearest to `wanted` within range and slew of one actuator, and the active limit.
fn limited(wanted: f64, last: f64, limits: &Limits, sample_rate_hz: f64) -> (f64, hysteron_rt::Limited) {
    use hysteron_rt::Limited;
    // The last drive where the model has left the range of numbers.
    let wanted = if wanted.is_finite() { wanted } else { last };
    let ranged = wanted.clamp(limits.low, limits.high);
    let step = limits.slew_v_per_s / sample_rate_hz;
    let slewed = ranged.clamp(last - step, last + step);
    let by = if slewed != ranged {
        Limited::Step
    } else if ranged != wanted {
        Limited::Range
    } else {
        Limited::No
    };
    (slewed, by)
}
