//! Part of a record by time, by the value of its columns and by the turning points of its drive.

use std::fmt;
use std::str::FromStr;

use hysteron_numeric::display::short;
use serde::{Deserialize, Serialize};

use crate::advice::ColumnRole;

use super::turning_points::{range_of, turning_points};
use super::{Record, RecordError, TimeBase};

/// Reversals of less than this share of the drive's range do not count: noise of a measured drive.
const SMALLEST_SWING: f64 = 0.02;
/// A stamp that lies outside of the time kept by less than this share of the mean period is inside.
const TIME_TOLERANCE_PERIODS: f64 = 1e-6;

/// Part of a record to keep; all of it by default. A sample is kept where every condition holds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Cut {
    /// First time kept \[s\].
    pub from_s: Option<f64>,
    /// Last time kept \[s\].
    pub to_s: Option<f64>,
    /// Conditions on the values of columns.
    pub conditions: Vec<Condition>,
    /// Turning points between which the drive is kept, counted in what the other conditions keep.
    pub turns: Option<Turns>,
}

/// Condition on the values of a column, parsed from `segment=2`, `segment=2..7`, `segment=2..` or
/// `segment=ramp`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Condition {
    /// Bare name or header of the column; `valid` is the sample mask (1 and 0).
    pub column: String,
    /// Values kept.
    pub is: Admitted,
}

/// Values that a [`Condition`] admits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Admitted {
    /// Numbers of a range, its ends included.
    Range {
        /// Smallest; `None`: no limit.
        low: Option<f64>,
        /// Largest; `None`: no limit.
        high: Option<f64>,
    },
    /// A text, exactly, in a column of texts. Records hold numbers alone: the reader of a text file decides.
    Text(String),
}

/// Turning points of the drive, parsed from `FIRST:LAST`, `FIRST:` or `:LAST`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Turns {
    /// Number of the first turning point kept, from 1; `None`: from the first sample.
    pub first: Option<usize>,
    /// Number of the last one kept; `None`: to the last sample.
    pub last: Option<usize>,
    /// Column that turns; `None`: the drive, by the rules of [`Record::drive`].
    pub column: Option<String>,
}

/// Text that is no [`Condition`] or no [`Turns`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CutError(&'static str);

impl FromStr for Condition {
    type Err = CutError;

    fn from_str(text: &str) -> Result<Self, CutError> {
        let form = CutError("expected COL=VALUE or COL=LOW..HIGH, e.g. segment=2..7");
        let (column, value) = text.split_once('=').ok_or(form.clone())?;
        let (column, value) = (column.trim(), value.trim());
        if column.is_empty() || value.is_empty() {
            return Err(form);
        }
        let end = |text: &str| match text.trim() {
            "" => Some(None),
            text => text.parse::<f64>().ok().filter(|x| x.is_finite()).map(Some),
        };
        let is = match value.split_once("..") {
            Some((low, high)) => {
                let (Some(low), Some(high)) = (end(low), end(high)) else { return Err(form) };
                if low.is_none() && high.is_none() {
                    return Err(form);
                }
                if low.zip(high).is_some_and(|(low, high)| low > high) {
                    return Err(CutError("the lower end of the range is above the upper one"));
                }
                Admitted::Range { low, high }
            }
            None => match value.parse::<f64>() {
                Ok(x) if x.is_finite() => Admitted::Range { low: Some(x), high: Some(x) },
                Ok(_) => return Err(CutError("the value must be finite")),
                Err(_) => Admitted::Text(value.to_owned()),
            },
        };
        Ok(Condition { column: column.to_owned(), is })
    }
}

/// The text it is parsed from: `segment=2..7`.
impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}=", self.column)?;
        match &self.is {
            Admitted::Range { low: Some(low), high: Some(high) } if low == high => write!(f, "{low}"),
            Admitted::Range { low, high } => {
                let end = |end: &Option<f64>| end.map(|x| x.to_string()).unwrap_or_default();
                write!(f, "{}..{}", end(low), end(high))
            }
            Admitted::Text(text) => f.write_str(text),
        }
    }
}

impl FromStr for Turns {
    type Err = CutError;

