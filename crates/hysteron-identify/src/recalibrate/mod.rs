//! Quick recalibration: gain, delay and offset of an existing model from short records, all else held.
//!
//! y = offset + g · model(u, delay): g multiplies the output of the hysteresis block, so that the loop scales
//! and keeps its shape. g and the delay are fitted to the records by least squares, with an offset per record
//! and a hysteresis memory where [`choose_start`] finds one; their covariance allows for coloured residuals.
//! The old model is the prior: (g, delay) ~ N((1, old), A), no prior on the offset, with A from the
//! covariance in the model file ([`Prior::of`]). A parameter that differs from the old value by more than
//! [`SIGNIFICANT`] combined standard errors has changed: the prior, which describes the unchanged device, is
//! not used for it.

mod file;
mod problem;
#[cfg(test)]
mod tests;

use super::{IdentifyError, RecordFacts, uncertainty};
pub use file::RecalibrationSummary;
use hysteron_model::hammerstein::Model;
use hysteron_model::model::Remark;
use hysteron_model::record::{InputOutput, MeasurementRun, RecordError, range_of};
use hysteron_model::validate::{ScoreError, Scores, Scoring, choose_start, score};
use hysteron_model::{Model as AnyModel, Start};
use hysteron_optimize::{Algorithm, LeastSquaresOptions, Settings, Unobserved, minimize};
use nalgebra::{DMatrix, DVector};
use problem::{GainAndDelay, Names};
use serde::{Deserialize, Serialize};

/// Combined standard errors beyond which a difference is a change.
pub const SIGNIFICANT: f64 = 3.0;
/// Fewest valid samples of a record.
const FEWEST_SAMPLES: usize = 20;
/// Rounds of choosing the starts: a changed gain can mimic a hysteresis memory until it is fitted.
const ROUNDS: usize = 3;

/// A record to recalibrate from.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The record.
    pub data: InputOutput,
    /// State before it, if known.
    pub start: Start,
    /// The start is known: no other is tried.
    pub start_is_known: bool,
    /// Beginning of a run of several records, which determines its start; `None`: the whole record determines
    /// it.
    pub beginning: Option<InputOutput>,
}

impl Recording {
    /// Records, or the runs that `continued` ones form, each from the start that the model file assumes;
    /// remarks on it are added to `remarks`.
    ///
    /// # Errors
    /// [`RecordError`] for records that are no parts of a run.
    pub fn of(
        model: &AnyModel,
        records: Vec<InputOutput>,
        continued: bool,
        remarks: &mut Vec<Remark>,
    ) -> Result<Vec<Self>, RecordError> {
        let mut recording = |data: InputOutput, beginning: Option<InputOutput>| {
            let start = model.expected_start(beginning.as_ref().unwrap_or(&data), remarks);
            Self { data, start, start_is_known: false, beginning }
        };
        if !continued {
            return Ok(records.into_iter().map(|data| recording(data, None)).collect());
        }
        let runs = MeasurementRun::of(&records)?;
        let of_run = |run: MeasurementRun| {
            let beginning = run.beginning();
            recording(run.data, Some(beginning))
        };
        Ok(runs.into_iter().map(of_run).collect())
    }
}

/// Prior of gain and delay from the old model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Prior {
    /// Standard error of the gain, relative to the old one; `None`: no prior.
    pub gain: Option<f64>,
    /// Standard error of the delay \[s\].
    pub delay_s: Option<f64>,
    /// Correlation of both, where both are known.
    pub correlation: f64,
    /// Smallest and largest input that the model was identified with.
    pub range_v: Option<(f64, f64)>,
}

/// A parameter of the model before and after.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Value in the old model; 1 for the gain.
    pub old: f64,
    /// Standard error of the old value, if known.
    pub old_std_error: Option<f64>,
    /// Estimate from the records alone.
    pub measured: f64,
    /// Its standard error; `None` where the records do not determine it.
    pub measured_std_error: Option<f64>,
    /// Value in the new model: from records and prior, or from the records alone where it has changed.
    pub value: f64,
    /// Its standard error.
    pub std_error: Option<f64>,
}

