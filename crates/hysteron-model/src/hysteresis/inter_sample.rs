//! Inter-sample behaviour of the drive.
//!
//! Rate-independent hysteresis depends only on the sequence of turning points, so [`InterSample::Hold`] and
//! [`InterSample::Linear`] give the same values at the sampling instants; they differ for the dynamics.
//! [`InterSample::BandLimited`] matters as soon as a period has few samples, because the true turning points
//! then lie between them.

use realfft::RealFftPlanner;

use super::HysteresisError;
use crate::record::InterSample;

/// Extension of the drive beyond the ends of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RecordEnds {
    /// The record repeats: the sample after the last is the first.
    Periodic,
    /// The record ends; for band-limited interpolation its deviation from the line through its ends is
    /// continued by point reflection, which keeps value and slope continuous.
    Open,
}

impl InterSample {
    /// The drive on a time base finer by `factor`: sample `k * factor` is `u[k]`, the ones between follow the
    /// rule.
    ///
    /// N samples become N · factor ([`RecordEnds::Periodic`]: the last interval leads back to the first
    /// sample) or (N − 1) · factor + 1 ([`RecordEnds::Open`]).
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

/// Trigonometric interpolation of one period: the spectrum, padded with zeros; a component at the Nyquist
/// frequency becomes a cosine.
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

/// x̃ such that the polygon through it has the mean of x over every sample period: x̃_k = x_k + ½ (b_{k−1} +
/// b_k), where b_k = ⅔ (x_{k+½} − ½ (x_k + x_{k+1})) is by Simpson's rule the mean deviation of x from the
/// straight line from x_k to x_{k+1}. `fine` holds x on a time base twice as fine; one sample more or less at
/// its end does not matter.
///
/// Under a piecewise linear drive the output of a hysteresis operator is curved between samples. Linear
/// dynamics much slower than a sample period respond to its means, so x̃ is the signal to interpolate
/// linearly.
#[doc(hidden)]
pub fn polygon_of_means(fine: &[f64], out: &mut [f64]) {
    // ½ (b_{k−1} + b_k) from five neighbours; beyond the ends nothing is left out.
    let bulge = |from: f64, middle: f64, to: f64| middle - 0.5 * (from + to);
    let end = |k: usize| {
        let here = fine.get(2 * k).copied().unwrap_or(0.0);
        let beside = |middle: usize| match (fine.get(middle - 1), fine.get(middle), fine.get(middle + 1)) {
            (Some(from), Some(middle), Some(to)) => bulge(*from, *middle, *to),
            _ => 0.0,
        };
        let before = if k > 0 { beside(2 * k - 1) } else { 0.0 };
        here + (before + beside(2 * k + 1)) / 3.0
    };
    let inner = fine.windows(5).step_by(2);
    let inside = inner.len().min(out.len().saturating_sub(1));
    for (x, w) in out.iter_mut().skip(1).zip(inner) {
        *x = w[2] + (bulge(w[0], w[1], w[2]) + bulge(w[2], w[3], w[4])) / 3.0;
    }
    let count = out.len();
    for k in (0..count.min(1)).chain(inside + 1..count) {
        out[k] = end(k);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygon_has_the_means_of_a_parabola() {
        // x = t², means over [k, k + 1]: k² + k + 1/3. Simpson's rule is exact.
        let fine: Vec<f64> = (0..21).map(|j| (0.5 * f64::from(j)).powi(2)).collect();
        let mut out = [0.0; 11];
        polygon_of_means(&fine, &mut out);
        for (k, pair) in out.windows(2).enumerate().skip(1).take(8) {
            let t = k as f64;
            assert!((0.5 * (pair[0] + pair[1]) - (t * t + t + 1.0 / 3.0)).abs() < 1e-13);
        }
        // A straight line stays as it is.
        let fine: Vec<f64> = (0..21).map(|j| 0.5 * f64::from(j)).collect();
        polygon_of_means(&fine, &mut out);
        assert!(out.iter().enumerate().all(|(k, x)| (x - k as f64).abs() < 1e-15));
    }
}
