//! Errors of inverting a model for a reference.

use crate::dynamics::DynamicsError;
use crate::hammerstein::SimulationError;
use crate::hysteresis::{HysteresisError, Invertibility};
use crate::misfit::NotCorrected;
use crate::realise::RealiseError;
use crate::record::Unit;
use hysteron_numeric::Stopped;
use hysteron_numeric::display::{exact, short};

/// Error of an inversion.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InversionError {
    /// Fewer than two samples.
    #[error("the reference has {samples} samples: at least 2 are needed")]
    TooShort {
        /// Samples of the reference.
        samples: usize,
    },
    /// A sample of the reference is not finite.
    #[error("sample {index} (from 0) of the reference is not finite")]
    NotFinite {
        /// Number of the sample.
        index: usize,
    },
    /// The last run does not match this reference.
    #[error(
        "the last run has {drive} samples of its drive and {measured} of its output, the reference has \
         {samples}: all must be the same and the drive within the range"
    )]
    LastRun {
        /// Samples of the drive.
        drive: usize,
        /// Samples of the output.
        measured: usize,
        /// Samples of the reference.
        samples: usize,
    },
    /// No range was given, and the model was identified in none.
    #[error("the model does not say which drive it was identified with: give the range of the drive")]
    RangeUnknown,
    /// A last run was given to a law that works sample by sample.
    #[error("a drive that learns from its last run is computed with the whole reference known ahead")]
    LearnedBySample,
    /// No voltage gives the first value of the reference.
    #[error(
        "the reference begins at {}, which no input from {} to {} holds: at rest these give {} to {}; begin \
         the reference between them, or give the input at which the device rests",
        short(*reference),
        short(*low),
        short(*high),
        short(*from),
        short(*to)
    )]
    Begins {
        /// First value of the reference \[µm\].
        reference: f64,
        /// Least voltage \[V\].
        low: f64,
        /// Largest voltage \[V\].
        high: f64,
        /// Output at rest at the least voltage \[µm\].
        from: f64,
        /// Output at rest at the largest voltage \[µm\].
        to: f64,
    },
    /// The drive was to be corrected by the model's misfit.
    #[error("the drive is not corrected by the predicted misfit of the model: {0}")]
    NotCorrected(#[from] NotCorrected),
    /// The computation was stopped by its listener.
    #[error("it was stopped")]
    Stopped,
    /// No voltage gives the first value of the reference, and the output falls somewhere in the range.
    #[error(
        "the hysteresis has no inverse over the range from {} to {}: near the input {} its output at rest \
         falls as the input rises; give a smaller range",
        short(*low),
        short(*high),
        short(*near)
    )]
    Falls {
        /// Least voltage \[V\].
        low: f64,
        /// Largest voltage \[V\].
        high: f64,
        /// Where the output falls \[V\].
        near: f64,
    },
    /// A periodic reference was to be followed one sample at a time.
    #[error(
        "a reference that repeats is followed as a whole: one sample at a time it has no steady state to \
         begin in"
    )]
    Repeats,
    /// The reference is not a whole number of the periods it is said to repeat with.
    #[error("the reference has {samples} samples: not a whole number of periods of {period_samples} samples")]
    Period {
        /// Samples of the reference.
        samples: usize,
        /// Samples of the period.
        period_samples: usize,
    },
    /// A hysteretic displacement was given where the voltage at which the device was virgin is needed.
    #[error(
        "one sample at a time the device begins where it was virgin: give that input, not its hysteretic \
         displacement"
    )]
    Displacement,
    /// The model cannot be realised, or not from where the device rests.
    #[error(transparent)]
    Realise(#[from] RealiseError),
    /// The model cannot be run at this rate.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The dynamics have no inverse.
    #[error("the dynamics cannot be inverted: {0}")]
    Dynamics(#[from] DynamicsError),
    /// The hysteresis has no inverse.
    #[error("the hysteresis cannot be inverted: {0}")]
    Hysteresis(HysteresisError),
    /// An option of a compensator is out of range.
    #[error("{name} must be {allowed}, but it is {value}", value = exact(*.value))]
    Option {
        /// Its name, with its unit where it has one.
        name: &'static str,
        /// The value given.
        value: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    /// The hysteresis has no inverse within the range.
    #[error("the hysteresis cannot be inverted: {0}")]
    NotInvertible(Invertibility),
    /// The static gain is 0 or negligible.
    #[error("the dynamics pass next to nothing at rest: no drive holds a displacement")]
    NoGain,
    /// The equations of the regulator have no solution in double precision.
    #[error("no stable regulator was found; ask for a lower bandwidth")]
    NoRegulator,
}

impl InversionError {
    /// The message with the units of the drive and the output.
    pub fn in_units(&self, input: &Unit, output: &Unit) -> String {
        let (input, output) = (input.spaced(), output.spaced());
        match self {
            Self::Hysteresis(HysteresisError::RestOutside { rest, low, high }) => format!(
                "the device rests at {}{input}, outside of the range of its drive, {}{input} to {}{input}",
                short(*rest),
                short(*low),
                short(*high)
            ),
            Self::Falls { low, high, near } => format!(
                "the hysteresis has no inverse over the range from {}{input} to {}{input}: near {}{input} its \
                 output at rest falls as the drive rises; give a smaller range",
                short(*low),
                short(*high),
                short(*near)
            ),
            Self::Begins { reference, low, high, from, to } => format!(
                "the reference begins at {}{output}, which no drive from {} to {}{input} holds: at rest these \
                 give {} to {}{output}",
                short(*reference),
                short(*low),
                short(*high),
                short(*from),
                short(*to)
            ),
            error => error.to_string(),
        }
    }
}

impl From<HysteresisError> for InversionError {
    fn from(error: HysteresisError) -> Self {
        match error {
            HysteresisError::Stopped => Self::Stopped,
            error => Self::Hysteresis(error),
        }
    }
}

impl From<Stopped> for InversionError {
    fn from(_: Stopped) -> Self {
        Self::Stopped
    }
}
