//! Truth of the simulated bench: chosen by the user, or the default that lies outside the model class.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Play;

/// The whole bench: plant, drive electronics and sensor. Every field has a default; `{}` is the default
/// bench.
///
/// ```text
/// command u ─► DAC ─► plant (amplifier ─► hysteresis ─► dynamics ─► delay)
///           ─► sensor (offset, drift, noise, ADC) ─► record
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Truth {
    /// The actuator with its mechanics.
    pub plant: Plant,
    /// Interpolation of the drive between two samples of the command.
    pub dac: Dac,
    /// The displacement sensor and its converter.
    pub sensor: Sensor,
    /// Steps of the computation in one sample period, ≥ 20.
    pub oversampling: u32,
}

/// The true plant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Plant {
    /// Amplifier lag, asymmetric plays, two modes, creep, delay: outside every model class this library
    /// identifies.
    PlayStack(PlayStack),
    /// Bouc–Wen hysteresis, fractional transfer function, delay: the article's class, to test recovery.
    BoucWenFractional(BoucWenFractional),
}

/// v = s + quadratic·s² + cubic·s³, s = linear·u + Σ plays, then
///
/// G(s) = (1 + k (s + ω_c)^−μ) · Σ_i share_i ω_i²/(s² + 2 ζ_i ω_i s + ω_i²) · e^(−τ s), Σ share = 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PlayStack {
    /// Corner of the amplifier's first-order lag \[Hz\]; `null`: ideal amplifier.
    pub amplifier_corner_hz: Option<f64>,
    /// Reversible part \[µm/V\].
    pub linear_um_per_v: f64,
    /// Irreversible part.
    pub plays: Vec<Play>,
    /// Coefficient of s² in the polynomial \[1/µm\].
    pub quadratic_per_um: f64,
    /// Coefficient of s³ in the polynomial \[1/µm²\].
    pub cubic_per_um2: f64,
    /// Vibration modes; shares are scaled to the sum 1.
    pub modes: Vec<Mode>,
    /// Creep; `null`: none.
    pub creep: Option<Creep>,
    /// Pure delay \[s\], any fraction of a sample.
    pub delay_s: f64,
}

/// One second-order mode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mode {
    /// Natural frequency \[Hz\].
    pub frequency_hz: f64,
    /// Damping ratio, between 0 and 1.
    pub damping: f64,
    /// Share of the static compliance, before scaling to the sum 1.
    pub share: f64,
}

/// Creep factor 1 + strength · (s + 2π corner)^−order: fractional above the corner, finite at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Creep {
    /// Strength k \[(rad/s)^order\].
    pub strength: f64,
    /// Order μ, between 0 and 1.
    pub order: f64,
    /// Corner \[Hz\]; 0: unbounded creep (then the drive must start at 0 V).
    pub corner_hz: f64,
}

/// v of article Eq. 1 (z = 0 at 0 V), then G of Eq. 6, then a delay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoucWenFractional {
    /// Coefficients of u, u², … \[µm/V, µm/V², …\].
    pub polynomial: Vec<f64>,
    /// α \[µm/V\].
    pub alpha: f64,
    /// β \[µm^(1−n)/V\].
    pub beta: f64,
    /// γ \[µm^(1−n)/V\].
    pub gamma: f64,
    /// n ≥ 1.
    #[serde(default = "one")]
    pub n: f64,
    /// Numerator terms.
    #[serde(default = "unity")]
    pub numerator: Vec<PowerTerm>,
    /// Denominator terms.
    #[serde(default = "unity")]
    pub denominator: Vec<PowerTerm>,
    /// Pure delay \[s\], any fraction of a sample.
    #[serde(default)]
    pub delay_s: f64,
}

/// `coefficient · s^order`, s in rad/s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PowerTerm {
    /// Coefficient.
    pub coefficient: f64,
    /// Real order ≥ 0.
    pub order: f64,
}

/// Interpolation of the drive between two samples of the command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Dac {
    /// Straight line from sample to sample: a generator that updates much faster than the recorder samples.
    #[default]
    Linear,
    /// Each sample held for one period: generator and recorder share one clock. Adds half a sample of delay.
    Hold,
}

/// The displacement sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Sensor {
    /// Standard deviation of white noise \[µm\].
    pub noise_um: f64,
    /// Reading at zero displacement \[µm\].
    pub offset_um: f64,
    /// Steady drift \[µm/s\].
    pub drift_um_per_s: f64,
    /// Random walk: standard deviation after one second \[µm/√s\].
    pub random_walk_um_per_sqrt_s: f64,
    /// Analogue-to-digital converter; `null`: none.
    pub adc: Option<Adc>,
}

