//! What can be asked for, checked.

use serde::{Deserialize, Serialize};

use super::{Excitation, ExcitationError, Shape, random, slow, sweep};

/// A drive waveform as asked for; see [`ExcitationSpec::generate`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Seed of whatever is random.
    #[serde(default)]
    pub seed: u64,
    /// The waveform proper.
    pub waveform: Waveform,
}

/// The waveform between lead-in and lead-out. Amplitudes are parts of the range `high_v − low_v`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Waveform {
    /// u = low + range·(1 − cos 2πft)/2: starts at `low_v` with zero slope.
    Sine {
        /// Frequency \[Hz\].
        frequency_hz: f64,
        /// Number of periods, not necessarily whole.
        periods: f64,
    },
    /// Slow loops of different amplitude, each starting and ending at `low_v`: u = low + a·range·(1 − cos 2πft)/2.
    NestedLoops {
        /// Frequency of every loop \[Hz\].
        frequency_hz: f64,
        /// Amplitudes in the order played, each above 0 and at most 1.
        amplitudes: Vec<f64>,
        /// Periods of each amplitude.
        periods_each: u32,
    },
    /// u = low + range·(1 − cos φ(t))/2 with instantaneous frequency φ'/2π going from `start_hz` to `end_hz`.
    Sweep {
        /// How the frequency goes.
        law: SweepLaw,
        /// Frequency at the start \[Hz\].
        start_hz: f64,
        /// Frequency at the end \[Hz\].
        end_hz: f64,
        /// Duration \[s\].
        duration_s: f64,
    },
    /// Gaussian noise with a flat spectrum between two frequencies and none outside, scaled to fill the range.
    Random {
        /// Lowest frequency \[Hz\].
        low_hz: f64,
        /// Highest frequency \[Hz\].
        high_hz: f64,
        /// Duration \[s\].
        duration_s: f64,
    },
}

/// How a sweep's frequency goes from f₀ to f₁ over T.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SweepLaw {
    /// f = f₀ + (f₁ − f₀) t/T.
    Linear,
    /// f = f₀ (f₁/f₀)^(t/T): equal time for every octave.
    #[default]
    Logarithmic,
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
    /// [`ExcitationError::Parameter`], [`ExcitationError::EmptyList`] or [`ExcitationError::TooLong`] naming what is wrong.
    pub fn validate(&self) -> Result<(), ExcitationError> {
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
            return Err(ExcitationError::TooLong {
                waveform: self.waveform.kind(),
                samples,
                max: MAX_SAMPLES,
            });
        }
        if samples < 1.0 {
            return Err(check.wrong(
                "sample_rate_hz",
                self.sample_rate_hz,
                "at least one sample in the duration".into(),
            ));
        }
        Ok(())
    }

    /// Makes the waveform.
    ///
    /// # Errors
    /// Those of [`ExcitationSpec::validate`].
    pub fn generate(&self) -> Result<Excitation, ExcitationError> {
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
            period_samples: shape.period_samples,
            excited_hz: shape.excited_hz,
            detection_hz: shape.detection_hz,
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

impl Waveform {
    /// Kind as written in a specification.
    pub fn kind(&self) -> &'static str {
        match self {
            Waveform::Sine { .. } => "sine",
            Waveform::NestedLoops { .. } => "nested_loops",
            Waveform::Sweep { .. } => "sweep",
            Waveform::Random { .. } => "random",
        }
    }

    /// Duration of the waveform proper \[s\].
    pub fn duration_s(&self) -> f64 {
        match self {
            Waveform::Sine { frequency_hz, periods } => periods / frequency_hz,
            Waveform::NestedLoops { frequency_hz, amplitudes, periods_each } => {
                amplitudes.len() as f64 * f64::from(*periods_each) / frequency_hz
            }
            Waveform::Sweep { duration_s, .. } | Waveform::Random { duration_s, .. } => *duration_s,
        }
    }

    fn describe(&self) -> String {
        match self {
            Waveform::Sine { frequency_hz, periods } => format!("sine {frequency_hz} Hz, {periods} periods"),
            Waveform::NestedLoops { frequency_hz, amplitudes, periods_each } => {
                format!(
                    "loops at {frequency_hz} Hz, {periods_each} periods each of amplitudes {amplitudes:?}"
                )
            }
            Waveform::Sweep { law, start_hz, end_hz, duration_s } => {
                let law = match law {
                    SweepLaw::Linear => "linear",
                    SweepLaw::Logarithmic => "logarithmic",
                };
                format!("{law} sweep {start_hz} Hz to {end_hz} Hz in {duration_s} s")
            }
            Waveform::Random { low_hz, high_hz, duration_s } => {
                format!("Gaussian noise {low_hz} Hz to {high_hz} Hz, {duration_s} s")
            }
        }
    }

    fn validate(&self, check: &Check, fs: f64) -> Result<(), ExcitationError> {
        match self {
            Waveform::Sine { frequency_hz, periods } => {
                check.below_nyquist("frequency_hz", *frequency_hz, fs)?;
                check.positive("periods", *periods)
            }
            Waveform::NestedLoops { frequency_hz, amplitudes, periods_each } => {
                check.below_nyquist("frequency_hz", *frequency_hz, fs)?;
                check.parts("amplitudes", amplitudes)?;
                check.at_least("periods_each", f64::from(*periods_each), 1.0)
            }
            Waveform::Sweep { start_hz, end_hz, duration_s, .. } => {
                check.below_nyquist("start_hz", *start_hz, fs)?;
                check.below_nyquist("end_hz", *end_hz, fs)?;
                check.positive("duration_s", *duration_s)
            }
            Waveform::Random { low_hz, high_hz, duration_s } => {
                check.positive("duration_s", *duration_s)?;
                check.not_negative("low_hz", *low_hz)?;
                check.below_nyquist("high_hz", *high_hz, fs)?;
                if high_hz <= low_hz {
                    return Err(check.wrong("high_hz", *high_hz, format!("above low_hz = {low_hz}")));
                }
                // The band must hold at least one line of the record's spectrum.
                check.lines_in_band(*low_hz, *high_hz, *duration_s)
            }
        }
    }

    fn shape(&self, fs: f64, seed: u64) -> Shape {
        match self {
            Waveform::Sine { frequency_hz, periods } => slow::sine(*frequency_hz, *periods, fs),
            Waveform::NestedLoops { frequency_hz, amplitudes, periods_each } => {
                slow::nested_loops(*frequency_hz, amplitudes, *periods_each, fs)
            }
            Waveform::Sweep { law, start_hz, end_hz, duration_s } => {
                sweep::sweep(*law, *start_hz, *end_hz, *duration_s, fs)
            }
            Waveform::Random { low_hz, high_hz, duration_s } => {
                random::band_limited(*low_hz, *high_hz, *duration_s, fs, seed)
            }
        }
    }
}

