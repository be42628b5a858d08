//! Identification of a force against a prescribed displacement ([`hysteron_model::force`]).
//!
//! 1. *Rate.* As measured, or of the displacement over a window of a fiftieth of the period of its fastest
//!    swings.
//! 2. *Search.* F = F₀ + Σ kᵢ xⁱ + Σ wⱼ Hⱼ\[x; θ\] + c v + d s\[v; ν, ρ\] is linear in all but the shape θ of
//!    the hysteresis and ν, ρ of the saturating force. These are searched by bounded least squares from
//!    several starts; for each candidate the others are eliminated. F₀ and kᵢ are free; c, d and the weights
//!    have the sign with which they dissipate, so that terms of one loop cannot cancel each other.
//! 3. Every record counts alike, its error a share of its range of force.
//!
//! Variable projection: G. H. Golub, V. Pereyra, doi:10.1137/0710036.

mod error;
mod estimates;
mod problem;
mod search;
mod written;

pub use error::ForceError;
pub use estimates::Estimate;

use super::{Finding, Searches, Watch};
use crate::{Correlation, IdentifyError};
use hysteron_model::Start;
use hysteron_model::force::ForceModel;
use hysteron_model::hysteresis::HysteresisForm;
use hysteron_model::model::{Score, Simulation};
use hysteron_model::record::InputOutput;
use hysteron_model::validate::Scores;
use hysteron_optimize::Outcome;
use schemars::JsonSchema;
pub(crate) use search::PLAN;
use serde::{Deserialize, Serialize};

/// Options of the identification of a force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "ForceOptions")]
pub struct Options {
    /// Family of the hysteresis of the displacement; `None`: `dahl` with exponent 1, one state that relaxes
    /// exponentially.
    pub hysteresis: Option<HysteresisForm>,
    /// Degree of the polynomial of the displacement, from 1: the stiffness alone.
    pub degree: usize,
    /// Numbers held at a value: those of the hysteresis family's shape, `viscous`, `saturating_force`,
    /// `saturating_rate`, `saturating_reach`.
    pub fixed: Vec<(String, f64)>,
    /// Time over which the rate of the displacement is averaged \[s\]; `None`: a fiftieth of the period of
    /// the fastest swings.
    pub rate_window_s: Option<f64>,
    /// Least fit accepted \[%\], see [`Scores::fit_percent`].
    pub least_fit_percent: f64,
}

impl Default for Options {
    /// Automatic choices, a linear stiffness, at least 75 % explained.
    fn default() -> Self {
        Self { hysteresis: None, degree: 1, fixed: Vec::new(), rate_window_s: None, least_fit_percent: 75.0 }
    }
}

/// An identified force.
#[derive(Clone, Debug)]
pub struct Identification {
    /// The model, in the units of the records.
    pub model: ForceModel,
    /// Its numbers in the order of [`ForceModel::numbers`].
    pub estimates: Vec<Estimate>,
    /// Correlations of the estimates; `None` where the records do not determine them.
    pub correlation: Option<Correlation>,
    /// Every record and the simulation of it.
    pub records: Vec<RecordFit>,
    /// The search.
    pub search: Outcome,
    /// Verdicts, warnings and advice in plain words.
    pub findings: Vec<Finding>,
    /// Treatment of the data, in plain words.
    pub treatment: Vec<String>,
    /// Largest rate of a displacement, in its unit per second.
    pub fastest_rate: f64,
    /// Lowest and highest frequency of the swings of the displacements \[Hz\].
    pub excited_hz: (f64, f64),
    /// The search was stopped early; the model is the best so far.
    pub interrupted: bool,
    /// State to resume from.
    pub resume: Searches,
}

/// One record and the simulation of it.
#[derive(Clone, Debug)]
pub struct RecordFit {
    /// The record.
    pub data: InputOutput,
    /// Simulated force at every sample.
    pub simulated: Vec<f64>,
    /// Scores (offset estimated).
    pub scores: Scores,
}

impl RecordFit {
    /// Scores of the record.
    pub fn score(&self) -> Score {
        let simulation =
            Simulation::of_single(self.simulated.clone(), Start::AsIdentified, self.data.u_unit.clone());
        Score::of_single(&self.data, self.data.y_unit.clone(), self.scores.clone(), simulation)
    }
}

/// Identifies a force from records that share the device: displacement in, force out.
///
/// # Errors
/// [`IdentifyError`]: records that cannot be used, options that cannot be met, records that are not those of
/// such a force.
pub fn identify(
    records: &[InputOutput],
    options: &Options,
    watch: &Watch<'_>,
    resume: Option<Searches>,
) -> Result<Identification, IdentifyError> {
    search::identify(records, options, watch, resume)
}
