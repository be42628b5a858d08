//! Simulation sample by sample.

use super::simulate::Runner;
use super::{LevelTracker, ScheduledModes};

/// A simulation fed sample by sample, the inputs linear between samples. A step allocates nothing.
#[derive(Clone, Debug)]
pub struct Streaming<'m> {
    runner: Runner<'m>,
    tracker: LevelTracker,
    last: Vec<f64>,
    fine: Vec<f64>,
    started: bool,
}

impl<'m> Streaming<'m> {
    /// Steady state under the inputs `u`, after a drive of rms `level` \[V\].
    pub fn new(model: &'m ScheduledModes, u: &[f64], level: f64) -> Self {
        let s = model.level.state(level);
        let mut runner = Runner::new(model, s);
        runner.settle(u, s);
        Self::from(runner, u, level)
    }

    /// From the state of `runner`, with the inputs `u` next, after a drive of rms `level` \[V\].
    pub(super) fn from(runner: Runner<'m>, u: &[f64], level: f64) -> Self {
        let model = runner.model.as_ref();
        let tracker = LevelTracker::new(&model.level, model.sample_rate_hz, u, level);
        let fine = vec![0.0; model.steps * model.inputs];
        Self { runner, tracker, last: u.to_vec(), fine, started: false }
    }

    /// The next sample of the inputs, and the outputs at it.
    pub fn step(&mut self, u: &[f64], y: &mut [f64]) {
        let steps = self.runner.model.steps;
        let mut fine = std::mem::take(&mut self.fine);
        for (j, row) in fine.chunks_exact_mut(u.len().max(1)).enumerate() {
            let share = (j + 1) as f64 / steps as f64;
            for ((to, last), now) in row.iter_mut().zip(&self.last).zip(u) {
                *to = last + (now - last) * share;
            }
        }
        let first = if self.started { 0 } else { fine.len() - u.len() };
        self.follow(&fine[first..], y);
        self.fine = fine;
    }

    /// [`Self::step`] where the inputs are held from sample to sample: the present ones act from now on.
    pub fn hold(&mut self, u: &[f64], y: &mut [f64]) {
        let mut fine = std::mem::take(&mut self.fine);
        fine.chunks_exact_mut(u.len().max(1)).for_each(|row| row.copy_from_slice(&self.last));
        let newest = fine.len() - u.len();
        fine[newest..].copy_from_slice(u);
        self.follow(&fine[if self.started { 0 } else { newest }..], y);
        self.fine = fine;
    }

    /// Advances by the inputs at every step since the last sample, up to and including the present one.
    pub(super) fn follow(&mut self, fine: &[f64], y: &mut [f64]) {
        let n = self.runner.model.inputs;
        let count = fine.len() / n.max(1);
        for (j, u) in fine.chunks_exact(n).enumerate() {
            // The state at a step follows from the inputs at the one before.
            if self.started {
                self.runner.advance(&self.last);
            }
            if j + 1 == count {
                let level = self.tracker.step(u);
                self.runner.set_state(self.runner.model.level.state(level));
            }
            self.runner.strain(u);
            self.started = true;
            self.last.copy_from_slice(u);
        }
        self.runner.output(&self.last, y);
    }
}
