//! Records prepared for a fit, step by step in a fixed order.

use serde::{Deserialize, Serialize};

use super::turning_points::range_of;
use super::{Gap, Record, RecordError, Scale, TimeBase};

/// Preparation of records, in this order: joined to one, scaled, mean and trend removed, resampled. By
/// default they are only joined. A [`super::Cut`] of each record comes before.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Prepare {
    /// Scales of channels, e.g. `y=2.5um/V`.
    pub scales: Vec<Scale>,
    /// Channels whose mean is removed.
    pub remove_mean: Vec<String>,
    /// Channels whose straight-line trend is removed, the mean with it.
    pub detrend: Vec<String>,
    /// New sample rate \[Hz\].
    pub sample_rate_hz: Option<f64>,
}

/// A prepared record and what was done.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// The record.
    pub record: Record,
    /// Steps done, in order.
    pub steps: Vec<Step>,
    /// Gaps between the samples before any resampling.
    pub gaps: Vec<Gap>,
}

/// A prepared record in figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PreparedSummary {
    /// Number of samples.
    pub samples: usize,
    /// Samples that the mask excludes.
    pub masked_samples: usize,
    /// Sample rate \[Hz\]; `None` where the stamps are not uniform, or there are none.
    pub sample_rate_hz: Option<f64>,
    /// First time \[s\].
    pub start_s: Option<f64>,
    /// Last time \[s\].
    pub end_s: Option<f64>,
    /// The columns and their ranges.
    pub columns: Vec<ColumnRange>,
    /// Gaps between the samples before any resampling.
    pub gaps: Vec<Gap>,
    /// Steps done, in order.
    pub steps: Vec<Step>,
}

/// One step of a preparation, as it was done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "step", rename_all = "kebab-case")]
pub enum Step {
    /// Records joined to one.
    Joined {
        /// Number of records.
        records: usize,
    },
    /// A channel scaled.
    Scaled {
        /// The scale, e.g. `y=2.5um/V`.
        scale: Scale,
    },
    /// The mean of a channel removed.
    MeanRemoved {
        /// The channel.
        channel: String,
        /// Its mean, in its unit.
        mean: f64,
    },
    /// The straight-line trend of a channel removed.
    Detrended {
        /// The channel.
        channel: String,
        /// Its mean, in its unit.
        mean: f64,
        /// The slope \[unit per second\].
        per_s: f64,
    },
    /// Resampled, with an anti-alias filter.
    Resampled {
        /// Sample rate before \[Hz\]; `None` where the stamps were not uniform.
        from_hz: Option<f64>,
        /// Sample rate \[Hz\].
        to_hz: f64,
        /// Gaps between the samples before, longer than three of their neighbours' periods.
        gaps: usize,
        /// New samples within these gaps, interpolated and not valid.
        samples_in_gaps: usize,
    },
}

/// Range of a column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColumnRange {
    /// Name of the column.
    pub name: String,
    /// Symbol of the unit.
    pub unit: String,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

impl Prepare {
    /// One record of several.
    ///
    /// # Errors
    /// Those of [`Record::joined`], [`Scale::apply`], [`Record::with_mean_removed`],
    /// [`Record::with_trend_removed`] and [`Record::resampled`].
    pub fn run(&self, records: &[Record]) -> Result<Prepared, RecordError> {
        let mut record = Record::joined(records)?;
        let gaps = record.time.gaps();
        let mut steps = Vec::new();
        if records.len() > 1 {
            steps.push(Step::Joined { records: records.len() });
        }
        for scale in &self.scales {
            record = scale.apply(&record)?;
            steps.push(Step::Scaled { scale: scale.clone() });
        }
        for channel in &self.remove_mean {
            let (changed, trend) = record.with_mean_removed(channel)?;
            record = changed;
            steps.push(Step::MeanRemoved { channel: channel.clone(), mean: trend.mean });
        }
        for channel in &self.detrend {
            let (changed, trend) = record.with_trend_removed(channel)?;
            record = changed;
            steps.push(Step::Detrended { channel: channel.clone(), mean: trend.mean, per_s: trend.per_s });
        }
        if let Some(to_hz) = self.sample_rate_hz {
            let from_hz = record.sample_rate_hz();
            record = record.resampled(to_hz)?;
            let in_gap = |k: &usize| {
                let t = record.time.time_s(*k).unwrap_or(f64::NAN);
                gaps.iter().any(|gap| gap.from_s < t && t < gap.to_s)
            };
            let invalid = (0..record.len()).filter(|k| record.valid.as_ref().is_some_and(|v| !v[*k]));
            let samples_in_gaps = if gaps.is_empty() { 0 } else { invalid.filter(in_gap).count() };
            steps.push(Step::Resampled { from_hz, to_hz, gaps: gaps.len(), samples_in_gaps });
        }
        Ok(Prepared { record, steps, gaps })
    }
}

