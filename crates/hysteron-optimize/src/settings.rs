//! Limits and starts of a run.

use super::OptimizeError;
use serde::{Deserialize, Serialize};

/// Seed, limits and starts of a run; the same for every algorithm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Seed of every random number.
    pub seed: u64,
    /// Generations after the initial population (the article's *Iter*, Eq. 9). Ignored by least squares,
    /// which has separate limits ([`LeastSquaresOptions`](super::LeastSquaresOptions)).
    pub generations: usize,
    /// Most cost evaluations; a generation that would pass it is cut short.
    pub budget: Option<usize>,
    /// Stop once the best cost is at or below this.
    pub target: Option<f64>,
    /// Stop once the best cost stagnates.
    pub stagnation: Option<Stagnation>,
    /// Points to begin with, in the problem's own units (clipped to the box): the first members of a
    /// population, the first starts of least squares.
    pub starts: Vec<Vec<f64>>,
    /// Threads to evaluate with; `None`: those of the current `rayon` pool. The result does not depend on it,
    /// and a checkpoint does not record it.
    #[serde(skip)]
    pub threads: Option<usize>,
}

/// The best cost J has stagnated when J(g − generations) − J(g) ≤ relative · J(g − generations).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stagnation {
    /// Length of the window, in generations.
    pub generations: usize,
    /// Smallest relative improvement over the window that is not stagnation.
    pub relative: f64,
}

impl Default for Settings {
    /// Seed 1, 150 generations (the article's number), no other limit.
    fn default() -> Self {
        Self {
            seed: 1,
            generations: 150,
            budget: None,
            target: None,
            stagnation: None,
            starts: Vec::new(),
            threads: None,
        }
    }
}

impl Settings {
    pub(super) fn validate(&self, parameters: usize) -> Result<(), OptimizeError> {
        let option = |option, value, wanted| Err(OptimizeError::Option { option, value, wanted });
        if self.generations == 0 {
            return option("generations", 0.0, "at least 1");
        }
        if self.budget == Some(0) {
            return option("budget", 0.0, "at least 1 evaluation");
        }
        if self.threads == Some(0) {
            return option("threads", 0.0, "at least 1");
        }
        if let Some(target) = self.target.filter(|target| !target.is_finite()) {
            return option("target", target, "a finite cost");
        }
        if let Some(stagnation) = self.stagnation {
            if stagnation.generations == 0 {
                return option("stagnation.generations", 0.0, "at least 1");
            }
            if !(0.0..1.0).contains(&stagnation.relative) {
                return option("stagnation.relative", stagnation.relative, "0 ≤ relative < 1");
            }
        }
        for (index, start) in self.starts.iter().enumerate() {
            if start.len() != parameters || start.iter().any(|x| !x.is_finite()) {
                return Err(OptimizeError::Start { index, parameters, found: start.clone() });
            }
        }
        Ok(())
    }
}
