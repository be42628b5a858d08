//! Differential evolution rand/1/bin, Storn and Price 1997, doi:10.1023/A:1008202821328.
//!
//! For each member i, three others r₁, r₂, r₃, all different, make v = x_r₁ + F (x_r₂ − x_r₃); the trial
//! takes each component from v with probability CR, one for certain, the others from x_i; clipped to the box.
//! It replaces the member if it is not worse. A generation proposes all, evaluates all, then accepts.

use super::OptimizeError;
use super::algorithm::{check_option, check_population};
use super::infinite_as_null;
use super::ledger::{Scratch, Search};
use super::points::Points;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Options of differential evolution.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DeOptions {
    /// Members, at least 4.
    pub population: usize,
    /// Mutation factor F, 0 < F ≤ 2.
    pub factor: f64,
    /// Crossover probability CR in [0, 1].
    pub crossover: f64,
}

impl Default for DeOptions {
    /// 50 members, F = 0.5, CR = 0.9.
    fn default() -> Self {
        Self { population: 50, factor: 0.5, crossover: 0.9 }
    }
}

impl DeOptions {
    pub(super) fn validate(&self) -> Result<(), OptimizeError> {
        check_population(self.population, 4, "at least 4 members, for three partners")?;
        check_option("factor", self.factor, self.factor > 0.0 && self.factor <= 2.0, "0 < F ≤ 2")?;
        check_option("crossover", self.crossover, (0.0..=1.0).contains(&self.crossover), "0 ≤ CR ≤ 1")
    }
}

/// Population of differential evolution.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Members {
    points: Points,
    #[serde(with = "infinite_as_null::many")]
    costs: Vec<f64>,
}

impl Members {
    pub(super) fn new(options: &DeOptions, search: &mut Search<'_>) -> Self {
        let (points, costs) = search.initial_population(options.population);
        Self { points, costs }
    }

    pub(super) fn is_consistent(&self, population: usize, dimension: usize) -> bool {
        self.points.are_in_unit_box(population, dimension) && self.costs.len() == population
    }
}

/// One generation.
pub(super) fn generation(
    options: &DeOptions,
    members: &mut Members,
    search: &mut Search<'_>,
    scratch: &mut Scratch,
) {
    scratch.clear();
    let count = members.costs.len();
    for i in 0..count {
        let mut random = search.stream();
        let r1 = random.index_except(count, &[i]);
        let r2 = random.index_except(count, &sorted([i, r1]));
        let r3 = random.index_except(count, &sorted([i, r1, r2]));
        let (base, plus, minus) = (members.points.get(r1), members.points.get(r2), members.points.get(r3));
        let trial = scratch.candidates.push(members.points.get(i));
        let forced = random.index(trial.len());
        for j in 0..trial.len() {
            if random.unit() < options.crossover || j == forced {
                trial[j] = (base[j] + options.factor * (plus[j] - minus[j])).clamp(0.0, 1.0);
            }
        }
    }
    search.evaluate(&mut scratch.candidates, &mut scratch.costs);
    for (i, &cost) in scratch.costs.iter().enumerate() {
        if cost <= members.costs[i] {
            members.points.get_mut(i).copy_from_slice(scratch.candidates.get(i));
            members.costs[i] = cost;
        }
    }
}

fn sorted<const N: usize>(mut indices: [usize; N]) -> [usize; N] {
    indices.sort_unstable();
    indices
}
