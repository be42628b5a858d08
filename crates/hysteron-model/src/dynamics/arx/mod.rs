//! ARX model: simulation, prediction, stability. Fitting is in [`fit`], choosing its orders in
//! [`select_orders`].

mod fit;
mod order;

pub use fit::{ArxFit, ArxOrders, ArxRecord, fit};
pub use order::{ArxCandidate, ArxSearch, OrderCriterion, select_orders};

use crate::start::{LinearStart, Start};
use std::f64::consts::TAU;

use super::DynamicsError;
use crate::dynamics_error::{check_finite, check_length, check_sample_rate};
use hysteron_numeric::Complex64;
use hysteron_numeric::fft::RealFft;

/// Linear autoregressive model with exogenous input, in the sampled domain:
///
/// y_k = −Σ_{i=1}^{na} a\[i−1\] y_{k−i} + Σ_{j=0}^{nb−1} b\[j\] v_{k−j}.
///
/// A delay of whole samples is leading zeros of b. Source: Ljung, System Identification (1999), §4.2. Its
/// parameters belong to the sample rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Arx {
    /// Autoregressive coefficients a₁ … a_na (the leading 1 is not stored).
    pub a: Vec<f64>,
    /// Input coefficients b₀ … b_(nb−1).
    pub b: Vec<f64>,
}

impl Arx {
    /// Checks the coefficients.
    ///
    /// # Errors
    /// [`DynamicsError::Coefficient`], [`DynamicsError::NoTerms`] if b is empty or all zero.
    pub fn validate(&self) -> Result<(), DynamicsError> {
        for (part, coefficients) in [("denominator", &self.a), ("numerator", &self.b)] {
            if let Some(index) = coefficients.iter().position(|x| !x.is_finite()) {
                return Err(DynamicsError::Coefficient { part, index, value: coefficients[index] });
            }
        }
        if self.b.iter().all(|b| *b == 0.0) {
            return Err(DynamicsError::NoTerms { part: "numerator" });
        }
        Ok(())
    }

    /// Gain at zero frequency, Σ b / (1 + Σ a); infinite where the denominator is 0.
    pub fn dc_gain(&self) -> f64 {
        self.b.iter().sum::<f64>() / (1.0 + self.a.iter().sum::<f64>())
    }

    /// Response at frequencies f \[Hz\]: B/A at z⁻¹ = e^(−2πi f / `sample_rate_hz`).
    ///
    /// # Errors
    /// [`DynamicsError::SampleRate`].
    pub fn frequency_response(
        &self,
        frequencies_hz: &[f64],
        sample_rate_hz: f64,
    ) -> Result<Vec<Complex64>, DynamicsError> {
        check_sample_rate(sample_rate_hz)?;
        let at = |&f: &f64| self.response_at(Complex64::from_polar(1.0, -TAU * f / sample_rate_hz));
        Ok(frequencies_hz.iter().map(at).collect())
    }

    /// B(q)/A(q) at a delay operator q = z⁻¹.
    pub(super) fn response_at(&self, q: Complex64) -> Complex64 {
        let horner = |coefficients: &[f64]| {
            coefficients.iter().rev().fold(Complex64::ZERO, |sum, &coefficient| sum * q + coefficient)
        };
        horner(&self.b) / (1.0 + q * horner(&self.a))
    }

    /// True if every pole lies inside the unit circle, by the Schur–Cohn recursion: all reflection
    /// coefficients of the denominator are below 1 (Jury 1964). No roots are computed.
    pub fn is_stable(&self) -> bool {
        let mut a = self.a.clone();
        while let Some(reflection) = a.pop() {
            if reflection.is_nan() || reflection.abs() >= 1.0 {
                return false;
            }
            let scale = 1.0 - reflection * reflection;
            let lower: Vec<f64> = a
                .iter()
                .zip(a.iter().rev())
                .map(|(x, mirrored)| (x - reflection * mirrored) / scale)
                .collect();
            a = lower;
        }
        true
    }

