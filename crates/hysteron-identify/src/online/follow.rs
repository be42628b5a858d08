//! Online correction of a model over a whole record.

use super::{Adapter, Alarm, Correction, Estimator, Term};
use crate::IdentifyError;
use hysteron_model::Start;
use hysteron_model::hammerstein::Model;
use hysteron_model::model_file::{ModelFile, ScoreRole};
use hysteron_model::record::{InputOutput, find_periods, noise_floor, range_of, shortest_swing};
use hysteron_model::validate::{OffsetTreatment, Scores, Scoring, score};
use hysteron_rt::{FitMonitor, MonitorSettings, Nlms, NlmsSettings, Rls, RlsSettings, Unexcited};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Most terms of a correction over a record.
pub const MOST_TERMS: usize = 6;
/// Default memory of recursive least squares, as a share of the record.
const MEMORY: f64 = 0.2;
/// Prior standard deviation of a coefficient's effect, as a share of the stroke.
const MAY_MOVE: f64 = 0.1;
/// Shift of the mean and growth of the standard deviation to be detected, in units of the noise.
const SHIFT: f64 = 0.5;
const SPREAD: f64 = 1.5;
/// Default number of samples used in half of the drive's shortest period.
const IN_A_SWING: usize = 20;
/// Fewest samples of an alarm.
const FEWEST: u16 = 3;
/// Shortest memory, in samples used.
const SHORTEST_MEMORY: f64 = 2.0;

/// Options of [`Followed::over`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FollowOptions {
    /// Estimator of the coefficients.
    pub method: FollowMethod,
    /// Adapted coefficients, 1 to [`MOST_TERMS`].
    pub terms: Vec<Term>,
    /// Standard deviation of a residual where the model fits \[µm\], above 0; see [`known_noise`].
    pub noise: f64,
    /// Decimation factor of the samples used; `None`: 40 samples per period of the fastest drive, fewer where
    /// the residuals are correlated for longer.
    pub every: Option<usize>,
    /// Least mean number of samples between false alarms (average run length).
    pub run_length: f64,
    /// Reset the covariance of the coefficients after an alarm.
    pub reopen: bool,
}

/// Estimator of the coefficients.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FollowMethod {
    /// Recursive least squares with forgetting.
    LeastSquares {
        /// Memory \[s\]; `None`: a fifth of the record.
        memory_s: Option<f64>,
    },
    /// Normalised least mean squares.
    Gradient {
        /// Step size, above 0 and below 2.
        step: f64,
    },
}

impl FollowMethod {
    /// `rls` or `nlms`.
    pub fn name(self) -> &'static str {
        match self {
            Self::LeastSquares { .. } => "rls",
            Self::Gradient { .. } => "nlms",
        }
    }

    /// Memory \[s\] over a record of this many samples; `None` for a method without one.
    pub fn memory_s(self, samples: usize, sample_rate_hz: f64) -> Option<f64> {
        match self {
            Self::LeastSquares { memory_s } => {
                Some(memory_s.unwrap_or(MEMORY * samples as f64 / sample_rate_hz))
            }
            Self::Gradient { .. } => None,
        }
    }
}

/// Standard deviation of a residual where the model fits: the largest training RMSE in the model file, else
/// the noise floor of the record; `None` where neither is above 0.
pub fn known_noise(file: &ModelFile, data: &InputOutput) -> Option<f64> {
    let training = file.scores.iter().filter(|s| s.role == ScoreRole::Training).map(|s| s.rmse);
    let floor = || noise_floor(data, find_periods(data).ok().as_ref()).map(|floor| floor.rms);
    training.reduce(f64::max).or_else(floor).filter(|noise| *noise > 0.0)
}

/// Trajectory of one coefficient over a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// The coefficient.
    pub term: Term,
    /// Its nominal value.
    pub start: f64,
    /// Its value after the last sample.
    pub end: f64,
    /// Standard error of the end; `None` where the method gives none.
    pub std_error: Option<f64>,
    /// Least value over the record, the nominal one included.
    pub least: f64,
    /// Greatest.
    pub greatest: f64,
}

/// A model corrected over a record.
#[derive(Debug)]
pub struct Followed {
    /// Decimation factor of the samples used.
    pub every: usize,
    /// Memory \[s\], if the method has one.
    pub memory_s: Option<f64>,
    /// The coefficients.
    pub paths: Vec<Path>,
    /// Scores of the uncorrected model.
    pub before: Scores,
    /// Scores of the uncorrected model with its offset estimated.
    pub before_offset_estimated: Scores,
    /// Scores of one-step prediction: every sample with the coefficients from those before it.
    pub predicted: Scores,
    /// Scores of all samples with the final coefficients.
    pub last: Scores,
    /// Alarms: first samples at which the corrected model no longer fitted.
    pub alarms: Vec<Alarm>,
    /// The model with the final coefficients; an error where a model cannot hold them.
    pub model: Result<Model, IdentifyError>,
}

