//! What can be wrong with a frequency response or its identification.

use crate::dynamics::DynamicsError;
use crate::optimize::OptimizeError;
use crate::record::RecordError;

/// Error of [`crate::frequency_response`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FrequencyResponseError {
    /// Lists of different lengths.
    #[error("frequency response `{name}`: {what} has {found} entries where there are {expected} frequencies")]
    Length {
        /// The response.
        name: String,
        /// Which list.
        what: &'static str,
        /// Entries found.
        found: usize,
        /// Number of frequencies.
        expected: usize,
    },
    /// A frequency that is not positive and finite, or not above the one before.
    #[error(
        "frequency response `{name}`, point {index}: frequency {value} Hz; frequencies must be positive, finite and strictly ascending"
    )]
    Frequency {
        /// The response.
        name: String,
        /// Point, from 1.
        index: usize,
        /// Frequency found \[Hz\].
        value: f64,
    },
    /// A value that is not finite, or zero where it has to be divided by.
    #[error("frequency response `{name}`, {frequency_hz} Hz: the value {found} is not {wanted}")]
    Value {
        /// The response.
        name: String,
        /// Frequency \[Hz\].
        frequency_hz: f64,
        /// Value found.
        found: String,
        /// What is wanted.
        wanted: &'static str,
    },
    /// A standard deviation that is not positive and finite.
    #[error(
        "frequency response `{name}`, {frequency_hz} Hz: the standard deviation is {found}; it must be positive and finite"
    )]
    Uncertainty {
        /// The response.
        name: String,
        /// Frequency \[Hz\].
        frequency_hz: f64,
        /// Standard deviation found.
        found: f64,
    },
    /// Two responses that do not share their frequencies.
    #[error("cannot divide frequency response `{over}` by `{under}`: they are not at the same frequencies")]
    OtherFrequencies {
        /// Numerator.
        over: String,
        /// Denominator.
        under: String,
    },
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
    },
    /// A structure that no model file can hold.
    #[error("{structure} is no transfer function: {problem}")]
    NoTransferFunction {
        /// The structure.
        structure: String,
        /// Why.
        problem: String,
    },
    /// From the record.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// From the transfer function.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// From the optimiser.
    #[error(transparent)]
    Optimize(#[from] OptimizeError),
}
