//! Derivatives of a model's output with respect to independent directions of its numbers.
//!
//! With the covariance C = Σ_k d_k d_kᵀ of the numbers, d_k the scaled eigenvectors of their correlation, the
//! numbers are θ + Σ_k z_k d_k with independent z_k of variance 1. ∂y/∂z_k is a central difference of two
//! simulations.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::IdentifyError;
use hysteron_model::Start;
use hysteron_model::dynamics::Dynamics;
use hysteron_model::hammerstein::{Model, SimulationError};
use hysteron_model::model_file::number_mut;
use hysteron_model::record::Timing;
use hysteron_numeric::Meter;

/// Step of the differences, in standard deviations along d_k: the truncation error is a millionth of the
/// nonlinear part.
pub(crate) const STEP: f64 = 1e-3;

/// The directions d_k of a covariance.
pub(crate) fn directions(covariance: &DMatrix<f64>) -> Vec<DVector<f64>> {
    let errors = covariance.diagonal().map(f64::sqrt);
    let correlation = covariance.map_with_location(|i, j, c| c / (errors[i] * errors[j]));
    let eigen = correlation.symmetric_eigen();
    (0..errors.len())
        // Negative eigenvalues are rounding errors.
        .filter(|&k| eigen.eigenvalues[k] > 0.0)
        .map(|k| eigen.eigenvectors.column(k).component_mul(&errors) * eigen.eigenvalues[k].sqrt())
        .collect()
}

/// The model with its numbers moved along `direction`.
pub(crate) fn moved(original: &Model, names: &[String], direction: &DVector<f64>, step: f64) -> Model {
    let mut model = original.clone();
    for (name, d) in names.iter().zip(direction) {
        if let Some(number) = number_mut(&mut model, name) {
            *number += step * d;
        }
    }
    // Equal orders are one number of the fit: rounding between them would make G improper.
    if let (Dynamics::Fractional(before), Dynamics::Fractional(g)) = (&original.dynamics, &mut model.dynamics)
    {
        for (order, term) in before.numerator.iter().map(|term| term.order).zip(&mut g.numerator) {
            if let Some(same) = before.denominator.iter().position(|of| of.order == order) {
                term.order = g.denominator[same].order;
            }
        }
    }
    model
}

/// ∂y/∂z_k about its mean over `drive`, for each of `count` directions; `at(k, step)` is the model a `step`
/// along direction k.
///
/// # Errors
/// [`IdentifyError::Simulation`] where the model cannot be simulated; [`IdentifyError::Stopped`].
pub(crate) fn sensitivities(
    count: usize,
    at: impl Fn(usize, f64) -> Result<Model, IdentifyError> + Sync,
    (drive, timing, start): (&[f64], Timing<'_>, &Start),
    meter: &Meter<'_>,
) -> Result<Vec<Vec<f64>>, IdentifyError> {
    let simulated = |k: usize, step: f64| -> Result<Vec<f64>, IdentifyError> {
        let simulated: Result<Vec<f64>, SimulationError> = at(k, step)?.simulate(drive, timing, start);
        Ok(simulated?)
    };
    (0..count)
        .into_par_iter()
        .map(|k| {
            let (up, down) = (simulated(k, STEP)?, simulated(k, -STEP)?);
            meter.add(1).map_err(|_| IdentifyError::Stopped)?;
            Ok(about_mean(up.iter().zip(&down).map(|(u, d)| (u - d) / (2.0 * STEP)).collect()))
        })
        // In order, independently of the threads.
        .collect()
}

/// The values less their mean.
pub(crate) fn about_mean(mut values: Vec<f64>) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter_mut().for_each(|v| *v -= mean);
    values
}
