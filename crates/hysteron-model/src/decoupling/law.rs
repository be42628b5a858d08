//! Inverse of scheduled modes sample by sample: a linear-quadratic regulator with preview.
//!
//! The drives minimise Σ |r − y|² + Σ_n λ_n (Δ²u_n)² over an infinite horizon, as [`crate::compensator`] does
//! for one axis:
//!
//! u_k = K_x x_k + K₁ u_(k−1) + K₂ u_(k−2) + K_w w + K_δ δ + Σ_j F_j r_(k+j), j = 0 … preview
//!
//! with w the strains of the hysteresis, taken to change by δ a sample for ever: exact at rest. δ is the
//! change of the last samples, smoothed over the reach of K_δ, so that the loop through the hysteresis keeps
//! its small gain. Beyond the preview the reference is taken to stay. λ is that of [`super::decouple`].

use nalgebra::DMatrix;

use super::linear::{LinearAxes, right_inverse};
use super::{AxesDrive, DecouplingController, DecouplingError, check, own_bandwidth};
use crate::axes::{HeldModes, ScheduledModes};
use crate::compensator::Limits;
use crate::compensator::riccati::{SeveralInputs, several_inputs};
use crate::invert::ERROR_AT_BANDWIDTH;
use hysteron_numeric::Complex64;
use hysteron_rt::Limited;
use std::f64::consts::{PI, TAU};

/// Longest reach of the gains on the references.
const MOST_AHEAD: usize = 4096;
/// Gains, as a share of the largest, that are negligible; so many in succession end the preview.
const NEGLIGIBLE: f64 = 1e-8;
const IN_A_ROW: usize = 32;
/// Share of the gains that the default preview leaves out.
const LEFT: f64 = 1e-4;
/// Weight of the drive itself where there are more actuators than axes, relative to the gain at rest.
const SURPLUS: f64 = 1e-6;

/// Options of a law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LawOptions {
    /// Tracking bandwidth \[Hz\]; `None`: [`super::own_bandwidth`].
    pub bandwidth_hz: Option<f64>,
    /// Preview of the references in samples; 0: the present ones only. `None`: as many as are useful.
    pub preview: Option<usize>,
    /// Level of the drive \[V rms\], for modes that move with it; `None`: the highest identified.
    pub level: Option<f64>,
}

/// The law of a model of several axes at one sample rate. Matrices are stored row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct DecouplingLaw {
    /// The model at the rate, at every level.
    pub held: HeldModes,
    /// S, at which the law works.
    pub state: f64,
    /// Level of S \[V rms\].
    pub level: f64,
    /// K_x: inputs × states.
    pub states: Vec<f64>,
    /// K₁, K₂: inputs × inputs.
    pub recent: [Vec<f64>; 2],
    /// K_w: inputs × inputs.
    pub strains: Vec<f64>,
    /// K_δ: inputs × inputs.
    pub strain_rates: Vec<f64>,
    /// Share by which δ moves to the newest change.
    pub smoothing: f64,
    /// F_j, inputs × outputs each, the present reference first.
    pub reference: Vec<Vec<f64>>,
    /// Preview \[samples\].
    pub preview: usize,
    /// Longest useful preview \[samples\].
    pub useful_preview: usize,
    /// True if more would be of use, but the gains on the references end there.
    pub preview_is_cut: bool,
    /// Bandwidth \[Hz\].
    pub bandwidth_hz: f64,
}