/// Analogue-to-digital converter: 2^bits equal steps over the range, clipping at its ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Adc {
    /// Resolution, 1 to 32 bits.
    pub bits: u32,
    /// Displacement at the lowest code \[µm\].
    pub low_um: f64,
    /// Displacement one step above the highest code \[µm\].
    pub high_um: f64,
}

impl Adc {
    /// Smallest step (high − low)/2^bits \[µm\].
    pub fn step_um(&self) -> f64 {
        (self.high_um - self.low_um) / 2f64.powi(self.bits as i32)
    }
}

fn one() -> f64 {
    1.0
}

fn unity() -> Vec<PowerTerm> {
    vec![PowerTerm { coefficient: 1.0, order: 0.0 }]
}

impl Default for Truth {
    fn default() -> Self {
        Truth {
            plant: Plant::PlayStack(PlayStack::default()),
            dac: Dac::default(),
            sensor: Sensor::default(),
            oversampling: 20,
        }
    }
}

/// 5 nm noise, 16 bits over −10 … 50 µm (0.92 nm a step).
impl Default for Sensor {
    fn default() -> Self {
        Sensor {
            noise_um: 0.005,
            offset_um: 0.0,
            drift_um_per_s: 0.0,
            random_walk_um_per_sqrt_s: 0.0,
            adc: Some(Adc { bits: 16, low_um: -10.0, high_um: 50.0 }),
        }
    }
}

/// A stage like the article's: 0–10 V command, about 30 µm, loop opening near 15 % at 1 Hz.
impl Default for PlayStack {
    fn default() -> Self {
        let count = 40;
        let plays = (0..count)
            .map(|i| {
                // Half-widths spread over 0–5 V, with smaller weights for wide loops.
                let r = 5.0 * (f64::from(i) + 0.5) / f64::from(count);
                Play { rising_v: 1.1 * r, falling_v: 0.9 * r, weight_um_per_v: 0.063 * (-r / 4.0).exp() }
            })
            .collect();
        PlayStack {
            amplifier_corner_hz: Some(2000.0),
            linear_um_per_v: 1.72,
            plays,
            quadratic_per_um: 4e-3,
            cubic_per_um2: -6e-5,
            modes: vec![
                Mode { frequency_hz: 475.0, damping: 0.03, share: 0.93 },
                Mode { frequency_hz: 1100.0, damping: 0.02, share: 0.07 },
            ],
            creep: Some(Creep { strength: 0.08, order: 0.15, corner_hz: 1e-3 }),
            delay_s: 1.23e-4,
        }
    }
}

impl Truth {
    /// The article's own numbers as the truth: Table 2 (n not printed: 1) and Eq. 13, no delay.
    pub fn article() -> Self {
        let term = |coefficient, order| PowerTerm { coefficient, order };
        Truth {
            plant: Plant::BoucWenFractional(BoucWenFractional {
                polynomial: vec![2.0, 0.0031],
                alpha: -1.2039,
                beta: 0.1111,
                gamma: 0.0024,
                n: 1.0,
                numerator: vec![term(5.2589e6, 0.0)],
                denominator: vec![term(5.4955e6, 0.0), term(3081.0, 1.0523), term(1.0, 2.0384)],
                delay_s: 0.0,
            }),
            ..Truth::default()
        }
    }

    /// This bench with an ideal sensor: no noise, drift, offset or converter.
    pub fn with_ideal_sensor(mut self) -> Self {
        self.sensor = Sensor {
            noise_um: 0.0,
            offset_um: 0.0,
            drift_um_per_s: 0.0,
            random_walk_um_per_sqrt_s: 0.0,
            adc: None,
        };
        self
    }

    /// Pure delay of the plant \[s\].
    pub fn delay_s(&self) -> f64 {
        match &self.plant {
            Plant::PlayStack(p) => p.delay_s,
            Plant::BoucWenFractional(p) => p.delay_s,
        }
    }

    /// One-line description of the true plant.
    pub fn describe(&self) -> String {
        match &self.plant {
            Plant::PlayStack(p) => format!(
                "{} asymmetric plays, {} modes{}{}, delay {} s",
                p.plays.len(),
                p.modes.len(),
                if p.creep.is_some() { ", fractional creep" } else { "" },
                p.amplifier_corner_hz.map_or(String::new(), |f| format!(", amplifier lag {f} Hz")),
                p.delay_s
            ),
            Plant::BoucWenFractional(p) => {
                format!(
                    "Bouc–Wen hysteresis (n = {}), fractional transfer function, delay {} s",
                    p.n, p.delay_s
                )
            }
        }
    }
}
