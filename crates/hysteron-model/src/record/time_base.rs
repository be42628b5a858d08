//! Time bases: recognising a uniform grid in a column of time stamps.

use super::{RATES_HZ, RecordError, TimeBase};

/// Largest deviation from the least-squares grid, in sample periods, up to which time stamps count as
/// uniform.
///
/// Rounding stamps to a fifth of the period gives a tenth of a sample. A missing sample shifts its neighbours
/// by about half a period and is never accepted.
pub const UNIFORM_TOLERANCE_SAMPLES: f64 = 0.1;
/// [`UNIFORM_TOLERANCE_SAMPLES`] for a part of a record whose stamps are uneven as a whole.
const PART_TOLERANCE_SAMPLES: f64 = 0.01;

/// A sample rate given beside a time column may differ from the column's mean rate by this fraction.
pub const GIVEN_RATE_TOLERANCE: f64 = 0.005;

/// Description of a record without time stamps, for messages.
pub(crate) const NO_TIMES: &str = "it has neither a time column nor a sample rate";

impl TimeBase {
    /// Uniform time base starting at 0 s.
    pub fn uniform(sample_rate_hz: f64) -> Self {
        TimeBase::Uniform { start_s: 0.0, sample_rate_hz, jitter_samples: 0.0 }
    }

    /// Time base from measured stamps \[s\].
    ///
    /// The grid t_k = a + b k is fitted by least squares. Where no stamp deviates from it by more than
    /// [`UNIFORM_TOLERANCE_SAMPLES`] periods, the base is uniform with rate 1/b, and the largest deviation is
    /// its jitter; the rate is rounded to the fewest digits (of itself or of the period) that move no sample
    /// by more than a tenth of the jitter or 1e-6 of a period, so that 0.005 s reads as 200 Hz. Otherwise the
    /// stamps are kept. Equal neighbouring stamps are allowed (loggers with a coarse clock write them) and
    /// make the base non-uniform.
    ///
    /// # Errors
    /// [`RecordError::TooShort`] below two stamps, [`RecordError::NotFinite`],
    /// [`RecordError::TimeDecreases`], [`RecordError::TimeStandsStill`], [`RecordError::BadSampleRate`].
    pub fn from_times(record: &str, times_s: Vec<f64>) -> Result<Self, RecordError> {
        Self::from_times_within(UNIFORM_TOLERANCE_SAMPLES, record, times_s)
    }

    /// Time base of a part of uneven stamps: a grid where the part is uniform up to the rounding of stamps,
    /// [`PART_TOLERANCE_SAMPLES`]; else the original stamps, also for a few neighbours that are nearly even
    /// by chance.
    ///
    /// # Errors
    /// Those of [`TimeBase::from_times`].
    pub(super) fn of_part(record: &str, times_s: Vec<f64>) -> Result<Self, RecordError> {
        Self::from_times_within(PART_TOLERANCE_SAMPLES, record, times_s)
    }

    fn from_times_within(tolerance: f64, record: &str, times_s: Vec<f64>) -> Result<Self, RecordError> {
        let n = times_s.len();
        check_times(record, &times_s)?;
        let grid = Grid::fit(&times_s);
        let jitter = grid.largest_deviation(&times_s);
        if jitter > tolerance {
            return Ok(TimeBase::NonUniform { times_s });
        }
        let drift_allowed = (0.1 * jitter).max(1e-6);
        let rate = rounded_rate(1.0 / grid.period_s, drift_allowed / n as f64);
        let start = if (grid.start_s - times_s[0]).abs() <= grid.period_s * drift_allowed {
            times_s[0]
        } else {
            grid.start_s
        };
        Ok(TimeBase::Uniform { start_s: start, sample_rate_hz: rate, jitter_samples: jitter })
    }

    /// Uniform base at a given rate, where a time column exists as well: the column gives the start and the
    /// jitter.
    ///
    /// # Errors
    /// Those of [`TimeBase::from_times`]; [`RecordError::BadSampleRate`];
    /// [`RecordError::RateContradictsTime`] where the column's mean rate differs by more than
    /// [`GIVEN_RATE_TOLERANCE`].
    pub fn from_times_at_rate(
        record: &str,
        times_s: &[f64],
        sample_rate_hz: f64,
    ) -> Result<Self, RecordError> {
        check_rate(record, sample_rate_hz)?;
        check_times(record, times_s)?;
        let grid = Grid::fit(times_s);
        let measured_hz = 1.0 / grid.period_s;
        if (measured_hz / sample_rate_hz - 1.0).abs() > GIVEN_RATE_TOLERANCE {
            return Err(RecordError::RateContradictsTime {
                record: record.to_string(),
                given_hz: sample_rate_hz,
                measured_hz,
                samples: times_s.len(),
                duration_s: times_s[times_s.len() - 1] - times_s[0],
            });
        }
        let period_s = 1.0 / sample_rate_hz;
        let mean_time = times_s.iter().sum::<f64>() / times_s.len() as f64;
        let given = Grid { start_s: mean_time - 0.5 * (times_s.len() - 1) as f64 * period_s, period_s };
        Ok(TimeBase::Uniform {
            start_s: given.start_s,
            sample_rate_hz,
            jitter_samples: given.largest_deviation(times_s),
        })
    }

