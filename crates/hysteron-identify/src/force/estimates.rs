//! Numbers of a force with their standard errors.

use hysteron_model::force::ForceModel;
use nalgebra::DMatrix;

use super::problem::ForceProblem;
use crate::Correlation;
use crate::uncertainty::{correlation, covariance_of};

/// One estimate.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Name as in [`ForceModel::numbers`].
    pub name: String,
    /// Value in the units of the records.
    pub value: f64,
    /// Standard error; `None` where the number was held, ended at a bound, or is not determined.
    pub std_error: Option<f64>,
    /// It was held at this value.
    pub held: bool,
    /// It ended at a bound of its range.
    pub at_limit: bool,
}

/// Step of a central difference, relative to the number.
const STEP: f64 = 1e-4;

/// Estimates of the numbers of `model`, and their correlation. `held`: names of the numbers that were not
/// estimated; `at_limit`: of those that ended at a bound. The others are estimated given these.
pub(super) fn estimates(
    problem: &ForceProblem<'_>,
    model: &ForceModel,
    held: &[String],
    at_limit: &[String],
) -> (Vec<Estimate>, Option<Correlation>) {
    let mut all: Vec<Estimate> = model
        .numbers()
        .into_iter()
        .map(|(name, value)| Estimate {
            held: held.contains(&name),
            at_limit: at_limit.contains(&name) || (value == 0.0 && name != "offset" && !held.contains(&name)),
            std_error: None,
            name,
            value,
        })
        .collect();
    let free: Vec<usize> = (0..all.len()).filter(|&i| !all[i].held && !all[i].at_limit).collect();
    let columns: Option<Vec<Vec<f64>>> =
        free.iter().map(|&i| derivative(problem, model, &all[i].name)).collect();
    let Some((columns, residual)) = columns.zip(problem.residual_of(model)) else { return (all, None) };
    let jacobian = DMatrix::from_fn(residual.len(), free.len(), |i, j| columns[j][i]);
    let Some(covariance) = covariance_of(jacobian, &residual) else { return (all, None) };
    for (j, &i) in free.iter().enumerate() {
        all[i].std_error = Some(covariance[(j, j)].sqrt()).filter(|error| error.is_finite());
    }
    let names = free.iter().map(|&i| all[i].name.clone()).collect();
    (all, Some(correlation("force", names, &covariance)))
}

/// ∂residual/∂number, by central differences.
fn derivative(problem: &ForceProblem<'_>, model: &ForceModel, name: &str) -> Option<Vec<f64>> {
    let at = |change: f64| {
        let mut moved = model.clone();
        *moved.number_mut(name)? += change;
        problem.residual_of(&moved)
    };
    let value = model.clone().number_mut(name).map(|value| *value)?;
    let step = STEP * if value == 0.0 { 1.0 } else { value.abs() };
    let (above, below) = (at(step)?, at(-step)?);
    Some(above.iter().zip(&below).map(|(a, b)| (a - b) / (2.0 * step)).collect())
}
