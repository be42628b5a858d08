//! Structural modes whose poles move with the level of the drive, and hysteresis in feedback with them.
//!
//! N inputs (actuators), M outputs (sensors), K modes; the state x holds Re q_k, Im q_k of the modes, then
//! one lag a_i per input (its amplifier). Time runs in [`ScheduledModes::steps`] steps per sample; u between
//! its samples as [`crate::record::InterSample`].
//!
//! ```text
//! S     = (level / reference)^exponent − 1          level: rms of the inputs about their means, a slow state
//! q_k⁺  = (p_k + S p'_k) q_k + b_k·u + h_k·w        complex, k = 1 … K
//! a_i⁺  = (α_i + S α'_i) a_i + β_i·u + h_i·w        real, i = 1 … N
//! y     = (C + S C') x + (D + S D') u + D_h w
//! w_i   = f(v_i) + f_i(σ_i)                             strains of actuator i
//! v_i, σ_i                                              rows of (x, u): its free stroke in V, and its stress
//! f(z)  = c₂ (z² − s²) + c₃ (z³ − 3 s² z) + Σ_j c_j (P_j[z] − γ_j z)
//! ```
//!
//! P_j are play operators (exact for any drive); f is shared by the actuators, f_i is
//! specific to each. There is no algebraic loop: v and σ are taken from the present state, w enters the next
//! one. s² and γ_j are frozen numbers that keep the terms of f nearly orthogonal to z; they do not change the
//! model class. Poles and output rows follow the level, input rows do not: their product would be quadratic
//! in S.
//!
//! The public steering-mirror data require a slow dependence on the level beside the fast hysteresis: neither
//! memoryless laws nor plays explain both the distortion within its records and the change between their
//! levels (`docs/theory/scheduled-modes.md`). Linear in amplitude is the Rayleigh law of ferroelectric
//! ceramics (D. A. Hall, *J. Mater. Sci.* 36 (2001) 4575, doi:10.1023/A:1017959111402).

mod bounded;
mod columns;
mod held;
mod held_simulation;
mod level;
mod simulate;
mod strain;
mod streaming;
mod trajectory;

pub use bounded::SquareWave;
pub use held::HeldModes;
pub use held_simulation::HeldSimulation;
pub use level::{LevelLaw, LevelTracker};
pub use simulate::simulate_steady;
#[doc(hidden)]
pub use strain::POWERS;
pub use strain::{FeedbackStrain, StrainLaw};
pub use streaming::Streaming;
pub use trajectory::Trajectory;

use crate::axes::AxesError;
use crate::record::RATES_HZ;
use hysteron_numeric::Complex64;
use serde::{Deserialize, Serialize};

/// Scheduled modes with the hysteresis of drive and stress in feedback. Matrices are stored row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct ScheduledModes {
    /// Number of inputs N.
    pub inputs: usize,
    /// Number of outputs M.
    pub outputs: usize,
    /// Number of modes K; there are 2K + N states.
    pub modes: usize,
    /// Sample rate of the signals \[Hz\].
    pub sample_rate_hz: f64,
    /// Steps from one sample to the next.
    pub steps: usize,
    /// Scheduling law: S as a function of the drive level.
    pub level: LevelLaw,
    /// Re p_k, Im p_k of every mode, then α_i: 2K + N numbers.
    pub transition: Vec<f64>,
    /// Their change with S.
    pub transition_slopes: Vec<f64>,
    /// Re b_k, Im b_k, β_i: rows of N \[1/V\].
    pub input: Vec<f64>,
    /// h: rows of N.
    pub strain_input: Vec<f64>,
    /// C: rows of 2K + N, one per output \[µm\].
    pub output: Vec<f64>,
    /// C', its change with S.
    pub output_slopes: Vec<f64>,
    /// D: rows of N, one per output \[µm/V\].
    pub feedthrough: Vec<f64>,
    /// D', its change with S.
    pub feedthrough_slopes: Vec<f64>,
    /// D_h: rows of N, one per output \[µm/V\].
    pub strain_feedthrough: Vec<f64>,
    /// The hysteresis; `None`: w = 0.
    pub feedback: Option<FeedbackStrain>,
}

/// Level-dependent coefficients at one S.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AtLevel {
    /// p + S p'.
    pub transition: Vec<f64>,
    /// C + S C'.
    pub output: Vec<f64>,
    /// D + S D'.
    pub feedthrough: Vec<f64>,
}

