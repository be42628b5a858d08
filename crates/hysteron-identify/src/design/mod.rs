//! Design of the next experiment: the drive of a given length, within range and slew rate, after which a
//! model is known best for a purpose.
//!
//! The covariance in the model file, or that of a fit of the records, is what is known now: independent
//! directions z of variance 1 (`prior`). A drive adds the Fisher information F of its record about z
//! (`information`), with the noise that the standard errors of the fit see, and leaves the covariance
//! (I + F)⁻¹. The drive is put together from segments (`candidates`: loops, first-order reversals, sines,
//! sweeps, multisines, random reversals, holds) by an exchange algorithm (`objective`), on the sum of the
//! segments' information, each from rest; then whole drives are compared by their own information, joined
//! within the slew rate (`limits`). The usual experiment, a loop and a sweep of the same length, is one of
//! them: the result is never worse than it.
//!
//! The design is that of the present estimates (locally optimal); mathematics and a study:
//! `docs/theory/experiments.md`.

mod assumptions;
mod candidates;
mod information;
mod limits;
mod objective;
mod outcome;
mod prior;
mod quantities;
mod record;
mod search;
#[cfg(test)]
mod tests;

pub use crate::purpose::Purpose;
pub use outcome::{Design, DesignSummary, Expected};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fit::{Fit, FitDetails};
use crate::prediction::scatter;
use crate::uncertainty::correlation_time;
use crate::{Identification, IdentifyError, ParameterRole};
use hysteron_model::hammerstein::Model;
use hysteron_model::model::Capability;
use hysteron_model::model_file::ModelFile;
use hysteron_numeric::Listener;

/// Correlation time in samples below which a residual counts as white.
const WHITE: f64 = 1.5;

/// Options of a design.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DesignOptions {
    /// What the drive is for.
    pub purpose: Purpose,
    /// Length of the drive \[s\].
    pub time_s: f64,
    /// Lowest and highest voltage; `None`: those of the records.
    pub range: Option<[f64; 2]>,
    /// Largest slew rate \[V/s\]; `None`: that of the records.
    pub slew_per_s: Option<f64>,
    /// Sample rate \[Hz\]; `None`: that of the records.
    pub sample_rate_hz: Option<f64>,
    /// Highest frequency excited \[Hz\], at most a tenth of the sample rate; `None`: that of the records or
    /// 1.5 times the resonance, whichever is higher.
    pub highest_hz: Option<f64>,
    /// Standard deviation of the noise \[output unit\]; `None`: the residual of the fit.
    pub noise: Option<f64>,
    /// Frequency \[Hz\] at which a resonance is assumed where the model has none; `None`: half the highest
    /// frequency.
    pub resonance_hz: Option<f64>,
    /// Seed of the phases and random levels.
    pub seed: u64,
}

impl DesignOptions {
    /// A drive of this length \[s\] for this purpose, all else by default.
    pub fn new(purpose: Purpose, time_s: f64) -> Self {
        Self {
            purpose,
            time_s,
            range: None,
            slew_per_s: None,
            sample_rate_hz: None,
            highest_hz: None,
            noise: None,
            resonance_hz: None,
            seed: 0,
        }
    }
}

impl Default for DesignOptions {
    /// 20 s for prediction.
    fn default() -> Self {
        Self::new(Purpose::default(), 20.0)
    }
}

/// What a design starts from: a model with the covariance of its numbers, and the noise of its records.
#[derive(Clone, Debug)]
pub struct DesignBasis {
    file: ModelFile,
    /// Numbers that were estimated but not determined.
    undetermined: Vec<String>,
    /// Residual of a record, and its sample rate \[Hz\].
    residual: Option<(Vec<f64>, f64)>,
}

impl From<&ModelFile> for DesignBasis {
    /// A model file: its noise is white, of the rms error over the scores in the file.
    fn from(file: &ModelFile) -> Self {
        Self { file: file.clone(), undetermined: Vec::new(), residual: None }
    }
}

impl DesignBasis {
    /// A fit, with the spectrum of its residual and the numbers that its records do not determine.
    ///
    /// # Errors
    /// [`IdentifyError::Unsupported`] for a fit of another kind than a Hammerstein model.
    pub fn of_fit(fit: &Fit) -> Result<Self, IdentifyError> {
        let file = fit.model.hammerstein(Capability::Design)?.data().clone();
        let FitDetails::Hammerstein(found) = &fit.found else { return Ok(Self::from(&file)) };
        let open = |p: &&crate::Parameter| {
            let is_own = !matches!(p.role, ParameterRole::Memory(_));
            !p.held && p.std_error.is_none() && is_own
        };
        let undetermined = found.parameters.iter().filter(open).map(|p| p.name.clone()).collect();
        Ok(Self { file, undetermined, residual: residual(found) })
    }

    /// The model file.
    pub fn file(&self) -> &ModelFile {
        &self.file
    }

    /// Standard deviation of the noise by the scores in the file; 0 without scores.
    fn scatter(&self) -> f64 {
        scatter(&self.file)
    }

    /// The residual where it is not white.
    fn coloured(&self) -> Option<&(Vec<f64>, f64)> {
        self.residual.as_ref().filter(|(residual, _)| correlation_time(residual) > WHITE)
    }
}

/// Residual of the longest uniformly sampled record.
fn residual(found: &Identification) -> Option<(Vec<f64>, f64)> {
    let uniform = found.records.iter().filter_map(|fit| Some((fit, fit.data.sample_rate_hz()?)));
    let (fit, rate_hz) = uniform.max_by_key(|(fit, _)| fit.data.len())?;
    let left = (0..fit.data.len()).filter(|&k| fit.data.is_valid(k));
    let residual = left.map(|k| fit.data.y[k] - fit.simulated[k] - fit.scores.offset);
    Some((residual.filter(|e| e.is_finite()).collect(), rate_hz))
}

/// Values of the quantities that a purpose is for, of a drive of this time \[s\]: delay; resonance and the
/// gain there; creep. `None` for one that the model does not have; empty for the other purposes.
pub fn quantities(purpose: Purpose, model: &Model, time_s: f64) -> Vec<Option<f64>> {
    quantities::quantities_of(purpose).iter().map(|quantity| quantity.of(model, time_s)).collect()
}

/// Designs the next drive.
///
/// # Errors
/// [`IdentifyError`]: no covariance, options out of range, a purpose that the model gives no meaning;
/// [`IdentifyError::Stopped`] where the listener ends it.
pub fn design(
    basis: &DesignBasis,
    options: &DesignOptions,
    listener: Listener<'_>,
) -> Result<Design, IdentifyError> {
    search::design(basis, options, listener)
}
