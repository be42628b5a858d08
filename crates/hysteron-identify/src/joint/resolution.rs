//! Tolerances of a joint fit, from the effective number of independent residual samples.

use super::super::uncertainty::correlation_time;
use super::problem::JointProblem;
use hysteron_optimize::{LeastSquaresOptions, LeastSquaresProblem};

/// Change of −2 ln of the likelihood by one step that changes no conclusion: that of a step of 0.3 standard
/// errors.
const NEGLIGIBLE: f64 = 0.1;
/// Share of the resolution to which the optimum of a chosen structure is fitted: steps of 0.03 standard
/// errors.
pub(super) const FINAL: f64 = 0.01;
/// The same for reduced records whose optimum starts the fit of all samples: steps of 0.1 standard errors.
pub(super) const BEFORE_ALL: f64 = 0.1;
/// Largest resolution: where the residuals have few independent samples, the structure or the start is wrong,
/// and a better one has more.
pub(super) const COARSE: f64 = 1e-5;

/// A rough fit whose cost is within this many times the best may lead to a better optimum.
pub(super) const NEAR: f64 = 1.1;

/// Effective number of independent samples of the residuals at `x`.
pub(in super::super) fn information(problem: &JointProblem, x: &[f64]) -> f64 {
    let times = correlation_times(problem, x);
    problem.records().iter().zip(times).map(|(record, time)| record.valid as f64 / time).sum::<f64>().max(2.0)
}

/// Correlation time of the residuals of every record at `x`; 1 where it cannot be simulated, or after a stop.
pub(super) fn correlation_times(problem: &JointProblem, x: &[f64]) -> Vec<f64> {
    let residuals = problem.residuals_of(x).unwrap_or_else(|| vec![0.0; problem.residual_count()]);
    (0..problem.records().len()).map(|r| correlation_time(&residuals[problem.rows(r)])).collect()
}

/// Fits that end where the squared cost falls by less than this share.
pub(super) fn resolved(resolution: f64) -> LeastSquaresOptions {
    LeastSquaresOptions { cost_tolerance: resolution, ..Default::default() }
}

/// Share by which the squared cost at `x` may differ without effect: −2 ln of the likelihood by
/// [`NEGLIGIBLE`], over the independent samples of the residuals; a power of two, the next below, since
/// resumed searches compare it and the last bits of the residuals differ between processors.
pub(super) fn resolution(problem: &JointProblem, x: &[f64]) -> f64 {
    let octave = (NEGLIGIBLE / information(problem, x)).log2().floor();
    2f64.powi(octave as i32).min(COARSE)
}