    /// Time of sample `k` \[s\]; `None` for an unknown time base or beyond the stamps.
    pub fn time_s(&self, k: usize) -> Option<f64> {
        match self {
            TimeBase::Uniform { start_s, sample_rate_hz, .. } => Some(start_s + k as f64 / sample_rate_hz),
            TimeBase::NonUniform { times_s } => times_s.get(k).copied(),
            TimeBase::Unknown => None,
        }
    }

    /// Times of the first and of the last of this many samples \[s\]; `None` where they are unknown.
    pub fn extent_s(&self, samples: usize) -> Option<(f64, f64)> {
        self.time_s(0).zip(self.time_s(samples.checked_sub(1)?))
    }

    /// Samples of a period of `period_s` from the first one on; `None` where times are unknown.
    pub fn samples_of(&self, period_s: f64) -> Option<usize> {
        match self {
            Self::Uniform { sample_rate_hz, .. } => Some((period_s * sample_rate_hz).round() as usize),
            // Stamps are rounded: the first sample of the next period may lie a little early.
            Self::NonUniform { times_s } => {
                let next_s = times_s.first()? + period_s * (1.0 - 1e-9);
                Some(times_s.partition_point(|time| *time < next_s))
            }
            Self::Unknown => None,
        }
    }

    /// The part of the base that belongs to samples `start..end`.
    pub(crate) fn cropped(&self, start: usize, end: usize) -> TimeBase {
        match self {
            TimeBase::Uniform { start_s, sample_rate_hz, jitter_samples } => TimeBase::Uniform {
                start_s: start_s + start as f64 / sample_rate_hz,
                sample_rate_hz: *sample_rate_hz,
                jitter_samples: *jitter_samples,
            },
            TimeBase::NonUniform { times_s } => {
                TimeBase::NonUniform { times_s: times_s.get(start..end).unwrap_or_default().to_vec() }
            }
            TimeBase::Unknown => TimeBase::Unknown,
        }
    }

    /// Description of the base, for messages, where it is not uniform.
    pub(crate) fn description(&self) -> &'static str {
        match self {
            TimeBase::Uniform { .. } => "it is uniform",
            TimeBase::NonUniform { .. } => "its time stamps are not uniform",
            TimeBase::Unknown => NO_TIMES,
        }
    }
}

pub(crate) fn check_rate(record: &str, sample_rate_hz: f64) -> Result<(), RecordError> {
    if RATES_HZ.contains(&sample_rate_hz) {
        return Ok(());
    }
    Err(RecordError::BadSampleRate { record: record.to_string(), value: sample_rate_hz })
}

/// Finite, at least two, never decreasing, not all equal, at a mean rate that an instrument has.
pub(crate) fn check_times(record: &str, times_s: &[f64]) -> Result<(), RecordError> {
    let n = times_s.len();
    if n < 2 {
        return Err(RecordError::TooShort {
            record: record.to_string(),
            got: n,
            need: 2,
            purpose: "a time base",
        });
    }
    if let Some(index) = times_s.iter().position(|t| !t.is_finite()) {
        return Err(RecordError::NotFinite {
            record: record.to_string(),
            channel: "time".to_string(),
            index,
            value: times_s[index],
        });
    }
    if let Some(k) = times_s.windows(2).position(|w| w[1] < w[0]) {
        return Err(RecordError::TimeDecreases {
            record: record.to_string(),
            index: k + 1,
            before: times_s[k],
            after: times_s[k + 1],
        });
    }
    let span = times_s[n - 1] - times_s[0];
    if !(span > 0.0 && span.is_finite()) {
        return Err(RecordError::TimeStandsStill {
            record: record.to_string(),
            samples: n,
            time_s: times_s[0],
        });
    }
    check_rate(record, (n - 1) as f64 / span)
}

/// Grid t_k = start + k period.
struct Grid {
    start_s: f64,
    period_s: f64,
}

impl Grid {
    /// Least squares, with index and time centred so that a late start costs no digits.
    fn fit(times_s: &[f64]) -> Grid {
        let n = times_s.len() as f64;
        let centre = 0.5 * (n - 1.0);
        let origin = times_s[0];
        let mean = times_s.iter().map(|t| t - origin).sum::<f64>() / n;
        let (mut cross, mut square) = (0.0, 0.0);
        for (k, t) in times_s.iter().enumerate() {
            let i = k as f64 - centre;
            cross += i * (t - origin - mean);
            square += i * i;
        }
        let period_s = cross / square;
        Grid { start_s: origin + mean - centre * period_s, period_s }
    }