/// Checks of numbers, for one kind of waveform.
struct Check(&'static str);

impl Check {
    fn wrong(&self, parameter: &'static str, value: f64, expected: String) -> ExcitationError {
        ExcitationError::Parameter { waveform: self.0, parameter, value, expected }
    }

    fn finite(&self, parameter: &'static str, value: f64) -> Result<(), ExcitationError> {
        if value.is_finite() { Ok(()) } else { Err(self.wrong(parameter, value, "a finite number".into())) }
    }

    fn positive(&self, parameter: &'static str, value: f64) -> Result<(), ExcitationError> {
        if value.is_finite() && value > 0.0 {
            Ok(())
        } else {
            Err(self.wrong(parameter, value, "a finite number above 0".into()))
        }
    }

    fn not_negative(&self, parameter: &'static str, value: f64) -> Result<(), ExcitationError> {
        self.at_least(parameter, value, 0.0)
    }

    fn at_least(&self, parameter: &'static str, value: f64, least: f64) -> Result<(), ExcitationError> {
        if value.is_finite() && value >= least {
            Ok(())
        } else {
            Err(self.wrong(parameter, value, format!("a finite number, at least {least}")))
        }
    }

    fn below_nyquist(&self, parameter: &'static str, value: f64, fs: f64) -> Result<(), ExcitationError> {
        if value > 0.0 && value < 0.5 * fs {
            Ok(())
        } else {
            Err(self.wrong(
                parameter,
                value,
                format!("above 0 and below half the sample rate, {} Hz", 0.5 * fs),
            ))
        }
    }

    fn parts(&self, parameter: &'static str, values: &[f64]) -> Result<(), ExcitationError> {
        if values.is_empty() {
            return Err(ExcitationError::EmptyList { waveform: self.0, parameter });
        }
        match values.iter().find(|a| !(**a > 0.0 && **a <= 1.0)) {
            Some(&bad) => {
                Err(self.wrong(parameter, bad, "parts of the range, each above 0 and at most 1".into()))
            }
            None => Ok(()),
        }
    }

    fn lines_in_band(&self, low_hz: f64, high_hz: f64, duration_s: f64) -> Result<(), ExcitationError> {
        let first = (low_hz * duration_s).ceil().max(1.0);
        if (high_hz * duration_s).floor() < first {
            return Err(self.wrong(
                "duration_s",
                duration_s,
                format!("long enough for a spectral line between {low_hz} Hz and {high_hz} Hz"),
            ));
        }
        Ok(())
    }
}
