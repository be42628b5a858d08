//! Identification of one structure from a frequency response.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::problem::ResponseProblem;
use super::start::{one_mode_more, starts};
use super::{Core, FrequencyResponse, Structure};
use crate::IdentifyError;
use hysteron_model::record::NOISY;
use hysteron_numeric::Complex64;
use hysteron_optimize::{
    Algorithm, Bounds, LeastSquaresOptions, OptimizeError, Outcome, Problem, Settings, Unobserved, minimize,
    root_mean_square,
};

/// Iterations of one start.
const ITERATIONS: usize = 150;
/// Relative cost tolerance for starts that reached the best optimum.
const SAME_OPTIMUM: f64 = 1e-4;

/// Scale of the residuals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weighting {
    /// The measured value: relative errors, to first order the difference of the complex logarithms.
    Relative,
    /// The measured value and the scatter of its neighbours ([`FrequencyResponse::scatter`]): √(|G|² +
    /// (s/0.3)²), so that noisy points have little weight.
    Scatter,
    /// The standard deviation of the point; `Relative` where the response has none.
    Uncertainty,
}

impl Weighting {
    /// By the uncertainty if given, by the scatter where more than 5 % of the points are noise, else
    /// relative.
    pub fn of(response: &FrequencyResponse) -> Self {
        if response.std_dev.is_some() {
            return Self::Uncertainty;
        }
        let points = response.scatter().into_iter().zip(&response.values);
        let noisy = points.filter(|(s, g)| *s > NOISY * g.norm()).count();
        if 20 * noisy > response.len() { Self::Scatter } else { Self::Relative }
    }

    /// Name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Relative => "relative",
            Self::Scatter => "scatter",
            Self::Uncertainty => "uncertainty",
        }
    }

    /// The weighting in words.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Relative => "relative errors",
            Self::Scatter => "relative errors, weighted less where neighbours scatter",
            Self::Uncertainty => "errors weighted by their uncertainty",
        }
    }
}

/// A parameter of a fitted structure.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedParameter {
    /// Name, e.g. `exponent`.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit: `Hz`, `s`, `rad`, the response's own for gains, empty for pure numbers.
    pub unit: String,
    /// Standard error; `None` at a bound or where the response does not determine it.
    pub std_error: Option<f64>,
    /// It ended at a bound of its search range.
    pub on_edge: bool,
}

/// A structure fitted to a response.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseFit {
    /// The structure.
    pub structure: Structure,
    /// Weighting of the residuals.
    pub weighting: Weighting,
    /// Nonlinear parameters, then linear coefficients.
    pub parameters: Vec<FittedParameter>,
    /// Covariance of the parameters; zero rows and columns for those at a bound, all zero where the others
    /// are not determined.
    pub covariance: DMatrix<f64>,
    /// Number of points.
    pub points: usize,
    /// √(mean |Ĝ/G − 1|²).
    pub relative_rms: f64,
    /// Largest |Ĝ/G − 1| and its frequency \[Hz\].
    pub largest: (f64, f64),
    /// Akaike's criterion for N points and k parameters: 2N ln(Σ|w e|²/2N) + 2k by relative weights, Σ|w
    /// e|² + 2k by uncertainties. Only differences between structures on the same points are meaningful;
    /// residuals are assumed independent.
    pub aic: f64,
    /// Σ|w e|², the weighted sum of squares.
    pub square: f64,
    /// Correlation factor: points per independent point (1: residuals independent).
    pub correlation: f64,
    /// Starts followed.
    pub starts: usize,
    /// Starts that ended in the best optimum.
    pub agreeing: usize,
}

