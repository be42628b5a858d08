//! Pure delay: shifting a sampled signal by a fraction of a sample.
//!
//! The signal is interpolated between its samples by the [`InterSample`] rule and read τ earlier. The factor
//! e^(−τ δ(z)/h) is not used: its gain and phase are wrong near the Nyquist frequency
//! (`docs/theory/fractional.md`).

use std::f64::consts::PI;

use super::DynamicsError;
use crate::dynamics_error::{check_finite, check_length, check_sample_rate};
pub use crate::record::InterSample;
use hysteron_numeric::Complex64;
use hysteron_numeric::fft::{RealFft, fast_length};

/// `signal` delayed by `delay_s` ≥ 0 seconds: y(t) = x(t − τ), with x = `before` ahead of the first sample.
///
/// `BandLimited` turns the phase of the signal's FFT, continued at its end by reflection and fading; it is
/// exact for a signal that is band-limited and joins `before` smoothly.
///
/// # Errors
/// [`DynamicsError::Parameter`] for a delay that is negative or not finite, [`DynamicsError::SampleRate`],
/// [`DynamicsError::InputNotFinite`].
///
/// ```
/// # use hysteron_model::dynamics::delay::{delayed, InterSample};
/// let ramp = [0.0, 1.0, 2.0, 3.0];
/// assert_eq!(delayed(&ramp, 1.25, 1.0, InterSample::Linear, 0.0)?, [0.0, 0.0, 0.75, 1.75]);
/// # Ok::<(), hysteron_model::dynamics::DynamicsError>(())
/// ```
pub fn delayed(
    signal: &[f64],
    delay_s: f64,
    sample_rate_hz: f64,
    rule: InterSample,
    before: f64,
) -> Result<Vec<f64>, DynamicsError> {
    check_finite("signal", signal)?;
    let mut output = vec![0.0; signal.len()];
    match rule {
        InterSample::Hold => {
            let shift = shift(delay_s, sample_rate_hz)?.ceil();
            for (k, y) in output.iter_mut().enumerate() {
                *y = sample(signal, k as f64 - shift, before);
            }
        }
        InterSample::Linear => delay_linear(signal, delay_s, sample_rate_hz, before, &mut output)?,
        InterSample::BandLimited => turn_phase(signal, shift(delay_s, sample_rate_hz)?, before, &mut output),
    }
    Ok(output)
}

/// [`delayed`] by the `Linear` rule into an existing buffer. Allocates nothing.
///
/// # Errors
/// Those of [`delayed`], and [`DynamicsError::Length`]; samples are not checked.
pub fn delay_linear(
    signal: &[f64],
    delay_s: f64,
    sample_rate_hz: f64,
    before: f64,
    output: &mut [f64],
) -> Result<(), DynamicsError> {
    check_length("output", output.len(), signal.len())?;
    let shift = shift(delay_s, sample_rate_hz)?;
    output.copy_from_slice(signal);
    delay_in_place(output, shift, before);
    Ok(())
}

/// Delays `x` by `samples` ≥ 0 in place, linear between samples; `before` is the value one sample ahead. A
/// negative or NaN delay counts as 0.
#[doc(hidden)]
pub fn delay_in_place(x: &mut [f64], samples: f64, before: f64) {
    if samples.is_nan() || samples <= 0.0 {
        return;
    }
    let whole = samples.floor();
    let fraction = samples - whole;
    let skip = (whole as usize).min(x.len());
    // From the end, so that what is read has not been written yet.
    for k in (skip..x.len()).rev() {
        let earlier = x[k - skip];
        let still_earlier = if k > skip { x[k - skip - 1] } else { before };
        x[k] = earlier + fraction * (still_earlier - earlier);
    }
    x[..skip].fill(before);
}

/// Delay in samples.
pub(super) fn shift(delay_s: f64, sample_rate_hz: f64) -> Result<f64, DynamicsError> {
    check_sample_rate(sample_rate_hz)?;
    let shift = delay_s * sample_rate_hz;
    if shift.is_finite() && shift >= 0.0 {
        Ok(shift)
    } else {
        Err(DynamicsError::Parameter {
            name: "delay_s",
            value: delay_s,
            allowed: "a finite number of seconds ≥ 0",
        })
    }
}

fn sample(signal: &[f64], index: f64, before: f64) -> f64 {
    if index < 0.0 { before } else { signal.get(index as usize).copied().unwrap_or(before) }
}