impl Change {
    /// |measured − old| in combined standard errors; `None` where the records do not determine it.
    pub fn in_standard_errors(&self) -> Option<f64> {
        let deviation = self.measured_std_error?.hypot(self.old_std_error.unwrap_or(0.0));
        (deviation > 0.0).then(|| (self.measured - self.old).abs() / deviation)
    }

    /// True if the records contradict the old value.
    pub fn is_significant(&self) -> bool {
        self.in_standard_errors().is_some_and(|t| t > SIGNIFICANT)
    }
}

/// One record before and after.
#[derive(Clone, Debug)]
pub struct RecalibratedRecord {
    /// The record.
    pub data: InputOutput,
    /// Start the new model is simulated from.
    pub start: Start,
    /// Scores of the old model.
    pub before: Scores,
    /// Scores of the new model.
    pub after: Scores,
}

/// A recalibrated model.
#[derive(Clone, Debug)]
pub struct Recalibration {
    /// The new model; its offset is that of the first record.
    pub model: Model,
    /// Factor of the hysteresis block's output; held at 1 where the records do not determine it.
    pub gain: Change,
    /// Delay \[s\]; held at the old value where a record has no time base, or the records do not determine
    /// it.
    pub delay: Change,
    /// Correlation of the new gain and delay.
    pub correlation: f64,
    /// Fit of every record.
    pub records: Vec<RecalibratedRecord>,
}

/// Recalibrates `model`.
///
/// # Errors
/// [`IdentifyError`]: no record, a constant or too short one, one on which the model cannot be simulated;
/// [`IdentifyError::OtherDevice`] where even the recalibrated model explains less than `least_fit_percent` of
/// a record.
pub fn recalibrate(
    model: &Model,
    prior: Prior,
    recordings: &[Recording],
    least_fit_percent: f64,
) -> Result<Recalibration, IdentifyError> {
    if recordings.is_empty() {
        return Err(IdentifyError::NoRecords);
    }
    recordings.iter().try_for_each(|recording| check(&recording.data))?;
    let mut starts = choose(model, prior, recordings)?;
    let before = scores(model, recordings, &starts)?;
    let mut found = fit(model, prior, recordings, &mut starts)?;
    for _ in 1..ROUNDS {
        let mut again = choose(&found.model, prior, recordings)?;
        if same_kinds(&again, &starts) {
            break;
        }
        // The fit uses memories of the old model's operator.
        for start in &mut again {
            if let Start::Remembering { memory, .. } = start {
                *memory = memory.scaled(1.0 / found.gain.value);
            }
        }
        starts = again;
        found = fit(model, prior, recordings, &mut starts)?;
    }
    let RecalibratedModel { model: mut new, gain, delay, correlation } = found;
    let after = scores(&new, recordings, &starts)?;
    for (scores, recording) in after.iter().zip(recordings) {
        let fit_percent = scores.fit_percent.unwrap_or(0.0);
        if fit_percent < least_fit_percent {
            let record = recording.data.name.clone();
            return Err(IdentifyError::OtherDevice { record, fit_percent, need: least_fit_percent });
        }
    }
    new.offset += after.first().map_or(0.0, |scores| scores.offset);
    let after = scores(&new, recordings, &starts)?;
    let records = recordings
        .iter()
        .zip(starts)
        .zip(before.into_iter().zip(after))
        .map(|((recording, start), (before, after))| RecalibratedRecord {
            data: recording.data.clone(),
            start,
            before,
            after,
        })
        .collect();
    Ok(Recalibration { model: new, gain, delay, correlation, records })
}