/// Fits a structure: linear starts over a coarse grid (modes one by one, each fit also a start of the next),
/// then bounded least squares on all nonlinear parameters, linear coefficients projected out.
///
/// Standard errors are those of linearised least squares. The variance is that of the residuals, or with
/// uncertainties 1 and more where the residuals exceed them; times the correlation factor of neighbouring
/// residuals (1 + 2Σρ up to the first ρ ≤ 0), as model error is always correlated.
///
/// # Errors
/// [`IdentifyError`]: an invalid response, too few points (2N must exceed the number of parameters), a value
/// of zero under relative weights, no start.
pub fn fit_structure(
    response: &FrequencyResponse,
    structure: &Structure,
    weighting: Weighting,
) -> Result<ResponseFit, IdentifyError> {
    response.check()?;
    structure.check()?;
    check_points(response, structure)?;
    match structure.core {
        Core::Modes { count } if count > 1 => {
            let simpler = Structure { core: Core::Modes { count: count - 1 }, ..*structure };
            let before = fit_structure(response, &simpler, weighting)?;
            fit_beside(response, structure, weighting, Some(&before))
        }
        _ => fit_beside(response, structure, weighting, None),
    }
}

/// [`fit_structure`] of a structure that contains a fitted one, with that as an additional start, so that it
/// never fits worse.
pub(super) fn fit_containing(
    response: &FrequencyResponse,
    weighting: Weighting,
    (fitted, contained): (ResponseFit, &ResponseFit),
) -> Result<ResponseFit, IdentifyError> {
    if fitted.square <= contained.square {
        return Ok(fitted);
    }
    let structure = fitted.structure;
    let problem = ResponseProblem::new(response, structure, weighting)?;
    // A factor missing in the simpler structure is one there.
    let start =
        problem.bounds().ranges.iter().map(|range| contained.value(&range.name).clamp(range.low, range.high));
    let outcome = polish(&problem, vec![start.collect()])?;
    let mut best = outcome.best;
    sort_pairs(&structure, &mut best);
    let again = result(response, &problem, weighting, &best, (fitted.starts + 1, 1));
    Ok(if again.square < fitted.square { again } else { fitted })
}

/// [`fit_structure`], started also from a fit of the same factors with one mode less.
pub(super) fn fit_beside(
    response: &FrequencyResponse,
    structure: &Structure,
    weighting: Weighting,
    before: Option<&ResponseFit>,
) -> Result<ResponseFit, IdentifyError> {
    response.check()?;
    structure.check()?;
    check_points(response, structure)?;
    if let Some(zero) = response.values.iter().position(|g| *g == Complex64::ZERO) {
        return Err(response.bad_value(zero, "usable for relative errors").into());
    }
    let problem = ResponseProblem::new(response, *structure, weighting)?;
    if structure.nonlinear_count() == 0 {
        return Ok(result(response, &problem, weighting, &[], (1, 1)));
    }
    let mut starts = starts(response, &problem);
    if let (Some(before), Core::Modes { count }) = (before, structure.core) {
        let x: Vec<f64> = before.parameters.iter().map(|p| p.value).collect();
        let x = &x[..before.structure.nonlinear_count().min(x.len())];
        starts.extend(one_mode_more(response, &problem, x, count - 1));
    }
    if starts.is_empty() {
        let (structure, name) = (structure.to_string(), response.name.clone());
        return Err(IdentifyError::NoResponseStart { structure, name });
    }
    let outcome = polish(&problem, starts)?;
    let same = |cost: f64| cost <= outcome.cost * (1.0 + SAME_OPTIMUM) + 1e-12;
    let agreeing = outcome.starts.iter().filter(|start| same(start.cost)).count();
    let mut best = outcome.best;
    sort_pairs(structure, &mut best);
    Ok(result(response, &problem, weighting, &best, (outcome.starts.len(), agreeing)))
}

/// Pairs of poles by ascending frequency.
fn sort_pairs(structure: &Structure, x: &mut [f64]) {
    let (real, pairs) = match structure.core {
        Core::Rational { poles, .. } => (poles % 2, poles / 2),
        Core::Modes { count } => (0, count),
        _ => return,
    };
    let mut sorted: Vec<[f64; 2]> = x[real..real + 2 * pairs].chunks_exact(2).map(|p| [p[0], p[1]]).collect();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    x[real..real + 2 * pairs].copy_from_slice(sorted.as_flattened());
}

