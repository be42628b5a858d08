//! Simulation at one level, sample by sample, the inputs held: the arithmetic of controllers and exports.

use std::borrow::Cow;

use super::ScheduledModes;
use super::simulate::Runner;

/// A model at a constant S whose inputs are held from sample to sample. It owns its memory; a step allocates
/// nothing.
#[derive(Clone, Debug)]
pub struct HeldSimulation {
    runner: Runner<'static>,
    s: f64,
    held: Vec<f64>,
    output: Vec<f64>,
}

impl HeldSimulation {
    /// At rest under inputs of 0.
    pub fn new(model: ScheduledModes, s: f64) -> Self {
        let (held, output) = (vec![0.0; model.inputs], vec![0.0; model.outputs]);
        let mut simulation = Self { runner: Runner::of(Cow::Owned(model), s), s, held, output };
        let rest = simulation.held.clone();
        simulation.rest_at(&rest);
        simulation
    }

    /// The model.
    pub fn model(&self) -> &ScheduledModes {
        &self.runner.model
    }

    /// At rest under these inputs, one per actuator, driven there from 0 without memory.
    pub fn rest_at(&mut self, u: &[f64]) {
        self.runner.reset();
        self.runner.settle(u, self.s);
        self.apply(u);
    }

    /// Steps simulated to rest.
    pub fn settling_steps(&self) -> usize {
        self.runner.settling(self.s)
    }

    /// To the next sample, the inputs held.
    pub fn advance(&mut self) {
        for step in 0..self.runner.model.steps {
            if step > 0 {
                self.runner.strain(&self.held);
            }
            self.runner.advance(&self.held);
        }
    }

    /// Applies inputs, one per actuator, from the present sample on; the outputs at it.
    pub fn apply(&mut self, u: &[f64]) -> &[f64] {
        self.held.copy_from_slice(u);
        self.runner.strain(u);
        self.runner.output(u, &mut self.output);
        &self.output
    }

    /// States of the modes, real and imaginary parts, then of the lags.
    pub fn states(&self) -> &[f64] {
        &self.runner.x
    }

    /// Strains of the actuators.
    pub fn strains(&self) -> &[f64] {
        &self.runner.w
    }

    /// Outputs at the present sample \[µm\].
    pub fn output(&self) -> &[f64] {
        &self.output
    }
}
