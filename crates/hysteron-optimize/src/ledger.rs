//! Records of a run: evaluations, best point, history.

use super::points::Points;
use super::stream::Stream;
use super::{Bounds, Settings, evaluate::Evaluate, infinite_as_null};
use serde::{Deserialize, Serialize};

/// Best cost after a generation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GenerationRecord {
    /// Generations done (0: the initial population).
    pub generation: usize,
    /// Cost evaluations so far.
    pub evaluations: usize,
    /// Best cost so far; +∞ (`null` in JSON) while no candidate could be simulated.
    #[serde(with = "infinite_as_null::one")]
    pub best_cost: f64,
}

/// One improvement of the best cost.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Improvement {
    /// Number of the evaluation that made it, from 1.
    pub evaluation: usize,
    /// The new best cost.
    pub cost: f64,
}

/// State common to all algorithms: counts, best point, history, position in the random streams.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Ledger {
    pub(super) generation: usize,
    pub(super) evaluations: usize,
    pub(super) next_stream: u64,
    /// In the unit box.
    pub(super) best: Vec<f64>,
    #[serde(with = "infinite_as_null::one")]
    pub(super) best_cost: f64,
    pub(super) improvements: Vec<Improvement>,
    pub(super) history: Vec<GenerationRecord>,
}

impl Ledger {
    pub(super) fn new(dimension: usize) -> Self {
        Self {
            generation: 0,
            evaluations: 0,
            next_stream: 0,
            best: vec![0.5; dimension],
            best_cost: f64::INFINITY,
            improvements: Vec::new(),
            history: Vec::new(),
        }
    }

    /// Counts one evaluation, and keeps the point if it is the best so far.
    pub(super) fn count(&mut self, point: &[f64], cost: f64) {
        self.evaluations += 1;
        if cost < self.best_cost {
            self.best_cost = cost;
            self.best.copy_from_slice(point);
            self.improvements.push(Improvement { evaluation: self.evaluations, cost });
        }
    }

    /// Prefers `point` among points of equal cost: a descent step may be below the rounding of the cost.
    pub(super) fn prefer(&mut self, point: &[f64], cost: f64) {
        if cost <= self.best_cost {
            self.best.copy_from_slice(point);
        }
    }

    /// Evaluations left of the budget.
    pub(super) fn remaining(&self, settings: &Settings) -> usize {
        settings.budget.map_or(usize::MAX, |budget| budget.saturating_sub(self.evaluations))
    }

    pub(super) fn close_generation(&mut self) {
        self.history.push(GenerationRecord {
            generation: self.generation,
            evaluations: self.evaluations,
            best_cost: self.best_cost,
        });
    }

    /// Next candidate's random stream.
    pub(super) fn stream(&mut self, settings: &Settings) -> Stream {
        let stream = Stream::new(settings.seed, self.next_stream);
        self.next_stream += 1;
        stream
    }
}

/// Buffers of a generation: proposals, their costs, and their members.
#[derive(Default)]
pub(super) struct Scratch {
    pub(super) candidates: Points,
    pub(super) costs: Vec<f64>,
    pub(super) owners: Vec<usize>,
    pub(super) weights: Vec<f64>,
}

impl Scratch {
    pub(super) fn new(dimension: usize) -> Self {
        Self { candidates: Points::new(dimension), ..Self::default() }
    }

    /// Clears the proposals of the last phase.
    pub(super) fn clear(&mut self) {
        self.candidates.clear();
        self.owners.clear();
    }
}

/// A population method's view of its run.
pub(super) struct Search<'a> {
    pub(super) ledger: &'a mut Ledger,
    pub(super) settings: &'a Settings,
    pub(super) bounds: &'a Bounds,
    pub(super) evaluator: &'a mut dyn Evaluate,
}

impl Search<'_> {
    pub(super) fn dimension(&self) -> usize {
        self.bounds.dimension()
    }

    pub(super) fn stream(&mut self) -> Stream {
        self.ledger.stream(self.settings)
    }

    /// Evaluates as many candidates as the budget allows and counts them in index order; `costs` has one
    /// entry for each.
    pub(super) fn evaluate(&mut self, candidates: &mut Points, costs: &mut Vec<f64>) {
        candidates.truncate(self.ledger.remaining(self.settings).min(candidates.len()));
        self.evaluator.costs(candidates, costs);
        for (i, &cost) in costs.iter().enumerate() {
            self.ledger.count(candidates.get(i), cost);
        }
    }

    /// Initial population: the given starts, then points drawn uniformly, with their costs (+∞ beyond the
    /// budget).
    pub(super) fn initial_population(&mut self, count: usize) -> (Points, Vec<f64>) {
        let mut points = Points::new(self.dimension());
        let origin = vec![0.0; self.dimension()];
        for start in self.settings.starts.iter().take(count) {
            self.bounds.to_unit(start, points.push(&origin));
        }
        while points.len() < count {
            let mut stream = self.stream();
            points.push(&origin).iter_mut().for_each(|t| *t = stream.unit());
        }
        let (mut evaluated, mut costs) = (points.clone(), Vec::new());
        self.evaluate(&mut evaluated, &mut costs);
        costs.resize(count, f64::INFINITY);
        (points, costs)
    }
}
