//! What can stand in the way of a loop.

use hysteron_rt::ModelError;

use super::TuningError;
use crate::compensator::CompensatorError;
use crate::hysteresis::HysteresisError;
use crate::invert::InversionError;
use crate::realise::RealiseError;
use hysteron_numeric::display::short;

/// Error of a [`Stage`](super::Stage), in the words of what drives it.
pub type StageError = Box<dyn std::error::Error + Send + Sync>;

/// Why a loop was not made, or not played.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ControlError {
    /// The inverse.
    #[error(transparent)]
    Compensator(#[from] CompensatorError),
    /// The feedback.
    #[error(transparent)]
    Tuning(#[from] TuningError),
    /// The model does not run sample by sample.
    #[error(transparent)]
    Realise(#[from] RealiseError),
    /// The stage.
    #[error(transparent)]
    Stage(#[from] StageError),
    /// The reference does not begin where the stage can rest.
    #[error(transparent)]
    Begins(#[from] InversionError),
    /// The hysteresis refuses.
    #[error(transparent)]
    Hysteresis(#[from] HysteresisError),
    /// A controller refuses.
    #[error(transparent)]
    Runtime(#[from] ModelError<f64>),
    /// A sine so slow that its samples would not fit.
    #[error("a sine of {} Hz is too long to be played: the lowest at this sample rate has {} Hz", short(*frequency_hz), short(*lowest_hz))]
    Sine {
        /// Its frequency \[Hz\].
        frequency_hz: f64,
        /// The lowest \[Hz\].
        lowest_hz: f64,
    },
    /// There is nothing to follow.
    #[error("a reference needs at least 2 samples, all of them finite")]
    Reference,
}