    /// Simulates over `input`: the model's own past output is fed back, no measured one. `Rest` starts from
    /// the steady state v = v(0), y = G(0) v(0), `Zero` from zeros, `Periodic` gives the steady state (by
    /// FFT). `Rest` and `Zero` allocate nothing.
    ///
    /// # Errors
    /// [`DynamicsError::Length`], [`DynamicsError::InputNotFinite`], what [`Arx::validate`] refuses,
    /// [`DynamicsError::InfiniteDcGain`] under `Rest` for an integrating model,
    /// [`DynamicsError::UnstableArx`] under `Periodic`, [`DynamicsError::OutputNotFinite`] where an unstable
    /// model overflows.
    pub fn simulate(
        &self,
        input: &[f64],
        initial: LinearStart,
        output: &mut [f64],
    ) -> Result<(), DynamicsError> {
        self.validate()?;
        check_length("output", output.len(), input.len())?;
        check_finite("input", input)?;
        let Some(&first) = input.first() else { return Ok(()) };
        let (v_before, y_before) = match initial {
            Start::ZERO => (0.0, 0.0),
            Start::AsIdentified => (first, self.dc_gain() * first),
            Start::Rest { voltage_v } => (voltage_v, self.dc_gain() * voltage_v),
            Start::Settled { period_samples: Some(period), .. } if period != input.len() => {
                return Err(DynamicsError::Length { what: "period", expected: input.len(), found: period });
            }
            Start::Settled { .. } => return self.steady_state(input, output),
            Start::Remembering { memory, .. } => match memory {},
        };
        if initial != Start::ZERO && !self.dc_gain().is_finite() {
            return Err(DynamicsError::InfiniteDcGain { numerator: 0.0, denominator: 1.0 });
        }
        for k in 0..input.len() {
            let forcing = past(&self.b, &input[..=k], v_before);
            let feedback = past(&self.a, &output[..k], y_before);
            output[k] = forcing - feedback;
        }
        if output.iter().all(|y| y.is_finite()) { Ok(()) } else { Err(DynamicsError::OutputNotFinite) }
    }

    /// One-step prediction: y_k from measured outputs up to k − 1 and the input, both constant before the
    /// first sample. Not a simulation: it looks good for any slow signal.
    ///
    /// # Errors
    /// [`DynamicsError::Length`], [`DynamicsError::InputNotFinite`], what [`Arx::validate`] refuses.
    pub fn predict(&self, input: &[f64], measured: &[f64]) -> Result<Vec<f64>, DynamicsError> {
        self.validate()?;
        check_length("measured output", measured.len(), input.len())?;
        check_finite("input", input)?;
        check_finite("measured output", measured)?;
        let (Some(&v), Some(&y)) = (input.first(), measured.first()) else { return Ok(Vec::new()) };
        Ok((0..input.len())
            .map(|k| past(&self.b, &input[..=k], v) - past(&self.a, &measured[..k], y))
            .collect())
    }

    fn steady_state(&self, input: &[f64], output: &mut [f64]) -> Result<(), DynamicsError> {
        if !self.is_stable() {
            return Err(DynamicsError::UnstableArx);
        }
        let fft = RealFft::new(input.len());
        let (mut time, mut spectrum) = (input.to_vec(), fft.forward.make_output_vec());
        fft.transform(&mut time, &mut spectrum);
        for (bin, x) in spectrum.iter_mut().enumerate() {
            let angle = TAU * bin as f64 / input.len() as f64;
            *x *= self.response_at(Complex64::from_polar(1.0, -angle)) / input.len() as f64;
        }
        // Real at zero and, for an even period, at the Nyquist frequency; rounding left traces.
        let last = spectrum.len() - 1;
        spectrum[0].im = 0.0;
        if input.len() == 2 * last {
            spectrum[last].im = 0.0;
        }
        fft.invert(&mut spectrum, output);
        Ok(())
    }
}

/// Σ_j coefficients\[j\] · signal\[last − j\], with `before` where the signal has not begun.
fn past(coefficients: &[f64], signal: &[f64], before: f64) -> f64 {
    let known: f64 = coefficients.iter().zip(signal.iter().rev()).map(|(c, x)| c * x).sum();
    let unknown: f64 = coefficients.get(signal.len()..).unwrap_or(&[]).iter().sum();
    if unknown == 0.0 { known } else { known + unknown * before }
}