fn check(data: &InputOutput) -> Result<(), IdentifyError> {
    let valid = |k: usize| data.is_valid(k);
    let found = (0..data.len()).filter(|&k| valid(k)).count();
    if found < FEWEST_SAMPLES {
        return Err(IdentifyError::TooFewSamples { record: data.name.clone(), need: FEWEST_SAMPLES, found });
    }
    for (signal, samples) in [("input", &data.u), ("output", &data.y)] {
        let (low, high) = range_of(samples);
        if low == high {
            return Err(IdentifyError::Constant { record: data.name.clone(), signal, value: low });
        }
    }
    Ok(())
}

fn choose(model: &Model, prior: Prior, recordings: &[Recording]) -> Result<Vec<Start>, IdentifyError> {
    let one = |recording: &Recording| {
        if recording.start_is_known {
            return Ok(recording.start);
        }
        let record = recording.beginning.as_ref().unwrap_or(&recording.data);
        match choose_start(model, record, recording.start, prior.range_v, &Scoring::default()) {
            Ok((start, _)) => Ok(start),
            Err(ScoreError::Simulation(e)) => Err(e.into()),
            Err(e) => Err(e.into()),
        }
    };
    recordings.iter().map(one).collect()
}

fn same_kinds(a: &[Start], b: &[Start]) -> bool {
    a.iter().zip(b).all(|(a, b)| match (a, b) {
        (Start::Remembering { .. }, Start::Remembering { .. }) => true,
        (a, b) => a == b,
    })
}

fn scores(model: &Model, recordings: &[Recording], starts: &[Start]) -> Result<Vec<Scores>, IdentifyError> {
    let one = |(recording, start): (&Recording, &Start)| {
        let data = &recording.data;
        let simulated = model.simulate(&data.u, &data.time, start)?;
        Ok(score(data, &simulated, &Scoring::default())?)
    };
    recordings.iter().zip(starts).map(one).collect()
}

/// The new model (with the old offset), gain and delay.
struct RecalibratedModel {
    model: Model,
    gain: Change,
    delay: Change,
    correlation: f64,
}

/// Fits at these starts, and updates their memories to the new model.
fn fit(
    model: &Model,
    prior: Prior,
    recordings: &[Recording],
    starts: &mut [Start],
) -> Result<RecalibratedModel, IdentifyError> {
    let facts: Vec<RecordFacts> = recordings.iter().map(|r| RecordFacts::new(r.data.clone())).collect();
    let timed = facts.iter().all(|facts| facts.require_timing().is_ok());
    let longest_s = timed.then(|| longest(model, &facts));
    let mut problem = GainAndDelay::new(model, &facts, starts, longest_s, model.delay_s);
    let mut measured = minimum(&problem)?;
    let mut covariance = uncertainty::covariance(&problem, &measured, None);
    // A delay at a bound stays there; one that the records do not determine keeps its old value.
    let edge = problem.names.delay.map(|at| measured[at]).filter(|&delay| problem.is_edge_of_delay(delay));
    if problem.names.delay.is_some() && (edge.is_some() || covariance.is_none()) {
        problem = GainAndDelay::new(model, &facts, starts, None, edge.unwrap_or(model.delay_s));
        measured = minimum(&problem)?;
        covariance = uncertainty::covariance(&problem, &measured, None);
    }
    let names = &problem.names;
    let std_error = |c: &Option<DMatrix<f64>>, at: usize| c.as_ref().map(|c| c[(at, at)].sqrt());
    let change = |at: Option<usize>, old: f64, old_std_error: Option<f64>| Change {
        old,
        old_std_error,
        measured: at.map_or(problem.held_delay_s, |at| measured[at]),
        measured_std_error: at.and_then(|at| std_error(&covariance, at)),
        value: at.map_or(problem.held_delay_s, |at| measured[at]),
        std_error: at.and_then(|at| std_error(&covariance, at)),
    };
    let mut gain = change(Some(Names::GAIN), 1.0, prior.gain);
    if covariance.is_none() {
        (gain.value, gain.std_error) = (gain.old, gain.old_std_error);
    }
    let mut delay = change(names.delay, model.delay_s, prior.delay_s);
    let mut x = measured.clone();
    if let Some(c) = &covariance {
        let known: Vec<(usize, f64, f64)> = [(Some(Names::GAIN), &gain), (names.delay, &delay)]
            .into_iter()
            .filter(|(_, change)| !change.is_significant())
            .filter_map(|(at, change)| Some((at?, change.old, change.old_std_error.filter(|s| *s > 0.0)?)))
            .collect();
        if let Some((mean, c)) = with_prior(&measured, c, &known, prior.correlation) {
            x = mean;
            covariance = Some(c);
            let c = &covariance;
            (gain.value, gain.std_error) = (x[Names::GAIN], std_error(c, Names::GAIN));
            if let Some(at) = names.delay {
                (delay.value, delay.std_error) = (x[at].max(0.0), std_error(c, at));
            }
        }
    }
    for (start, at) in starts.iter_mut().zip(&names.memories) {
        if let (Start::Remembering { memory, .. }, Some(at)) = (start, at) {
            *memory = memory.with_value(x[*at]).scaled(gain.value);
        }
    }
    let hysteresis = model.hysteresis.scaled(gain.value)?;
    let model = Model { hysteresis, delay_s: delay.value, ..model.clone() };
    let correlation = match (&covariance, names.delay) {
        (Some(c), Some(at)) => {
            let g = Names::GAIN;
            (c[(g, at)] / (c[(g, g)] * c[(at, at)]).sqrt()).clamp(-1.0, 1.0)
        }
        _ => 0.0,
    };
    Ok(RecalibratedModel { model, gain, delay, correlation })
}

