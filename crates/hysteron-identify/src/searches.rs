//! State of an interrupted identification.

use std::collections::BTreeMap;

use hysteron_model::model_file::ModesFile;
use hysteron_optimize::Checkpoint;
use serde::{Deserialize, Serialize};

/// State of an identification: the searches done and the one under way. Serialise it to interrupt an
/// identification and go on later to the same final bits.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Searches {
    /// `hysteron-searches`.
    pub format: SearchesFormat,
    /// Checkpoint of each search, by its name.
    pub searches: BTreeMap<String, Checkpoint>,
    /// The search for modes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modes: Option<Box<ModesCheckpoint>>,
}

/// Where the search for modes stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModesCheckpoint {
    /// Of the records and options.
    pub problem: String,
    /// Searches done.
    pub stage: usize,
    /// Iterations of the one under way.
    pub iteration: usize,
    /// Damping of its next step.
    pub damping: f64,
    /// The best model so far.
    pub model: ModesFile,
}

/// Format tag of [`Searches`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum SearchesFormat {
    /// The only one.
    #[default]
    #[serde(rename = "hysteron-searches-1")]
    Version1,
}