impl Followed {
    /// Runs `data` through the correction of `model`, simulated from `start`.
    ///
    /// # Errors
    /// [`IdentifyError`]: a record without sample rate, terms that cannot be corrected, options out of range.
    pub fn over(
        data: &InputOutput,
        model: &Model,
        start: &Start,
        options: &FollowOptions,
    ) -> Result<Self, IdentifyError> {
        let task = Task {
            data,
            model,
            start,
            options,
            sample_rate_hz: data.sample_rate_hz().ok_or(IdentifyError::FollowNotUniform)?,
        };
        match options.terms.len() {
            1 => task.with_terms::<1>(),
            2 => task.with_terms::<2>(),
            3 => task.with_terms::<3>(),
            4 => task.with_terms::<4>(),
            5 => task.with_terms::<5>(),
            MOST_TERMS => task.with_terms::<MOST_TERMS>(),
            count => Err(IdentifyError::FollowTerms(count)),
        }
    }
}

struct Task<'a> {
    data: &'a InputOutput,
    model: &'a Model,
    start: &'a Start,
    options: &'a FollowOptions,
    sample_rate_hz: f64,
}

impl Task<'_> {
    /// The record with only one of `every` samples valid: the others are only predicted.
    fn learnt_from(&self, every: usize) -> InputOutput {
        let is_valid = |k: usize| self.data.is_valid(k);
        let mask = (0..self.data.len()).map(|k| k.is_multiple_of(every) && is_valid(k)).collect();
        InputOutput { valid: Some(mask), ..self.data.clone() }
    }

    fn with_terms<const N: usize>(&self) -> Result<Followed, IdentifyError> {
        let Self { data, options, sample_rate_hz, .. } = *self;
        let noise = options.noise;
        let terms: [Term; N] = options
            .terms
            .as_slice()
            .try_into()
            .map_err(|_| IdentifyError::FollowTerms(options.terms.len()))?;
        let correction = Correction::new(self.model.clone(), terms)?;
        let regressors = correction.regressors(&data.u, Some(sample_rate_hz), self.start)?;
        let every = match options.every {
            Some(every) => every.max(1),
            None => {
                let alike = regressors.samples_per_independent_one(data)?.ceil() as usize;
                alike.max(shortest_swing(&data.u) / IN_A_SWING)
            }
        };
        let nominal = correction.nominal();
        let output =
            |parameters: &[f64; N]| regressors.rows().map(|r| r.output(parameters)).collect::<Vec<_>>();
        let as_it_was = output(&nominal);
        let (low, high) = range_of(&as_it_was);
        let deviations = regressors.spans().map(|span| MAY_MOVE * (high - low) / span);
        let memory_s = options.method.memory_s(data.len(), sample_rate_hz);
        let estimator = match options.method {
            FollowMethod::LeastSquares { .. } => {
                let memory = memory_s.unwrap_or_default() * sample_rate_hz / every as f64;
                Estimator::LeastSquares(Rls::new(RlsSettings {
                    start: nominal,
                    deviations,
                    noise,
                    forgetting: 1.0 - 1.0 / memory.max(SHORTEST_MEMORY),
                    unexcited: Unexcited::Hold,
                    bounds: None,
                })?)
            }
            FollowMethod::Gradient { step } => Estimator::Gradient {
                nlms: Nlms::new(NlmsSettings {
                    start: nominal,
                    deviations,
                    step,
                    regulariser: noise * noise,
                    bounds: None,
                })?,
                deviation_um: noise,
            },
        };
        let monitor = FitMonitor::new(MonitorSettings {
            shift: Some(SHIFT),
            spread: Some(SPREAD),
            run_length: options.run_length,
            fewest: FEWEST,
        })?;
        let mut adapter = Adapter::new(estimator, monitor, options.reopen);
        let trace = adapter.run(&regressors, &self.learnt_from(every))?;
        let end = *adapter.parameters();
        let path = |i: usize| {
            let over = trace.parameters.iter().map(|p| p[i]);
            let std_error = match adapter.estimator() {
                Estimator::LeastSquares(rls) => rls.covariance(i).map(|row| row[i].sqrt()),
                Estimator::Gradient { .. } => None,
            };
            Path {
                term: terms[i],
                start: nominal[i],
                end: end[i],
                std_error,
                least: over.clone().fold(nominal[i], f64::min),
                greatest: over.fold(nominal[i], f64::max),
            }
        };
        let scored =
            |simulated: &[f64], offset| score(data, simulated, &Scoring { offset, ..Scoring::default() });
        Ok(Followed {
            every,
            memory_s,
            paths: (0..N).map(path).collect(),
            before: scored(&as_it_was, OffsetTreatment::Fixed)?,
            before_offset_estimated: scored(&as_it_was, OffsetTreatment::Estimated)?,
            predicted: scored(&trace.predicted, OffsetTreatment::Fixed)?,
            last: scored(&output(&end), OffsetTreatment::Fixed)?,
            alarms: trace.alarms,
            model: correction.corrected(&end),
        })
    }
}

#[cfg(test)]
mod tests;
