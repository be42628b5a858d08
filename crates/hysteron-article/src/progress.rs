//! Progress of the reproduction, and its stop request.

use super::ArticleError;
use std::ops::ControlFlow;

use hysteron_identify::{Event, Stop, Watch};

/// The stages in order, with their usual fraction of the time.
const WEIGHTS: [(&str, f64); 5] = [
    ("measuring on the simulated bench", 0.04),
    ("Table 1: comparing the optimisers", 0.48),
    ("Table 2 and Eq. 13: identifying by DE-ABC", 0.36),
    ("Table 3: identifying by least squares", 0.04),
    ("recovering Table 2 and Eq. 13", 0.08),
];

/// A stage of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    Bench,
    Optimizers,
    Colony,
    LeastSquares,
    Recovery,
}

pub(super) struct Stages<'a, 'w> {
    watch: &'a Watch<'w>,
}

impl<'a, 'w> Stages<'a, 'w> {
    pub(super) fn new(watch: &'a Watch<'w>) -> Self {
        Self { watch }
    }

    pub(super) fn stop(&self) -> &Stop {
        self.watch.stop()
    }

    /// The share `within` (0 … 1) of a stage is done; `detail` says with what.
    pub(super) fn at(&self, stage: Stage, within: f64, detail: &str) -> ControlFlow<()> {
        let index = stage as usize;
        let before: f64 = WEIGHTS[..index].iter().map(|(_, weight)| weight).sum();
        let (name, weight) = WEIGHTS[index];
        let done = before + weight * within.clamp(0.0, 1.0);
        let stage = if detail.is_empty() { name.to_owned() } else { format!("{name} ({detail})") };
        self.watch.tell(Event::new(&stage, done, None))
    }

    /// [`Self::at`], with a stop as an error.
    pub(super) fn check(&self, stage: Stage, within: f64, detail: &str) -> Result<(), ArticleError> {
        if self.at(stage, within, detail).is_break() { Err(ArticleError::Stopped) } else { Ok(()) }
    }
}
