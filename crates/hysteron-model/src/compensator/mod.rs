//! The inverse of a model, sample by sample: for a reference that is known a few samples ahead, or not at
//! all.
//!
//! [`crate::invert`] knows the whole reference; a controller knows it up to now, or for a short preview. The
//! output v of the hysteresis is computed, sample by sample, to minimise
//!
//! Σ (r − y)² + λ Σ (Δ²v)²
//!
//! over an infinite horizon, y the response of the dynamics to held samples of v: a linear-quadratic
//! regulator with preview (M. Tomizuka, *J. Dyn. Syst. Meas. Control* 97 (1975) 172–179,
//! doi:10.1115/1.3426902) on the realised dynamics ([`crate::realise`]). With enough preview it is the
//! inverse of [`crate::invert`]; the unknown part of the reference is predicted ([`Prediction`]), and the
//! prediction is folded into the gains. The hysteresis is inverted exactly, one step at a time, by
//! `hysteron-rt`, which runs the compensator: [`hysteron_rt::Compensator`].

mod controller;
mod parts;
mod prediction;
pub(crate) mod riccati;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector, RowDVector};

pub use controller::{Controller, Limits};
pub use parts::CompensatorParts;
pub use prediction::Prediction;

use crate::hammerstein::Model;
use crate::invert::{BANDWIDTH_SHARE, ERROR_AT_BANDWIDTH, InversionError};
use crate::realise::{LinearRealisation, RealiseOptions, held};
use hysteron_numeric::Complex64;
use riccati::{StateSpace, regulator};

/// Largest reach of the gains on the reference, delay excluded, and largest number of predicted samples.
const MOST_AHEAD: usize = 4096;
/// Share of the largest gain below which a gain on the reference is negligible; [`IN_A_ROW`] of them in
/// succession end the preview.
const NEGLIGIBLE: f64 = 1e-10;
const IN_A_ROW: usize = 32;
/// Default preview: leaves at most this share of the sum of the gains on the reference to prediction.
const LEFT_TO_PREDICTION: f64 = 1e-4;
/// Frequencies over which the noise is integrated.
const ANGLES: usize = 4096;
/// Lowest frequency of the search for an error, as a share of half the sample rate.
const LOWEST_SHARE: f64 = 1e-6;

/// Options of a compensator: bandwidth, preview and prediction of the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CompensatorOptions {
    /// Tracking bandwidth \[Hz\]; `None`: [`BANDWIDTH_SHARE`] of the sample rate.
    pub bandwidth_hz: Option<f64>,
    /// Relative error there if the whole reference were known.
    pub error_at_bandwidth: f64,
    /// Preview of the reference in samples; 0: the present one only. `None`: as many as are useful.
    pub preview: Option<usize>,
    /// Prediction of the reference beyond the preview.
    pub prediction: Prediction,
    /// Accuracy of the dynamics, and the lowest frequency of creep.
    pub realise: RealiseOptions,
}

impl Default for CompensatorOptions {
    fn default() -> Self {
        Self {
            bandwidth_hz: None,
            error_at_bandwidth: ERROR_AT_BANDWIDTH,
            preview: None,
            prediction: Prediction::Stays,
            realise: RealiseOptions::default(),
        }
    }
}

/// The linear law of a compensator at one sample rate; see [`hysteron_rt::Law`].
#[derive(Clone, Debug, PartialEq)]
pub struct Compensation {
    /// The model.
    pub model: Model,
    /// Its dynamics under a zero-order hold, delay included.
    pub dynamics: LinearRealisation,
    /// Gains on v₂ − v₁, v₃ − v₁, …
    pub recent: Vec<f64>,
    /// Gains on the states, per section: real (counted from v₁) and imaginary part.
    pub states: Vec<[f64; 2]>,
    /// Gains on the reference, the newest first.
    pub reference: Vec<f64>,
    /// Preview: samples by which the newest reference is ahead.
    pub preview: usize,
    /// Longest useful preview in samples.
    pub useful_preview: usize,
    /// True if more would be of use, but the gains on the reference end there.
    pub preview_is_cut: bool,
    /// The rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Tracking bandwidth \[Hz\]; infinite for a static model.
    pub bandwidth_hz: f64,
    /// Gain from white noise on the reference to noise on the hysteresis output, both rms.
    pub noise_gain: f64,
    /// Largest gain from the reference to the output of the hysteresis.
    pub peak: f64,
}

