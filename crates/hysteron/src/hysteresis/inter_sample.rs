//! How the drive goes from one sample to the next.
//!
//! Hysteresis sees nothing but the sequence of turning points, so at the sampling instants [`InterSample::Hold`] and
//! [`InterSample::Linear`] give it the same values; they differ for what follows it. [`InterSample::BandLimited`] matters
//! as soon as a period has few samples, because the true turning points then lie between them.

use realfft::RealFftPlanner;

use super::HysteresisError;
use crate::record::InterSample;

/// What the drive is taken to do beyond the ends of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RecordEnds {
    /// The record repeats: the sample after the last is the first.
    Periodic,
    /// The record ends; for band-limited interpolation its deviation from the line through its ends is continued by
    /// point reflection, which keeps value and slope continuous.
    Open,
}

impl InterSample {
    /// The drive on a time base finer by `factor`: sample `k * factor` is `u[k]`, the ones between follow the rule.
    ///
    /// N samples become N · factor ([`RecordEnds::Periodic`]: the last interval leads back to the first sample) or
    /// (N − 1) · factor + 1 ([`RecordEnds::Open`]).
    ///
    /// # Errors
    /// [`HysteresisError::Factor`] for factor 0, [`HysteresisError::Fourier`] where the transform fails.
    pub fn upsample(self, u: &[f64], factor: usize, ends: RecordEnds) -> Result<Vec<f64>, HysteresisError> {
        if factor == 0 {
            return Err(HysteresisError::Factor);
        }
        let (Some(&first), Some(&last)) = (u.first(), u.last()) else { return Ok(Vec::new()) };
        if factor == 1 {
            return Ok(u.to_vec());
        }
        if self == Self::BandLimited && u.len() > 1 {
            return match ends {
                RecordEnds::Periodic => trigonometric(u, factor),
                RecordEnds::Open => {
                    let intervals = (u.len() - 1) as f64;
                    let line = |k: usize, per_interval: f64| {
                        first + (last - first) * (k as f64 / (intervals * per_interval))
                    };
                    let deviation: Vec<f64> = u.iter().enumerate().map(|(k, u)| u - line(k, 1.0)).collect();
                    let mirrored = deviation.iter().skip(1).rev().skip(1).map(|d| -d);
                    let period: Vec<f64> = deviation.iter().copied().chain(mirrored).collect();
                    let mut fine = trigonometric(&period, factor)?;
                    fine.truncate((u.len() - 1) * factor + 1);
                    for (k, f) in fine.iter_mut().enumerate() {
                        *f += line(k, factor as f64);
                    }
                    Ok(fine)
                }
            };
        }
        let mut fine = Vec::with_capacity(u.len() * factor);
        let next = u.iter().skip(1).chain(match ends {
            RecordEnds::Periodic => Some(&first),
            RecordEnds::Open => None,
        });
        for (&from, &to) in u.iter().zip(next) {
            for j in 0..factor {
                let share = if self == Self::Hold { 0.0 } else { j as f64 / factor as f64 };
                fine.push(from + (to - from) * share);
            }
        }
        if ends == RecordEnds::Open {
            fine.push(last);
        }
        Ok(fine)
    }
}

/// Trigonometric interpolation of one period: the spectrum, padded with zeros; a component at the Nyquist frequency
/// becomes a cosine.
fn trigonometric(u: &[f64], factor: usize) -> Result<Vec<f64>, HysteresisError> {
    let samples = u.len();
    let failed = |e: realfft::FftError| HysteresisError::Fourier { samples, message: e.to_string() };
    let mut planner = RealFftPlanner::<f64>::new();
    let forward = planner.plan_fft_forward(samples);
    let inverse = planner.plan_fft_inverse(samples * factor);
    let mut time = u.to_vec();
    let mut coarse = forward.make_output_vec();
    forward.process(&mut time, &mut coarse).map_err(failed)?;
    let mut spectrum = inverse.make_input_vec();
    for (s, c) in spectrum.iter_mut().zip(&coarse) {
        *s = c / samples as f64;
    }
    if samples.is_multiple_of(2)
        && let Some(nyquist) = spectrum.get_mut(samples / 2)
    {
        *nyquist *= 0.5;
    }
    let mut fine = inverse.make_output_vec();
    inverse.process(&mut spectrum, &mut fine).map_err(failed)?;
    Ok(fine)
}
