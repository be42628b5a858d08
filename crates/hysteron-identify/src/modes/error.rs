//! Why no model was identified.

use hysteron_model::axes::AxesError;
use hysteron_model::model_file::ModelFileError;

/// Why no modes were identified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModesFitError {
    /// What was to be gone on with is of another problem.
    #[error("the interrupted search is of other records or options")]
    Resume,
    /// The model of an interrupted search is not sound.
    #[error(transparent)]
    ModelFile(#[from] ModelFileError),
    /// Stopped too early.
    #[error("the fit was stopped before there was a model")]
    Stopped,
    /// A record or model that cannot be used.
    #[error(transparent)]
    Axes(#[from] AxesError),
    /// No records.
    #[error("no records were given")]
    NoRecords,
    /// Records that do not belong together.
    #[error("records `{first}` and `{other}` differ in their {what}: {of_first} and {of_other}")]
    Different {
        /// One record.
        first: String,
        /// Another.
        other: String,
        /// In what they differ.
        what: &'static str,
        /// What the first has.
        of_first: String,
        /// What the other has.
        of_other: String,
    },
    /// An option that cannot be met.
    #[error("{name} is {value}: expected {expected}")]
    Option {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        expected: &'static str,
    },
    /// No mode was found.
    #[error(
        "no lightly damped mode was found in the frequency response up to {top_hz:.1} Hz: nothing resonates there"
    )]
    NoModes {
        /// Highest excited frequency \[Hz\].
        top_hz: f64,
    },
    /// Actuators that the outputs do not tell apart.
    #[error(
        "the influence matrix is singular (condition number {condition:.1e}): the outputs do not tell the inputs apart at slow movement"
    )]
    Singular {
        /// Condition number.
        condition: f64,
    },
    /// The model does not describe a record.
    #[error(
        "the modes do not describe record `{record}`: the best fit explains {fit_percent:.1} % of it, {need} % are needed"
    )]
    ModelClass {
        /// Record.
        record: String,
        /// Fit \[%\].
        fit_percent: f64,
        /// Least fit accepted \[%\].
        need: f64,
    },
}
