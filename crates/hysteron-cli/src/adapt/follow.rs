//! The correction over the record; the numbers are the library's.

use hysteron_identify::online::{Adapter, Alarm, Correction, CorrectionError, Estimator, Term};
use hysteron_model::hammerstein::Model;
use hysteron_model::record::{InputOutput, shortest_swing};
use hysteron_model::validate::{OffsetTreatment, ScoreError, Scores, Scoring, score};
use hysteron_rt::{
    FitMonitor, MonitorSettings, Nlms, NlmsSettings, OnlineError, Rls, RlsSettings, Unexcited,
};

use super::{Method, Task};
use crate::numbers::ends;

/// A coefficient may move the output by this share of its stroke.
const MAY_MOVE: f64 = 0.1;
/// What the monitor looks for: a shift of the mean and a growth of the spread, in units of the noise.
const SHIFT: f64 = 0.5;
const SPREAD: f64 = 1.5;
/// Samples learnt from in half of the drive's shortest period, where nothing is said.
const IN_A_SWING: usize = 20;
/// Fewest samples an alarm is made of.
const FEWEST: u16 = 3;

/// Why a record could not be followed.
#[derive(Debug, thiserror::Error)]
pub enum CannotFollow {
    #[error(transparent)]
    Correction(#[from] CorrectionError),
    #[error(transparent)]
    Settings(#[from] OnlineError<f64>),
    #[error(transparent)]
    Score(#[from] ScoreError),
    #[error("between one and six terms can be followed, not {0}")]
    Terms(usize),
}

/// One coefficient over the record.
pub struct Path {
    pub term: Term,
    pub start: f64,
    pub end: f64,
    /// Of the end; `None` where the method gives none.
    pub std_error: Option<f64>,
    pub least: f64,
    pub greatest: f64,
}

/// What came of it.
pub struct Followed {
    /// One of so many samples was learnt from.
    pub every: usize,
    pub paths: Vec<Path>,
    /// The model as it was.
    pub before: Scores,
    /// The same but for its offset.
    pub before_offset_estimated: Scores,
    /// Every sample predicted with the coefficients of the samples before it.
    pub predicted: Scores,
    /// All samples with the coefficients of the last.
    pub last: Scores,
    pub alarms: Vec<Alarm>,
    /// The model with the coefficients of the last sample; the error where a model has no place for them.
    pub model: Result<Model, CorrectionError>,
}

impl Task<'_> {
    /// Runs the record through the correction.
    pub fn followed(&self) -> Result<Followed, CannotFollow> {
        match self.terms.len() {
            1 => self.with_terms::<1>(),
            2 => self.with_terms::<2>(),
            3 => self.with_terms::<3>(),
            4 => self.with_terms::<4>(),
            5 => self.with_terms::<5>(),
            6 => self.with_terms::<6>(),
            count => Err(CannotFollow::Terms(count)),
        }
    }

    /// The record with only one of `every` samples valid: the others are predicted.
    fn learnt_from(&self, every: usize) -> InputOutput {
        let is_valid = |k: usize| self.data.valid.as_ref().is_none_or(|valid| valid[k]);
        let mask = (0..self.data.len()).map(|k| k.is_multiple_of(every) && is_valid(k)).collect();
        InputOutput { valid: Some(mask), ..self.data.clone() }
    }

    fn with_terms<const N: usize>(&self) -> Result<Followed, CannotFollow> {
        let terms: [Term; N] = self.terms.try_into().map_err(|_| CannotFollow::Terms(self.terms.len()))?;
        let correction = Correction::new(self.model.clone(), terms)?;
        let regressors = correction.regressors(&self.data.u, Some(self.sample_rate_hz), &self.start)?;
        let every = match self.every {
            Some(every) => every,
            None => {
                let alike = regressors.samples_per_independent_one(self.data)?.ceil() as usize;
                alike.max(shortest_swing(&self.data.u) / IN_A_SWING)
            }
        };
        let nominal = correction.nominal();
        let output =
            |parameters: &[f64; N]| regressors.rows().map(|r| r.output(parameters)).collect::<Vec<_>>();
        let as_it_was = output(&nominal);
        let spread = |y: &[f64]| {
            let (low, high) = ends(y);
            high - low
        };
        let stroke = spread(&as_it_was);
        let deviations = regressors.spans().map(|span| MAY_MOVE * stroke / span);
        let estimator = match self.method {
            Method::Rls => Estimator::LeastSquares(Rls::new(RlsSettings {
                start: nominal,
                deviations,
                noise: self.noise,
                forgetting: 1.0 - 1.0 / (self.memory_s * self.sample_rate_hz / every as f64).max(2.0),
                unexcited: Unexcited::Hold,
                bounds: None,
            })?),
            Method::Nlms => Estimator::Gradient {
                nlms: Nlms::new(NlmsSettings {
                    start: nominal,
                    deviations,
                    step: self.step,
                    regulariser: self.noise * self.noise,
                    bounds: None,
                })?,
                deviation_um: self.noise,
            },
        };
        let monitor = FitMonitor::new(MonitorSettings {
            shift: Some(SHIFT),
            spread: Some(SPREAD),
            run_length: self.run_length,
            fewest: FEWEST,
        })?;
        let mut adapter = Adapter::new(estimator, monitor, self.reopen);
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
        let scored = |simulated: &[f64], offset| {
            score(self.data, simulated, &Scoring { offset, ..Scoring::default() })
        };
        Ok(Followed {
            every,
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
