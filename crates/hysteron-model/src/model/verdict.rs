//! Verdict on whether a record is of the device and range that a model was identified with.

use serde::{Deserialize, Serialize};

use crate::model_file::{ScoreEntry, ScoreRole, ValidRange};
use crate::record::{InputOutput, Unit, range_of};
use crate::validate::{Scores, loop_opening};
use hysteron_numeric::display::{short, short_to};

/// An error up to this many times that of the training is as good as in training.
const AS_IN_TRAINING: f64 = 2.0;
/// A gain explains an error if it removes this share of it and differs from 1 by at least this much.
const EXPLAINED: f64 = 0.4;
const OTHER_GAIN: f64 = 0.02;
/// A loop this many times as wide or as narrow is a different one, where the difference exceeds this many
/// times the error of the training.
const OTHER_WIDTH: f64 = 1.25;
const BEYOND_ERROR: f64 = 3.0;
/// Judgement on device and range from the score of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Judgement {
    /// The error is what it was in training.
    AsInTraining,
    /// The error is larger, and the drive leaves the range of the identification.
    AnotherRange,
    /// The error is larger, and the output's gain or the width of the loop differs.
    AnotherDevice,
    /// Both.
    AnotherDeviceOrRange,
    /// The error is larger, and neither the range nor the gain explains it.
    WorseThanInTraining,
}

impl Judgement {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::AsInTraining => "as in training",
            Self::AnotherRange => "another range",
            Self::AnotherDevice => "another device",
            Self::AnotherDeviceOrRange => "another device or another range",
            Self::WorseThanInTraining => "worse than in training",
        }
    }
}

/// A [`Judgement`] with its reasons.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Verdict {
    /// The judgement.
    pub judgement: Judgement,
    /// Why, in plain words.
    pub why: String,
}

impl Verdict {
    /// The verdict on a record with its simulation and scores; `training`: the scores in the model file.
    /// `None` where none of them is of a record that was fitted, or the record's output is constant.
    pub(super) fn of(
        training: &[ScoreEntry],
        range: Option<&ValidRange>,
        record: &InputOutput,
        simulated: &[f64],
        scores: &Scores,
    ) -> Option<Self> {
        let fitted = training.iter().filter(|entry| entry.role == ScoreRole::Training);
        let fitted = fitted.filter_map(|entry| Some((entry.rmse, entry.rmse_percent_of_stroke?)));
        let (rmse, percent) = fitted.reduce(|a, b| (a.0.max(b.0), a.1.max(b.1)))?;
        let own = scores.rmse_percent_of_stroke?;
        let outside = range.map_or_else(Vec::new, |range| leaves(range, record));
        let errors = format!(
            "rms error {} % of the stroke, {} % in training",
            short_to(own, 3),
            if training.len() > 1 {
                format!("at most {}", short_to(percent, 3))
            } else {
                short_to(percent, 3)
            }
        );
        let verdict = |judgement, reasons: Vec<String>| {
            let why = std::iter::once(errors).chain(reasons).collect::<Vec<_>>().join("; ");
            Some(Self { judgement, why })
        };
        if own <= AS_IN_TRAINING * percent || scores.rmse <= AS_IN_TRAINING * rmse {
            return verdict(Judgement::AsInTraining, outside);
        }
        let other = differs(record, simulated, scores, percent);
        let judgement = match (outside.is_empty(), other.is_empty()) {
            (true, true) => Judgement::WorseThanInTraining,
            (false, true) => Judgement::AnotherRange,
            (true, false) => Judgement::AnotherDevice,
            (false, false) => Judgement::AnotherDeviceOrRange,
        };
        let unknown = (judgement == Judgement::WorseThanInTraining).then(|| {
            "the drive stays in the range of the identification, and no other gain explains it".to_owned()
        });
        verdict(judgement, outside.into_iter().chain(other).chain(unknown).collect())
    }
}

/// Ways in which the drive leaves the range of the identification, in words.
fn leaves(range: &ValidRange, record: &InputOutput) -> Vec<String> {
    let (low, high) = range_of(&record.u);
    let (least, most) = (range.input.low, range.input.high);
    let amplitude = range.is_left_by((low, high)).then(|| {
        format!(
            "the input runs from {} to {} {unit}, the model was identified from {} to {} {unit}",
            short(low),
            short(high),
            short(least),
            short(most),
            unit = Unit::new(&range.input.unit)
        )
    });
    let frequency = range.exceeded_by(&record.u, &record.time).map(|(fastest, covered)| {
        format!(
            "it swings at up to {} Hz, the model was identified up to {} Hz",
            short_to(fastest, 3),
            short_to(covered, 3)
        )
    });
    amplitude.into_iter().chain(frequency).collect()
}