impl DecouplingLaw {
    /// The law of a model at a controller's rate \[Hz\].
    ///
    /// # Errors
    /// [`DecouplingError`].
    pub fn new(
        model: &ScheduledModes,
        sample_rate_hz: f64,
        options: &LawOptions,
    ) -> Result<Self, DecouplingError> {
        let (n, m) = (model.inputs, model.outputs);
        if n < m {
            return Err(DecouplingError::TooFewActuators { inputs: n, outputs: m });
        }
        let held = model.held_at(sample_rate_hz)?;
        let bandwidth_hz = options.bandwidth_hz.unwrap_or_else(|| own_bandwidth(model, sample_rate_hz));
        if !(bandwidth_hz > 0.0 && bandwidth_hz < 0.5 * sample_rate_hz.min(model.sample_rate_hz)) {
            let allowed = "positive and below half the sample rates of controller and model";
            return Err(DecouplingError::Option { name: "bandwidth [Hz]", value: bandwidth_hz, allowed });
        }
        let level = options.level.unwrap_or(model.level.highest);
        if !(level.is_finite() && level >= 0.0) {
            let allowed = "finite and not negative";
            return Err(DecouplingError::Option { name: "level", value: level, allowed });
        }
        let state = model.level.state(level);
        let linear = LinearAxes::of(&held.model, state);
        let gain = linear.gain();
        let back = right_inverse(&gain)?;
        let regulator = Regulator::new(&linear, &gain, bandwidth_hz / sample_rate_hz)
            .ok_or(DecouplingError::NoRegulator)?;
        let sum = if n == m { Some(regulator.held(&linear)? * back) } else { None };
        let mut ahead = regulator.ahead(sum);
        let useful_preview = useful(&ahead);
        let preview = options.preview.unwrap_or(useful_preview).min(ahead.len() - 1);
        // Beyond the preview the reference stays: its gains act on the last one known.
        let left: DMatrix<f64> =
            ahead[preview + 1..].iter().fold(DMatrix::zeros(n, m), |sum, gains| sum + gains);
        ahead.truncate(preview + 1);
        ahead[preview] += left;
        let (strains, strain_rates) = regulator.strains(&linear).ok_or(DecouplingError::NoRegulator)?;
        let reach = strain_rates.norm() / strains.norm().max(f64::MIN_POSITIVE);
        let states = held.model.states();
        let part = |from: usize, count: usize| rows(&(-regulator.found.gains.columns(from, count)));
        Ok(Self {
            states: part(0, states),
            recent: [part(states, n), part(states + n, n)],
            strains: rows(&strains),
            strain_rates: rows(&strain_rates),
            smoothing: 1.0 / (1.0 + reach),
            reference: ahead.iter().map(rows).collect(),
            held,
            state,
            level,
            preview,
            useful_preview,
            preview_is_cut: useful_preview + 1 == MOST_AHEAD,
            bandwidth_hz,
        })
    }

    /// The controller that runs the law within these limits, at rest at 0 V or, where the limits of an
    /// actuator exclude it, at the nearest voltage.
    ///
    /// # Errors
    /// [`DecouplingError::Limits`], [`DecouplingError::Hysteresis`].
    pub fn controller(&self, limits: &[Limits]) -> Result<DecouplingController, DecouplingError> {
        DecouplingController::new(self.clone(), limits.to_vec())
    }

    /// True if the drives `found` along `references` \[µm\] do not depend on their last digits. At bandwidths that are high
    /// for the hysteresis the loop through it may not settle: the drives are then as chance has it.
    ///
    /// # Errors
    /// Those of [`Self::follow`].
    pub fn is_steady(
        &self,
        found: &AxesDrive,
        references: &[Vec<f64>],
        limits: &[Limits],
    ) -> Result<bool, DecouplingError> {
        let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        let nudged: Vec<Vec<f64>> = references
            .iter()
            .map(|r| r.iter().enumerate().map(|(k, r)| r * (1.0 + NUDGE * sign(k))).collect())
            .collect();
        let other = self.follow(&nudged, limits)?;
        let alike = |((a, b), limits): ((&Vec<f64>, &Vec<f64>), &Limits)| {
            let most = a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
            most <= STEADY * (limits.high - limits.low)
        };
        Ok(found.drive.iter().zip(&other.drive).zip(limits).all(alike))
    }