/// Longest delay searched \[s\]: twice the old one, ten samples, a tenth of the fastest period.
fn longest(model: &Model, facts: &[RecordFacts]) -> f64 {
    let of = |facts: &RecordFacts| {
        let period_s = facts.data.time.shortest_period_s(facts.data.len()).unwrap_or(0.0);
        (0.1 / facts.highest_frequency_hz()).max(10.0 * period_s)
    };
    facts.iter().map(of).fold(2.0 * model.delay_s, f64::max)
}

fn minimum(problem: &GainAndDelay<'_>) -> Result<Vec<f64>, IdentifyError> {
    let options = LeastSquaresOptions { starts: 1, ..Default::default() };
    let settings = Settings { starts: vec![problem.start()], ..Default::default() };
    Ok(minimize(problem, &Algorithm::LeastSquares(options), &settings, &mut Unobserved, None)?.best)
}

/// Mean and covariance of the product of the Gaussians N(x, c) and `known` (index, mean, standard deviation),
/// the latter with this correlation if there are two.
fn with_prior(
    x: &[f64],
    c: &DMatrix<f64>,
    known: &[(usize, f64, f64)],
    correlation: f64,
) -> Option<(Vec<f64>, DMatrix<f64>)> {
    // Scaled to unit deviations: gain, seconds and micrometres differ by many decades.
    let scale: Vec<f64> = c.diagonal().iter().map(|v| v.sqrt()).collect();
    let unit = c.map_with_location(|i, j, v| v / (scale[i] * scale[j]));
    let mut information = unit.try_inverse()?;
    let mut pull = DVector::zeros(x.len());
    let prior = DMatrix::from_fn(known.len(), known.len(), |i, j| if i == j { 1.0 } else { correlation });
    let prior = prior.try_inverse()?;
    for (i, &(at, _, deviation)) in known.iter().enumerate() {
        for (j, &(other, mean, other_deviation)) in known.iter().enumerate() {
            let weight = prior[(i, j)] * scale[at] / deviation * scale[other] / other_deviation;
            information[(at, other)] += weight;
            pull[at] += weight * (mean - x[other]) / scale[other];
        }
    }
    let unit = information.try_inverse()?;
    let step = &unit * pull;
    let mean = x.iter().zip(&scale).zip(step.iter()).map(|((x, s), d)| x + s * d).collect();
    let covariance = unit.map_with_location(|i, j, v| v * scale[i] * scale[j]);
    covariance.iter().all(|v| v.is_finite()).then_some((mean, covariance))
}