impl Compensation {
    /// The law for a model at a controller's rate.
    ///
    /// # Errors
    /// [`InversionError`].
    pub fn new(
        model: &Model,
        sample_rate_hz: f64,
        options: &CompensatorOptions,
    ) -> Result<Self, InversionError> {
        options.check(sample_rate_hz)?;
        let dynamics = held(model, sample_rate_hz, &options.realise)?;
        let plant = plant(&dynamics);
        let gain = dynamics.held_gain();
        if gain.abs() <= 1e-6 * dynamics.reference_gain {
            return Err(InversionError::NoGain);
        }
        let own_bandwidth = options.bandwidth_hz.unwrap_or(BANDWIDTH_SHARE * sample_rate_hz);
        let is_static = dynamics.sections.is_empty() && dynamics.taps.len() == 1;
        let (weight, bandwidth_hz) = if is_static {
            (0.0, f64::INFINITY)
        } else {
            let passed = dynamics.response(own_bandwidth, sample_rate_hz).norm_sqr();
            let roughness = (2.0 * (PI * own_bandwidth / sample_rate_hz).sin()).powi(4);
            let error = options.error_at_bandwidth;
            (error / (1.0 - error) * passed / roughness, own_bandwidth)
        };
        let gains = feedback(&plant, weight).ok_or(InversionError::NoRegulator)?;
        let states = dynamics.sections.len();
        let mut kept = gains.gains.iter().map(|k| -k);
        let mut section_gains = Vec::with_capacity(states);
        for section in &dynamics.sections {
            let re = kept.next().unwrap_or(0.0);
            section_gains.push([re, if section.is_pair() { kept.next().unwrap_or(0.0) } else { 0.0 }]);
        }
        let on_inputs: Vec<f64> = kept.collect();
        // At a constant displacement all states and inputs equal v (imaginary parts 0): the total gain on v.
        let held: f64 = section_gains.iter().map(|[re, _]| re).sum::<f64>() + on_inputs.iter().sum::<f64>();
        let ahead = ahead(&plant, &gains, (1.0 - held) / gain);
        let late = dynamics.delay_samples;
        let useful_preview = late + useful(&ahead);
        let preview = options.preview.unwrap_or(useful_preview).min(late + ahead.len() - 1);
        let reference = known(&ahead, late, preview, options.prediction, sample_rate_hz)?;
        let mut found = Self {
            model: model.clone(),
            dynamics,
            recent: on_inputs.into_iter().skip(1).collect(),
            states: section_gains,
            reference,
            preview,
            useful_preview,
            preview_is_cut: ahead.len() == MOST_AHEAD && useful_preview + 1 == late + MOST_AHEAD,
            sample_rate_hz,
            bandwidth_hz,
            noise_gain: 0.0,
            peak: 0.0,
        };
        let angle = |k: usize| PI * (k as f64 + 0.5) / ANGLES as f64;
        let (mut sum, mut largest) = (0.0, 0.0_f64);
        for k in 0..ANGLES {
            let square = found.response(angle(k) / TAU * sample_rate_hz).norm_sqr();
            sum += square;
            largest = largest.max(square);
        }
        (found.noise_gain, found.peak) = ((sum / ANGLES as f64).sqrt(), largest.sqrt());
        Ok(found)
    }

    /// W: from the reference r(t) to the output v of the hysteresis at a frequency \[Hz\].
    pub fn response(&self, frequency_hz: f64) -> Complex64 {
        let theta = TAU * frequency_hz / self.sample_rate_hz;
        let back = |samples: usize| Complex64::from_polar(1.0, -theta * samples as f64);
        let forward: Complex64 = self.reference.iter().enumerate().map(|(j, gain)| *gain * back(j)).sum();
        forward * back(self.preview).conj() / self.without_feedback(frequency_hz)
    }

    /// Response of the stage to a displacement added to the whole reference at once, as
    /// [`hysteron_rt::Compensator::step_against`] subtracts a disturbance: the path of a feedback correction.
    pub fn correction(&self, frequency_hz: f64) -> Complex64 {
        let all: f64 = self.reference.iter().sum();
        let dynamics = self.dynamics.response(frequency_hz, self.sample_rate_hz);
        all * dynamics / self.without_feedback(frequency_hz)
    }