    /// The drives along `references` \[µm\], one list per axis, computed sample by sample from rest at their
    /// first values; after their end they stay.
    ///
    /// # Errors
    /// [`DecouplingError`].
    pub fn follow(&self, references: &[Vec<f64>], limits: &[Limits]) -> Result<AxesDrive, DecouplingError> {
        let model = &self.held.model;
        check(references, limits, (model.inputs, model.outputs))?;
        let samples = references.first().map_or(0, Vec::len);
        let at = |k: usize| -> Vec<f64> { references.iter().map(|r| r[k.min(samples - 1)]).collect() };
        let mut controller = self.controller(limits)?;
        let rest = controller.rest_at(&at(0))?;
        for k in 1..=self.preview {
            controller.know(&at(k - 1));
        }
        let (mut drive, mut predicted) = (vec![Vec::new(); model.inputs], vec![Vec::new(); model.outputs]);
        let (mut at_range, mut at_slew) = (vec![0; model.inputs], vec![0; model.inputs]);
        for k in 0..samples {
            let u = controller.step(&at(k + self.preview));
            drive.iter_mut().zip(u).for_each(|(list, u)| list.push(*u));
            predicted.iter_mut().zip(controller.output()).for_each(|(list, y)| list.push(*y));
            for (n, by) in controller.limited().iter().enumerate() {
                at_range[n] += usize::from(*by == Limited::Range);
                at_slew[n] += usize::from(*by == Limited::Step);
            }
        }
        if !predicted.iter().flatten().chain(drive.iter().flatten()).all(|y| y.is_finite()) {
            return Err(crate::axes::AxesError::RunsAway.into());
        }
        Ok(AxesDrive {
            drive,
            predicted,
            rest: Some(rest),
            level: self.level,
            at_range,
            at_slew,
            rounds: 1,
            bandwidth_hz: self.bandwidth_hz,
            rate_error: self.held.error,
        })
    }
}

/// Relative change of references, and the share of their limits that the drives may change by.
const NUDGE: f64 = 1e-12;
const STEADY: f64 = 1e-6;

/// The regulator of (x, u_(k−1), u_(k−2)).
struct Regulator {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    /// C − D K and A − B K.
    seen: DMatrix<f64>,
    closed: DMatrix<f64>,
    feedthrough: DMatrix<f64>,
    found: SeveralInputs,
}

impl Regulator {
    fn new(linear: &LinearAxes, gain: &DMatrix<f64>, bandwidth: f64) -> Option<Self> {
        let (n, states) = (linear.inputs, linear.input.nrows());
        let size = states + 2 * n;
        let mut a = DMatrix::zeros(size, size);
        a.view_mut((0, 0), (states, states)).copy_from(&linear.matrix());
        a.view_mut((states + n, states), (n, n)).copy_from(&DMatrix::identity(n, n));
        let mut b = DMatrix::zeros(size, n);
        b.view_mut((0, 0), (states, n)).copy_from(&linear.input);
        b.view_mut((states, 0), (n, n)).copy_from(&DMatrix::identity(n, n));
        let mut c = DMatrix::zeros(linear.outputs, size);
        c.view_mut((0, 0), (linear.outputs, states)).copy_from(&linear.output);
        // Δ²u = u + T ξ.
        let mut second = DMatrix::zeros(n, size);
        for i in 0..n {
            (second[(i, states + i)], second[(i, states + n + i)]) = (-2.0, 1.0);
        }
        let passed = linear.transfer(Complex64::from_polar(1.0, TAU * bandwidth));
        let roughness = (2.0 * (PI * bandwidth).sin()).powi(4);
        let share = ERROR_AT_BANDWIDTH / (1.0 - ERROR_AT_BANDWIDTH) / roughness;
        let weights = DMatrix::from_fn(n, n, |i, j| {
            let column = passed.iter().skip(i).step_by(n).map(|p| p.norm_sqr()).sum::<f64>();
            if i == j { share * column } else { 0.0 }
        });
        let d = &linear.feedthrough;
        let q = c.transpose() * &c + second.transpose() * &weights * &second;
        let s = c.transpose() * d + second.transpose() * &weights;
        let mut r = d.transpose() * d + &weights;
        if n > linear.outputs {
            for i in 0..n {
                r[(i, i)] += SURPLUS * gain.column(i).norm_squared();
            }
        }
        let found = several_inputs((&a, &b), &q, &s, &r)?;
        let (seen, closed) = (&c - d * &found.gains, &a - &b * &found.gains);
        Some(Self { a, b, seen, closed, feedthrough: d.clone(), found })
    }

