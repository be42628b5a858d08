//! The operator of `hysteron-rt` that runs a family, in its numbers.

use hysteron_rt::{Branch, Sides};

/// An operator of the runtime.
#[derive(Clone, Debug, PartialEq)]
pub enum RuntimeOperator {
    /// States of Bouc–Wen: α, β, γ, n of each.
    BoucWen(Vec<[f64; 4]>),
    /// One law on each branch.
    Branch {
        /// The law.
        law: Branch<f64>,
        /// Weights of its states.
        weights: Vec<f64>,
    },
    /// Plays.
    Plays {
        /// Half-widths \[V\].
        thresholds: Vec<f64>,
        /// Weights.
        weights: Vec<f64>,
    },
    /// Plays between other sides, with a broken line of their mean where it has slopes.
    SidedPlays {
        /// Their sides.
        sides: Sides<f64>,
        /// Thresholds, or the lines of their ramps.
        thresholds: Vec<f64>,
        /// Weights.
        weights: Vec<f64>,
        /// The broken line.
        line: MeanLine<f64>,
    },
    /// Plays with thermally activated edges.
    ActivatedPlays {
        /// Activation \[V\].
        sigma: f64,
        /// Time between samples \[s\].
        interval_s: f64,
        /// Ends of the range of their slopes \[V\].
        range: [f64; 2],
        /// Half-widths \[V\].
        thresholds: Vec<f64>,
        /// Slopes, three a play.
        slopes: Vec<f64>,
    },
    /// A plane of relays.
    Plane {
        /// Lowest and highest level \[V\].
        range: [f64; 2],
        /// Intervals between levels.
        intervals: usize,
        /// Weights of the cells (0, 0), (1, 0), (1, 1), (2, 0), ….
        cells: Vec<f64>,
    },
}

/// A broken line of the mean of plays; none without slopes.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanLine<T> {
    /// Shares of the plays in the mean.
    pub shares: Vec<T>,
    /// Corners \[V\].
    pub corners: Vec<T>,
    /// Slopes \[µm/V\], one more.
    pub slopes: Vec<T>,
}

impl<T> MeanLine<T> {
    pub(in crate::hysteresis) fn none() -> Self {
        Self { shares: Vec::new(), corners: Vec::new(), slopes: Vec::new() }
    }

    /// The line in another type of numbers.
    pub(crate) fn map<U>(self, of: impl Fn(T) -> U) -> MeanLine<U> {
        let all = |numbers: Vec<T>| numbers.into_iter().map(&of).collect();
        MeanLine { shares: all(self.shares), corners: all(self.corners), slopes: all(self.slopes) }
    }
}

impl RuntimeOperator {
    pub(in crate::hysteresis) fn branch(law: Branch<f64>, weights: &[f64]) -> Self {
        Self::Branch { law, weights: weights.to_vec() }
    }

    pub(in crate::hysteresis) fn sided(sides: Sides<f64>, thresholds: Vec<f64>, weights: &[f64]) -> Self {
        Self::SidedPlays { sides, thresholds, weights: weights.to_vec(), line: MeanLine::none() }
    }
}
