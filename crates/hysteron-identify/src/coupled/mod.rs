//! Identification of coupled Hammerstein branches ([`hysteron_model::axes::CoupledHammerstein`]): all
//! branches of all outputs in one fit.
//!
//! Gains and offsets are linear and eliminated at every point of the search (variable projection: G. H.
//! Golub, V. Pereyra, doi:10.1137/0710036); the search is over three parameters per actuator and three per
//! path. Starts: one shape for all actuators, then a coordinate search over a grid of natural frequency,
//! damping and delay of each path; bounded least squares from the best. Standard errors are from the
//! derivatives with respect to all parameters, gains included, assuming white noise.

mod problem;
mod written;

use rayon::prelude::*;

use super::engine::Engine;
use super::watch::Plan;
use super::{Finding, FindingKind, Searches, Watch};
use crate::IdentifyError;
use crate::alike::same;
use hysteron_model::Model;
use hysteron_model::axes::{AxesRecord, AxesScores, CoupledErrors, CoupledHammerstein, SteadyPeriod};
use hysteron_model::model_file::{CoupledFile, SignalUnits};
use hysteron_model::validate::Scoring;
use hysteron_optimize::{
    Algorithm, Differences, LeastSquaresOptions, Problem, Settings, Stop, residual_jacobian,
};
use problem::{CoupledProblem, OF_ACTUATOR, OF_PATH, SettledRecord};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Grid of damping ratios, and of natural frequencies as shares of the sample rate.
const DAMPINGS: [f64; 3] = [0.02, 0.15, 0.8];
const FREQUENCIES: [f64; 14] =
    [0.01, 0.016, 0.025, 0.035, 0.05, 0.065, 0.08, 0.1, 0.125, 0.15, 0.19, 0.24, 0.3, 0.4];
/// Grid of delays \[samples\].
const DELAYS: [f64; 2] = [0.3, 3.0];
/// Rounds over all paths.
const ROUNDS: usize = 3;
/// Initial loop shapes: α, β' times half the range of the drive.
const SHAPES: [(f64, f64); 2] = [(0.2, 2.0), (0.35, 0.7)];

/// Options of the identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "BranchesOptions")]
pub struct Options {
    /// Least fit accepted, pooled over the outputs of each record \[%\].
    pub least_fit_percent: f64,
}

impl Default for Options {
    /// At least 75 % explained.
    fn default() -> Self {
        Self { least_fit_percent: 75.0 }
    }
}

/// Stages of the identification.
pub(crate) const PLAN: Plan = Plan(&[("starts", 0.3), ("branches", 0.6), ("standard errors", 0.1)]);

/// Identified branches.
#[derive(Clone, Debug)]
pub struct CoupledIdentification {
    /// The model.
    pub model: CoupledHammerstein,
    /// Standard errors; `None` where the records do not determine the parameters.
    pub errors: Option<CoupledErrors>,
    /// Scores of every record, in their order.
    pub records: Vec<AxesScores>,
    /// Verdicts, advice and warnings in plain words.
    pub findings: Vec<Finding>,
    /// The search was stopped early; the model is the best so far.
    pub interrupted: bool,
    /// State to resume from.
    pub resume: Searches,
}

