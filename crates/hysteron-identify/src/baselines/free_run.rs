//! Simulation: the model's own past output is fed back.

use super::BaselineError;
use super::regressors::{Regressors, Series};
use super::signals::Units;
use hysteron_model::record::InputOutput;

/// A simulation has diverged beyond this multiple of half the training range from its middle.
const FAR: f64 = 10.0;

/// One step of a NARX model: y_k from its regressors.
pub trait OneStep: Sync {
    /// Prediction from regressors `x`.
    fn next(&self, x: &[f64]) -> f64;
    /// Number of fitted coefficients.
    fn parameters(&self) -> usize;
}

/// A [`OneStep`] with derivatives.
pub(super) trait Differentiable: OneStep + Clone {
    /// Its parameters.
    fn coefficients(&self) -> &[f64];
    /// Replaces the parameters of the model; its structure stays.
    fn set_coefficients(&mut self, coefficients: &[f64]);
    /// Prediction, and its derivatives by regressors and by parameters.
    fn derivatives(&self, x: &[f64], by_x: &mut [f64], by_parameter: &mut [f64]) -> f64;
}

/// Index of the sample at which a simulation diverged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Divergence(pub usize);

/// Simulates a series from the measured initial outputs spanned by the lags.
pub(super) fn free_run(
    model: &impl OneStep,
    regressors: &Regressors,
    series: &Series,
) -> Result<Vec<f64>, Divergence> {
    let past = regressors.lags.past();
    let mut y = series.y[..past.min(series.y.len())].to_vec();
    y.reserve(series.y.len() - y.len());
    let mut x = vec![0.0; regressors.lags.count()];
    for sample in past..series.y.len() {
        regressors.fill(series, &y, sample, &mut x);
        let output = model.next(&x);
        if output.is_nan() || output.abs() > FAR {
            return Err(Divergence(sample));
        }
        y.push(output);
    }
    Ok(y)
}

/// rms simulated error over the samples that are valid in `scored`, in units of half the training range;
/// `None` where a simulation diverges or nothing is scored. Initial samples are not scored.
pub(super) fn simulated_error(
    model: &impl OneStep,
    regressors: &Regressors,
    series: &[Series],
    scored: &[Vec<bool>],
) -> Option<f64> {
    let (mut square, mut count) = (0.0, 0usize);
    for (one, scored) in series.iter().zip(scored) {
        let y = free_run(model, regressors, one).ok()?;
        for k in (regressors.lags.past()..y.len()).filter(|&k| scored[k]) {
            square += (one.y[k] - y[k]).powi(2);
            count += 1;
        }
    }
    (count > 0).then(|| (square / count as f64).sqrt())
}

/// Simulates a record at its own rate: each phase of the lag interval is simulated separately.
pub(super) fn simulate_record(
    model: &impl OneStep,
    regressors: &Regressors,
    units: &Units,
    record: &InputOutput,
) -> Result<Vec<f64>, BaselineError> {
    let phases = units.phases(record)?;
    let stride = phases.len();
    let mut simulated = record.y.clone();
    let mut diverged: Option<usize> = None;
    for (p, phase) in phases.iter().enumerate() {
        match free_run(model, regressors, phase) {
            Ok(y) => {
                let places = simulated.iter_mut().skip(p).step_by(stride);
                places.zip(y).for_each(|(place, y)| *place = units.output.physical(y));
            }
            Err(Divergence(sample)) => {
                let sample = p + stride * sample;
                diverged = Some(diverged.map_or(sample, |first| first.min(sample)));
            }
        }
    }
    match diverged {
        None => Ok(simulated),
        Some(sample) => {
            Err(BaselineError::Diverged { time_s: sample as f64 * units.interval_s / stride as f64 })
        }
    }
}
