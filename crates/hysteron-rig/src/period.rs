//! Simulation of the true plant, one sample period at a time.

use std::collections::VecDeque;

use super::RigError;
use super::plant::HysteresisState;
use super::propagation::Propagator;
use super::truth::Truth;

/// First-order amplifier, exact for a drive that is linear over each step.
struct Amplifier {
    decay: f64,
    from_start: f64,
    from_end: f64,
}

impl Amplifier {
    fn new(corner_rad_s: f64, step_s: f64) -> Self {
        // x' = ω(u − x): x₁ = e^(−z) x₀ + (1 − e^(−z) − w) u₀ + w u₁, z = ωh, w = 1 − (1 − e^(−z))/z.
        let z = corner_rad_s * step_s;
        let filled = -(-z).exp_m1();
        let from_end = if z < 1e-4 { z * (0.5 - z / 6.0) } else { 1.0 - filled / z };
        Amplifier { decay: 1.0 - filled, from_start: filled - from_end, from_end }
    }
}

/// Amplifier, hysteresis and dynamics with their states.
pub(super) struct Periods<'a> {
    hysteresis: HysteresisState<'a>,
    plant: Propagator,
    amplifier: Option<Amplifier>,
    sample_rate_hz: f64,
    /// Grid steps of a period.
    steps: usize,
    /// Periods simulated.
    period: usize,
    amplified_v: f64,
    v: f64,
    /// Displacements computed but not yet output, because of the delay.
    due: VecDeque<f64>,
    /// Grid point at which the next one is read.
    next_read: usize,
}

impl<'a> Periods<'a> {
    /// A plant in equilibrium at `first_v`. The truth must be valid.
    pub fn at_rest(truth: &'a Truth, sample_rate_hz: f64, first_v: f64) -> Result<Self, RigError> {
        if !(sample_rate_hz.is_finite() && sample_rate_hz > 0.0) {
            let (what, expected) = ("sample_rate_hz", "a finite rate above 0");
            return Err(RigError::Drive { what, value: sample_rate_hz, expected });
        }
        let steps = truth.oversampling as usize;
        let step_s = 1.0 / (sample_rate_hz * steps as f64);
        let dynamics = truth.plant.dynamics(step_s)?;

        // Output k is read at grid point k·steps − delay: `whole` points back and `fraction` of a step on.
        let delay_steps = truth.delay_s() / step_s;
        let nearest = delay_steps.round();
        let is_whole = (delay_steps - nearest).abs() < 1e-9;
        let whole = if is_whole { nearest } else { delay_steps.ceil() };
        let fraction = if is_whole { 0.0 } else { (whole - delay_steps).max(0.0) };
        let whole = whole as usize;

        let mut hysteresis = truth.plant.hysteresis();
        let rest_um = hysteresis.step(first_v);
        if first_v != 0.0 && !dynamics.static_gain.is_finite() {
            return Err(RigError::NoRest { drive_v: first_v });
        }
        let plant = Propagator::at_rest(&dynamics, step_s, fraction, rest_um);
        let at_rest_um = if rest_um == 0.0 { 0.0 } else { plant.output(rest_um, rest_um) };
        // Delayed outputs from before the record are those at rest.
        let before = whole.div_ceil(steps);
        Ok(Periods {
            hysteresis,
            plant,
            amplifier: truth.plant.amplifier_rad_s().map(|w| Amplifier::new(w, step_s)),
            sample_rate_hz,
            steps,
            period: 0,
            amplified_v: first_v,
            v: rest_um,
            due: std::iter::repeat_n(at_rest_um, before).collect(),
            next_read: before * steps - whole,
        })
    }

    /// Simulates one period, in which the drive jumps to `start_v` and then goes linearly to `end_v`; returns
    /// displacement and output of the hysteresis at its beginning \[µm\].
    pub fn next(&mut self, start_v: f64, end_v: f64) -> Result<(f64, f64), RigError> {
        let diverged =
            RigError::Diverged { time_s: self.period as f64 / self.sample_rate_hz, drive_v: start_v };
        if self.amplifier.is_none() {
            // A held drive jumps here; a linear one has already reached this value.
            self.v = self.hysteresis.step(start_v);
            if !self.v.is_finite() {
                return Err(diverged);
            }
        }
        let at_start = self.v;
        let steps = self.steps;
        for j in 0..steps {
            let at = |i: usize| {
                if i == steps { end_v } else { start_v + (end_v - start_v) * (i as f64 / steps as f64) }
            };
            let drive_v = match &self.amplifier {
                None => at(j + 1),
                Some(a) => {
                    self.amplified_v =
                        a.decay * self.amplified_v + a.from_start * at(j) + a.from_end * at(j + 1);
                    self.amplified_v
                }
            };
            let v_next = self.hysteresis.step(drive_v);
            if self.period * steps + j == self.next_read {
                self.due.push_back(self.plant.output(self.v, v_next));
                self.next_read += steps;
            }
            self.plant.advance(self.v, v_next);
            self.v = v_next;
        }
        self.period += 1;
        match self.due.pop_front() {
            Some(y) if self.v.is_finite() => Ok((y, at_start)),
            _ => Err(diverged),
        }
    }
}
