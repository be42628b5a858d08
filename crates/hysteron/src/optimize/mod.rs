//! Bounded global and local optimisation: seeded, identical for any number of threads, observable, resumable.

use std::ops::ControlFlow;

/// A function to be minimised over a box.
///
/// `x` is in the problem's own units; scaling to the unit box is the optimiser's business ([`Bounds`]).
pub trait Problem: Sync {
    /// Scratch buffers of one evaluating thread: an evaluation allocates nothing.
    type Workspace: Send;

    /// The search box.
    fn bounds(&self) -> &Bounds;
    /// Fresh scratch buffers.
    fn workspace(&self) -> Self::Workspace;
    /// Cost at `x`; anything not finite counts as +∞ and never wins.
    fn cost(&self, x: &[f64], workspace: &mut Self::Workspace) -> f64;
}

/// A [`Problem`] whose cost is the root mean square of a residual vector.
pub trait LeastSquaresProblem: Problem {
    /// Number of residuals.
    fn residual_count(&self) -> usize;
    /// Residuals at `x` into `out` (length [`Self::residual_count`]); `false` where the model cannot be simulated.
    fn residuals(&self, x: &[f64], workspace: &mut Self::Workspace, out: &mut [f64]) -> bool;
}

/// Search box, one entry a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// The parameters' ranges.
    pub ranges: Vec<Range>,
}

/// Range of one parameter; `low < high`, both finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// Name, for messages and checkpoints.
    pub name: String,
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
    /// Scaled logarithmically onto [0, 1] (needs `low > 0`).
    pub logarithmic: bool,
}

/// Told about progress once a generation (or iteration); may stop the run, whose best so far is kept.
pub trait Observer {
    /// One generation is done.
    fn generation(&mut self, progress: &Progress<'_>) -> ControlFlow<()>;
}

/// State of a run after a generation.
#[derive(Clone, Debug)]
pub struct Progress<'a> {
    /// Generations done, from 1 (0: initial population).
    pub generation: usize,
    /// Generations planned.
    pub generations: usize,
    /// Cost evaluations so far.
    pub evaluations: usize,
    /// Best cost so far.
    pub best_cost: f64,
    /// Best parameters so far.
    pub best: &'a [f64],
}
