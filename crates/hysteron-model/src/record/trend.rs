//! Offset and slow straight-line drift of the output.

use super::{InputOutput, Periods, RecordError};

/// Straight-line drift of the output over its settled part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearDrift {
    /// Slope, output units per second.
    pub per_second: f64,
    /// Standard error of the slope (from the scatter about the line, taken as independent).
    pub std_error: f64,
}

/// Drift of the output: least-squares line through the means of the settled periods (each mean free of the
/// motion), or, without periods, through all valid samples (where a motion that does not repeat is mistaken
/// for drift: use with care).
///
/// # Errors
/// [`RecordError::NotUniform`]; [`RecordError::TooShort`] with fewer than three settled periods, or samples.
pub fn linear_drift(data: &InputOutput, periods: Option<&Periods>) -> Result<LinearDrift, RecordError> {
    let rate = data.require_sample_rate_hz("a drift per second")?;
    let points: Vec<(f64, f64)> = match periods {
        Some(p) => (p.settling..p.count)
            .map(|m| {
                let one = p.one(&data.y, m);
                (m as f64 * p.period_samples / rate, one.iter().sum::<f64>() / one.len().max(1) as f64)
            })
            .collect(),
        None => data
            .y
            .iter()
            .enumerate()
            .filter(|(k, _)| data.valid.as_ref().is_none_or(|v| v.get(*k).copied().unwrap_or(true)))
            .map(|(k, y)| (k as f64 / rate, *y))
            .collect(),
    };
    let n = points.len();
    if n < 3 {
        return Err(RecordError::TooShort {
            record: data.name.clone(),
            got: n,
            need: 3,
            purpose: "a drift (in settled periods, or samples where nothing repeats)",
        });
    }
    let count = n as f64;
    let (t_mean, y_mean) = points.iter().fold((0.0, 0.0), |(t, y), p| (t + p.0 / count, y + p.1 / count));
    let (mut cross, mut square) = (0.0, 0.0);
    for (t, y) in &points {
        cross += (t - t_mean) * (y - y_mean);
        square += (t - t_mean) * (t - t_mean);
    }
    let per_second = cross / square;
    let scatter: f64 = points.iter().map(|(t, y)| (y - y_mean - per_second * (t - t_mean)).powi(2)).sum();
    Ok(LinearDrift { per_second, std_error: (scatter / (count - 2.0) / square).sqrt() })
}

impl InputOutput {
    /// The record with this offset subtracted from the output.
    pub fn with_offset_removed(&self, offset: f64) -> InputOutput {
        let mut changed = self.clone();
        for y in &mut changed.y {
            *y -= offset;
        }
        changed
    }

    /// The record with the drift subtracted from the output: y_k − drift · (t_k − t_0).
    ///
    /// # Errors
    /// [`RecordError::NotUniform`] where there are no times at all.
    pub fn with_drift_removed(&self, drift: &LinearDrift) -> Result<InputOutput, RecordError> {
        let mut changed = self.clone();
        let start = self.time.time_s(0).ok_or_else(|| RecordError::NotUniform {
            record: self.name.clone(),
            purpose: "taking out a drift",
            found: self.time.description(),
        })?;
        for (k, y) in changed.y.iter_mut().enumerate() {
            *y -= drift.per_second * (self.time.time_s(k).unwrap_or(start) - start);
        }
        Ok(changed)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{TimeBase, find_periods};
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn the_drift_of_a_sine_is_found_and_removed_and_the_record_is_left_alone() {
        let u: Vec<f64> = (0..2030).map(|k| (TAU * f64::from(k) / 200.0).sin()).collect();
        let y: Vec<f64> =
            u.iter().enumerate().map(|(k, u)| 3.0 + 10.0 * u + 0.25 * k as f64 / 100.0).collect();
        let data = InputOutput::new("r", TimeBase::uniform(100.0), u, y).unwrap();
        let before = data.clone();
        let periods = find_periods(&data).unwrap();
        let drift = linear_drift(&data, Some(&periods)).unwrap();
        assert!((drift.per_second - 0.25).abs() < 1e-9, "{drift:?}");
        assert!(drift.std_error < 1e-9);
        let level = data.with_drift_removed(&drift).unwrap().with_offset_removed(3.0);
        for (y, u) in level.y.iter().zip(&level.u) {
            assert!((y - 10.0 * u).abs() < 1e-7);
        }
        assert_eq!(data, before);
    }

    #[test]
    fn a_record_without_times_has_no_drift() {
        let data =
            InputOutput::new("r", TimeBase::Unknown, vec![0.0, 1.0, 2.0], vec![0.0, 1.0, 2.0]).unwrap();
        assert!(matches!(linear_drift(&data, None), Err(RecordError::NotUniform { .. })));
        let drift = LinearDrift { per_second: 1.0, std_error: 0.0 };
        assert!(matches!(data.with_drift_removed(&drift), Err(RecordError::NotUniform { .. })));
    }
}
