//! Nonlinear black-box models to compare an identified model with: NARX models trained on the same records
//! and simulated.
//!
//! ```text
//! y_k = f(y_{k−1}, …, y_{k−ny}, u_k, …, u_{k−nu}, s_k)
//! ```
//!
//! with f a polynomial whose terms orthogonal least squares selects ([`PolynomialNarx`]), kernel ridge
//! regression ([`KernelNarx`]), or a network with one hidden layer ([`NeuralNarx`]). The regressors hold the
//! direction s of the drive ([`Lags`]): without it there is no hysteresis. All choices are made on the
//! training records, by simulation of a held-out quarter. [`cross_validate`] scores them on the folds of a
//! comparison of structures.
//!
//! These are baselines: without physical parameters, inverse or confidence intervals, for one lag interval.
//! See `docs/theory/baselines.md` for when to prefer one.

mod cross_validation;
mod error;
mod free_run;
mod kernel_narx;
mod monomial;
mod neural_narx;
mod orthogonal_least_squares;
mod pivoted_cholesky;
mod polynomial_narx;
mod regressors;
mod signals;
mod simulation_error;
mod training_set;

pub use cross_validation::{CrossValidated, cross_validate, cross_validate_all};
pub use error::BaselineError;
pub use free_run::OneStep;
pub use kernel_narx::KernelNarx;
pub use monomial::Monomial;
pub use neural_narx::NeuralNarx;
pub use orthogonal_least_squares::{Selected, StoppingRule, select};
pub use polynomial_narx::PolynomialNarx;
pub use regressors::{Lags, Regressors, Series};
pub use signals::{Scale, Units, lag_intervals};

use hysteron_model::record::InputOutput;
use training_set::TrainingSet;

/// Lags tried.
const LAGS: [Lags; 3] =
    [Lags { output: 1, input: 1 }, Lags { output: 2, input: 2 }, Lags { output: 3, input: 3 }];

/// Kind of f.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Baseline {
    /// [`PolynomialNarx`].
    Polynomial,
    /// [`KernelNarx`].
    Kernel,
    /// [`NeuralNarx`].
    Neural,
}

impl Baseline {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Polynomial, Self::Kernel, Self::Neural];

    /// Name for tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Polynomial => "polynomial-narx",
            Self::Kernel => "kernel-narx",
            Self::Neural => "neural-narx",
        }
    }
}

/// A trained baseline.
#[derive(Clone, Debug, PartialEq)]
pub struct Trained {
    /// Scales of its signals and the lag interval.
    pub units: Units,
    /// Its regressors.
    pub regressors: Regressors,
    /// f.
    pub model: TrainedModel,
}

/// f of a [`Trained`] baseline.
#[derive(Clone, Debug, PartialEq)]
pub enum TrainedModel {
    /// A polynomial.
    Polynomial(PolynomialNarx),
    /// Kernel ridge regression.
    Kernel(KernelNarx),
    /// A network.
    Neural(NeuralNarx),
}

/// Trains a baseline on the valid samples of some records. `intervals_s`: lag intervals to choose from
/// ([`lag_intervals`]).
///
/// # Errors
/// [`BaselineError`]: records that cannot be used, or no model that can be simulated on them.
pub fn train(kind: Baseline, records: &[InputOutput], intervals_s: &[f64]) -> Result<Trained, BaselineError> {
    let sets = intervals_s
        .iter()
        .map(|&interval_s| TrainingSet::new(records, interval_s))
        .collect::<Result<Vec<_>, _>>()?;
    let (number, regressors, model) = match kind {
        Baseline::Polynomial => {
            let (number, regressors, model) = polynomial_narx::train(&sets, &LAGS)?;
            (number, regressors, TrainedModel::Polynomial(model))
        }
        Baseline::Kernel => {
            let (number, regressors, model) = kernel_narx::train(&sets, &LAGS)?;
            (number, regressors, TrainedModel::Kernel(model))
        }
        Baseline::Neural => {
            let (number, regressors, model) = neural_narx::train(&sets, &LAGS[1..2])?;
            (number, regressors, TrainedModel::Neural(model))
        }
    };
    Ok(Trained { units: sets[number].units, regressors, model })
}

impl Trained {
    /// Number of fitted coefficients.
    pub fn parameters(&self) -> usize {
        match &self.model {
            TrainedModel::Polynomial(model) => model.parameters(),
            TrainedModel::Kernel(model) => model.parameters(),
            TrainedModel::Neural(model) => model.parameters(),
        }
    }

    /// Number of measured initial samples used by the simulation.
    ///
    /// # Errors
    /// [`BaselineError::NoSampleRate`], [`BaselineError::Interval`].
    pub fn start_samples(&self, record: &InputOutput) -> Result<usize, BaselineError> {
        Ok((self.units.stride(record)? * self.regressors.lags.past()).min(record.len()))
    }

    /// Simulates a record at its own rate, in its output unit: from its drive and the first
    /// [`Trained::start_samples`] of its output. Samples less than a lag interval apart are simulated
    /// separately.
    ///
    /// # Errors
    /// [`BaselineError::Diverged`]; [`BaselineError::NoSampleRate`], [`BaselineError::Interval`],
    /// [`BaselineError::NotFinite`].
    pub fn simulate(&self, record: &InputOutput) -> Result<Vec<f64>, BaselineError> {
        let (regressors, units) = (&self.regressors, &self.units);
        match &self.model {
            TrainedModel::Polynomial(model) => free_run::simulate_record(model, regressors, units, record),
            TrainedModel::Kernel(model) => free_run::simulate_record(model, regressors, units, record),
            TrainedModel::Neural(model) => free_run::simulate_record(model, regressors, units, record),
        }
    }
}

#[cfg(test)]
mod tests;
