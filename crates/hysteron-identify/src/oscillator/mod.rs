//! Identification of a mass on a hysteretic spring ([`hysteron_model::oscillator`]): hysteresis in feedback.
//!
//! 1. *Records.* A force that repeats gives one mean period, in its steady state ([`Initial::Auto`]).
//! 2. *Equation error.* With ẏ and ÿ of the measured output by its spectrum, u = m ÿ + c ẏ + k y + α ζ\[y\] +
//!    e is linear in m, c, k and α for every shape (β', γ', n) of the loop: variable projection leaves two or
//!    three unknowns. Lines are divided by the impedance of the best linear oscillator, so that e counts as
//!    an error of the output. A lattice of shapes, then least squares from its best points, give starts.
//! 3. *Output error.* Simulated against measured output, all parameters at once, exact derivatives, bounded
//!    Levenberg–Marquardt. The coordinates are those of small motion: the stiffness K = k + α, the share ρ =
//!    α/K of the hysteretic spring in it, and the shape of the loop over the size of the motion; k and α
//!    themselves trade.
//!
//! The offset of each record's sensor is the mean residual, at every candidate. Variable projection: G. H.
//! Golub, V. Pereyra, doi:10.1137/0710036. Iterated weights of the linear fit: C. K. Sanathanan, J. Koerner,
//! doi:10.1109/TAC.1963.1105517.

mod coordinates;
mod equation_error;
mod knowledge;
mod output_error;
mod preparation;
mod search;
mod shapes;
mod written;

pub use knowledge::Estimate;

use super::{Correlation, Finding, Initial, Searches, Watch};
use crate::IdentifyError;
use hysteron_model::Start;
use hysteron_model::model::{Score, Simulation};
use hysteron_model::oscillator::{Oscillator, OscillatorState};
use hysteron_model::record::{InputOutput, InterSample};
use hysteron_model::validate::Scores;
use hysteron_optimize::Outcome;
use schemars::JsonSchema;
pub(crate) use search::PLAN;
use serde::{Deserialize, Serialize};

/// Options of the identification of an oscillator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "OscillatorOptions")]
pub struct Options {
    /// Start of each record: at rest without force (`Rest` and `Zero`), periodic (`Periodic`; the whole
    /// record is one period where no shorter one is found), or with y, ẏ and z at the first sample estimated
    /// (`Free`). `Auto`: a steady state where the force repeats, else rest.
    pub initial: Initial,
    /// Inter-sample behaviour of the force.
    pub inter_sample: InterSample,
    /// Parameters held at a value: `mass`, `damping`, `n`.
    pub fixed: Vec<(String, f64)>,
    /// An oscillator whose loop shape is the start instead of the grid. m, c, k and α are estimated from the
    /// records.
    pub start: Option<Oscillator>,
    /// Simulation steps per sample; `None`: [`Oscillator::steps`].
    pub steps: Option<usize>,
    /// Least fit accepted \[%\], see [`Scores::fit_percent`].
    pub least_fit_percent: f64,
}

impl Default for Options {
    /// Automatic choices, a band-limited force, at least 75 % explained.
    fn default() -> Self {
        Self {
            initial: Initial::Auto,
            inter_sample: InterSample::BandLimited,
            fixed: Vec::new(),
            start: None,
            steps: None,
            least_fit_percent: 75.0,
        }
    }
}

/// An identified oscillator.
#[derive(Clone, Debug)]
pub struct Identification {
    /// The oscillator, in the units of the records.
    pub oscillator: Oscillator,
    /// Its parameters in the order of [`Oscillator::NAMES`], then natural frequency and damping ratio for
    /// small motion.
    pub estimates: Vec<Estimate>,
    /// Correlations of the estimates; `None` where the records do not determine them.
    pub correlation: Option<Correlation>,
    /// Sensor offset of the first record.
    pub offset: f64,
    /// Rule assumed for the force between its samples.
    pub inter_sample: InterSample,
    /// Every record and the simulation of it.
    pub records: Vec<RecordFit>,
    /// The searches of the shape by the equation error; empty for a single grid point.
    pub shapes: Vec<Outcome>,
    /// The search by the output error.
    pub search: Outcome,
    /// Verdicts, warnings and advice in plain words.
    pub findings: Vec<Finding>,
    /// Treatment of the data, in plain words.
    pub treatment: Vec<String>,
    /// Lowest and highest frequency of the forces \[Hz\].
    pub excited_hz: (f64, f64),
    /// The search was stopped early; the model is the best so far.
    pub interrupted: bool,
    /// State to resume from.
    pub resume: Searches,
}

/// One record and the oscillator's simulation of it.
#[derive(Clone, Debug)]
pub struct RecordFit {
    /// The record, those samples masked in which the displacement settles to the steady state fitted.
    pub data: InputOutput,
    /// Fitted start; see also `period_samples`.
    pub start: Start<OscillatorState>,
    /// Samples of the period of a periodic start.
    pub period_samples: Option<usize>,
    /// Simulated displacement at every sample, without offset.
    pub simulated: Vec<f64>,
    /// Scores (offset estimated).
    pub scores: Scores,
}

impl RecordFit {
    /// Scores of the record.
    pub fn score(&self) -> Score {
        let start = self.period_samples.map_or(Start::AsIdentified, Start::settled);
        let simulation = Simulation::of_single(self.simulated.clone(), start, self.data.u_unit.clone());
        Score::of_single(&self.data, self.data.y_unit.clone(), self.scores.clone(), simulation)
    }
}

/// Identifies an oscillator from records that share the device.
///
/// # Errors
/// [`IdentifyError`]: records that cannot be used, options that cannot be met, records that are not those of
/// an oscillator.
pub fn identify(
    records: &[InputOutput],
    options: &Options,
    watch: &Watch<'_>,
    resume: Option<Searches>,
) -> Result<Identification, IdentifyError> {
    search::identify(records, options, watch, resume)
}
