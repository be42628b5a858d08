//! Errors of a reproduction.

use hysteron_identify::IdentifyError;
use hysteron_model::dynamics::DynamicsError;
use hysteron_model::hammerstein::SimulationError;
use hysteron_model::hysteresis::HysteresisError;
use hysteron_model::record::RecordError;
use hysteron_model::validate::ScoreError;
use hysteron_optimize::OptimizeError;
use hysteron_rig::RigError;

/// Why the article could not be reproduced.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ArticleError {
    /// Stopped by the watcher.
    #[error("stopped before the reproduction was complete")]
    Stopped,
    /// A setting of the plan is outside its allowed range.
    #[error("the plan's {setting} is {value}: need {wanted}")]
    Plan {
        /// Setting.
        setting: &'static str,
        /// Its value.
        value: f64,
        /// Allowed values.
        wanted: &'static str,
    },
    /// The bench could not be simulated.
    #[error("the simulated bench: {0}")]
    Bench(#[from] RigError),
    /// A record could not be made.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A search failed.
    #[error(transparent)]
    Optimize(#[from] OptimizeError),
    /// An identification failed.
    #[error("identification of the {model}: {source}")]
    Identify {
        /// Which model.
        model: String,
        /// Why.
        source: Box<IdentifyError>,
    },
    /// A model could not be simulated.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A hysteresis block could not be simulated.
    #[error(transparent)]
    Hysteresis(#[from] HysteresisError),
    /// A dynamic block could not be simulated.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// A simulation could not be scored.
    #[error(transparent)]
    Score(#[from] ScoreError),
    /// An option of the study of optimisers outside its allowed range.
    #[error("option {option} of the optimiser study is {value}: need {wanted}")]
    StudyOption {
        /// Option.
        option: &'static str,
        /// Its value.
        value: usize,
        /// Allowed values.
        wanted: &'static str,
    },
    /// The study of optimisers was asked to stop.
    #[error("the optimiser study was stopped after {done} of {runs} runs")]
    StudyStopped {
        /// Runs done.
        done: usize,
        /// Runs planned.
        runs: usize,
    },
}
