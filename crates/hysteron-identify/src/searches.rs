//! State of an interrupted identification.

use std::collections::BTreeMap;

use hysteron_model::model_file::ModesFile;
use hysteron_optimize::Checkpoint;
use serde::{Deserialize, Serialize};

use crate::structure::ComparisonCheckpoint;

/// State of an identification: the searches done and the current one. Serialised, it resumes an interrupted
/// identification with a bit-identical result.
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
    /// The candidates of a comparison, or of the choice of the family of hysteresis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub comparison: Option<Box<ComparisonCheckpoint>>,
    /// The fits of a comparison of structures of modes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modes_comparison: Option<Box<ModesComparisonCheckpoint>>,
}

/// State of a comparison of structures of modes: the fits that are finished.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModesComparisonCheckpoint {
    /// Fingerprint of the records and options.
    pub problem: String,
    /// The fits.
    pub fits: Vec<ModesFitCheckpoint>,
}

/// A finished fit of a comparison of structures of modes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModesFitCheckpoint {
    /// Name of the structure.
    pub candidate: String,
    /// Number of the fold that was held out, from 1; 0: all records are in the fit.
    pub fold: usize,
    /// Free parameters.
    pub parameters: usize,
    /// Modes found.
    pub modes: usize,
    /// Error on the records held out, or on all.
    pub error: Option<f64>,
    /// Why it failed.
    pub failure: Option<String>,
}

/// State of the search for modes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModesCheckpoint {
    /// Fingerprint of the records and options.
    pub problem: String,
    /// Number of searches done.
    pub stage: usize,
    /// Iterations of the current search.
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
