//! Records at another sample rate.

use std::f64::consts::PI;

use super::time_base::check_rate;
use super::{InputOutput, RecordError, TimeBase};

/// Zero crossings of the interpolating kernel on either side.
const HALF_WIDTH: f64 = 32.0;
/// Shape of its Kaiser window: side lobes below −90 dB.
const KAISER_BETA: f64 = 9.0;
/// Cut-off as a fraction of the lower of the two Nyquist frequencies.
const PASSBAND: f64 = 0.92;

impl InputOutput {
    /// The record at another sample rate, over the same time.
    ///
    /// Uniform samples are interpolated with a Kaiser-windowed sinc of 2 · 32 zero crossings, cut off at 0.92 of the lower Nyquist
    /// frequency (so nothing aliases); within that distance of the ends the kernel is what is left of it, scaled to
    /// unit gain at zero frequency. Measured on a sine at 0.4 of the old rate's Nyquist frequency: error below 1e-4 of
    /// the amplitude, away from the ends. Non-uniform samples are joined by straight lines (equal stamps are averaged). A new
    /// sample is valid where its two old neighbours are.
    ///
    /// # Errors
    /// [`RecordError::BadSampleRate`]; [`RecordError::NotUniform`] without a time base; [`RecordError::TooShort`] where fewer than
    /// two samples would be left; [`RecordError::BadSetting`] above 2²⁹ samples.
    pub fn resampled(&self, sample_rate_hz: f64) -> Result<InputOutput, RecordError> {
        check_rate(&self.name, sample_rate_hz)?;
        if self.sample_rate_hz() == Some(sample_rate_hz) {
            return Ok(self.clone());
        }
        let n = self.len();
        let (Some(start), Some(end)) = (self.time.time_s(0), self.time.time_s(n.saturating_sub(1))) else {
            return Err(RecordError::NotUniform {
                record: self.name.clone(),
                purpose: "resampling",
                found: self.time.description(),
            });
        };
        // A last sample that rounding alone puts behind the end is kept.
        let intervals = ((end - start) * sample_rate_hz * (1.0 + 1e-12) + 1e-9).floor();
        if intervals < 1.0 {
            return Err(RecordError::TooShort {
                record: self.name.clone(),
                got: intervals as usize + 1,
                need: 2,
                purpose: "resampling to this rate",
            });
        }
        if intervals >= (1u64 << 29) as f64 {
            return Err(RecordError::BadSetting {
                record: self.name.clone(),
                setting: "sample rate",
                value: sample_rate_hz,
                allowed: "the new record must stay below 2^29 samples",
            });
        }
        let count = intervals as usize + 1;
        // Places of the new samples, in old sample indices.
        let places: Vec<f64> = match &self.time {
            TimeBase::NonUniform { times_s } => {
                let mut k = 0;
                (0..count)
                    .map(|i| {
                        let t = start + i as f64 / sample_rate_hz;
                        while k + 2 < n && times_s[k + 1] < t {
                            k += 1;
                        }
                        let width = times_s[k + 1] - times_s[k];
                        k as f64 + if width > 0.0 { ((t - times_s[k]) / width).clamp(0.0, 1.0) } else { 0.5 }
                    })
                    .collect()
            }
            _ => {
                let rate = self.sample_rate_hz().unwrap_or(sample_rate_hz);
                (0..count).map(|i| (i as f64 * rate / sample_rate_hz).min((n - 1) as f64)).collect()
            }
        };
        let cutoff = match &self.time {
            TimeBase::Uniform { sample_rate_hz: old, .. } => Some(PASSBAND * (sample_rate_hz / old).min(1.0)),
            _ => None,
        };
        let at = |x: &[f64]| -> Vec<f64> {
            places
                .iter()
                .map(|&place| match cutoff {
                    Some(cutoff) => by_sinc(x, place, cutoff),
                    None => by_line(x, place),
                })
                .collect()
        };
        Ok(InputOutput {
            time: TimeBase::Uniform { start_s: start, sample_rate_hz, jitter_samples: 0.0 },
            u: at(&self.u),
            y: at(&self.y),
            valid: self.valid.as_ref().map(|valid| {
                let ok = |k: f64| valid.get(k as usize).copied().unwrap_or(true);
                places.iter().map(|p| ok(p.floor()) && ok(p.ceil())).collect()
            }),
            ..self.without_samples()
        })
    }

