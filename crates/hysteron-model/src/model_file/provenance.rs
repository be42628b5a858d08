//! Provenance and scores of a model.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::axes::AxesRecord;
use crate::record::{InputOutput, Source};
use crate::validate::Scores;

/// Provenance of a model: enough to repeat its identification.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object with the key `program` and further ones")]
pub struct Provenance {
    /// Program and version, e.g. `hysteron 0.1.0`.
    pub program: String,
    /// When, RFC 3339 in UTC ([`timestamp`]).
    #[serde(default)]
    pub created: Option<String>,
    /// The records used.
    #[serde(default)]
    pub records: Vec<RecordEntry>,
    /// Options in force by name, defaults and automatic choices included.
    #[serde(default)]
    pub options: BTreeMap<String, String>,
    /// Seed of the random numbers.
    #[serde(default)]
    pub seed: Option<u64>,
    /// The command that made the model.
    #[serde(default)]
    pub command: Option<String>,
}

/// Facts known only to the program that makes a model: its version, the time, its command line.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Maker {
    /// Program and version, e.g. `hysteron 0.1.0`.
    pub program: String,
    /// When, RFC 3339 in UTC ([`timestamp`]).
    pub created: Option<String>,
    /// The command that makes the model.
    pub command: Option<String>,
}

impl Provenance {
    /// Provenance of a model made from these records with these options by name.
    pub fn new(
        maker: &Maker,
        records: Vec<RecordEntry>,
        options: BTreeMap<String, String>,
        seed: Option<u64>,
    ) -> Self {
        let Maker { program, created, command } = maker.clone();
        Self { program, created, records, options, seed, command }
    }
}

/// A record used for an identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object with the keys `path`, `sha256`, `samples` and `role`")]
pub struct RecordEntry {
    /// Path as given by the user.
    pub path: String,
    /// SHA-256 of the file, lower-case hexadecimal; null for a record made in memory.
    #[serde(default)]
    pub sha256: Option<String>,
    /// Number of samples.
    pub samples: u64,
    /// Role of the record in the identification.
    pub role: RecordRole,
}

impl RecordEntry {
    /// A record of one input and one output.
    pub fn of(record: &InputOutput, role: RecordRole) -> Self {
        Self::named(record.source.as_ref(), &record.name, record.len(), role)
    }

    /// A record of several inputs and outputs.
    pub fn of_axes(record: &AxesRecord) -> Self {
        Self::named(record.source.as_ref(), &record.name, record.len(), RecordRole::Both)
    }

    fn named(source: Option<&Source>, name: &str, samples: usize, role: RecordRole) -> Self {
        Self {
            path: source.map_or(name, |s| &s.path).to_owned(),
            sha256: source.map(|s| s.sha256.clone()),
            samples: samples as u64,
            role,
        }
    }
}

/// Role of a record in the identification.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RecordRole {
    /// Quasi-static: the hysteresis block.
    Static,
    /// The dynamic block.
    Dynamic,
    /// Both blocks.
    Both,
    /// Neither: held out to score the model.
    Validation,
}

/// Scores of the model on one record; definitions in [`crate::validate::definitions`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object of scores")]
pub struct ScoreEntry {
    /// The record.
    pub record: String,
    /// Whether the model was fitted to these samples.
    pub role: ScoreRole,
    /// Unit of `offset`, `rmse` and `max_abs_error`.
    pub unit: String,
    /// Samples scored.
    pub samples: u64,
    /// Samples not scored.
    pub skipped_samples: u64,
    /// Constant added to the simulation before the comparison.
    pub offset: f64,
    /// Root mean square error.
    pub rmse: f64,
    /// Largest error.
    pub max_abs_error: f64,
    /// RMSE in % of the record's stroke; null for a constant record, as the following.
    pub rmse_percent_of_stroke: Option<f64>,
    /// Largest error in % of the stroke.
    pub max_percent_of_stroke: Option<f64>,
    /// 100 · (1 − ‖e‖₂/‖y − mean y‖₂).
    pub fit_percent: Option<f64>,
    /// ‖e‖₁/‖y − min y‖₁.
    pub relative_error: Option<f64>,
    /// Simulated minus measured loop opening in % of the stroke; null where the record is no loop.
    pub loop_width_error_percent: Option<f64>,
}

/// Whether a model was fitted to what it is scored on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ScoreRole {
    /// Fitted to these samples.
    Training,
    /// Not seen by the fit.
    Validation,
}

impl ScoreEntry {
    /// Entry for `scores` of the record of this name, whose output has the unit `unit` (header symbol).
    pub fn new(record: &str, role: ScoreRole, unit: &str, scores: &Scores) -> Self {
        ScoreEntry {
            record: record.to_owned(),
            role,
            unit: unit.to_owned(),
            samples: scores.samples as u64,
            skipped_samples: scores.skipped_samples as u64,
            offset: scores.offset,
            rmse: scores.rmse,
            max_abs_error: scores.max_abs_error,
            rmse_percent_of_stroke: scores.rmse_percent_of_stroke,
            max_percent_of_stroke: scores.max_percent_of_stroke,
            fit_percent: scores.fit_percent,
            relative_error: scores.relative_error,
            loop_width_error_percent: scores.loop_width_error_percent,
        }
    }
}

/// The day of a time in seconds since 1970, in UTC: `2025-01-31`.
pub fn day(seconds: u64) -> String {
    let mut day = timestamp(seconds);
    day.truncate("2025-01-31".len());
    day
}

/// A time in seconds since 1970 as RFC 3339 in UTC, to the second: `2025-01-31T09:30:00Z`.
pub fn timestamp(seconds: u64) -> String {
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    // Civil date from days since 1970-01-01, in years that begin on 1 March (so that leap days come last).
    let shifted = days + 719_468;
    let era = shifted / 146_097;
    let day_of_era = shifted % 146_097;
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
    let year = year_of_era + 400 * era + u64::from(month <= 2);
    let (hour, minute, second) = (rest / 3600, rest / 60 % 60, rest % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}
