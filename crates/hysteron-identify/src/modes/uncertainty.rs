//! Standard errors of the physical quantities of scheduled modes.
//!
//! With the weights w of the fit, the estimates have the covariance
//!
//! ```text
//! H⁻¹ (Σ w² σ² τ JᵀJ) H⁻¹,   H = Σ w JᵀJ,   over the outputs of all records
//! ```
//!
//! with the ridge on the slopes in H, whose bias is not counted; σ² the mean square of an output's residual
//! and τ its correlation time, as for the other kinds of model: correlated residuals carry less information
//! than white ones. A search that ends before its optimum adds the square of the Gauss–Newton step that it
//! has left. The scales of the states are undetermined, and H is singular along them; the quantities do not
//! depend on them.

use nalgebra::{DMatrix, DVector};

use super::columns::{Freedom, Group};
use super::normal::{information, residual};
use super::quantities::{Quantity, order, quantities};
use super::records::RecordPeriod;
use super::ridge::Ridge;
use crate::uncertainty::correlation_time;
use hysteron_model::axes::ScheduledModes;
use hysteron_numeric::cholesky;
use hysteron_optimize::Stop;

/// Added to the diagonal of H, scaled to 1: directions of less information count as undetermined.
const UNDETERMINED: f64 = 1e-9;
/// Largest share of a quantity's gradient along undetermined directions.
const LARGEST_SHARE: f64 = 0.01;
/// Step of the differences of a quantity, relative to a parameter of this size or more.
const STEP: f64 = 1e-6;
const LEAST_SIZE: f64 = 1e-3;

/// The quantities of the model with their standard errors: without where the records do not determine them,
/// or after a stop.
pub(super) fn with_standard_errors(
    model: &ScheduledModes,
    (groups, ridge): (&[Group], f64),
    pieces: &[&RecordPeriod],
    stop: &Stop,
) -> Vec<Quantity> {
    let order = order(model);
    let mut all = quantities(model, &order);
    let freedom = Freedom::new(model, groups);
    let Some(errors) = standard_errors(model, (&freedom, ridge), &order, pieces, stop) else { return all };
    all.iter_mut().zip(errors).for_each(|(quantity, error)| quantity.std_error = error);
    all
}

fn standard_errors(
    model: &ScheduledModes,
    (freedom, ridge): (&Freedom, f64),
    order: &[usize],
    pieces: &[&RecordPeriod],
    stop: &Stop,
) -> Option<Vec<Option<f64>>> {
    let variances = variances(model, freedom.columns.len(), pieces)?;
    let (mut inner, outer) = information(model, freedom, pieces, &variances, stop)?;
    let count = freedom.columns.len();
    let penalty = Ridge::new(freedom, model, &inner.matrix, ridge);
    penalty.add(&mut inner.matrix, &mut inner.gradient, &freedom.values(model));
    let per: Vec<f64> =
        inner.matrix.diagonal().iter().map(|d| if *d > 0.0 { d.sqrt().recip() } else { 0.0 }).collect();
    let scaled =
        |matrix: &DMatrix<f64>| DMatrix::from_fn(count, count, |i, j| matrix[(i, j)] * per[i] * per[j]);
    let mut regularised = scaled(&inner.matrix);
    (0..count).for_each(|k| regularised[(k, k)] += UNDETERMINED);
    let gradients = gradients(model, freedom, order, &per);
    let moved = cholesky(regularised)?.solve(&gradients);
    let spread = scaled(&outer) * &moved;
    let descent = DVector::from_fn(count, |k, _| inner.gradient[k] * per[k]);
    let error = |q: usize| {
        let (gradient, moved) = (gradients.column(q), moved.column(q));
        let undetermined = UNDETERMINED * moved.norm() / gradient.norm().max(f64::MIN_POSITIVE);
        let remaining = moved.dot(&descent);
        let variance = moved.dot(&spread.column(q)) + remaining * remaining;
        (undetermined <= LARGEST_SHARE && variance.is_finite()).then(|| variance.max(0.0).sqrt())
    };
    Some((0..gradients.ncols()).map(error).collect())
}

/// Variance that a sample of each output carries, record by record: mean square of the residual, corrected
/// for the number of parameters, times its correlation time.
fn variances(model: &ScheduledModes, parameters: usize, pieces: &[&RecordPeriod]) -> Option<Vec<Vec<f64>>> {
    let numbers: usize = pieces.iter().map(|piece| piece.period.y.len()).sum();
    let free = numbers.checked_sub(parameters).filter(|free| *free > 0)?;
    let correction = numbers as f64 / free as f64;
    let of_record = |piece: &&RecordPeriod| {
        let e = residual(model, piece)?;
        let of_output = |m: usize| {
            let e: Vec<f64> = e.iter().skip(m).step_by(model.outputs).copied().collect();
            let mean_square = e.iter().map(|e| e * e).sum::<f64>() / e.len() as f64;
            correction * mean_square * correlation_time(&e)
        };
        Some((0..model.outputs).map(of_output).collect())
    };
    pieces.iter().map(of_record).collect()
}

/// Derivatives of the quantities with respect to the scaled parameters, a column per quantity, by central
/// differences.
fn gradients(model: &ScheduledModes, freedom: &Freedom, order: &[usize], per: &[f64]) -> DMatrix<f64> {
    let sizes = freedom.values(model);
    let mut step = vec![0.0; sizes.len()];
    let mut gradients = DMatrix::zeros(sizes.len(), quantities(model, order).len());
    for (k, size) in sizes.iter().enumerate() {
        let h = STEP * size.abs().max(LEAST_SIZE);
        let mut at = |h: f64| {
            step[k] = h;
            let found = quantities(&freedom.moved(model, &step), order);
            step[k] = 0.0;
            found
        };
        for (q, (up, down)) in at(h).iter().zip(at(-h)).enumerate() {
            gradients[(k, q)] = (up.value - down.value) / (2.0 * h) * per[k];
        }
    }
    gradients
}