/// Differences in gain and loop width between record and model, in words; `trained`: error of the training
/// \[% of the stroke\].
fn differs(record: &InputOutput, simulated: &[f64], scores: &Scores, trained: f64) -> Vec<String> {
    let scored: Vec<bool> = match &record.valid {
        Some(mask) => mask.clone(),
        None => vec![true; record.len()],
    };
    let pairs =
        || record.y.iter().zip(simulated).zip(&scored).filter(|(_, scored)| **scored).map(|(pair, _)| pair);
    let count = pairs().count() as f64;
    let mean = |sum: f64| sum / count;
    let (y_mean, s_mean) = (mean(pairs().map(|(y, _)| y).sum()), mean(pairs().map(|(_, s)| s).sum()));
    let (ss, sy): (f64, f64) = pairs()
        .fold((0.0, 0.0), |(ss, sy), (y, s)| (ss + (s - s_mean).powi(2), sy + (s - s_mean) * (y - y_mean)));
    let mut found = Vec::new();
    let gain = sy / ss;
    let left = mean(pairs().map(|(y, s)| (y - y_mean - gain * (s - s_mean)).powi(2)).sum()).sqrt();
    if gain.is_finite() && (gain - 1.0).abs() > OTHER_GAIN && left <= (1.0 - EXPLAINED) * scores.rmse {
        found.push(if gain < 0.0 {
            format!("the output moves the other way, {} times as far as the model's", short_to(-gain, 3))
        } else {
            format!("the output moves {} times as far as the model's", short_to(gain, 3))
        });
    }
    let opening = |output: &[f64]| loop_opening(&record.u, output, &scored);
    if let (Some(measured), Some(model), Some(error)) =
        (opening(&record.y), opening(simulated), scores.loop_width_error_percent)
    {
        let ratio = measured / model;
        let other = !(1.0 / OTHER_WIDTH..=OTHER_WIDTH).contains(&ratio);
        if other && error.abs() > BEYOND_ERROR * trained && ratio.is_finite() {
            found.push(format!("its loop is {} times as wide as the model's", short_to(ratio, 3)));
        }
    }
    found
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use crate::record::TimeBase;
    use crate::validate::{Scoring, score};

    fn drive(amplitude: f64, hz: f64) -> Vec<f64> {
        (0..2000).map(|k| amplitude * (std::f64::consts::TAU * hz * f64::from(k) / 1000.0).sin()).collect()
    }

    /// The verdict on a record of 0.2 µm/V times `gain` with a small error, of a model of 0.2 µm/V identified
    /// to ±10 V, 5 Hz.
    fn judged(amplitude: f64, hz: f64, gain: f64) -> Verdict {
        let u = drive(amplitude, hz);
        let model: Vec<f64> = u.iter().map(|u| 0.2 * u).collect();
        let error = |k: usize| if k.is_multiple_of(2) { 0.01 } else { -0.01 };
        let y = model.iter().enumerate().map(|(k, y)| gain * y + error(k)).collect();
        let record = InputOutput::new("r", TimeBase::uniform(1000.0), u, y).unwrap();
        let scores = score(&record, &model, &Scoring::default()).unwrap();
        let trained = Scores { rmse: 0.01, rmse_percent_of_stroke: Some(0.25), ..scores.clone() };
        let entry = ScoreEntry::new("t", ScoreRole::Training, "um", &trained);
        let range = ValidRange::of_inputs(&[-10.0, 10.0], "V", Some((1.0, 5.0)));
        Verdict::of(&[entry], Some(&range), &record, &model, &scores).unwrap()
    }

    #[test]
    fn the_reasons_decide() {
        assert_eq!(judged(10.0, 5.0, 1.0).judgement, Judgement::AsInTraining);
        // As good beyond the range: said all the same.
        let beyond = judged(20.0, 5.0, 1.0);
        assert_eq!(beyond.judgement, Judgement::AsInTraining);
        assert!(beyond.why.contains("from -20 to 20 V"), "{}", beyond.why);
        let other = judged(10.0, 5.0, 1.3);
        assert_eq!(other.judgement, Judgement::AnotherDevice);
        assert!(other.why.contains("1.3 times as far"), "{}", other.why);
        assert_eq!(judged(20.0, 5.0, 1.3).judgement, Judgement::AnotherDeviceOrRange);
        let fast = judged(10.0, 50.0, 1.3);
        assert!(fast.why.contains("up to 50 Hz, the model was identified up to 5 Hz"), "{}", fast.why);
        assert!(judged(10.0, 5.0, -1.0).why.contains("the other way"));
    }

    #[test]
    fn no_verdict_without_a_score_of_the_training() {
        let u = drive(1.0, 5.0);
        let record = InputOutput::new("r", TimeBase::uniform(1000.0), u.clone(), u.clone()).unwrap();
        let scores = score(&record, &u, &Scoring::default()).unwrap();
        let held_out = ScoreEntry::new("t", ScoreRole::Validation, "um", &scores);
        assert_eq!(Verdict::of(&[held_out], None, &record, &u, &scores), None);
    }
}
