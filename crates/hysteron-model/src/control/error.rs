//! Errors of a closed loop.

use hysteron_rt::ModelError;

use crate::dynamics::DynamicsError;
use crate::hysteresis::HysteresisError;
use crate::invert::InversionError;
use crate::realise::RealiseError;
use crate::record::Unit;
use hysteron_numeric::Stopped;
use hysteron_numeric::display::{exact, short};

/// Error of a [`Stage`](super::Stage), in the words of what drives it.
pub type StageError = Box<dyn std::error::Error + Send + Sync>;

/// Error of building or running a closed loop.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ControlError {
    /// The computation was stopped by its listener.
    #[error("it was stopped")]
    Stopped,
    /// The model cannot be realised.
    #[error(transparent)]
    Realise(#[from] RealiseError),
    /// Error of the stage.
    #[error(transparent)]
    Stage(#[from] StageError),
    /// The inverse, or a reference that does not begin where the stage can rest.
    #[error(transparent)]
    Inversion(#[from] InversionError),
    /// Error of the hysteresis.
    #[error(transparent)]
    Hysteresis(#[from] HysteresisError),
    /// Error of a controller.
    #[error(transparent)]
    Runtime(#[from] ModelError<f64>),
    /// The sine is too slow to be played.
    #[error(
        "a sine of {} Hz is too long to be played: the lowest at this sample rate has {} Hz",
        short(*frequency_hz),
        short(*lowest_hz)
    )]
    Sine {
        /// Its frequency \[Hz\].
        frequency_hz: f64,
        /// The lowest \[Hz\].
        lowest_hz: f64,
    },
    /// The reference is too short or not finite.
    #[error("a reference needs at least 2 samples, all of them finite")]
    Reference,
    /// A number of the feedback is out of range.
    #[error("{name} is out of range: {value}", value = exact(*.value))]
    Number {
        /// Its name, with its unit where it has one.
        name: &'static str,
        /// The value given.
        value: f64,
    },
    /// No gain of the feedback keeps the margins.
    #[error("no gain of the feedback keeps the margins asked for")]
    NoGain,
    /// The model has no resonance for a notch.
    #[error("the model has no resonance below half the sample rate, so a notch has no effect")]
    NoResonance,
    /// The poles of the feedback are invalid.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// A reference without a sample rate.
    #[error("the reference has no uniform sample rate, which sets the controller's")]
    NoSampleRate,
    /// The drive has no range.
    #[error("the model file does not say which voltages it was identified with")]
    NoRange,
    /// Too few samples are scored.
    #[error(
        "nothing is left to score: the reference has {samples} samples, {skipped} at its beginning are \
         skipped and {ahead} at its end lack preview"
    )]
    NothingScored {
        /// Samples of the reference.
        samples: usize,
        /// Skipped at its beginning.
        skipped: usize,
        /// Skipped at its end.
        ahead: usize,
    },
    /// Sines that the controller's rate does not allow.
    #[error("the sines must lie above 0 and below half the sample rate, {} Hz", short(*half_rate_hz))]
    Sines {
        /// Half the sample rate \[Hz\].
        half_rate_hz: f64,
    },
    /// Sines that are too slow.
    #[error(
        "the sines begin at {} Hz, with a period of a million samples or more; the lowest that is played is \
         {} Hz",
        short(*begin_hz),
        short(*lowest_hz)
    )]
    SlowSines {
        /// Where they begin \[Hz\].
        begin_hz: f64,
        /// The lowest possible \[Hz\].
        lowest_hz: f64,
    },
}

impl ControlError {
    /// The message with the units of the drive and the output.
    pub fn in_units(&self, input: &Unit, output: &Unit) -> String {
        match self {
            Self::Inversion(error) => error.in_units(input, output),
            error => error.to_string(),
        }
    }
}

impl From<Stopped> for ControlError {
    fn from(_: Stopped) -> Self {
        Self::Stopped
    }
}
