//! What can be wrong with a correction while running.

use hysteron_rt::{ParameterError, SampleError};
use thiserror::Error;

use hysteron_model::hammerstein::SimulationError;
use hysteron_model::hysteresis::HysteresisError;
use hysteron_model::validate::ScoreError;

/// A correction that cannot be set up, run or written back.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CorrectionError {
    /// A term with a number out of its range.
    #[error("term {index} (from 0): {name} is {value}, it must be {must}")]
    Term {
        /// Number of the term, from 0.
        index: usize,
        /// Name of the number.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// A term that is there twice.
    #[error("term {index} (from 0) is there before: its coefficients cannot be told apart")]
    Twice {
        /// Number of the later one, from 0.
        index: usize,
    },
    /// A creep term over a record without a sample rate.
    #[error("a creep term needs the time between samples, but the record has no uniform sample rate")]
    NoSampleRate,
    /// Not one regressor row a sample.
    #[error("the record has {found} samples but the regressors {expected}: make them from this record")]
    Lengths {
        /// Rows of the regressors.
        expected: usize,
        /// Samples of the record.
        found: usize,
    },
    /// A creep coefficient that a Hammerstein model has no place for.
    #[error(
        "term {index} (from 0) creeps by {value}: a model file has no place for it; leave creep terms out"
    )]
    Creep {
        /// Number of the term, from 0.
        index: usize,
        /// Its coefficient.
        value: f64,
    },
    /// The model cannot be simulated.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The corrected hysteresis block is none.
    #[error(transparent)]
    Hysteresis(#[from] HysteresisError),
    /// Settings of an estimator or a monitor.
    #[error(transparent)]
    Settings(#[from] ParameterError<f64>),
    /// A sample that cannot be learnt from.
    #[error("sample {index}: {cause}")]
    Sample {
        /// Its number, from 0.
        index: usize,
        /// Why.
        cause: SampleError,
    },
    /// The outputs cannot be scored.
    #[error(transparent)]
    Score(#[from] ScoreError),
    /// No terms, or too many.
    #[error("between one and six terms can be followed, not {0}")]
    Terms(usize),
    /// A record whose samples are not equally spaced.
    #[error("it has no uniform sample rate, and a memory is a number of samples")]
    NotUniform,
}