    /// Every `factor`-th sample, after the low-pass that this needs (see [`InputOutput::resampled`]).
    ///
    /// # Errors
    /// As [`InputOutput::resampled`]; [`RecordError::BadSetting`] for a factor of 0.
    pub fn decimated(&self, factor: usize) -> Result<InputOutput, RecordError> {
        if factor == 0 {
            return Err(RecordError::BadSetting {
                record: self.name.clone(),
                setting: "decimation factor",
                value: 0.0,
                allowed: "it must be at least 1",
            });
        }
        self.resampled(self.require_sample_rate_hz("decimation")? / factor as f64)
    }
}

/// A low-pass ahead of taking every `factor`-th sample: a Kaiser-windowed sinc that reaches `reach` new samples to either
/// side, an odd number of values with the sum 1. What lies above half the new rate is stopped to 5e-5; the pass band,
/// kept to 5e-5 (both from a reach of 16 on), ends as far below as the reach allows, at 0.5 − 2.87/reach of the new rate.
#[doc(hidden)]
pub fn low_pass(factor: usize, reach: usize) -> Vec<f64> {
    // Kaiser's rule for the width of the transition, A = 90 dB: (A − 7.95)/14.36 over the length.
    let transition = (90.0 - 7.95) / 14.36 / (2 * reach) as f64;
    let cutoff = (1.0 - transition) / factor as f64;
    let half = (reach * factor) as i32;
    let mut kernel: Vec<f64> =
        (-half..=half).map(|j| windowed_sinc(f64::from(j), cutoff, f64::from(half))).collect();
    let gain: f64 = kernel.iter().sum();
    kernel.iter_mut().for_each(|h| *h /= gain);
    kernel
}

/// Value between samples on a straight line.
fn by_line(x: &[f64], place: f64) -> f64 {
    let k = (place.floor() as usize).min(x.len().saturating_sub(2));
    let t = place - k as f64;
    (1.0 - t) * x[k] + t * x[k + 1]
}

/// Σ x_k h(place − k) / Σ h, h the windowed sinc with cut-off `cutoff` (1: the Nyquist frequency).
fn by_sinc(x: &[f64], place: f64, cutoff: f64) -> f64 {
    let reach = HALF_WIDTH / cutoff;
    let first = (place - reach).ceil().max(0.0) as usize;
    let last = ((place + reach).floor() as usize).min(x.len() - 1);
    let (mut sum, mut weight) = (0.0, 0.0);
    for (k, x) in x.iter().enumerate().take(last + 1).skip(first) {
        let h = windowed_sinc(place - k as f64, cutoff, reach);
        sum += h * x;
        weight += h;
    }
    sum / weight
}

/// The sinc with cut-off `cutoff` (1: the Nyquist frequency) at `d` samples, times Kaiser's window.
fn windowed_sinc(d: f64, cutoff: f64, reach: f64) -> f64 {
    let a = PI * cutoff * d;
    let sinc = if a == 0.0 { 1.0 } else { a.sin() / a };
    sinc * bessel_i0(KAISER_BETA * (1.0 - (d / reach).powi(2)).max(0.0).sqrt())
}

