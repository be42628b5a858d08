//! Specification of an excitation, checked.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::Check;
use super::{Excitation, Waveform};
use crate::RigError;

/// Specification of a drive waveform; see [`ExcitationSpec::generate`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExcitationSpec {
    /// Name of the result; default: the kind of waveform.
    #[serde(default)]
    pub name: Option<String>,
    /// Sample rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Lowest voltage of the waveform \[V\].
    pub low_v: f64,
    /// Highest voltage of the waveform \[V\].
    pub high_v: f64,
    /// Duration \[s\] of a raised-cosine lead-in from 0 V to the first sample; 0: none.
    #[serde(default)]
    pub soft_start_s: f64,
    /// Duration \[s\] of a raised-cosine lead-out from the last sample to 0 V; 0: none.
    #[serde(default)]
    pub soft_end_s: f64,
    /// Seed of all random numbers.
    #[serde(default)]
    pub seed: u64,
    /// The waveform proper.
    pub waveform: Waveform,
}

/// Most samples of one waveform (800 MB).
const MAX_SAMPLES: usize = 100_000_000;

impl ExcitationSpec {
    /// A waveform without lead-in and lead-out, seed 0.
    pub fn new(sample_rate_hz: f64, low_v: f64, high_v: f64, waveform: Waveform) -> Self {
        ExcitationSpec {
            name: None,
            sample_rate_hz,
            low_v,
            high_v,
            soft_start_s: 0.0,
            soft_end_s: 0.0,
            seed: 0,
            waveform,
        }
    }

    /// Checks every number, the length included.
    ///
    /// # Errors
    /// [`RigError::Waveform`], [`RigError::EmptyWaveform`] or [`RigError::TooLong`] naming what is wrong.
    pub fn validate(&self) -> Result<(), RigError> {
        let check = Check(self.waveform.kind());
        check.positive("sample_rate_hz", self.sample_rate_hz)?;
        check.finite("low_v", self.low_v)?;
        if !(self.high_v.is_finite() && self.high_v > self.low_v) {
            return Err(check.wrong(
                "high_v",
                self.high_v,
                format!("a finite voltage above low_v = {}", self.low_v),
            ));
        }
        check.not_negative("soft_start_s", self.soft_start_s)?;
        check.not_negative("soft_end_s", self.soft_end_s)?;
        self.waveform.validate(&check, self.sample_rate_hz)?;
        let samples =
            (self.waveform.duration_s() + self.soft_start_s + self.soft_end_s) * self.sample_rate_hz;
        if samples.is_nan() || samples > MAX_SAMPLES as f64 {
            return Err(RigError::TooLong { waveform: self.waveform.kind(), samples, max: MAX_SAMPLES });
        }
        if samples < 1.0 {
            return Err(check.wrong("sample_rate_hz", self.sample_rate_hz, "high enough for one sample"));
        }
        Ok(())
    }

    /// Makes the waveform.
    ///
    /// # Errors
    /// Those of [`ExcitationSpec::validate`].
    pub fn generate(&self) -> Result<Excitation, RigError> {
        self.validate()?;
        let shape = self.waveform.shape(self.sample_rate_hz, self.seed);
        let range_v = self.high_v - self.low_v;
        let first_v = shape.values.first().map_or(0.0, |x| self.low_v + range_v * x);
        let last_v = shape.values.last().map_or(0.0, |x| self.low_v + range_v * x);
        let lead = |seconds: f64| (seconds * self.sample_rate_hz).round() as usize;
        let (lead_in_samples, lead_out_samples) = (lead(self.soft_start_s), lead(self.soft_end_s));
        let mut samples_v = Vec::with_capacity(lead_in_samples + shape.values.len() + lead_out_samples);
        let ramp = |k: usize, n: usize| 0.5 * (1.0 - (std::f64::consts::PI * k as f64 / n as f64).cos());
        samples_v.extend((0..lead_in_samples).map(|k| first_v * ramp(k, lead_in_samples)));
        samples_v
            .extend(shape.values.iter().map(|x| (self.low_v + range_v * x).clamp(self.low_v, self.high_v)));
        samples_v.extend((1..=lead_out_samples).map(|k| last_v * (1.0 - ramp(k, lead_out_samples))));
        Ok(Excitation {
            name: self.name.clone().unwrap_or_else(|| self.waveform.kind().to_owned()),
            description: self.describe(),
            samples_v,
            sample_rate_hz: self.sample_rate_hz,
            lead_in_samples,
            lead_out_samples,
            period_samples: shape.period_samples,
            excited_hz: shape.excited_hz,
            odd_detection_hz: shape.odd_detection_hz,
            even_detection_hz: shape.even_detection_hz,
        })
    }

    fn describe(&self) -> String {
        let mut text = format!(
            "{}, {} V to {} V, sampled at {} Hz",
            self.waveform.describe(),
            self.low_v,
            self.high_v,
            self.sample_rate_hz
        );
        if self.soft_start_s > 0.0 {
            text += &format!(", soft start {} s", self.soft_start_s);
        }
        if self.soft_end_s > 0.0 {
            text += &format!(", soft end {} s", self.soft_end_s);
        }
        text
    }
}