/// Frequency and damping of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mode {
    /// \|s\|/2π of its pole s \[Hz\].
    pub frequency_hz: f64,
    /// Damping ratio, −Re s/\|s\|.
    pub damping: f64,
}

/// Pole magnitude from which a pole counts as unstable.
#[doc(hidden)]
pub const LARGEST_POLE: f64 = 0.9999;

impl ScheduledModes {
    /// Number of states, 2K + N.
    pub fn states(&self) -> usize {
        2 * self.modes + self.inputs
    }

    /// Rate of the steps \[Hz\].
    pub fn step_rate_hz(&self) -> f64 {
        self.sample_rate_hz * self.steps as f64
    }

    /// Level-dependent coefficients at S.
    pub fn at(&self, s: f64) -> AtLevel {
        let mut at = AtLevel::default();
        self.set(s, &mut at);
        at
    }

    /// [`Self::at`] into an existing buffer; allocates nothing once that has its size.
    pub(super) fn set(&self, s: f64, at: &mut AtLevel) {
        let sum = |to: &mut Vec<f64>, base: &[f64], slopes: &[f64]| {
            to.clear();
            to.extend(base.iter().zip(slopes).map(|(b, d)| b + s * d));
        };
        sum(&mut at.transition, &self.transition, &self.transition_slopes);
        sum(&mut at.output, &self.output, &self.output_slopes);
        sum(&mut at.feedthrough, &self.feedthrough, &self.feedthrough_slopes);
    }

    /// The modes at S, in their order.
    pub fn modes_at(&self, s: f64) -> Vec<Mode> {
        let transition = self.at(s).transition;
        let pole = |p: &[f64]| Complex64::new(p[0], p[1]);
        transition
            .chunks_exact(2)
            .take(self.modes)
            .map(|p| {
                let log = pole(p).ln() * self.step_rate_hz();
                Mode {
                    frequency_hz: log.norm() / std::f64::consts::TAU,
                    damping: -log.re / log.norm().max(f64::MIN_POSITIVE),
                }
            })
            .collect()
    }

    /// Largest magnitude of a pole at S, and its number from 0 (lags after the modes).
    pub fn largest_pole(&self, s: f64) -> (f64, usize) {
        let at = self.at(s);
        let pairs = at.transition.chunks_exact(2).take(self.modes).map(|p| p[0].hypot(p[1]));
        let lags = at.transition.iter().skip(2 * self.modes).map(|a| a.abs());
        let worst = |(most, place), (k, magnitude): (usize, f64)| {
            // NaN counts as the largest.
            if magnitude > most || magnitude.is_nan() { (magnitude, k) } else { (most, place) }
        };
        pairs.chain(lags).enumerate().fold((0.0, 0), worst)
    }

    /// Steps in which the slowest state decays by e^(−folds) at S, at most a million.
    pub fn settling_steps(&self, s: f64, folds: f64) -> usize {
        const MOST: f64 = 1e6;
        let rate = -self.largest_pole(s).0.max(f64::MIN_POSITIVE).ln();
        if rate > folds / MOST { (folds / rate).ceil() as usize } else { MOST as usize }
    }

    /// Linear part of the response at e^(iωT), outputs × inputs row by row, at S.
    pub fn linear_response(&self, frequency_hz: f64, s: f64) -> Vec<Complex64> {
        let z = Complex64::from_polar(1.0, std::f64::consts::TAU * frequency_hz / self.step_rate_hz());
        self.transfer(z, &self.at(s))
    }

    /// Linear part of the response at z, one step of the simulation, outputs × inputs row by row.
    pub(crate) fn transfer(&self, z: Complex64, at: &AtLevel) -> Vec<Complex64> {
        let (n, states) = (self.inputs, self.states());
        let mut response: Vec<Complex64> = at.feedthrough.iter().map(|d| Complex64::new(*d, 0.0)).collect();
        for input in 0..n {
            let x = linear_states(&at.transition, self.modes, z, |k| {
                Complex64::new(self.input[k * n + input], 0.0)
            });
            for m in 0..self.outputs {
                let row = &at.output[m * states..(m + 1) * states];
                response[m * n + input] += row.iter().zip(&x).map(|(c, x)| x * *c).sum::<Complex64>();
            }
        }
        response
    }

