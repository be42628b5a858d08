//! Identification of scheduled modes with hysteresis in feedback ([`hysteron_model::axes::ScheduledModes`])
//! from periodic records of several inputs and outputs.
//!
//! 1. *Records.* Mean of the settled periods; level: rms of the inputs. Records within 5 % of each other are
//!    of one level.
//! 2. *Response.* Frequency responses of the highest level by the local polynomial method, common poles by
//!    vector fitting, residues of rank one by singular value decomposition.
//! 3. *Linear modes.* Levenberg–Marquardt on the simulated outputs of the highest level, then of all levels
//!    with poles, output rows and feedthrough that follow the level.
//! 4. *Hysteresis.* Hysteretic strains of each actuator's free stroke and stress are added in feedback;
//!    first their coefficients, then all parameters.
//!
//! 5. *Standard errors* of the physical quantities, from the Jacobian of the last search.
//!
//! Derivatives are exact forward sensitivities of the simulation itself. Levels are weighted by their squared
//! error over their rms output, between absolute and relative errors. The result does not depend on the
//! number of threads.

mod candidate;
mod columns;
mod compare;
mod exponent;
mod linearised;
mod normal;
mod quantities;
mod records;
mod ridge;
mod search;
mod start;
mod stress_scale;
mod summary;
#[cfg(test)]
mod tests;
mod uncertainty;
mod written;

pub use candidate::{ModesCandidate, StrainChoice, UnknownModes};
pub use compare::{
    ModesCandidateSummary, ModesComparison, ModesComparisonSummary, ModesEntry, compare_modes,
};
pub use quantities::{Name as QuantityName, Part, Quantity};
pub use summary::{LevelInfluence, ModeShift, ModesRecordFit};

use super::{Finding, Searches, Watch};
use crate::IdentifyError;
use hysteron_model::axes::{AxesRecord, InfluenceMatrix, ScheduledModes};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Options of the identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "ModesOptions")]
pub struct Options {
    /// Initial pole pairs of the vector fit; `None`: chosen by their fit of the response. The result can have
    /// fewer.
    pub modes: Option<usize>,
    /// Simulation steps per sample.
    pub steps: usize,
    /// Plays of each strain; 0: polynomials alone.
    pub plays: usize,
    /// Hysteresis in feedback; without it the modes are linear at each level.
    pub hysteresis: bool,
    /// Corner of the inputs' lags to start from \[Hz\]; `None`: 0.8 of the highest excited frequency.
    pub lag_hz: Option<f64>,
    /// Exponent of the level in S; `None`: from the responses of three levels or more where they determine
    /// it, else 0.3.
    pub exponent: Option<f64>,
    /// Weight of the ridge that shrinks the slopes over the level towards one common relative shift; 0: none.
    pub ridge: f64,
    /// Time constant of the running level where a drive does not repeat \[s\].
    pub time_constant_s: f64,
    /// Iterations of the last search.
    pub iterations: usize,
    /// Treat a record without a detected period as one period of a steady state.
    pub whole_records: bool,
    /// Least fit accepted, pooled over the outputs of each record \[%\].
    pub least_fit_percent: f64,
}

impl Default for Options {
    /// Two steps a sample, six plays, exponent by the records, no ridge, twelve iterations, at least 75 %
    /// explained.
    fn default() -> Self {
        Self {
            modes: None,
            steps: 2,
            plays: 6,
            hysteresis: true,
            lag_hz: None,
            exponent: None,
            ridge: 0.0,
            time_constant_s: 2.0,
            iterations: 12,
            whole_records: false,
            least_fit_percent: 75.0,
        }
    }
}

/// An identified model.
#[derive(Clone, Debug)]
pub struct ModesIdentification {
    /// The model.
    pub model: ScheduledModes,
    /// Free parameters of the last search.
    pub parameters: usize,
    /// Fit of every record, in their order.
    pub records: Vec<ModesRecordFit>,
    /// The modes at the lowest and the highest level.
    pub modes: Vec<ModeShift>,
    /// Frequencies, dampings, gains and weights of the hysteresis with their standard errors.
    pub quantities: Vec<Quantity>,
    /// Influence matrix of every level whose records determine it, ascending.
    pub influence: Vec<LevelInfluence>,
    /// The search was stopped before its end.
    pub interrupted: bool,
    /// State to resume from.
    pub resume: Searches,
    /// Verdicts, advice and warnings in plain words.
    pub findings: Vec<Finding>,
    /// Treatment of the data, in plain words.
    pub treatment: Vec<String>,
    /// Lowest and highest frequency of the drive \[Hz\].
    pub excited_hz: (f64, f64),
    /// Influence matrix of the highest level.
    pub top_influence: InfluenceMatrix,
}

/// Identifies scheduled modes from records that share the device, the sample rate and the channels.
///
/// # Errors
/// [`IdentifyError`]: records that cannot be used, options that cannot be met, a model that does not describe
/// the records.
pub fn identify(
    records: &[AxesRecord],
    options: &Options,
    watch: &Watch<'_>,
    resume: Option<Searches>,
) -> Result<ModesIdentification, IdentifyError> {
    summary::identify(records, options, watch, resume)
}
