//! A law of several axes at work: references in, drives out.

use super::linear::{LinearAxes, right_inverse};
use super::{DecouplingError, DecouplingLaw, check_limits, limited};
use crate::axes::HeldSimulation;
use crate::compensator::Limits;
use hysteron_rt::Limited;

/// Rounds for the voltages at rest, and the change, relative to the widest limits, at which they are settled.
const REST_ROUNDS: usize = 40;
const SETTLED: f64 = 1e-10;

/// The inverse of a model of several axes, sample by sample. It owns its coefficients and its memory; a step
/// allocates nothing.
///
/// Its model runs at the constant S of the law.
#[derive(Clone, Debug)]
pub struct DecouplingController {
    law: DecouplingLaw,
    limits: Vec<Limits>,
    model: HeldSimulation,
    /// u_(k−1), u_(k−2).
    recent: [Vec<f64>; 2],
    /// w of the present step as predicted, and its smoothed change a sample.
    strains: Vec<f64>,
    strain_rates: Vec<f64>,
    last_strains: Vec<f64>,
    drive: Vec<f64>,
    limited: Vec<Limited>,
    /// References from the present one to the end of the preview, a ring of samples.
    window: Vec<f64>,
    /// Place of the present one.
    present: usize,
}

impl DecouplingController {
    /// Of a law within limits, one an actuator.
    ///
    /// # Errors
    /// [`DecouplingError::Limits`], [`DecouplingError::Hysteresis`] for limits that are empty.
    pub(super) fn new(law: DecouplingLaw, limits: Vec<Limits>) -> Result<Self, DecouplingError> {
        let model = &law.held.model;
        check_limits(&limits, model.inputs)?;
        let rest: Vec<f64> = limits.iter().map(|limit| 0.0_f64.clamp(limit.low, limit.high)).collect();
        let mut controller = Self {
            model: HeldSimulation::new(model.clone(), law.state),
            recent: [rest.clone(), rest.clone()],
            strains: vec![0.0; model.inputs],
            strain_rates: vec![0.0; model.inputs],
            last_strains: vec![0.0; model.inputs],
            drive: rest.clone(),
            limited: vec![Limited::No; model.inputs],
            window: vec![0.0; (law.preview + 1) * model.outputs],
            present: 0,
            limits,
            law,
        };
        controller.settle(&rest);
        Ok(controller)
    }

    /// Rests at these voltages; the references known are the outputs there.
    fn settle(&mut self, rest: &[f64]) {
        self.model.rest_at(rest);
        for list in self.recent.iter_mut().chain([&mut self.drive]) {
            list.copy_from_slice(rest);
        }
        self.strains.copy_from_slice(self.model.strains());
        self.strain_rates.fill(0.0);
        self.limited.fill(Limited::No);
        let output = self.model.output();
        self.window.chunks_exact_mut(output.len()).for_each(|row| row.copy_from_slice(output));
        self.present = 0;
    }

    /// Rests where these outputs \[µm\] are held; returns the voltages.
    ///
    /// # Errors
    /// [`DecouplingError::Begins`] outside of the limits, [`DecouplingError::NoRest`],
    /// [`DecouplingError::References`].
    pub fn rest_at(&mut self, outputs: &[f64]) -> Result<Vec<f64>, DecouplingError> {
        let model = &self.law.held.model;
        if outputs.len() != model.outputs {
            return Err(DecouplingError::References { outputs: model.outputs, references: outputs.len() });
        }
        let back = right_inverse(&LinearAxes::of(model, self.law.state).gain())?;
        let mut rest = vec![0.0; model.inputs];
        for round in 0..REST_ROUNDS {
            self.settle(&rest);
            let size = self.limits.iter().fold(0.0_f64, |most, l| most.max(l.high - l.low));
            let mut change = 0.0_f64;
            for (n, u) in rest.iter_mut().enumerate() {
                let missed = outputs.iter().zip(self.model.output()).enumerate();
                let step: f64 = missed.map(|(m, (r, y))| back[(n, m)] * (r - y)).sum();
                change = change.max(step.abs() / size);
                *u += step;
            }
            if change.is_nan() || (round + 1 == REST_ROUNDS && change > SETTLED) {
                return Err(DecouplingError::NoRest { rounds: round + 1, change });
            }
            if change <= SETTLED {
                break;
            }
        }
        for (n, (rest, limit)) in rest.iter().zip(&self.limits).enumerate() {
            let Limits { low, high, .. } = *limit;
            if !(low..=high).contains(rest) {
                return Err(DecouplingError::Begins { actuator: n + 1, rest: *rest, low, high });
            }
        }
        self.settle(&rest);
        Ok(rest)
    }

    /// Tells a reference of the preview in advance: called [`DecouplingLaw::preview`] times before the first
    /// step, the first reference first.
    pub fn know(&mut self, reference: &[f64]) {
        let outputs = self.model.output().len();
        let rows = self.window.len() / outputs;
        let at = self.present * outputs;
        self.window[at..at + outputs].iter_mut().zip(reference).for_each(|(to, r)| *to = *r);
        self.present = (self.present + 1) % rows;
    }

    /// The next sample: the drives to be held from now on. `newest`: the references
    /// [`DecouplingLaw::preview`] samples ahead; one that is not finite is replaced by the last.
    pub fn step(&mut self, newest: &[f64]) -> &[f64] {
        let (n, outputs) = (self.drive.len(), self.model.output().len());
        let rows = self.window.len() / outputs;
        let (before, at) = ((self.present + rows - 1) % rows * outputs, self.present * outputs);
        for (m, r) in newest.iter().enumerate().take(outputs) {
            self.window[at + m] = if r.is_finite() { *r } else { self.window[before + m] };
        }
        // The oldest of the window follows its newest: the present reference.
        self.present = (self.present + 1) % rows;
        let [last, before_last] = &mut self.recent;
        self.last_strains.copy_from_slice(self.model.strains());
        self.model.advance();
        let law = &self.law;
        for i in 0..n {
            let row = |gains: &[f64], x: &[f64]| -> f64 {
                gains[i * x.len()..(i + 1) * x.len()].iter().zip(x).map(|(k, x)| k * x).sum()
            };
            let mut wanted = row(&law.states, self.model.states())
                + row(&law.recent[0], last)
                + row(&law.recent[1], before_last)
                + row(&law.strains, &self.strains)
                + row(&law.strain_rates, &self.strain_rates);
            for (j, gains) in law.reference.iter().enumerate() {
                let at = (self.present + j) % rows * outputs;
                wanted += row(gains, &self.window[at..at + outputs]);
            }
            let rate = law.held.model.sample_rate_hz;
            (self.drive[i], self.limited[i]) = limited(wanted, last[i], &self.limits[i], rate);
        }
        before_last.copy_from_slice(last);
        last.copy_from_slice(&self.drive);
        self.model.apply(&self.drive);
        let strains = self.strains.iter_mut().zip(&mut self.strain_rates);
        for (((predicted, rate), strain), last) in strains.zip(self.model.strains()).zip(&self.last_strains) {
            *rate += law.smoothing * (strain - last - *rate);
            *predicted = strain + *rate;
        }
        &self.drive
    }

    /// Outputs of the model at the last step \[µm\].
    pub fn output(&self) -> &[f64] {
        self.model.output()
    }

    /// The limit that was active at the last step, of every actuator.
    pub fn limited(&self) -> &[Limited] {
        &self.limited
    }

    /// The law.
    pub fn law(&self) -> &DecouplingLaw {
        &self.law
    }
}
