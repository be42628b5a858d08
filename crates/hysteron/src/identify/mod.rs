//! From records to a model: the article's two-step identification (§4.3) with any of the optimisers.
//!
//! [`identify`] recognises which records are quasi-static and which carry dynamics, chooses what the user left
//! open (start, polynomial degree, delay and lag) from the data, runs the searches and hands out an
//! [`Identification`]: the model, its parameters with standard errors, the fit of every record, and in plain words what
//! the records do not determine. [`optimizer_study`] compares the optimisers on the article's two problems.

mod dynamic_problem;
mod dynamic_step;
mod engine;
mod error;
mod facts;
mod findings;
mod identifiability;
mod joint;
mod layout;
pub mod optimizer_study;
mod options;
mod prediction;
mod projection;
pub mod recalibrate;
mod result;
mod static_fit;
mod static_problem;
mod static_step;
pub mod structure;
mod two_step;
mod uncertainty;

pub use engine::{Search, Searches, SearchesFormat, Unwatched, Watcher};
pub use error::IdentifyError;
pub use joint::{
    Covariance, Interval, IntervalMethod, JointObjective, JointScratch, OutputUncertainty, PredictionBand,
};
pub use layout::Demands;
pub use options::{
    CampaignRecord, Choice, DynamicsChoice, HIGHEST_DEGREE, Initial, Method, Options, RecordRole,
};
pub use prediction::PredictionError;
pub use result::{
    Correlation, Finding, FindingKind, Identification, Parameter, RecordFit, Reduction, StructureChoice,
};
pub use static_fit::StaticFit;
pub use two_step::identify;

use engine::Engine;
use facts::RecordFacts;

/// FNV-1a over 64-bit words: tells the checkpoint of another problem.
fn fingerprint(values: impl Iterator<Item = u64>) -> u64 {
    values.fold(0xcbf2_9ce4_8422_2325, |hash, value| (hash ^ value).wrapping_mul(0x0100_0000_01b3))
}
