//! Signals of NARX models: normalised to the training ranges, one lag interval apart.

use super::BaselineError;
use super::regressors::{Series, directions};
use hysteron_model::record::{InputOutput, range_of, shortest_swing};

/// Least return of the drive at a reversal, as a share of its training range.
const TURN: f64 = 0.005;
/// Relative tolerance for an interval of a whole number of samples.
const WHOLE: f64 = 1e-3;

/// An affine map of a signal onto −1 … 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Middle of the range.
    pub middle: f64,
    /// Half of its width.
    pub half: f64,
}

/// Scales of both signals, and the time between lags.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Of the input.
    pub input: Scale,
    /// Of the output.
    pub output: Scale,
    /// Time between lags \[s\].
    pub interval_s: f64,
}

impl Scale {
    fn of<'a>(signal: &'static str, samples: impl Iterator<Item = &'a f64>) -> Result<Self, BaselineError> {
        let samples: Vec<f64> = samples.copied().collect();
        let (low, high) = range_of(&samples);
        let scale = Self { middle: 0.5 * (low + high), half: 0.5 * (high - low) };
        if scale.half > 0.0 { Ok(scale) } else { Err(BaselineError::Constant { signal }) }
    }

    pub(super) fn normalised(self, x: f64) -> f64 {
        (x - self.middle) / self.half
    }

    pub(super) fn physical(self, x: f64) -> f64 {
        self.middle + self.half * x
    }
}

impl Units {
    /// From the valid samples of the training records.
    ///
    /// # Errors
    /// [`BaselineError::NoRecords`], [`BaselineError::NotFinite`], [`BaselineError::Constant`].
    pub(super) fn of(records: &[InputOutput], interval_s: f64) -> Result<Self, BaselineError> {
        if records.is_empty() {
            return Err(BaselineError::NoRecords);
        }
        records.iter().try_for_each(finite)?;
        let input = Scale::of("input", records.iter().flat_map(|r| valid(r, &r.u)))?;
        let output = Scale::of("output", records.iter().flat_map(|r| valid(r, &r.y)))?;
        Ok(Self { input, output, interval_s })
    }

    /// Samples of the record in one lag interval.
    ///
    /// # Errors
    /// [`BaselineError::NoSampleRate`], [`BaselineError::Interval`].
    pub(super) fn stride(&self, record: &InputOutput) -> Result<usize, BaselineError> {
        let sample_rate_hz = rate(record)?;
        let samples = self.interval_s * sample_rate_hz;
        let stride = samples.round();
        if stride < 1.0 || (samples - stride).abs() > WHOLE * stride {
            return Err(BaselineError::Interval {
                record: record.name.clone(),
                sample_rate_hz,
                interval_s: self.interval_s,
            });
        }
        Ok(stride as usize)
    }

    /// Splits the record into one series per sample in a lag interval, each one sample later than the
    /// previous one.
    ///
    /// # Errors
    /// Those of [`Units::stride`]; [`BaselineError::NotFinite`].
    pub(super) fn phases(&self, record: &InputOutput) -> Result<Vec<Series>, BaselineError> {
        finite(record)?;
        let stride = self.stride(record)?;
        let u: Vec<f64> = record.u.iter().map(|&u| self.input.normalised(u)).collect();
        let direction = directions(&u, 2.0 * TURN);
        let is_valid = |k: usize| record.is_valid(k);
        let phase = |p: usize| {
            let at = || (p..u.len()).step_by(stride);
            Series {
                u: at().map(|k| u[k]).collect(),
                y: at().map(|k| self.output.normalised(record.y[k])).collect(),
                direction: at().map(|k| direction[k]).collect(),
                valid: at().map(is_valid).collect(),
            }
        };
        Ok((0..stride).map(phase).collect())
    }
}

/// Lag intervals to try for these records \[s\]: about 10, 20 and 40 to the period of the fastest drive, each
/// a whole number of samples of the slowest-sampled record. Only the drives are used.
///
/// # Errors
/// [`BaselineError::NoRecords`], [`BaselineError::NoSampleRate`].
pub fn lag_intervals(records: &[InputOutput]) -> Result<Vec<f64>, BaselineError> {
    let mut period_s = f64::INFINITY;
    let mut sample_s = 0.0_f64;
    for record in records {
        let rate = rate(record)?;
        period_s = period_s.min(2.0 * shortest_swing(&record.u) as f64 / rate);
        sample_s = sample_s.max(1.0 / rate);
    }
    if records.is_empty() {
        return Err(BaselineError::NoRecords);
    }
    let mut strides: Vec<f64> =
        [10.0, 20.0, 40.0].iter().map(|n| (period_s / n / sample_s).round().max(1.0)).collect();
    strides.dedup();
    Ok(strides.into_iter().map(|stride| stride * sample_s).collect())
}

fn rate(record: &InputOutput) -> Result<f64, BaselineError> {
    record.sample_rate_hz().ok_or_else(|| BaselineError::NoSampleRate { record: record.name.clone() })
}

fn finite(record: &InputOutput) -> Result<(), BaselineError> {
    for (signal, samples) in [("input", &record.u), ("output", &record.y)] {
        if let Some(index) = samples.iter().position(|x| !x.is_finite()) {
            return Err(BaselineError::NotFinite { signal, record: record.name.clone(), index });
        }
    }
    Ok(())
}

fn valid<'a>(record: &'a InputOutput, samples: &'a [f64]) -> impl Iterator<Item = &'a f64> {
    let mask = record.valid.as_deref();
    samples.iter().enumerate().filter(move |(k, _)| mask.is_none_or(|m| m[*k])).map(|(_, x)| x)
}