/// Modified Bessel function I₀ by its power series (all terms positive; 40 of them suffice to 1e-15 below 10).
fn bessel_i0(x: f64) -> f64 {
    let quarter = 0.25 * x * x;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..40 {
        term *= quarter / f64::from(k * k);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn record(frequency: f64, rate: f64, n: usize) -> InputOutput {
        let u: Vec<f64> = (0..n).map(|k| (TAU * frequency * k as f64 / rate).sin()).collect();
        let y = u.iter().map(|u| 2.0 + u).collect();
        InputOutput::new("r", TimeBase::uniform(rate), u, y).unwrap()
    }

    #[test]
    fn the_bessel_function_is_right() {
        // Abramowitz and Stegun, table 9.8 and 9.11: I0(1), I0(5).
        assert!((bessel_i0(1.0) - 1.266_065_877_752_008).abs() < 1e-14);
        assert!((bessel_i0(5.0) - 27.239_871_823_604_44).abs() < 1e-12);
    }

    #[test]
    fn the_low_pass_passes_and_stops_what_it_says() {
        for (factor, reach) in [(2, 16), (5, 16), (16, 24)] {
            let kernel = low_pass(factor, reach);
            let half = (kernel.len() / 2) as f64;
            assert!((kernel.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            // Gain at a frequency in parts of the new rate.
            let gain = |frequency: f64| -> f64 {
                let step = TAU * frequency / factor as f64;
                kernel.iter().enumerate().map(|(k, h)| h * (step * (k as f64 - half)).cos()).sum()
            };
            let pass = 0.5 - 2.87 / reach as f64;
            for i in 0..=50 {
                let share = f64::from(i) / 50.0;
                let (passed, stopped) = (gain(share * pass), gain(0.5 + share * 0.5 * (factor - 1) as f64));
                assert!((passed - 1.0).abs() < 5e-5, "{factor} {reach} {share}: {passed}");
                assert!(stopped.abs() < 5e-5, "{factor} {reach} {share}: {stopped}");
            }
        }
    }

    #[test]
    fn a_sine_in_the_passband_survives_up_and_down_to_1e_4() {
        let data = record(20.0, 100.0, 1000);
        for rate in [1000.0, 137.0, 60.0] {
            let new = data.resampled(rate).unwrap();
            assert_eq!(new.sample_rate_hz(), Some(rate));
            for (k, u) in new.u.iter().enumerate() {
                let t = k as f64 / rate;
                if (1.0..9.0).contains(&t) {
                    assert!((u - (TAU * 20.0 * t).sin()).abs() < 1e-4, "{rate} Hz, {t} s");
                }
            }
        }
    }

    #[test]
    fn what_the_new_rate_cannot_carry_is_removed_and_not_aliased() {
        let new = record(40.0, 100.0, 2000).resampled(50.0).unwrap();
        let middle = &new.u[100..900];
        assert!(
            middle.iter().all(|u| u.abs() < 1e-4),
            "{:?}",
            middle.iter().fold(0.0, |m: f64, u| m.max(u.abs()))
        );
        assert!(new.y[100..900].iter().all(|y| (y - 2.0).abs() < 1e-4));
    }

    #[test]
    fn the_same_rate_returns_the_same_samples_and_decimation_keeps_the_duration() {
        let data = record(5.0, 100.0, 501);
        assert!(data.resampled(100.0).unwrap() == data);
        let tenth = data.decimated(5).unwrap();
        assert_eq!((tenth.len(), tenth.sample_rate_hz()), (101, Some(20.0)));
        assert!(matches!(data.decimated(0), Err(RecordError::BadSetting { .. })));
        assert!(matches!(data.resampled(0.1), Err(RecordError::TooShort { .. })));
        assert!(matches!(data.resampled(f64::INFINITY), Err(RecordError::BadSampleRate { .. })));
        assert!(matches!(data.resampled(1e12), Err(RecordError::BadSetting { .. })));
    }

    #[test]
    fn non_uniform_samples_are_joined_by_lines() {
        let times = TimeBase::from_times("r", vec![0.0, 1.0, 1.0, 4.0]).unwrap();
        let mut data = InputOutput::new("r", times, vec![0.0, 2.0, 4.0, 10.0], vec![0.0; 4]).unwrap();
        data.valid = Some(vec![true, true, true, false]);
        let new = data.resampled(1.0).unwrap();
        assert_eq!(new.u[0], 0.0);
        assert!(new.u[2..].iter().zip([6.0, 8.0, 10.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{:?}", new.u);
        assert_eq!(new.valid, Some(vec![true, true, false, false, false]));
    }
}