/// Identifies the branches from records that share the device, the sample rate and the channels. Every input
/// is at rest at its first sample before its record, or in periodic steady state where all repeat.
///
/// # Errors
/// [`IdentifyError`].
pub fn identify(
    records: &[AxesRecord],
    options: &Options,
    watch: &Watch<'_>,
    resume: Option<Searches>,
) -> Result<CoupledIdentification, IdentifyError> {
    let first = records.first().filter(|r| !r.y.is_empty()).ok_or(IdentifyError::NoOutputs)?;
    same(first, records)?;
    let pieces: Vec<SettledRecord> = records
        .iter()
        .map(|record| {
            let period = SteadyPeriod::find(record, false).ok().filter(|p| p.settling == 0);
            SettledRecord { record, settled: period.map(|p| p.samples()) }
        })
        .collect();
    let problem = CoupledProblem::new(&pieces, None).ok_or(IdentifyError::NoOutputs)?;
    let mut engine = Engine::new(None, Settings::default(), watch, PLAN, resume);
    engine.enter("starts");
    let starts: Vec<Vec<f64>> =
        SHAPES.par_iter().filter_map(|shape| start(&problem, *shape, watch.stop())).collect();
    if starts.is_empty() {
        return Err(if watch.is_stopped() { IdentifyError::Stopped } else { IdentifyError::NoBranches });
    }
    let search =
        LeastSquaresOptions { starts: starts.len(), agreement: None, ..LeastSquaresOptions::default() };
    let shown = |x: &[f64]| {
        let units = SignalUnits::of(&first.u_unit, &first.y_unit);
        let names = (first.inputs.clone(), first.outputs.clone());
        Model::try_from(CoupledFile::new(&problem.model(x)?, None, units, names)).ok()
    };
    let search = Algorithm::LeastSquares(search);
    let found = engine.run("branches", &problem, &search, starts, Some(&shown))?.outcome;
    let model = problem.model(&found.best).ok_or(IdentifyError::NoBranches)?;
    let errors =
        if engine.enter("standard errors") { errors(&pieces, &problem, &model, &found.best) } else { None };
    let scores = pieces
        .iter()
        .map(|piece| {
            let r = piece.record;
            let simulated = model.simulate(&r.u, r.sample_rate_hz, piece.settled)?;
            Ok(AxesScores::new(r, &simulated, &Scoring::default(), None)?)
        })
        .collect::<Result<Vec<_>, IdentifyError>>()?;
    for (record, score) in records.iter().zip(&scores) {
        let fit_percent = score.fit_percent.unwrap_or(0.0);
        // After a stop any fit is accepted.
        if fit_percent < options.least_fit_percent && !engine.cancelled {
            let (record, need) = (record.label(), options.least_fit_percent);
            return Err(IdentifyError::AxesClass { what: "branches", record, fit_percent, need });
        }
    }
    let findings = findings(errors.as_ref());
    let (interrupted, resume) = (engine.cancelled, engine.searches());
    Ok(CoupledIdentification { model, errors, records: scores, findings, interrupted, resume })
}

/// Best point of the grid, by coordinate search over the paths; `None` where no point can be simulated, or
/// after a stop.
fn start(problem: &CoupledProblem<'_>, (alpha, beta): (f64, f64), stop: &Stop) -> Option<Vec<f64>> {
    let bounds = problem.bounds();
    let rate = problem.pieces.first()?.record.sample_rate_hz;
    let mut x: Vec<f64> = bounds.ranges.iter().map(|r| r.from_unit(0.5)).collect();
    for n in 0..problem.inputs {
        // The range of β' is centred on 2 over the range of the drive.
        x[n * OF_ACTUATOR] = alpha;
        x[n * OF_ACTUATOR + 1] *= beta;
        x[n * OF_ACTUATOR + 2] = 0.0;
    }
    let paths = problem.inputs * problem.outputs;
    let place = |path: usize| OF_ACTUATOR * problem.inputs + OF_PATH * path;
    let mut tried: Vec<[f64; 3]> = Vec::new();
    for frequency in FREQUENCIES {
        for damping in DAMPINGS {
            tried.extend(DELAYS.map(|delay| [frequency * rate, damping, delay / rate]));
        }
    }
    let set = |x: &mut [f64], path: usize, values: &[f64; 3]| {
        x[place(path)..place(path) + OF_PATH].copy_from_slice(values);
    };
    (0..paths).for_each(|path| set(&mut x, path, &tried[tried.len() / 2]));
    let mut columns = problem.columns(&problem.point(&x))?;
    let mut least = vec![f64::INFINITY; problem.outputs];
    for _ in 0..ROUNDS {
        let before: f64 = least.iter().sum();
        for path in 0..paths {
            let (m, n) = (path / problem.inputs, path % problem.inputs);
            let attempt = |values: &[f64; 3]| {
                if stop.is_requested() {
                    return None;
                }
                let mut moved = x.clone();
                set(&mut moved, path, values);
                let column = problem.column(&problem.point(&moved), m, n)?;
                let own: Vec<&Vec<f64>> = (0..problem.inputs)
                    .map(|k| if k == n { &column } else { &columns[m * problem.inputs + k] })
                    .collect();
                let (e, _) = problem.residuals_of(m, &own, None)?;
                let cost: f64 = e.iter().map(|e| e * e).sum();
                Some((cost, column))
            };
            let attempts: Vec<_> = tried.par_iter().map(attempt).collect();
            for (values, found) in tried.iter().zip(attempts) {
                if let Some((cost, column)) = found
                    && cost < least[m]
                {
                    least[m] = cost;
                    columns[path] = column;
                    set(&mut x, path, values);
                }
            }
        }
        if least.iter().sum::<f64>() >= before {
            break;
        }
    }
    least.iter().all(|cost| cost.is_finite()).then_some(x)
}