fn check_points(response: &FrequencyResponse, structure: &Structure) -> Result<(), IdentifyError> {
    let parameters = structure.parameter_count();
    if 2 * response.len() <= parameters {
        let (low_hz, high_hz) = response.range_hz();
        return Err(IdentifyError::TooFewPoints {
            name: response.name.clone(),
            low_hz,
            high_hz,
            structure: structure.to_string(),
            parameters,
            need: parameters / 2 + 1,
            found: response.len(),
        });
    }
    Ok(())
}

fn polish(problem: &ResponseProblem, starts: Vec<Vec<f64>>) -> Result<Outcome, OptimizeError> {
    let algorithm = Algorithm::LeastSquares(LeastSquaresOptions {
        starts: starts.len(),
        agreement: None,
        iterations: ITERATIONS,
        ..LeastSquaresOptions::default()
    });
    let settings = Settings { starts, ..Settings::default() };
    minimize(problem, &algorithm, &settings, &mut Unobserved, None)
}

fn result(
    response: &FrequencyResponse,
    problem: &ResponseProblem,
    weighting: Weighting,
    x: &[f64],
    (starts, agreeing): (usize, usize),
) -> ResponseFit {
    let structure = problem.structure;
    let coefficients = problem.coefficients(x);
    let edges = on_edge(problem.bounds(), x);
    let covariance = covariance(problem, weighting, response.std_dev.is_some(), x, &edges);
    let std_error = |i: usize| Some(covariance[(i, i)].sqrt()).filter(|error| *error > 0.0);
    let gain = || response.unit.clone();
    let units = structure.units().into_iter().map(str::to_owned);
    let named = problem.bounds().ranges.iter().map(|range| range.name.clone()).zip(units);
    let named = named.chain(structure.linear_names().into_iter().map(|name| (name, gain())));
    let values: Vec<f64> = x.iter().chain(&coefficients).copied().collect();
    let parameters = named
        .zip(&values)
        .enumerate()
        .map(|(i, ((name, unit), &value))| FittedParameter {
            name,
            value,
            unit,
            std_error: std_error(i).filter(|error| *error <= UNDETERMINED * value.abs()),
            on_edge: edges.get(i).copied().unwrap_or(false),
        })
        .collect();
    let (residuals, _) = problem.full_jacobian(x);
    let square: f64 = residuals.iter().map(|r| r * r).sum();
    let (rows, k) = (residuals.len() as f64, values.len() as f64);
    let by_uncertainty = weighting == Weighting::Uncertainty && response.std_dev.is_some();
    let aic = 2.0 * k + if by_uncertainty { square } else { rows * (square / rows).ln() };
    let mut fit = ResponseFit {
        structure,
        weighting,
        parameters,
        covariance,
        points: response.len(),
        relative_rms: 0.0,
        largest: (0.0, 0.0),
        aic,
        square,
        correlation: correlation(&residuals),
        starts,
        agreeing,
    };
    let errors: Vec<f64> = fit.relative_errors(response).iter().map(|e| e.norm()).collect();
    fit.relative_rms = root_mean_square(&errors);
    for (&error, &f) in errors.iter().zip(&response.frequency_hz) {
        if error > fit.largest.0 {
            fit.largest = (error, f);
        }
    }
    fit
}

fn on_edge(bounds: &Bounds, x: &[f64]) -> Vec<bool> {
    let edge = |t: f64| !(1e-9..=1.0 - 1e-9).contains(&t);
    bounds.ranges.iter().zip(x).map(|(range, &x)| edge(range.to_unit(x))).collect()
}

/// A parameter whose standard error exceeds this multiple of its value is undetermined.
const UNDETERMINED: f64 = 1e3;