    /// 1 − the feedback of v through the states and its past values.
    fn without_feedback(&self, frequency_hz: f64) -> Complex64 {
        let theta = TAU * frequency_hz / self.sample_rate_hz;
        let back = |samples: usize| Complex64::from_polar(1.0, -theta * samples as f64);
        let last = back(1);
        let mut fed_back = last;
        for (l, gain) in self.recent.iter().enumerate() {
            fed_back += *gain * (back(l + 2) - last);
        }
        let behind = back(self.dynamics.taps.len() + 1);
        for (section, [re, im]) in self.dynamics.sections.iter().zip(&self.states) {
            let state = |g: Complex64| g * behind / (1.0 - (1.0 - g) * last);
            let (own, other) = (state(section.gain), state(section.gain.conj()));
            fed_back += *re * (0.5 * (own + other) - last) + *im * (-0.5 * Complex64::I * (own - other));
        }
        let sum: f64 = self.reference.iter().sum();
        fed_back -= sum * self.dynamics.held_gain() * last;
        1.0 - fed_back
    }

    /// Response from the reference to the displacement at a frequency \[Hz\]; 1 is ideal.
    pub fn tracking(&self, frequency_hz: f64) -> Complex64 {
        self.response(frequency_hz) * self.dynamics.response(frequency_hz, self.sample_rate_hz)
    }

    /// Frequency \[Hz\] up to which the relative error of a sine is at most `error`, delay included.
    pub fn follows_to(&self, error: f64) -> f64 {
        let half = 0.5 * self.sample_rate_hz;
        let missed = |f: &f64| (1.0 - self.tracking(*f)).norm() > error;
        let at = |k: usize| half * LOWEST_SHARE.powf(1.0 - k as f64 / ANGLES as f64);
        (0..ANGLES).map(at).find(missed).unwrap_or(half)
    }
}

impl CompensatorOptions {
    fn check(&self, sample_rate_hz: f64) -> Result<(), InversionError> {
        let refuse = |name, value, allowed| Err(InversionError::Option { name, value, allowed });
        if !(sample_rate_hz.is_finite() && sample_rate_hz > 0.0) {
            return refuse("sample rate [Hz]", sample_rate_hz, "positive and finite");
        }
        let half = |f: f64| f > 0.0 && f < 0.5 * sample_rate_hz;
        if let Some(value) = self.bandwidth_hz.filter(|f| !half(*f)) {
            return refuse("bandwidth [Hz]", value, "positive and below half the sample rate");
        }
        let error = self.error_at_bandwidth;
        if !(error > 0.0 && error < 1.0) {
            return refuse("error at the bandwidth", error, "between 0 and 1");
        }
        if let Prediction::Band { highest_hz, noise } = self.prediction {
            if !half(highest_hz) {
                return refuse(
                    "highest frequency of the reference [Hz]",
                    highest_hz,
                    "positive and below half the sample rate",
                );
            }
            if !(noise > 0.0 && noise < 1.0) {
                return refuse("noise of the reference", noise, "between 0 and 1");
            }
        }
        Ok(())
    }
}

/// State-space form of the dynamics without their delay: sections (real part, then imaginary), then v₁, v₂,
/// ….
fn plant(dynamics: &LinearRealisation) -> StateSpace {
    let taps = dynamics.taps.len();
    let sections = dynamics.states();
    let inputs = taps.max(2);
    let n = sections + inputs;
    let mut a = DMatrix::zeros(n, n);
    let mut c = RowDVector::zeros(n);
    let drive = sections + taps - 1;
    let mut at = 0;
    for section in &dynamics.sections {
        let (g, weight) = (section.gain, section.weight);
        if section.is_pair() {
            let keep = 1.0 - g;
            for (row, [on_re, on_im, on_drive]) in
                [[keep.re, -keep.im, g.re], [keep.im, keep.re, g.im]].into_iter().enumerate()
            {
                a[(at + row, at)] = on_re;
                a[(at + row, at + 1)] = on_im;
                a[(at + row, drive)] = on_drive;
            }
            for column in [at, at + 1, drive] {
                c[column] += weight.re * a[(at, column)] - weight.im * a[(at + 1, column)];
            }
            at += 2;
        } else {
            a[(at, at)] = 1.0 - g.re;
            a[(at, drive)] = g.re;
            for column in [at, drive] {
                c[column] += weight.re * a[(at, column)];
            }
            at += 1;
        }
    }
    for (j, tap) in dynamics.taps.iter().enumerate().skip(1) {
        c[sections + j - 1] += tap;
    }
    for row in 1..inputs {
        a[(sections + row, sections + row - 1)] = 1.0;
    }
    let mut b = DVector::zeros(n);
    b[sections] = 1.0;
    StateSpace { a, b, c, d: dynamics.taps.first().copied().unwrap_or(0.0) }
}