    fn from_str(text: &str) -> Result<Self, CutError> {
        let form = CutError("expected FIRST:LAST, numbers of turning points from 1, e.g. 1:5, 3: or :5");
        let (first, last) = text.split_once(':').ok_or(form.clone())?;
        let number = |text: &str| match text.trim() {
            "" => Ok(None),
            text => text.parse().ok().filter(|n| *n >= 1).map(Some).ok_or(form.clone()),
        };
        let (first, last) = (number(first)?, number(last)?);
        match (first, last) {
            (None, None) => Err(form),
            (Some(first), Some(last)) if first >= last => {
                Err(CutError("the first turning point must come before the last"))
            }
            _ => Ok(Turns { first, last, column: None }),
        }
    }
}

impl Cut {
    /// True if the whole record is kept.
    pub fn is_whole(&self) -> bool {
        *self == Cut::default()
    }

    /// Indices of the samples of a record that are kept, in order. The record's samples need not be finite:
    /// those that are not satisfy no condition.
    ///
    /// # Errors
    /// Those of [`Record::cut`].
    pub fn kept(&self, record: &Record) -> Result<Vec<usize>, RecordError> {
        let mut kept: Vec<usize> = (0..record.len()).collect();
        if self.from_s.is_some() || self.to_s.is_some() {
            let (start, end) = record.extent_s().ok_or_else(|| RecordError::NoTimes {
                record: record.name.clone(),
                purpose: "a cut by time",
            })?;
            let slack = TIME_TOLERANCE_PERIODS * (end - start) / record.len().max(1) as f64;
            let from = self.from_s.unwrap_or(f64::NEG_INFINITY) - slack;
            let to = self.to_s.unwrap_or(f64::INFINITY) + slack;
            kept.retain(|&k| record.time.time_s(k).is_some_and(|t| t >= from && t <= to));
        }
        for condition in &self.conditions {
            condition.retain(record, &mut kept)?;
        }
        self.check(record, &kept)?;
        if let Some(turns) = &self.turns {
            kept = turns.between(record, &kept)?;
            self.check(record, &kept)?;
        }
        Ok(kept)
    }

    fn check(&self, record: &Record, kept: &[usize]) -> Result<(), RecordError> {
        if kept.len() >= 2 {
            return Ok(());
        }
        let mut ranges = Vec::new();
        if let Some((start, end)) = record.extent_s() {
            ranges.push(format!("time from {} to {} s", short(start), short(end)));
        }
        for Condition { column, .. } in &self.conditions {
            if let Some(values) = values(record, column) {
                let (low, high) = range_of(&values);
                let range = format!("`{column}` from {} to {}", short(low), short(high));
                if !ranges.contains(&range) {
                    ranges.push(range);
                }
            }
        }
        Err(RecordError::EmptyCut {
            record: record.name.clone(),
            kept: kept.len(),
            samples: record.len(),
            holds: ranges.join(", "),
        })
    }
}

impl Condition {
    fn retain(&self, record: &Record, kept: &mut Vec<usize>) -> Result<(), RecordError> {
        let values = values(record, &self.column)
            .ok_or_else(|| record.no_such(&self.column, ColumnRole::Condition))?;
        let Admitted::Range { low, high } = self.is else {
            let Admitted::Text(text) = &self.is else { return Ok(()) };
            return Err(RecordError::TextCondition {
                record: record.name.clone(),
                channel: self.column.clone(),
                text: text.clone(),
            });
        };
        let (low, high) = (low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY));
        kept.retain(|&k| values.get(k).is_some_and(|&x| x >= low && x <= high));
        Ok(())
    }
}

impl Turns {
    /// Those of the `kept` samples that lie between the turning points.
    fn between(&self, record: &Record, kept: &[usize]) -> Result<Vec<usize>, RecordError> {
        let drive = &record.channels[record.input_position(self.column.as_deref())?];
        let samples: Vec<f64> = kept.iter().filter_map(|&k| drive.samples.get(k).copied()).collect();
        let (low, high) = range_of(&samples);
        let points = turning_points(&samples, SMALLEST_SWING * (high - low));
        let index = |number: usize| {
            points.get(number.saturating_sub(1)).map(|p| p.index).ok_or_else(|| RecordError::TooFewTurns {
                record: record.name.clone(),
                channel: drive.name.clone(),
                asked: number,
                found: points.len(),
            })
        };
        let first = self.first.map_or(Ok(0), index)?;
        let last = self.last.map_or(Ok(kept.len().saturating_sub(1)), index)?;
        Ok(kept.get(first..=last).unwrap_or_default().to_vec())
    }
}

impl Record {
    /// First and last time \[s\].
    pub(super) fn extent_s(&self) -> Option<(f64, f64)> {
        self.time.extent_s(self.len())
    }

