//! Progress of an identification of any kind, and the right to stop it.

use std::ops::ControlFlow;

use hysteron_optimize::Progress;

use crate::engine::{Searches, Watcher};
use crate::modes::ModesProgress;

/// What an identification tells about itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Event<'a> {
    /// What is being done.
    pub stage: &'a str,
    /// Share of the stage that is done, 0 to 1.
    pub fraction: f64,
    /// Best cost so far: RMSE in the unit of the output, in a joint fit weighted.
    pub cost: Option<f64>,
}

/// Told about an identification; may stop it, and the best so far is kept.
pub trait Watch {
    /// Something was done.
    fn event(&mut self, event: &Event<'_>) -> ControlFlow<()>;
}

impl<F: FnMut(&Event<'_>) -> ControlFlow<()>> Watch for F {
    fn event(&mut self, event: &Event<'_>) -> ControlFlow<()> {
        self(event)
    }
}

/// A [`Watch`] told about the searches of every kind of identification.
pub struct Told<'a>(pub &'a mut dyn Watch);

impl Told<'_> {
    /// One generation of a search.
    pub fn search(&mut self, stage: &str, progress: &Progress<'_>) -> ControlFlow<()> {
        self.tell(stage, progress.generation as f64, progress.generations as f64, Some(progress.best_cost))
    }

    /// One step of an identification of modes.
    pub fn modes(&mut self, progress: &ModesProgress) -> ControlFlow<()> {
        self.tell(progress.step, progress.done as f64, progress.whole as f64, progress.rmse)
    }

    fn tell(&mut self, stage: &str, done: f64, whole: f64, cost: Option<f64>) -> ControlFlow<()> {
        let fraction = if whole > 0.0 { (done / whole).clamp(0.0, 1.0) } else { 0.0 };
        self.0.event(&Event { stage, fraction, cost: cost.filter(|cost| cost.is_finite()) })
    }
}

impl Watcher for Told<'_> {
    fn progress(&mut self, step: &str, progress: &Progress<'_>, _: &dyn Fn() -> Searches) -> ControlFlow<()> {
        self.search(step, progress)
    }
}