/// Covariance of all parameters; zero for those at a bound, and for all where the others are not determined.
fn covariance(
    problem: &ResponseProblem,
    weighting: Weighting,
    has_uncertainty: bool,
    x: &[f64],
    edges: &[bool],
) -> DMatrix<f64> {
    let (residuals, columns) = problem.full_jacobian(x);
    let rows = residuals.len();
    let count = columns.len() / rows;
    let free: Vec<usize> = (0..count).filter(|&j| !edges.get(j).copied().unwrap_or(false)).collect();
    let mut covariance = DMatrix::zeros(count, count);
    let mut jacobian = DMatrix::from_column_slice(rows, count, &columns).select_columns(&free);
    // Columns of unit length: their units differ by many decades.
    let norms: Vec<f64> = jacobian.column_iter().map(|c| c.norm()).collect();
    if rows <= free.len() || norms.iter().any(|n| !(*n > 0.0 && n.is_finite())) {
        return covariance;
    }
    for (mut column, norm) in jacobian.column_iter_mut().zip(&norms) {
        column /= *norm;
    }
    let Some(inverse) = jacobian.qr().r().try_inverse() else { return covariance };
    let square: f64 = residuals.iter().map(|r| r * r).sum();
    let mut variance = square / (rows - free.len()) as f64;
    if weighting == Weighting::Uncertainty && has_uncertainty {
        variance = variance.max(1.0);
    }
    let factor = variance * correlation(&residuals);
    let small = &inverse * inverse.transpose() * factor;
    if small.iter().all(|v| v.is_finite()) {
        for (a, (&i, own)) in free.iter().zip(&norms).enumerate() {
            for (b, (&j, other)) in free.iter().zip(&norms).enumerate() {
                covariance[(i, j)] = small[(a, b)] / (own * other);
            }
        }
    }
    covariance
}

/// 1 + 2Σ ρ_k over neighbouring frequencies, up to the first ρ_k ≤ 0 or a tenth of the points. `residuals`:
/// real parts, then imaginary parts.
fn correlation(residuals: &[f64]) -> f64 {
    let (re, im) = residuals.split_at(residuals.len() / 2);
    let power: f64 = residuals.iter().map(|r| r * r).sum();
    if power <= 0.0 {
        return 1.0;
    }
    let products = |x: &[f64], lag: usize| x.iter().zip(&x[lag..]).map(|(a, b)| a * b).sum::<f64>();
    let shares = (1..=re.len() / 10).map(|lag| (products(re, lag) + products(im, lag)) / power);
    1.0 + shares.take_while(|&share| share > 0.0).map(|share| 2.0 * share).sum::<f64>()
}

impl ResponseFit {
    /// The parameter of this name.
    pub fn parameter(&self, name: &str) -> Option<&FittedParameter> {
        self.parameters.iter().find(|p| p.name == name)
    }

    /// Value of the parameter of this name; 0 where the structure has none.
    pub fn value(&self, name: &str) -> f64 {
        self.parameter(name).map_or(0.0, |p| p.value)
    }

    /// The fitted response at frequencies \[Hz\].
    pub fn response_at(&self, frequency_hz: &[f64]) -> Vec<Complex64> {
        let values: Vec<f64> = self.parameters.iter().map(|p| p.value).collect();
        let (x, coefficients) = values.split_at(self.structure.nonlinear_count().min(values.len()));
        let mut functions = vec![Complex64::ZERO; coefficients.len()];
        let mut slopes = vec![Complex64::ZERO; coefficients.len() * x.len()];
        let at = |&f: &f64| {
            self.structure.evaluate(TAU * f, x, &mut functions, &mut slopes);
            functions.iter().zip(coefficients).map(|(value, c)| value * c).sum()
        };
        frequency_hz.iter().map(at).collect()
    }

    /// Ĝ/G − 1 at the points of a response.
    pub fn relative_errors(&self, response: &FrequencyResponse) -> Vec<Complex64> {
        let fitted = self.response_at(&response.frequency_hz);
        fitted.iter().zip(&response.values).map(|(fit, measured)| fit / measured - 1.0).collect()
    }
}

#[cfg(test)]
mod tests;
