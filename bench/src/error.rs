//! Errors of the benchmarks.

use std::path::PathBuf;

use hysteron_identify::IdentifyError;
use hysteron_model::dynamics::DynamicsError;
use hysteron_model::hysteresis::HysteresisError;
use hysteron_model::record::RecordError;
use hysteron_rig::RigError;
use thiserror::Error;

/// A request that could not be met.
#[derive(Debug, Error)]
pub enum BenchError {
    /// Standard input or output.
    #[error("cannot talk to bench.py: {0}")]
    Pipe(#[from] std::io::Error),
    /// A line that is no request.
    #[error("request not understood: {0}")]
    Request(#[from] serde_json::Error),
    /// A file of samples.
    #[error("{}: {source}", path.display())]
    SignalFile {
        /// The file.
        path: PathBuf,
        /// Cause given by the system.
        source: std::io::Error,
    },
    /// Simulation before its plan.
    #[error("no simulation is planned: ask for 'plan_fractional' first")]
    NotPlanned,
    /// A scheme by a name that is none.
    #[error("no such scheme: tustin, grunwald-letnikov, bdf2 or band-limited")]
    Scheme,
    /// A record of the campaign is missing in memory.
    #[error("the simulated bench made no {0} record")]
    NoRecord(&'static str),
    /// An algorithm the bench does not run.
    #[error("no algorithm '{0}': choose de-abc, de or auto")]
    Algorithm(String),
    /// The dynamic block.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// The static block.
    #[error(transparent)]
    Hysteresis(#[from] HysteresisError),
    /// The simulated bench.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// A record.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// An identification.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// Records to time on.
    #[error("the records to time on could not be made: {0}")]
    Synthetic(Box<dyn std::error::Error + Send + Sync>),
    /// Threads.
    #[error(transparent)]
    Threads(#[from] rayon::ThreadPoolBuildError),
}