    /// The samples that a [`Cut`] keeps. Stamps stay as they are: where samples are left out between others,
    /// or segments of different rates are kept, the time base is not uniform; a segment of one rate is.
    ///
    /// # Errors
    /// [`RecordError::EmptyCut`] where fewer than two samples are kept; [`RecordError::NoTimes`];
    /// [`RecordError::NoSuchChannel`]; [`RecordError::TextCondition`]; [`RecordError::TooFewTurns`], and for
    /// turning points those of [`Record::drive`].
    pub fn cut(&self, cut: &Cut) -> Result<Record, RecordError> {
        if cut.is_whole() {
            return Ok(self.clone());
        }
        let part = self.at(&cut.kept(self)?)?;
        part.check()?;
        Ok(part)
    }

    /// The samples of these indices, which increase.
    ///
    /// # Errors
    /// Those of [`TimeBase::from_times`].
    pub fn at(&self, kept: &[usize]) -> Result<Record, RecordError> {
        fn pick<T: Copy>(values: &[T], kept: &[usize]) -> Vec<T> {
            kept.iter().filter_map(|&k| values.get(k).copied()).collect()
        }
        let mut part = self.clone();
        for (to, from) in part.channels.iter_mut().zip(&self.channels) {
            to.samples = pick(&from.samples, kept);
        }
        part.valid = self.valid.as_ref().map(|valid| pick(valid, kept));
        let ends = (kept.first().copied().unwrap_or(0), kept.last().map_or(0, |last| last + 1));
        part.time = match &self.time {
            // A piece of a grid is the same grid, to the last bit.
            TimeBase::Uniform { .. } | TimeBase::Unknown if ends.1 - ends.0 == kept.len() => {
                self.time.cropped(ends.0, ends.1)
            }
            TimeBase::Unknown => TimeBase::Unknown,
            time => {
                let times_s = kept.iter().filter_map(|&k| time.time_s(k)).collect();
                TimeBase::of_part(&self.name, times_s)?
            }
        };
        Ok(part)
    }
}

/// Values of a column: of a channel, or of the mask.
fn values(record: &Record, column: &str) -> Option<Vec<f64>> {
    if let Ok(index) = record.position(column, ColumnRole::Condition) {
        return Some(record.channels[index].samples.clone());
    }
    let mask = record.valid.as_ref().filter(|_| column.eq_ignore_ascii_case("valid"))?;
    Some(mask.iter().map(|&valid| f64::from(u8::from(valid))).collect())
}

#[cfg(test)]
mod tests {
    use super::super::Channel;
    use super::*;

    /// Three segments: 10 samples at 100 Hz, 10 at 1 kHz, 10 at 100 Hz, without a pause between them.
    fn record() -> Record {
        let mut times = vec![0.0];
        for (steps, period) in [(9, 0.01), (10, 0.001), (10, 0.01)] {
            for _ in 0..steps {
                times.push(times.last().unwrap() + period);
            }
        }
        let n = times.len();
        let segment: Vec<f64> = (0..n).map(|k| (k / 10) as f64).collect();
        let u: Vec<f64> = (0..n).map(|k| [0.0, 1.0, 2.0, 1.0][k % 4]).collect();
        let channels = vec![Channel::new("u", "V", u), Channel::new("segment", "", segment)];
        let mut record =
            Record::new("r.csv", TimeBase::from_times("r.csv", times).unwrap(), channels).unwrap();
        record.valid = Some((0..n).map(|k| k != 4).collect());
        record
    }

    fn cut(conditions: &[&str]) -> Cut {
        Cut { conditions: conditions.iter().map(|c| c.parse().unwrap()).collect(), ..Cut::default() }
    }

    fn rate(record: &Record) -> Option<f64> {
        match record.time {
            TimeBase::Uniform { sample_rate_hz, .. } => Some(sample_rate_hz),
            _ => None,
        }
    }

    #[test]
    fn a_segment_of_one_rate_is_uniform_and_two_that_are_apart_are_not() {
        let record = record();
        assert_eq!(rate(&record), None);
        let middle = record.cut(&cut(&["segment=1"])).unwrap();
        assert_eq!((middle.len(), rate(&middle)), (10, Some(1000.0)));
        assert!((middle.time.time_s(0).unwrap() - 0.091).abs() < 1e-12);
        assert_eq!(middle.channels[0].samples, record.channels[0].samples[10..20]);
        assert_eq!(record.cut(&cut(&["segment=1..2"])).unwrap().len(), 20);
        assert_eq!(record.cut(&cut(&["segment=1.."])).unwrap().len(), 20);
        let ends = record.cut(&cut(&["segment=0..2", "u=2"])).unwrap();
        assert!(matches!(ends.time, TimeBase::NonUniform { .. }));
        assert!(ends.channels[0].samples.iter().all(|&u| u == 2.0));
        assert_eq!(record.cut(&cut(&["VALID=1", "Segment=0"])).unwrap().len(), 9);
        assert_eq!(record.cut(&Cut::default()).unwrap(), record);
    }

