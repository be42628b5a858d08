//! Progress of a run, and its cancellation.

use super::{Bounds, Checkpoint, Stop};
use std::ops::ControlFlow;

/// Receives progress once per generation (or iteration); may stop the run, whose best so far is kept.
///
/// Any closure `FnMut(&Progress) -> ControlFlow<()>` is one; [`Unobserved`] never stops.
pub trait Observer {
    /// One generation is done.
    fn generation(&mut self, progress: &Progress<'_>) -> ControlFlow<()>;

    /// Stop signal that ends the run within a generation, from another thread: evaluations not yet begun are
    /// skipped, and the checkpoint is that of the previous generation.
    fn stop(&self) -> Option<Stop> {
        None
    }
}

impl<F: FnMut(&Progress<'_>) -> ControlFlow<()>> Observer for F {
    fn generation(&mut self, progress: &Progress<'_>) -> ControlFlow<()> {
        self(progress)
    }
}

impl Observer for Stop {
    fn generation(&mut self, _: &Progress<'_>) -> ControlFlow<()> {
        if self.is_requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn stop(&self) -> Option<Stop> {
        Some(self.clone())
    }
}

/// An observer that ignores progress.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unobserved;

impl Observer for Unobserved {
    fn generation(&mut self, _: &Progress<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// State of a run after a generation.
#[derive(Clone, Debug)]
pub struct Progress<'a> {
    /// Generations done, from 1 (0: initial population).
    pub generation: usize,
    /// Generations planned; least squares: the most iterations that all its starts may take.
    pub generations: usize,
    /// Cost evaluations so far.
    pub evaluations: usize,
    /// Best cost so far.
    pub best_cost: f64,
    /// Best parameters so far, in the problem's own units.
    pub best: &'a [f64],
    pub(super) checkpoint: &'a Checkpoint,
}

impl<'a> Progress<'a> {
    /// State of the run, from which [`minimize`](super::minimize()) can resume.
    pub fn checkpoint(&self) -> &'a Checkpoint {
        self.checkpoint
    }

    pub(super) fn of(checkpoint: &'a Checkpoint, bounds: &Bounds, best: &'a mut Vec<f64>) -> Self {
        let ledger = &checkpoint.ledger;
        best.resize(bounds.dimension(), 0.0);
        bounds.from_unit(&ledger.best, best);
        Self {
            generation: ledger.generation,
            generations: checkpoint.algorithm.planned_generations(&checkpoint.settings),
            evaluations: ledger.evaluations,
            best_cost: ledger.best_cost,
            best,
            checkpoint,
        }
    }
}