    /// max_k |t_k − grid_k| / period.
    fn largest_deviation(&self, times_s: &[f64]) -> f64 {
        let largest = times_s
            .iter()
            .enumerate()
            .map(|(k, t)| (t - self.start_s - k as f64 * self.period_s).abs())
            .fold(0.0, f64::max);
        largest / self.period_s
    }
}

/// Rate with the fewest digits, of itself or of its period, within the relative tolerance.
fn rounded_rate(rate_hz: f64, tolerance: f64) -> f64 {
    let close = |candidate: f64| (candidate / rate_hz - 1.0).abs() <= tolerance;
    for digits in 1..=15 {
        let rate = with_significant_digits(rate_hz, digits);
        if close(rate) {
            return rate;
        }
        let period = with_significant_digits(1.0 / rate_hz, digits);
        if close(1.0 / period) {
            return 1.0 / period;
        }
    }
    rate_hz
}

/// `value` rounded to this many significant decimal digits; the decimal text decides, so that no power of ten
/// rounds.
fn with_significant_digits(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uniform(times: Vec<f64>) -> (f64, f64, f64) {
        match TimeBase::from_times("r", times).unwrap() {
            TimeBase::Uniform { start_s, sample_rate_hz, jitter_samples } => {
                (start_s, sample_rate_hz, jitter_samples)
            }
            other => panic!("not uniform: {other:?}"),
        }
    }

    #[test]
    fn a_step_of_five_milliseconds_reads_as_exactly_200_hz() {
        let (start, rate, jitter) = uniform((0..8027).map(|k| f64::from(k) * 0.005).collect());
        assert_eq!((start, rate), (0.0, 200.0));
        assert!(jitter < 1e-9, "{jitter}");
    }

    #[test]
    fn thirds_of_a_millisecond_written_with_nine_digits_read_as_750_hz() {
        let times = (0..40960).map(|k| format!("{:.8e}", f64::from(k) / 750.0).parse().unwrap()).collect();
        let (_, rate, jitter) = uniform(times);
        assert_eq!(rate, 750.0);
        assert!(jitter > 0.0 && jitter < 1e-4, "{jitter}");
    }

    #[test]
    fn a_late_start_and_a_period_that_is_no_round_rate_are_kept() {
        let (start, rate, _) = uniform((0..1000).map(|k| 1.0e6 + f64::from(k) * 0.03).collect());
        assert!((start - 1.0e6).abs() < 1e-9);
        assert!((rate * 0.03 - 1.0).abs() < 1e-9, "{rate}");
    }

    #[test]
    fn a_missing_sample_makes_the_base_non_uniform_and_jitter_below_a_tenth_does_not() {
        let mut times: Vec<f64> = (0..1000).map(|k| f64::from(k) * 1e-3).collect();
        times[500] += 0.06e-3;
        let (_, rate, jitter) = uniform(times.clone());
        assert!((rate - 1000.0).abs() < 0.01);
        assert!((jitter - 0.06).abs() < 1e-3, "{jitter}");
        times.remove(300);
        assert!(matches!(TimeBase::from_times("r", times).unwrap(), TimeBase::NonUniform { .. }));
    }

    #[test]
    fn equal_stamps_are_kept_and_decreasing_or_constant_ones_refused() {
        let base = TimeBase::from_times("r", vec![0.0, 0.0, 1.0, 1.0, 2.0]).unwrap();
        assert!(matches!(base, TimeBase::NonUniform { .. }));
        let err = TimeBase::from_times("r", vec![0.0, 1.0, 0.5]).unwrap_err();
        assert!(matches!(err, RecordError::TimeDecreases { index: 2, .. }));
        let err = TimeBase::from_times("r", vec![1.0; 5]).unwrap_err();
        assert!(matches!(err, RecordError::TimeStandsStill { samples: 5, .. }));
        let err = TimeBase::from_times("r", vec![1.0]).unwrap_err();
        assert!(matches!(err, RecordError::TooShort { got: 1, .. }));
        let err = TimeBase::from_times("r", vec![0.0, f64::NAN, 1.0]).unwrap_err();
        assert!(matches!(err, RecordError::NotFinite { index: 1, .. }));
    }

    #[test]
    fn a_given_rate_replaces_coarse_stamps_and_is_refused_when_the_column_contradicts_it() {
        let coarse: Vec<f64> = (0..5000).map(|k| (f64::from(k) * 0.2).floor() * 1e-3).collect();
        let base = TimeBase::from_times_at_rate("r", &coarse, 5000.0).unwrap();
        let TimeBase::Uniform { jitter_samples, .. } = base else { panic!("not uniform") };
        assert!(jitter_samples > 1.0 && jitter_samples < 5.0);
        let err = TimeBase::from_times_at_rate("r", &coarse, 1000.0).unwrap_err();
        assert!(err.to_string().contains("1000 Hz"), "{err}");
        let err = TimeBase::from_times_at_rate("r", &coarse, -1.0).unwrap_err();
        assert!(matches!(err, RecordError::BadSampleRate { .. }));
    }
}
