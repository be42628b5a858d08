//! Errors of a realisation.

use crate::dynamics::DynamicsError;
use crate::hammerstein::SimulationError;
use crate::hysteresis::HysteresisError;
use hysteron_numeric::display::exact;

/// Error of [`crate::realise`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RealiseError {
    /// An option is out of range.
    #[error("{name} must be {allowed}, but it is {value}", value = exact(*.value))]
    Option {
        /// Its name, with its unit where it has one.
        name: &'static str,
        /// The value given.
        value: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    /// The model's parameters belong to one sample rate.
    #[error(
        "the model ({scheme}) belongs to {model_hz} Hz, the rate it was identified at, and cannot run at \
         {rate_hz} Hz",
        model_hz = exact(*.model_hz),
        rate_hz = exact(*.rate_hz)
    )]
    SampleRate {
        /// Scheme that ties the model to its rate, or `ARX`.
        scheme: &'static str,
        /// Rate of the model \[Hz\].
        model_hz: f64,
        /// Rate requested \[Hz\].
        rate_hz: f64,
    },
    /// The gain at zero frequency is infinite, or not reached within practical times: the lowest frequency of
    /// the realisation must be named.
    #[error(
        "the model creeps for ever (its gain at zero frequency is infinite, or not reached within practical \
         times): give the lowest frequency of the realisation"
    )]
    LowestFrequency,
    /// The dynamics are not stable.
    #[error(
        "the dynamics are not stable ({poles} poles in the right half-plane or on the imaginary axis) and \
         cannot run sample by sample"
    )]
    Unstable {
        /// Number of such poles; 0 where it is not known.
        poles: usize,
    },
    /// The accuracy is not reached.
    #[error(
        "the dynamics cannot be realised to {wanted:e} of the range: {poles} real poles beside those of the \
         model leave {reached:e}"
    )]
    Accuracy {
        /// Accuracy requested.
        wanted: f64,
        /// Accuracy reached.
        reached: f64,
        /// Real poles tried.
        poles: usize,
    },
    /// The delay has more whole samples than are kept.
    #[error(
        "a delay of {samples} samples is longer than the {most} that are kept",
        samples = exact(*.samples)
    )]
    Delay {
        /// Whole samples of delay.
        samples: f64,
        /// Most.
        most: usize,
    },
    /// Parameters valid in double precision are invalid in the number type requested.
    #[error("the model's numbers are out of range, or not in order any more, in the number type asked for")]
    Rounded,
    /// A step has no result.
    #[error(transparent)]
    Step(#[from] hysteron_rt::ModelError<f64>),
    /// The dynamic block is invalid.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// The hysteresis block is invalid, or has no result.
    #[error(transparent)]
    Hysteresis(#[from] HysteresisError),
    /// The model could not be simulated to check the realisation.
    #[error("the model could not be simulated to check its realisation: {0}")]
    Simulation(String),
}

impl From<SimulationError> for RealiseError {
    fn from(error: SimulationError) -> Self {
        Self::Simulation(error.to_string())
    }
}
