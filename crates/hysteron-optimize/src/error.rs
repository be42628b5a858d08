//! Errors of an optimisation.

use hysteron_numeric::display::exact;
use thiserror::Error;

/// Error of a minimisation.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum OptimizeError {
    /// The search box has no parameter.
    #[error("the search box is empty: there is no parameter to search for")]
    NoParameters,
    /// A range that cannot be searched.
    #[error("range of {name} is [{low}, {high}]: need {wanted}", low = exact(*.low), high = exact(*.high))]
    Range {
        /// Parameter.
        name: String,
        /// Its lower bound.
        low: f64,
        /// Its upper bound.
        high: f64,
        /// Allowed values.
        wanted: &'static str,
    },
    /// An option outside its allowed range.
    #[error("option {option} is {value}: need {wanted}", value = exact(*.value))]
    Option {
        /// Option, as named in the settings or the algorithm's options.
        option: &'static str,
        /// Its value.
        value: f64,
        /// Allowed values.
        wanted: &'static str,
    },
    /// A start point of the wrong length or with a value that is not finite.
    #[error(
        "start point {index} is no point of the search box: need {parameters} finite values, found {found:?}"
    )]
    Start {
        /// Position in [`Settings::starts`](super::Settings::starts).
        index: usize,
        /// Number of parameters.
        parameters: usize,
        /// The start point.
        found: Vec<f64>,
    },
    /// Least squares requested for a problem with only a cost.
    #[error(
        "least squares needs residuals, and this problem has only a cost: choose de-abc, abc, de, pso or \
         cma-es"
    )]
    NeedsResiduals,
    /// A least-squares problem without residuals.
    #[error("the problem has no residuals: there is nothing to fit")]
    NoResiduals,
    /// Every candidate had an infinite cost.
    #[error("none of {evaluations} candidates could be simulated: check the search box and the record")]
    NoFeasiblePoint {
        /// Evaluations spent.
        evaluations: usize,
    },
    /// The threads could not be started.
    #[error("cannot start {threads} threads: {reason}")]
    Threads {
        /// Number asked for.
        threads: usize,
        /// Error of the operating system.
        reason: String,
    },
    /// A Jacobian was requested at a point where the model cannot be simulated.
    #[error("the residuals cannot be differentiated with respect to {name} at {x:?}")]
    NotDifferentiable {
        /// Parameter.
        name: String,
        /// The point.
        x: Vec<f64>,
    },
    /// A checkpoint of another format or version.
    #[error(
        "the checkpoint is of format \"{format}\" version {version}, this program reads \"{expected}\" \
         version {expected_version}"
    )]
    CheckpointFormat {
        /// Format found.
        format: String,
        /// Version found.
        version: u32,
        /// Format read.
        expected: &'static str,
        /// Version read.
        expected_version: u32,
    },
    /// A checkpoint of another problem.
    #[error("the checkpoint is of the problem \"{found}\", not of \"{expected}\"")]
    CheckpointProblem {
        /// Identity in the checkpoint.
        found: String,
        /// Identity of the problem given.
        expected: String,
    },
    /// A checkpoint with another search box.
    #[error("the checkpoint's search box differs in {parameter}: resume with the bounds it was started with")]
    CheckpointBounds {
        /// First parameter that differs.
        parameter: String,
    },
    /// A checkpoint of another algorithm or other options of it.
    #[error(
        "the checkpoint is of {found}, asked for is {expected}: resume with the algorithm and options it was \
         started with"
    )]
    CheckpointAlgorithm {
        /// Algorithm and options in the checkpoint.
        found: String,
        /// Algorithm and options given.
        expected: String,
    },
    /// A checkpoint with other settings.
    #[error("the checkpoint was made with another {setting}: {found} there, {expected} here")]
    CheckpointSettings {
        /// Which setting.
        setting: &'static str,
        /// Value in the checkpoint.
        found: String,
        /// Value given.
        expected: String,
    },
    /// The cost at the checkpoint's best point differs from the stored one: other data.
    #[error(
        "the cost at the checkpoint's best point is {now} here and {stored} there: it was made with other \
         data",
        now = exact(*.now),
        stored = exact(*.stored)
    )]
    CheckpointCost {
        /// Cost in the checkpoint.
        stored: f64,
        /// Cost of this problem at the same point.
        now: f64,
    },
    /// The state of a checkpoint is inconsistent: the file was damaged or edited.
    #[error("the checkpoint is damaged: {what}")]
    CheckpointDamaged {
        /// The contradiction.
        what: &'static str,
    },
}

impl OptimizeError {
    /// True if the checkpoint to resume from was rejected.
    pub fn is_of_checkpoint(&self) -> bool {
        matches!(
            self,
            Self::CheckpointFormat { .. }
                | Self::CheckpointProblem { .. }
                | Self::CheckpointBounds { .. }
                | Self::CheckpointAlgorithm { .. }
                | Self::CheckpointSettings { .. }
                | Self::CheckpointCost { .. }
                | Self::CheckpointDamaged { .. }
        )
    }
}