    /// Checks lengths, finite numbers, ranges, and that every pole is stable over the levels the model holds
    /// for.
    ///
    /// # Errors
    /// The first of [`AxesError::Length`], [`AxesError::Value`], [`AxesError::Unstable`].
    pub fn validate(&self) -> Result<(), AxesError> {
        for (what, value, most, expected) in [
            ("inputs", self.inputs, 64, "a whole number from 1 to 64"),
            ("outputs", self.outputs, 64, "a whole number from 1 to 64"),
            ("modes", self.modes, 512, "a whole number from 1 to 512"),
            ("steps", self.steps, 64, "a whole number from 1 to 64"),
        ] {
            if value < 1 || value > most {
                return Err(AxesError::Value { what, value: value as f64, expected });
            }
        }
        if !RATES_HZ.contains(&self.sample_rate_hz) {
            return Err(AxesError::Value {
                what: "sample_rate_hz",
                value: self.sample_rate_hz,
                expected: "a rate from 1e-9 to 1e12 Hz",
            });
        }
        let (n, m, x) = (self.inputs, self.outputs, self.states());
        for (what, list, expected) in [
            ("transition", &self.transition, x),
            ("transition_slopes", &self.transition_slopes, x),
            ("input", &self.input, x * n),
            ("strain_input", &self.strain_input, x * n),
            ("output", &self.output, m * x),
            ("output_slopes", &self.output_slopes, m * x),
            ("feedthrough", &self.feedthrough, m * n),
            ("feedthrough_slopes", &self.feedthrough_slopes, m * n),
            ("strain_feedthrough", &self.strain_feedthrough, m * n),
        ] {
            finite_list(what, list, expected)?;
        }
        if let Some(feedback) = &self.feedback {
            feedback.validate(n, x).map_err(|e| e.within("feedback"))?;
        }
        self.level.validate()?;
        for level in [self.level.lowest, self.level.highest] {
            let (magnitude, mode) = self.largest_pole(self.level.state(level));
            if magnitude.is_nan() || magnitude >= 1.0 {
                return Err(AxesError::Unstable { mode: mode + 1, modes: self.modes, level, magnitude });
            }
        }
        Ok(())
    }
}

/// States under the input e^(iωT): (zI − A)⁻¹ b, b given by its row.
#[doc(hidden)]
pub fn linear_states(
    transition: &[f64],
    modes: usize,
    z: Complex64,
    b: impl Fn(usize) -> Complex64,
) -> Vec<Complex64> {
    let mut x = Vec::with_capacity(transition.len());
    for (k, p) in transition.chunks_exact(2).take(modes).enumerate() {
        let d = (z - p[0]) * (z - p[0]) + p[1] * p[1];
        let (b0, b1) = (b(2 * k), b(2 * k + 1));
        x.push(((z - p[0]) * b0 - b1 * p[1]) / d);
        x.push(((z - p[0]) * b1 + b0 * p[1]) / d);
    }
    for (k, a) in transition.iter().enumerate().skip(2 * modes) {
        x.push(b(k) / (z - *a));
    }
    x
}

/// The pole of a mode, e^(sT), s = 2πf(−ζ + i√(1 − ζ²)).
#[doc(hidden)]
pub fn pole(mode: Mode, step_rate_hz: f64) -> Complex64 {
    let Mode { frequency_hz, damping } = mode;
    let s = Complex64::new(-damping, (1.0 - damping * damping).max(0.0).sqrt());
    (s * (std::f64::consts::TAU * frequency_hz / step_rate_hz)).exp()
}

/// Frequency and damping of the pole e^(sT).
#[doc(hidden)]
pub fn frequency(pole: Complex64, step_rate_hz: f64) -> Mode {
    let s = pole.ln() * step_rate_hz;
    Mode { frequency_hz: s.norm() / std::f64::consts::TAU, damping: -s.re / s.norm().max(f64::MIN_POSITIVE) }
}

pub(super) fn finite_list(what: &'static str, list: &[f64], expected: usize) -> Result<(), AxesError> {
    if list.len() != expected {
        return Err(AxesError::Length { what, expected, found: list.len() });
    }
    match list.iter().find(|x| !x.is_finite()) {
        None => Ok(()),
        Some(&value) => Err(AxesError::Value { what, value, expected: "finite numbers" }),
    }
}

pub(super) fn positive(what: &'static str, value: f64) -> Result<(), AxesError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(AxesError::Value { what, value, expected: "a finite number above 0" })
}
