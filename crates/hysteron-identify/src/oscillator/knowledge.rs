//! Covariance of the parameters of an oscillator.

use hysteron_model::model_file::OscillatorFile;
use nalgebra::DMatrix;

use super::coordinates::covariance as of_parameters;
use super::output_error::OutputError;
use crate::Correlation;
use crate::uncertainty::{correlation, covariance_of, standard_error};
use hysteron_model::oscillator::Oscillator;
use hysteron_optimize::{Derivative, LeastSquaresProblem, Problem};

/// One estimate.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Name as in [`Oscillator::NAMES`], or `natural_frequency` \[Hz\], `damping_ratio`.
    pub name: &'static str,
    /// Value in the units of the records.
    pub value: f64,
    /// Standard error; `None` where the parameter was held, ended at a bound, or is not determined.
    pub std_error: Option<f64>,
    /// It was held at this value.
    pub held: bool,
    /// It ended at a bound of its range.
    pub at_limit: bool,
}

impl Estimate {
    /// Unit as in the model file, empty for a pure number.
    pub fn unit(&self, file: &OscillatorFile) -> String {
        let parameter =
            Oscillator::NAMES.iter().zip(file.parameters.all()).find(|(name, _)| **name == self.name);
        match (parameter, self.name) {
            (Some((_, quantity)), _) if quantity.unit == "1" => String::new(),
            (Some((_, quantity)), _) => quantity.unit.clone(),
            (None, "natural_frequency") => "Hz".to_owned(),
            (None, _) => String::new(),
        }
    }
}

/// Distance from a bound on the unit box within which a coordinate is at the bound.
const AT_END: f64 = 1e-9;

/// Estimates of the parameters at the solution `x`, and their correlation.
pub(super) fn estimates(
    problem: &OutputError<'_>,
    x: &[f64],
    held: &[&str],
) -> (Vec<Estimate>, Option<Correlation>) {
    let oscillator = problem.oscillator(x);
    let values = oscillator.values();
    let at_end = |index: usize| {
        let range = &problem.bounds().ranges[index];
        let t = range.to_unit(x[index]);
        !(AT_END..=1.0 - AT_END).contains(&t)
    };
    let free: Vec<usize> = (0..x.len()).filter(|&i| !at_end(i)).collect();
    let covariance = covariance(problem, x, &free);
    let n_at_end = problem.searched.iter().position(|&j| j == super::coordinates::N).is_some_and(at_end);
    let variance = |i: usize| covariance.as_ref().map(|c| c[(i, i)]).filter(|v| *v > 0.0);
    let mut all: Vec<Estimate> = Oscillator::NAMES
        .into_iter()
        .zip(values)
        .enumerate()
        .map(|(i, (name, value))| {
            let held = held.contains(&name);
            let at_limit = !held && name == "n" && n_at_end;
            let std_error = variance(i).map(f64::sqrt).filter(|_| !held && !at_limit);
            Estimate { name, value, std_error, held, at_limit }
        })
        .collect();
    let mut derive = |name, f: fn(&Oscillator) -> f64| {
        let of = |values: &[f64]| {
            values.try_into().map_or(f64::NAN, |values: [f64; 7]| f(&Oscillator::from_values(values)))
        };
        let std_error = covariance.as_ref().and_then(|c| standard_error(c, &values, of));
        all.push(Estimate { name, value: f(&oscillator), std_error, held: false, at_limit: false });
    };
    derive("natural_frequency", Oscillator::natural_frequency_hz);
    derive("damping_ratio", Oscillator::damping_ratio);
    let names: Vec<usize> = (0..values.len()).filter(|&i| all[i].std_error.is_some()).collect();
    let correlation = covariance.filter(|_| !names.is_empty()).map(|c| {
        let chosen = DMatrix::from_fn(names.len(), names.len(), |i, j| c[(names[i], names[j])]);
        correlation("oscillator", names.iter().map(|&i| all[i].name.to_owned()).collect(), &chosen)
    });
    (all, correlation)
}

/// Covariance of the seven parameters, given the coordinates that are not `free`.
fn covariance(problem: &OutputError<'_>, x: &[f64], free: &[usize]) -> Option<DMatrix<f64>> {
    let rows = problem.residual_count();
    let mut workspace = problem.workspace();
    let mut residual = vec![0.0; rows];
    let mut columns = vec![0.0; rows * x.len()];
    if !problem.residuals(x, &mut workspace, &mut residual)
        || problem.jacobian(x, &mut workspace, &mut columns) != Derivative::Written
    {
        return None;
    }
    let jacobian = DMatrix::from_fn(rows, free.len(), |i, j| columns[free[j] * rows + i]);
    let all = covariance_of(jacobian, &residual)?;
    let count = free.iter().filter(|&&i| i < problem.searched.len()).count();
    let searched: Vec<usize> = free.iter().take(count).map(|&i| problem.searched[i]).collect();
    let own = all.view((0, 0), (count, count)).into_owned();
    Some(of_parameters(&problem.coordinates(x), problem.size, &searched, &own))
}