/// The regulator of (r − y)² + λ (Δ²v)².
fn feedback(plant: &StateSpace, weight: f64) -> Option<riccati::Regulator> {
    let n = plant.b.len();
    let newest = plant.b.iter().position(|b| *b != 0.0)?;
    let mut second = RowDVector::<f64>::zeros(n);
    second[newest] = 2.0;
    second[newest + 1] = -1.0;
    let q = plant.c.transpose() * &plant.c + weight * second.transpose() * &second;
    let s = plant.d * plant.c.transpose() - weight * second.transpose();
    regulator(plant, &q, &s, plant.d * plant.d + weight)
}

/// Gains on the reference from the present sample (the first that v affects) on: f₀ = d/w, fⱼ = bᵀ(A −
/// bK)ᵀʲ⁻¹(c − dK)ᵀ/w. They sum to `sum`, which holds a constant displacement: the truncated tail is added to
/// the last.
fn ahead(plant: &StateSpace, found: &riccati::Regulator, sum: f64) -> Vec<f64> {
    let closed = (&plant.a - &plant.b * &found.gains).transpose();
    let mut q = (&plant.c - plant.d * &found.gains).transpose();
    let mut gains = vec![plant.d / found.weight];
    let (mut largest, mut small) = (gains[0].abs(), 0);
    while gains.len() < MOST_AHEAD && small < IN_A_ROW {
        let next = plant.b.dot(&q) / found.weight;
        gains.push(next);
        largest = largest.max(next.abs());
        small = if next.abs() <= NEGLIGIBLE * largest { small + 1 } else { 0 };
        q = &closed * q;
    }
    gains.truncate((gains.len() - small).max(1));
    let left = sum - gains.iter().sum::<f64>();
    if let Some(last) = gains.last_mut() {
        *last += left;
    }
    gains
}

/// Samples ahead beyond which the gains add up to a negligible share of all.
fn useful(ahead: &[f64]) -> usize {
    let all: f64 = ahead.iter().map(|f| f.abs()).sum();
    let mut left = 0.0;
    let tail = ahead.iter().rev().take_while(|f| {
        left += f.abs();
        left <= LEFT_TO_PREDICTION * all
    });
    ahead.len() - 1 - tail.count().min(ahead.len() - 1)
}

/// Gains on the known reference, the newest first: the prediction distributes those on future samples.
fn known(
    ahead: &[f64],
    late: usize,
    preview: usize,
    prediction: Prediction,
    sample_rate_hz: f64,
) -> Result<Vec<f64>, InversionError> {
    // Gain j applies to the sample late + j ahead.
    let last = late + ahead.len() - 1;
    let unknown = last - preview.min(last);
    if unknown > MOST_AHEAD {
        let (value, allowed) = (unknown as f64, "at most 4096: give more preview");
        return Err(InversionError::Option { name: "samples to predict", value, allowed });
    }
    let gain_at = |samples_ahead: usize| {
        samples_ahead.checked_sub(late).and_then(|j| ahead.get(j)).copied().unwrap_or(0.0)
    };
    let weights = prediction.weights(unknown, sample_rate_hz).ok_or(InversionError::NoRegulator)?;
    let first = preview.saturating_sub(late);
    let mut known = vec![0.0; (first + 1).max(weights.ncols())];
    for (l, gain) in known.iter_mut().enumerate() {
        if let Some(samples_ahead) = preview.checked_sub(l) {
            *gain += gain_at(samples_ahead);
        }
        if l < weights.ncols() {
            *gain += (0..unknown).map(|step| gain_at(preview + 1 + step) * weights[(step, l)]).sum::<f64>();
        }
    }
    Ok(known)
}
