//! A simulated period with the signals its derivatives need.

use super::ScheduledModes;
use super::simulate::Runner;

/// A period in its steady state, step by step, and the steps before it from which derivatives are followed.
///
/// Row k of `signals` holds, at step k: the states x, the inputs u, the strains w, the terms of the laws of v
/// (input by input), those of σ.
#[derive(Clone, Debug)]
pub struct Trajectory {
    /// Signals, `width` a step.
    pub signals: Vec<f64>,
    /// Signals a step.
    pub width: usize,
    /// Slopes of the laws of v and σ while no play moves: 2N a step.
    pub slopes: Vec<f64>,
    /// Bit masks of the plays of the laws of v and σ that moved: 2N per step.
    pub moved: Vec<u32>,
    /// Steps before the period.
    pub before: usize,
    /// Outputs at every sample, interleaved.
    pub y: Vec<f64>,
}

impl Trajectory {
    /// Simulates one period of inputs `fine` at every step after `preroll` steps from rest, of which the last
    /// `before` are kept. `None` on overflow.
    pub fn new(model: &ScheduledModes, s: f64, fine: &[f64], preroll: usize, before: usize) -> Option<Self> {
        let n = model.inputs;
        let count = fine.len() / n;
        let mut runner = Runner::new(model, s);
        let before = before.min(preroll);
        // Everything up to the steps that are kept: those end where the period begins.
        let shift = before % count;
        let rotated: Vec<f64> = fine[(count - shift) % count * n..]
            .iter()
            .chain(&fine[..(count - shift) % count * n])
            .copied()
            .collect();
        runner.preroll(&rotated, preroll - before);
        let width = model.states() + 2 * n + runner.terms.len();
        let rows = before + count;
        let mut kept = Self {
            signals: Vec::with_capacity(rows * width),
            width,
            slopes: Vec::with_capacity(rows * 2 * n),
            moved: Vec::with_capacity(rows * 2 * n),
            before,
            y: vec![0.0; count / model.steps * model.outputs],
        };
        for step in 0..rows {
            let u = &rotated[step % count * n..(step % count + 1) * n];
            runner.strain(u);
            for part in [&runner.x, u, &runner.w, &runner.terms] {
                kept.signals.extend_from_slice(part);
            }
            kept.slopes.extend_from_slice(&runner.slopes);
            kept.moved.extend_from_slice(&runner.moved);
            let (k, m) = (step.wrapping_sub(before), model.outputs);
            if step >= before && k % model.steps == 0 {
                let at = k / model.steps * m;
                runner.output(u, &mut kept.y[at..at + m]);
            }
            runner.advance(u);
        }
        (runner.is_finite() && kept.y.iter().all(|y| y.is_finite())).then_some(kept)
    }

    /// Signals at a sample of the period.
    pub fn at_sample(&self, sample: usize, steps: usize) -> &[f64] {
        let row = self.before + sample * steps;
        &self.signals[row * self.width..(row + 1) * self.width]
    }
}