fn turn_phase(signal: &[f64], shift: f64, before: f64, output: &mut [f64]) {
    let count = signal.len();
    let Some(&end) = signal.last() else { return };
    if shift >= count as f64 {
        return output.fill(before);
    }
    // The second half of the period is the fade to `before` and the quiet stretch ahead of the first sample,
    // long enough that the shifted fade does not reach it.
    let fade = count.max(64);
    let fft = RealFft::new(fast_length(count + fade + shift.ceil() as usize + fade));
    let mut time = vec![0.0; fft.len()];
    for (x, s) in time.iter_mut().zip(signal) {
        *x = s - before;
    }
    for j in 1..fade {
        let mirrored =
            2.0 * (end - before) - (sample(signal, count as f64 - 1.0 - j as f64, before) - before);
        time[count - 1 + j] = mirrored * (0.5 + 0.5 * (PI * j as f64 / fade as f64).cos());
    }
    let mut spectrum = fft.forward.make_output_vec();
    fft.transform(&mut time, &mut spectrum);
    let step = -std::f64::consts::TAU * shift / fft.len() as f64;
    let last = spectrum.len() - 1;
    for (bin, x) in spectrum.iter_mut().enumerate() {
        *x *= Complex64::from_polar(1.0 / fft.len() as f64, step * bin as f64);
    }
    // fast_length is even: the last bin is the Nyquist frequency, whose phase a real signal cannot carry.
    spectrum[last].im = 0.0;
    fft.invert(&mut spectrum, &mut time);
    for (y, x) in output.iter_mut().zip(&time) {
        *y = x + before;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hold_and_linear_read_the_signal_between_its_samples() {
        let x = [1.0, 3.0, -1.0, 5.0];
        let hold = delayed(&x, 0.0015, 1000.0, InterSample::Hold, 7.0).unwrap();
        assert_eq!(hold, [7.0, 7.0, 1.0, 3.0]);
        let linear = delayed(&x, 0.0015, 1000.0, InterSample::Linear, 7.0).unwrap();
        assert_eq!(linear, [7.0, 4.0, 2.0, 1.0]);
        for rule in [InterSample::Hold, InterSample::Linear] {
            assert_eq!(delayed(&x, 0.0, 1000.0, rule, 7.0).unwrap(), x);
            assert_eq!(delayed(&x, 1.0, 1000.0, rule, 7.0).unwrap(), [7.0; 4]);
        }
        assert!(delayed(&x, -1e-3, 1000.0, InterSample::Linear, 0.0).is_err());
        assert!(delayed(&x, f64::NAN, 1000.0, InterSample::Hold, 0.0).is_err());
        assert_eq!(delayed(&[], 1.0, 1.0, InterSample::BandLimited, 0.0).unwrap(), [0.0; 0]);
    }

    /// The record goes on past its end with its value and slope: only a bend is left there.
    #[test]
    fn band_limited_does_not_ring_where_a_record_ends_on_its_way() {
        let way = |t: f64| 2.0 + if t > 0.0 { 1.0 - (0.03 * t).cos() } else { 0.0 };
        let signal: Vec<f64> = (0..600).map(|k| way(k as f64)).collect();
        for shift in [0.37, 2.5] {
            let found = delayed(&signal, shift * 1e-3, 1000.0, InterSample::BandLimited, 2.0).unwrap();
            for (k, y) in found.iter().enumerate().skip(500) {
                let expected = way(k as f64 - shift);
                assert!((y - expected).abs() < 1e-3, "{shift} {k}: {y} {expected}");
            }
        }
    }

    #[test]
    fn band_limited_is_exact_for_a_smooth_pulse() {
        let pulse = |t: f64| 2.0 + (-((t - 300.0) / 12.0).powi(2)).exp() * (0.9 * t).sin();
        let signal: Vec<f64> = (0..600).map(|k| pulse(k as f64)).collect();
        for shift in [0.0, 0.37, 2.5, 41.25] {
            let found = delayed(&signal, shift * 1e-3, 1000.0, InterSample::BandLimited, 2.0).unwrap();
            for (k, y) in found.iter().enumerate() {
                let expected = pulse(k as f64 - shift);
                assert!((y - expected).abs() < 1e-12, "{shift} {k}: {y} {expected}");
            }
        }
    }
}
