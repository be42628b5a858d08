//! Mean and straight-line trend of a channel.

use serde::{Deserialize, Serialize};

use crate::advice::ColumnRole;

use super::{Record, RecordError};

/// Straight line through a channel: mean + slope · (t − mean time).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trend {
    /// Mean of the valid samples, in the channel's unit.
    pub mean: f64,
    /// Slope \[unit per second\]; 0 where the mean alone was requested.
    pub per_s: f64,
    /// Mean time of the valid samples \[s\].
    pub mean_time_s: f64,
}

impl Record {
    /// The record with the mean of a channel's valid samples taken from the channel, and that mean.
    ///
    /// # Errors
    /// [`RecordError::NoSuchChannel`]; [`RecordError::TooShort`] without valid samples.
    pub fn with_mean_removed(&self, channel: &str) -> Result<(Record, Trend), RecordError> {
        let index = self.position(channel, ColumnRole::Detrended)?;
        let valid = self.valid_indices(1, "a mean")?;
        let samples = &self.channels[index].samples;
        let mean = valid.iter().map(|&k| samples[k]).sum::<f64>() / valid.len() as f64;
        let mut changed = self.clone();
        changed.channels[index].samples.iter_mut().for_each(|x| *x -= mean);
        changed.check()?;
        Ok((changed, Trend { mean, per_s: 0.0, mean_time_s: 0.0 }))
    }

    /// The record with the least-squares line through a channel's valid samples taken from the channel, and
    /// that line.
    ///
    /// A drive that begins and ends at different values adds a slope, which is removed as well; for a
    /// periodic drive [`super::linear_drift`] separates the drift from the motion.
    ///
    /// # Errors
    /// [`RecordError::NoSuchChannel`]; [`RecordError::NoTimes`]; [`RecordError::TooShort`] with fewer than
    /// two valid samples; [`RecordError::TimeStandsStill`] where these are of one time.
    pub fn with_trend_removed(&self, channel: &str) -> Result<(Record, Trend), RecordError> {
        let index = self.position(channel, ColumnRole::Detrended)?;
        let valid = self.valid_indices(2, "a trend")?;
        let times = (0..self.len()).map(|k| self.time.time_s(k)).collect::<Option<Vec<f64>>>();
        let times = times.ok_or_else(|| RecordError::NoTimes {
            record: self.name.clone(),
            purpose: "a trend per second",
        })?;
        let samples = &self.channels[index].samples;
        let count = valid.len() as f64;
        // About the first stamp, so that a late start costs no digits.
        let origin = times[valid[0]];
        let mean_time = valid.iter().map(|&k| times[k] - origin).sum::<f64>() / count;
        let mean = valid.iter().map(|&k| samples[k]).sum::<f64>() / count;
        let (mut cross, mut square) = (0.0, 0.0);
        for &k in &valid {
            let t = times[k] - origin - mean_time;
            cross += t * (samples[k] - mean);
            square += t * t;
        }
        if square == 0.0 {
            return Err(RecordError::TimeStandsStill {
                record: self.name.clone(),
                samples: valid.len(),
                time_s: origin,
            });
        }
        let per_s = cross / square;
        let mut changed = self.clone();
        for (x, t) in changed.channels[index].samples.iter_mut().zip(&times) {
            *x -= mean + per_s * (t - origin - mean_time);
        }
        changed.check()?;
        Ok((changed, Trend { mean, per_s, mean_time_s: origin + mean_time }))
    }

    fn valid_indices(&self, need: usize, purpose: &'static str) -> Result<Vec<usize>, RecordError> {
        let is_valid = |k: &usize| self.valid.as_ref().is_none_or(|valid| valid.get(*k) == Some(&true));
        let valid: Vec<usize> = (0..self.len()).filter(is_valid).collect();
        if valid.len() >= need {
            return Ok(valid);
        }
        Err(RecordError::TooShort { record: self.name.clone(), got: valid.len(), need, purpose })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Channel, TimeBase};
    use super::*;

    fn record() -> Record {
        let times = vec![1e6, 1e6 + 1.0, 1e6 + 2.0, 1e6 + 5.0];
        let y = vec![3.0, 5.0, 100.0, 13.0];
        let base = TimeBase::from_times("r", times).unwrap();
        let mut record = Record::new("r", base, vec![Channel::new("y", "um", y)]).unwrap();
        record.valid = Some(vec![true, true, false, true]);
        record
    }

    #[test]
    fn a_line_through_the_valid_samples_is_removed() {
        let (level, trend) = record().with_trend_removed("y_um").unwrap();
        assert!((trend.per_s - 2.0).abs() < 1e-12 && (trend.mean - 7.0).abs() < 1e-12, "{trend:?}");
        assert!((trend.mean_time_s - 1e6 - 2.0).abs() < 1e-9);
        for (x, expected) in level.channels[0].samples.iter().zip([0.0, 0.0, 93.0, 0.0]) {
            assert!((x - expected).abs() < 1e-9, "{level:?}");
        }
        let (about_zero, trend) = record().with_mean_removed("y").unwrap();
        assert_eq!((about_zero.channels[0].samples[0], trend.mean, trend.per_s), (-4.0, 7.0, 0.0));
    }

    #[test]
    fn a_trend_needs_the_channel_times_and_valid_samples() {
        assert!(matches!(record().with_trend_removed("z"), Err(RecordError::NoSuchChannel { .. })));
        let without = Record { time: TimeBase::Unknown, ..record() };
        assert!(matches!(without.with_trend_removed("y"), Err(RecordError::NoTimes { .. })));
        assert!(without.with_mean_removed("y").is_ok());
        let masked = Record { valid: Some(vec![false, false, true, false]), ..record() };
        assert!(matches!(masked.with_trend_removed("y"), Err(RecordError::TooShort { got: 1, .. })));
        let times_s = vec![0.0, 0.0, 1.0, 1.0];
        let still = Record {
            time: TimeBase::NonUniform { times_s },
            valid: Some(vec![true, true, false, false]),
            ..record()
        };
        assert!(matches!(still.with_trend_removed("y"), Err(RecordError::TimeStandsStill { .. })));
    }
}
