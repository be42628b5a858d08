//! What a device does beside its model: a Gaussian model of the misfit, and the band that it gives.
//!
//! The model class is rarely true. Its misfit δ(t) = y − m is described by a linear model on a rich basis
//! ([`Basis`]), δ = Φβ with β normal: fitted to the residual of the training records, it predicts for another
//! drive the discrepancy μ = φᵀβ̂ and its standard deviation √(φᵀ Σ φ) (model discrepancy: M. C. Kennedy and A.
//! O'Hagan, *J. R. Stat. Soc. B* 63 (2001) 425, doi:10.1111/1467-9868.00294). What the drive has that is new,
//! a memory corner, an amplitude, a rate, comes in by itself as variance: Σ is the prior's in directions that
//! training did not excite. `docs/theory/uncertainty.md`, "Bands outside the class".

mod basis;
mod correction;
mod finding;
mod prediction;
mod response;
mod steps;

use basis::OWN_MEMORY;
pub use basis::{Basis, COLUMNS, ColumnGroup, GROUPS, POLYNOMIALS, TimedRun};
pub use correction::NotCorrected;
pub use prediction::{MisfitPrediction, half_width};

use crate::dynamics::DynamicsError;
use crate::hammerstein::{Model, SimulationError};
use crate::record::Timing;
use crate::start::Start;

/// Rows of the columns that are computed at most for one drive; longer drives are averaged.
const MOST_ROWS: usize = 60_000;

/// A fitted model of the misfit.
///
/// The covariance of the coefficients is Σ = Σ_k f_k f_kᵀ over the eigenvectors of the information that the
/// training records have beside the prior: `directions[k]` is f_k.
#[derive(Clone, Debug, PartialEq)]
pub struct MisfitModel {
    /// The columns.
    pub basis: Basis,
    /// Standard deviation of the residual that the columns do not explain \[output unit\].
    pub noise: f64,
    /// Share of the power of the training residual that the columns explain.
    pub explained: f64,
    /// Error of model and predicted discrepancy on parts of the training records that were left out of its fit,
    /// over that of the model alone; `None` in files written before it was known.
    pub left_out: Option<f64>,
    /// Mean of the coefficients \[output unit over unit of the column\].
    pub mean: Vec<f64>,
    /// Deviations of the coefficients, a vector of one coefficient a column each; uncorrelated.
    pub directions: Vec<Vec<f64>>,
    /// Information of the training records on each direction, in units of the prior's: below 1 the direction
    /// rests on the prior.
    pub information: Vec<f64>,
    /// The training records hold loops of one amplitude only: how the memory of smaller ones differs from the
    /// model's rests on the prior, however well its columns fit the large loop.
    pub one_amplitude: bool,
}

/// Reason why there is no misfit model, or no prediction by it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MisfitError {
    /// A record or drive without times.
    #[error("a misfit is modelled over time, and the samples have none")]
    NoTimes,
    /// Dynamics that are valid at one sample rate only.
    #[error("a misfit is not modelled beside dynamics that belong to one sample rate")]
    OneRate,
    /// The simulation of the model fails.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The dynamics cannot be simulated.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
}

impl MisfitModel {
    /// The misfit of a device whose hysteresis has changed by the factor `gain`. The columns of the model's own
    /// memory and of the groups dynamics and creep are proportional to its output, and change with it.
    #[must_use]
    pub fn scaled(mut self, gain: f64) -> Self {
        let follows = GROUPS.iter().flat_map(|(group, count)| {
            let own = matches!(group, ColumnGroup::Memory | ColumnGroup::Rate);
            std::iter::repeat_n(if own { gain } else { 1.0 }, *count)
        });
        let mut factors: Vec<f64> = follows.collect();
        factors[OWN_MEMORY] = 1.0;
        for coefficients in std::iter::once(&mut self.mean).chain(&mut self.directions) {
            coefficients.iter_mut().zip(&factors).for_each(|(c, factor)| *c *= factor);
        }
        self.noise *= gain.abs();
        self
    }

    /// Predicted misfit of `model` for `drive` \[V\]. Drives over 60 000 samples are averaged in blocks, between
    /// whose centres the result is linear.
    ///
    /// # Errors
    /// [`MisfitError`].
    pub fn predict(
        &self,
        model: &Model,
        drive: &[f64],
        timing: Timing<'_>,
        start: &Start,
    ) -> Result<MisfitPrediction, MisfitError> {
        let factor = drive.len().div_ceil(MOST_ROWS).max(1);
        let columns = self.basis.columns(model, &TimedRun { samples_v: drive, timing, start }, factor)?;
        Ok(MisfitPrediction::new(self, columns, (factor, drive.len())))
    }
}

#[cfg(test)]
mod tests;