impl Prepared {
    /// The record in figures.
    pub fn summary(&self) -> PreparedSummary {
        let extent = self.record.extent_s();
        PreparedSummary {
            samples: self.record.len(),
            masked_samples: self.record.valid.iter().flatten().filter(|valid| !**valid).count(),
            sample_rate_hz: self.record.sample_rate_hz(),
            start_s: extent.map(|(start, _)| start),
            end_s: extent.map(|(_, end)| end),
            columns: self.record.ranges(),
            gaps: self.gaps.clone(),
            steps: self.steps.clone(),
        }
    }
}

impl Record {
    /// Sample rate \[Hz\], if the time base is uniform.
    pub fn sample_rate_hz(&self) -> Option<f64> {
        match self.time {
            TimeBase::Uniform { sample_rate_hz, .. } => Some(sample_rate_hz),
            _ => None,
        }
    }

    /// Range of every column.
    pub fn ranges(&self) -> Vec<ColumnRange> {
        let range = |channel: &super::Channel| {
            let (low, high) = range_of(&channel.samples);
            ColumnRange { name: channel.name.clone(), unit: channel.unit.symbol().to_owned(), low, high }
        };
        self.channels.iter().map(range).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::Channel;
    use super::*;

    fn record(name: &str, start_s: f64) -> Record {
        let time = TimeBase::Uniform { start_s, sample_rate_hz: 100.0, jitter_samples: 0.0 };
        let y = (0..200).map(|k| 0.1 + 0.01 * f64::from(k)).collect();
        let u = (0..200).map(|k| f64::from(k % 20)).collect();
        Record::new(name, time, vec![Channel::new("u", "V", u), Channel::new("y", "V", y)]).unwrap()
    }

    #[test]
    fn steps_are_done_in_order_and_told() {
        let prepare = Prepare {
            scales: vec!["y=2um/V".parse().unwrap()],
            remove_mean: vec!["u".into()],
            detrend: vec!["y".into()],
            sample_rate_hz: Some(50.0),
        };
        let done = prepare.run(&[record("a", 0.0), record("b", 4.0)]).unwrap();
        assert_eq!(done.record.channels[1].unit.symbol(), "um");
        assert_eq!(done.record.sample_rate_hz(), Some(50.0));
        assert_eq!(done.record.len(), 300);
        let [joined, scaled, mean, trend, resampled] = done.steps.as_slice() else {
            panic!("{:?}", done.steps)
        };
        assert_eq!(*joined, Step::Joined { records: 2 });
        assert_eq!(*scaled, Step::Scaled { scale: prepare.scales[0].clone() });
        assert!(matches!(mean, Step::MeanRemoved { mean, .. } if (mean - 9.5).abs() < 1e-12), "{mean:?}");
        // The mean of y is that in µm: scaled before.
        assert!(matches!(trend, Step::Detrended { mean, .. } if (mean - 2.19).abs() < 1e-9), "{trend:?}");
        let expected = Step::Resampled { from_hz: None, to_hz: 50.0, gaps: 1, samples_in_gaps: 100 };
        assert_eq!(*resampled, expected);
        assert_eq!((done.summary().masked_samples, done.gaps.len()), (100, 1));
        let nothing = Prepare::default().run(&[record("a", 0.0)]).unwrap();
        assert_eq!(nothing, Prepared { record: record("a", 0.0), steps: Vec::new(), gaps: Vec::new() });
        let summary = nothing.summary();
        assert_eq!((summary.samples, summary.masked_samples, summary.sample_rate_hz), (200, 0, Some(100.0)));
        assert_eq!((summary.start_s, summary.end_s), (Some(0.0), Some(1.99)));
        let [u, y] = summary.columns.as_slice() else { panic!("{summary:?}") };
        assert_eq!((u.low, u.high, y.unit.as_str()), (0.0, 19.0, "V"));
    }
}