    #[test]
    fn time_is_kept_with_both_ends() {
        let record = Record::new(
            "r",
            TimeBase::Uniform { start_s: 0.1, sample_rate_hz: 10.0, jitter_samples: 0.0 },
            vec![Channel::new("u", "V", (0..10).map(f64::from).collect())],
        )
        .unwrap();
        let part = record.cut(&Cut { from_s: Some(0.3), to_s: Some(0.6), ..Cut::default() }).unwrap();
        assert_eq!(part.channels[0].samples, [2.0, 3.0, 4.0, 5.0]);
        assert_eq!(rate(&part), Some(10.0));
        let error = record.cut(&Cut { from_s: Some(7.0), ..Cut::default() }).unwrap_err().to_string();
        assert!(error.contains("0 of 10 samples") && error.contains("time from 0.1 to 1 s"), "{error}");
        let without = Record { time: TimeBase::Unknown, ..record };
        let error = without.cut(&Cut { from_s: Some(0.3), ..Cut::default() }).unwrap_err();
        assert!(matches!(error, RecordError::NoTimes { .. }), "{error}");
    }

    #[test]
    fn turns_are_those_of_the_drive_in_what_is_kept() {
        let turns = |text: &str| Cut { turns: Some(text.parse().unwrap()), ..Cut::default() };
        let u = |cut: &Cut| record().cut(cut).map(|r| r.channels[0].samples.clone());
        // The drive turns at samples 2, 4, 6, …, 28.
        assert_eq!(u(&turns("1:3")).unwrap(), [2.0, 1.0, 0.0, 1.0, 2.0]);
        assert_eq!(u(&turns("13:")).unwrap(), [2.0, 1.0, 0.0, 1.0]);
        assert_eq!(u(&turns(":2")).unwrap(), [0.0, 1.0, 2.0, 1.0, 0.0]);
        let segment = Cut { conditions: cut(&["segment=1"]).conditions, ..turns("1:2") };
        assert_eq!(u(&segment).unwrap(), [0.0, 1.0, 2.0]);
        let error = u(&turns("3:40")).unwrap_err().to_string();
        assert!(error.contains("turns 14 times") && error.contains("40"), "{error}");
        let of = Turns { column: Some("segment".into()), ..":1".parse().unwrap() };
        assert!(matches!(
            u(&Cut { turns: Some(of), ..Cut::default() }),
            Err(RecordError::TooFewTurns { .. })
        ));
    }

    #[test]
    fn what_cannot_be_kept_is_said_with_what_there_is() {
        let refused = |conditions: &[&str]| record().cut(&cut(conditions)).unwrap_err().to_string();
        let text = refused(&["speed=1"]);
        assert!(text.contains("no channel `speed`") && text.contains("`u` (V), `segment`"), "{text}");
        let text = refused(&["segment=7"]);
        assert!(text.contains("0 of 30 samples") && text.contains("`segment` from 0 to 2"), "{text}");
        let text = refused(&["segment=ramp"]);
        assert!(text.contains("`segment` holds numbers") && text.contains("`ramp`"), "{text}");
    }

    #[test]
    fn conditions_and_turns_are_parsed_or_refused() {
        let range = |low, high| Admitted::Range { low, high };
        for (text, is) in [
            ("segment=2", range(Some(2.0), Some(2.0))),
            ("segment = -1.5 .. 7 ", range(Some(-1.5), Some(7.0))),
            ("segment=..1e3", range(None, Some(1e3))),
            ("segment=up ramp", Admitted::Text("up ramp".into())),
        ] {
            assert_eq!(text.parse(), Ok(Condition { column: "segment".into(), is }), "{text}");
        }
        for text in ["segment", "=2", "segment=", "segment=..", "segment=3..2", "segment=a..b", "segment=nan"]
        {
            assert!(text.parse::<Condition>().is_err(), "{text}");
        }
        for text in ["1", ":", "0:3", "3:3", "5:2", "a:b", "1:2:3"] {
            assert!(text.parse::<Turns>().is_err(), "{text}");
        }
    }
}
