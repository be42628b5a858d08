//! What can be wrong with a frequency response or its identification.

use hysteron_model::Advice;
use hysteron_model::dynamics::DynamicsError;
use hysteron_model::record::RecordError;
use hysteron_optimize::OptimizeError;

/// Error of [`crate::frequency_response`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FrequencyResponseError {
    /// Too few points for the parameters.
    #[error(
        "{found} points of `{name}` between {low_hz} and {high_hz} Hz; {structure} with {parameters} parameters needs at least {need}: take a wider band or a simpler structure"
    )]
    TooFewPoints {
        /// The response.
        name: String,
        /// Lower end of the band \[Hz\].
        low_hz: f64,
        /// Upper end \[Hz\].
        high_hz: f64,
        /// The structure.
        structure: String,
        /// Its parameters.
        parameters: usize,
        /// Points needed.
        need: usize,
        /// Points there are.
        found: usize,
    },
    /// A structure outside of what is fitted.
    #[error("{what} is {found}; allowed is {allowed}")]
    Structure {
        /// What of the structure.
        what: &'static str,
        /// Found.
        found: usize,
        /// Allowed range.
        allowed: &'static str,
    },
    /// No start could be evaluated.
    #[error("no start for {structure} could be evaluated on `{name}`")]
    NoStart {
        /// The structure.
        structure: String,
        /// The response.
        name: String,
    },
    /// Linear equations without a solution.
    #[error(
        "the response at {points} frequencies does not determine the {coefficients} coefficients of the transfer function"
    )]
    Undetermined {
        /// Number of frequencies.
        points: usize,
        /// Coefficients wanted.
        coefficients: usize,
    },
    /// Records that no empirical response can be taken from.
    #[error("cannot take a frequency response from `{record}`: {problem}")]
    Records {
        /// The record.
        record: String,
        /// What is wrong and what to do.
        problem: String,
        /// Remedy, typed.
        advice: Option<Advice>,
    },
    /// A structure that no model file can hold.
    #[error("{structure} is no transfer function: {problem}")]
    NoTransferFunction {
        /// The structure.
        structure: String,
        /// Why.
        problem: String,
    },
    /// From the record, or the response.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// From the transfer function.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// From the optimiser.
    #[error(transparent)]
    Optimize(#[from] OptimizeError),
}

impl FrequencyResponseError {
    /// Remedy, where there is one that the user can choose.
    pub fn advice(&self) -> Option<Advice> {
        match self {
            Self::Records { advice, .. } => advice.clone(),
            Self::Record(e) => e.advice(),
            _ => None,
        }
    }
}
