//! Outcome of a run.

use super::{Checkpoint, GenerationRecord, Improvement, StartResult};
use serde::{Deserialize, Serialize};

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum StopReason {
    /// All generations done.
    Generations,
    /// The budget of evaluations is spent.
    Budget,
    /// The target cost is reached.
    Target,
    /// The best cost has stagnated.
    Stagnation,
    /// Stopped by the observer; the best so far is kept.
    Cancelled,
    /// Least squares: all starts are done.
    StartsDone,
    /// Least squares: enough starts ended in the same best minimum.
    Agreement,
}

/// Result of an optimisation run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outcome {
    /// Best parameters, in the problem's own units.
    pub best: Vec<f64>,
    /// Their cost, finite.
    pub cost: f64,
    /// Cost evaluations, those of finite differences and scouts included.
    pub evaluations: usize,
    /// Generations after the initial population; least squares: iterations of all starts.
    pub generations: usize,
    /// Best cost after each generation, the initial population first.
    pub history: Vec<GenerationRecord>,
    /// Every improvement of the best cost, with the number of the evaluation that made it.
    pub improvements: Vec<Improvement>,
    /// Why the run ended.
    pub stopped: StopReason,
    /// Number of scouts sent out (bee colonies; 0 elsewhere).
    pub scouts_fired: usize,
    /// Result of each start (least squares; empty elsewhere).
    pub starts: Vec<StartResult>,
    /// Final state: a cancelled run resumes from here.
    pub checkpoint: Checkpoint,
}

impl Outcome {
    /// Number of the evaluation that first brought the cost to `target` or below; `None` if none did.
    pub fn evaluations_to(&self, target: f64) -> Option<usize> {
        self.improvements.iter().find(|i| i.cost <= target).map(|i| i.evaluation)
    }
}

/// Outcome of a generation: continue or stop.
pub(super) enum Advance {
    Continue,
    Finished(StopReason),
}
