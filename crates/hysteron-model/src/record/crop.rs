//! Parts of a record, and records with a changed channel: each returns a new one.

use std::ops::Range;

use crate::advice::ColumnRole;

use super::{InputOutput, Record, RecordError, Unit};

impl Record {
    /// The samples of a range, at least two.
    ///
    /// # Errors
    /// [`RecordError::BadRange`].
    pub fn cropped(&self, range: Range<usize>) -> Result<Record, RecordError> {
        check_range(&self.name, &range, self.len())?;
        let mut cropped = Record {
            name: self.name.clone(),
            time: self.time.cropped(range.start, range.end),
            channels: self.channels.clone(),
            valid: self.valid.as_ref().map(|v| part(v, &range)),
            source: self.source.clone(),
        };
        for channel in &mut cropped.channels {
            channel.samples = part(&channel.samples, &range);
        }
        Ok(cropped)
    }

    /// The record with one channel multiplied by `factor` and given another unit, e.g. sensor volts to µm
    /// (2.5 µm/V: factor 2.5, unit `um`).
    ///
    /// # Errors
    /// [`RecordError::NoSuchChannel`], [`RecordError::BadScale`], [`RecordError::NotFinite`] where a product
    /// overflows.
    pub fn with_channel_scaled(&self, name: &str, factor: f64, unit: Unit) -> Result<Record, RecordError> {
        let index = self.position(name, ColumnRole::Scaled)?;
        if !factor.is_finite() || factor == 0.0 {
            return Err(RecordError::BadScale {
                record: self.name.clone(),
                channel: name.to_string(),
                factor,
            });
        }
        let mut scaled = self.clone();
        let channel = &mut scaled.channels[index];
        channel.unit = unit;
        for x in &mut channel.samples {
            *x *= factor;
        }
        scaled.check()?;
        Ok(scaled)
    }
}

impl InputOutput {
    /// The samples of a range, at least two.
    ///
    /// # Errors
    /// [`RecordError::BadRange`].
    pub fn cropped(&self, range: Range<usize>) -> Result<InputOutput, RecordError> {
        check_range(&self.name, &range, self.len())?;
        Ok(InputOutput {
            time: self.time.cropped(range.start, range.end),
            u: part(&self.u, &range),
            y: part(&self.y, &range),
            rate: self.rate.as_ref().map(|rate| part(rate, &range)),
            valid: self.valid.as_ref().map(|v| part(v, &range)),
            ..self.without_samples()
        })
    }

    /// Sample rate \[Hz\], or the error for a base without one.
    ///
    /// # Errors
    /// [`RecordError::NotUniform`]; `purpose` names the step that needs the rate.
    pub fn require_sample_rate_hz(&self, purpose: &'static str) -> Result<f64, RecordError> {
        self.sample_rate_hz().ok_or_else(|| RecordError::NotUniform {
            record: self.name.clone(),
            purpose,
            found: self.time.description(),
        })
    }

    /// Names, units and source alone.
    pub(crate) fn without_samples(&self) -> InputOutput {
        InputOutput {
            name: self.name.clone(),
            time: super::TimeBase::Unknown,
            u: Vec::new(),
            y: Vec::new(),
            rate: None,
            valid: None,
            input: self.input.clone(),
            output: self.output.clone(),
            u_unit: self.u_unit.clone(),
            y_unit: self.y_unit.clone(),
            source: self.source.clone(),
        }
    }
}

fn part<T: Clone>(samples: &[T], range: &Range<usize>) -> Vec<T> {
    samples.get(range.clone()).unwrap_or_default().to_vec()
}

fn check_range(record: &str, range: &Range<usize>, samples: usize) -> Result<(), RecordError> {
    if range.start < range.end && range.end <= samples && range.end - range.start >= 2 {
        return Ok(());
    }
    Err(RecordError::BadRange { record: record.to_string(), start: range.start, end: range.end, samples })
}

#[cfg(test)]
mod tests {
    use super::super::{Channel, TimeBase};
    use super::*;

    fn record() -> Record {
        let mut record = Record::new(
            "r",
            TimeBase::uniform(10.0),
            vec![
                Channel::new("u", "V", (0..5).map(f64::from).collect()),
                Channel::new("y", "V", (0..5).map(|k| 2.0 * f64::from(k)).collect()),
            ],
        )
        .unwrap();
        record.valid = Some(vec![true, true, false, true, true]);
        record
    }

    #[test]
    fn a_part_keeps_its_times_and_mask_and_leaves_the_record_alone() {
        let before = record();
        let part = before.cropped(2..5).unwrap();
        assert_eq!(part.channels[1].samples, [4.0, 6.0, 8.0]);
        assert_eq!(part.time.time_s(0), Some(0.2));
        assert_eq!(part.valid, Some(vec![false, true, true]));
        assert_eq!(before, record());
        for range in [3..3, 4..5, 0..6, 7..9] {
            assert!(matches!(before.cropped(range), Err(RecordError::BadRange { samples: 5, .. })));
        }
    }

    #[test]
    fn sensor_volts_become_micrometres() {
        let scaled = record().with_channel_scaled("y", 2.5, Unit::new("um")).unwrap();
        assert_eq!(scaled.channels[1].header(), "y_um");
        assert_eq!(scaled.channels[1].samples, [0.0, 5.0, 10.0, 15.0, 20.0]);
        let scaled = |name, factor| record().with_channel_scaled(name, factor, Unit::new("um")).unwrap_err();
        assert!(matches!(scaled("x", 1.0), RecordError::NoSuchChannel { .. }));
        assert!(matches!(scaled("y", f64::NAN), RecordError::BadScale { .. }));
        assert!(matches!(scaled("y", 1e308), RecordError::NotFinite { .. }));
    }

    #[test]
    fn a_rate_is_refused_with_the_reason() {
        let base = TimeBase::from_times("r", vec![0.0, 1.0, 5.0]).unwrap();
        let io = InputOutput::new("r", base, vec![0.0, 1.0, 2.0], vec![0.0, 1.0, 2.0]).unwrap();
        let text = io.require_sample_rate_hz("a dynamic fit").unwrap_err().to_string();
        assert!(text.contains("a dynamic fit") && text.contains("not uniform"), "{text}");
    }
}