/// Standard errors from the derivatives with respect to all parameters but the offsets, which are eliminated
/// in every residual.
fn errors(
    pieces: &[SettledRecord<'_>],
    problem: &CoupledProblem<'_>,
    model: &CoupledHammerstein,
    best: &[f64],
) -> Option<CoupledErrors> {
    let gains: Vec<f64> = model.paths.iter().map(|p| p.gain).collect();
    let whole = CoupledProblem::new(pieces, Some(&gains))?;
    let x: Vec<f64> = best.iter().chain(&gains).copied().collect();
    let jacobian = residual_jacobian(&whole, &x, Differences::central()).ok()?;
    let (residuals, _) = problem.solve(best)?;
    let free = residuals.len().checked_sub(x.len() + pieces.len() * problem.outputs).filter(|n| *n > 0)?;
    let variance = residuals.iter().map(|e| e * e).sum::<f64>() / free as f64;
    let normal = jacobian.transpose() * &jacobian;
    let scale: Vec<f64> = normal.diagonal().iter().map(|d| d.sqrt()).collect();
    if scale.iter().any(|s| !(s.is_finite() && *s > 0.0)) {
        return None;
    }
    let count = scale.len();
    let scaled = nalgebra::DMatrix::from_fn(count, count, |i, j| normal[(i, j)] / (scale[i] * scale[j]));
    let inverse = scaled.cholesky()?.inverse();
    let of = |i: usize, j: usize| variance * inverse[(i, j)] / (scale[i] * scale[j]);
    let error = |i: usize| of(i, i).sqrt();
    let actuators = (0..problem.inputs).map(|n| {
        let (a, b, c) = (n * OF_ACTUATOR, n * OF_ACTUATOR + 1, n * OF_ACTUATOR + 2);
        // γ = ± β ρ.
        let (beta, rho) = (best[b], best[c]);
        let of_gamma = rho * rho * of(b, b) + beta * beta * of(c, c) + 2.0 * rho * beta * of(b, c);
        [error(a), error(b), of_gamma.max(0.0).sqrt()]
    });
    let first = OF_ACTUATOR * problem.inputs;
    let paths = (0..gains.len()).map(|k| {
        let at = first + OF_PATH * k;
        [error(best.len() + k), error(at), error(at + 1), error(at + 2)]
    });
    Some(CoupledErrors { actuators: actuators.collect(), paths: paths.collect() })
}

fn findings(errors: Option<&CoupledErrors>) -> Vec<Finding> {
    if errors.is_some() {
        return Vec::new();
    }
    let text = "these records do not determine all parameters: there are no standard errors. Drive every \
                input over a wider range of frequencies and amplitudes."
        .to_owned();
    vec![Finding::new(FindingKind::Warning, "parameters", text)]
}
