//! Common parts of the two bee colonies: food sources, acceptance, roulette and exhaustion.

use super::infinite_as_null;
use super::ledger::{Scratch, Search};
use super::points::Points;
use super::stream::Stream;
use serde::{Deserialize, Serialize};

/// Food sources of a bee colony.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Colony {
    pub(super) sources: Points,
    #[serde(with = "infinite_as_null::many")]
    pub(super) costs: Vec<f64>,
    /// Consecutive failures of each source.
    pub(super) trials: Vec<usize>,
    pub(super) scouts_fired: usize,
}

impl Colony {
    pub(super) fn new(population: usize, search: &mut Search<'_>) -> Self {
        let (sources, costs) = search.initial_population(population);
        Self { sources, costs, trials: vec![0; population], scouts_fired: 0 }
    }

    pub(super) fn is_consistent(&self, population: usize, dimension: usize) -> bool {
        self.sources.are_in_unit_box(population, dimension)
            && self.costs.len() == population
            && self.trials.len() == population
    }

    /// Proposes for each owner in turn, evaluates all proposals, accepts in index order.
    /// `propose(colony, i, random, candidate)` changes `candidate`, which comes as a copy of source i.
    pub(super) fn phase(
        &mut self,
        owners: Owners,
        search: &mut Search<'_>,
        scratch: &mut Scratch,
        propose: impl Fn(&Self, usize, &mut Stream, &mut [f64]),
    ) {
        scratch.clear();
        let total = match owners {
            Owners::Each => 0.0,
            Owners::Roulette => self.fill_wheel(&mut scratch.weights),
        };
        for i in 0..self.costs.len() {
            let mut random = search.stream();
            let owner = match owners {
                Owners::Each => i,
                Owners::Roulette => spin(&scratch.weights, random.unit() * total),
            };
            let candidate = scratch.candidates.push(self.sources.get(owner));
            propose(self, owner, &mut random, candidate);
            scratch.owners.push(owner);
        }
        search.evaluate(&mut scratch.candidates, &mut scratch.costs);
        for (c, (&owner, &cost)) in scratch.owners.iter().zip(&scratch.costs).enumerate() {
            if cost < self.costs[owner] {
                self.replace(owner, scratch.candidates.get(c), cost);
            } else {
                self.trials[owner] += 1;
            }
        }
    }

    /// Replaces source i and resets its counter.
    pub(super) fn replace(&mut self, i: usize, point: &[f64], cost: f64) {
        self.sources.get_mut(i).copy_from_slice(point);
        self.costs[i] = cost;
        self.trials[i] = 0;
    }

    /// Source with the largest counter above `limit` (the first of equals), other than `spared`.
    pub(super) fn most_exhausted(&self, limit: usize, spared: Option<usize>) -> Option<usize> {
        let mut worst = None;
        for (i, &trials) in self.trials.iter().enumerate() {
            if trials > limit && Some(i) != spared && worst.is_none_or(|w: usize| trials > self.trials[w]) {
                worst = Some(i);
            }
        }
        worst
    }

    /// Source of the least cost, the first of equals.
    pub(super) fn best(&self) -> Option<usize> {
        (0..self.costs.len()).min_by(|&i, &j| self.costs[i].total_cmp(&self.costs[j]))
    }

    /// Roulette weights 1/(1 + J), uniform where every J is infinite; returns their sum.
    fn fill_wheel(&self, weights: &mut Vec<f64>) -> f64 {
        weights.clear();
        weights.extend(self.costs.iter().map(|&cost| 1.0 / (1.0 + cost.max(0.0))));
        let total: f64 = weights.iter().sum();
        if total > 0.0 {
            return total;
        }
        weights.fill(1.0);
        weights.len() as f64
    }
}

/// Assignment of the bees of a phase to sources.
#[derive(Clone, Copy)]
pub(super) enum Owners {
    /// Employed bees: one each.
    Each,
    /// Onlookers: drawn in proportion to 1/(1 + J).
    Roulette,
}

/// Index selected by the pointer, 0 ≤ pointer < Σ weights; never a source of weight zero.
fn spin(weights: &[f64], mut pointer: f64) -> usize {
    let mut last = 0;
    for (i, &weight) in weights.iter().enumerate() {
        if weight > 0.0 {
            last = i;
            if pointer < weight {
                return i;
            }
            pointer -= weight;
        }
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;

    fn colony(costs: &[f64], trials: &[usize]) -> Colony {
        let mut sources = Points::new(1);
        costs.iter().for_each(|_| {
            sources.push(&[0.5]);
        });
        Colony { sources, costs: costs.to_vec(), trials: trials.to_vec(), scouts_fired: 0 }
    }

    #[test]
    fn wheel_has_shares_of_one_over_one_plus_cost() {
        let mut weights = Vec::new();
        let total = colony(&[0.0, 1.0, f64::INFINITY, 3.0], &[0; 4]).fill_wheel(&mut weights);
        assert_eq!((weights.as_slice(), total), (&[1.0, 0.5, 0.0, 0.25][..], 1.75));
        assert_eq!(spin(&weights, 0.0), 0);
        assert_eq!(spin(&weights, 1.0), 1);
        assert_eq!(spin(&weights, 1.5), 3);
        assert_eq!(spin(&weights, 1.75), 3);
    }

    #[test]
    fn wheel_is_uniform_where_every_cost_is_infinite() {
        let mut weights = Vec::new();
        assert_eq!(colony(&[f64::INFINITY; 3], &[0; 3]).fill_wheel(&mut weights), 3.0);
        assert_eq!(spin(&weights, 2.5), 2);
    }

    #[test]
    fn most_exhausted_source_is_strictly_above_the_limit_and_not_the_spared_one() {
        let colony = colony(&[1.0, 0.5, 2.0, 3.0], &[4, 9, 7, 7]);
        assert_eq!(colony.best(), Some(1));
        assert_eq!(colony.most_exhausted(6, None), Some(1));
        assert_eq!(colony.most_exhausted(6, Some(1)), Some(2));
        assert_eq!(colony.most_exhausted(7, Some(1)), None);
    }
}