    /// I + K Ξ: drives held, the part of them that the reference has to give.
    fn held(&self, linear: &LinearAxes) -> Result<DMatrix<f64>, DecouplingError> {
        let (n, states) = (linear.inputs, linear.input.nrows());
        let rest = (DMatrix::identity(states, states) - self.a.view((0, 0), (states, states)))
            .lu()
            .solve(&linear.input)
            .ok_or(DecouplingError::NoRegulator)?;
        let k = &self.found.gains;
        Ok(DMatrix::identity(n, n)
            + k.columns(0, states) * rest
            + k.columns(states, n)
            + k.columns(states + n, n))
    }

    /// F₀ = W Dᵀ, F_j = W Bᵀ (A_cᵀ)^(j−1) (C − D K)ᵀ, W = (R + BᵀPB)⁻¹; the truncated tail, up to the `sum`
    /// of all, is added to the last.
    fn ahead(&self, sum: Option<DMatrix<f64>>) -> Vec<DMatrix<f64>> {
        let weight = &self.found.inverse_weight;
        let mut gains = vec![weight * self.feedthrough.transpose()];
        let left = weight * self.b.transpose();
        let closed = self.closed.transpose();
        let mut q = self.seen.transpose();
        let (mut largest, mut small) = (gains[0].amax(), 0);
        while gains.len() < MOST_AHEAD && small < IN_A_ROW {
            let next = &left * &q;
            largest = largest.max(next.amax());
            small = if next.amax() <= NEGLIGIBLE * largest { small + 1 } else { 0 };
            gains.push(next);
            q = &closed * q;
        }
        gains.truncate((gains.len() - small).max(1));
        if let Some(mut rest) = sum {
            gains.iter().for_each(|gain| rest -= gain);
            if let Some(last) = gains.last_mut() {
                *last += rest;
            }
        }
        gains
    }

    /// K_w and K_δ. With h and e the strains' part of a step and of the output, a disturbance w + i δ costs
    /// g_i = G (w + i δ) + G₁ δ from step i on: G = A_cᵀ(G + P h) + (C − D K)ᵀ e, G₁ = A_cᵀ(G + G₁). Then
    /// K_w = −W (Bᵀ(G + P h) + Dᵀ e), K_δ = −W Bᵀ(G + G₁).
    fn strains(&self, linear: &LinearAxes) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let size = self.a.nrows();
        let mut h = DMatrix::zeros(size, linear.inputs);
        h.view_mut((0, 0), linear.strain_input.shape()).copy_from(&linear.strain_input);
        let e = &linear.strain_feedthrough;
        let cost = &self.found.cost * h;
        let closed = self.closed.transpose();
        let factors = (DMatrix::identity(size, size) - &closed).lu();
        let g = factors.solve(&(&closed * &cost + self.seen.transpose() * e))?;
        let later = factors.solve(&(&closed * &g))?;
        let (weight, b) = (-&self.found.inverse_weight, self.b.transpose());
        let steady = &weight * (&b * (&g + cost) + self.feedthrough.transpose() * e);
        Some((steady, weight * b * (g + later)))
    }
}

/// Samples ahead beyond which the gains add up to a negligible share.
fn useful(ahead: &[DMatrix<f64>]) -> usize {
    let all: f64 = ahead.iter().map(|gain| gain.amax()).sum();
    let mut left = 0.0;
    let tail = ahead.iter().rev().take_while(|gain| {
        left += gain.amax();
        left <= LEFT * all
    });
    ahead.len() - 1 - tail.count().min(ahead.len() - 1)
}

fn rows(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}
