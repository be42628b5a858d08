//! Errors of a baseline.

use hysteron_numeric::display::{exact, short};

/// Error of [`crate::baselines`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BaselineError {
    /// Nothing to train on.
    #[error("there is no record to train on")]
    NoRecords,
    /// A record without uniform sample rate.
    #[error("{record} has no uniform sample rate: a NARX model has one sample interval")]
    NoSampleRate {
        /// Name of the record.
        record: String,
    },
    /// A record whose samples do not fit the lag interval.
    #[error(
        "{record} is sampled at {sample_rate_hz} Hz, and {interval_s} s between the lags of a NARX model is \
         no whole number of its samples: resample the records to one rate",
        sample_rate_hz = exact(*.sample_rate_hz),
        interval_s = exact(*.interval_s)
    )]
    Interval {
        /// Name of the record.
        record: String,
        /// Its sample rate \[Hz\].
        sample_rate_hz: f64,
        /// Time between lags \[s\].
        interval_s: f64,
    },
    /// A signal that is constant over all training records.
    #[error("the {signal} is constant in the training records")]
    Constant {
        /// `input` or `output`.
        signal: &'static str,
    },
    /// Fewer equations than the smallest model needs.
    #[error("only {found} samples to train on have a valid past, need at least {need}")]
    TooFewRows {
        /// Rows found.
        found: usize,
        /// Rows needed.
        need: usize,
    },
    /// A sample that is not finite.
    #[error("the {signal} of {record} is not finite at sample {index}")]
    NotFinite {
        /// `input` or `output`.
        signal: &'static str,
        /// Name of the record.
        record: String,
        /// Its number, from 0.
        index: usize,
    },
    /// Columns that do not determine a coefficient.
    #[error("the records do not determine the coefficients of the model: its regressors are collinear")]
    Dependent,
    /// No trained model has a stable simulation on the training records.
    #[error("every model of this kind fitted to these records diverges in simulation")]
    NoStableModel,
    /// A simulation that left ten times the range of the training outputs.
    #[error(
        "the simulation diverges: at {} s it is ten times as far from the middle as any training output",
        short(*time_s)
    )]
    Diverged {
        /// Time since the start of the record \[s\].
        time_s: f64,
    },
    /// The search for coefficients failed.
    #[error("the coefficients were not found: {because}")]
    Search {
        /// Reason.
        because: String,
    },
}
