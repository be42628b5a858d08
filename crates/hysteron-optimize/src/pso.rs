//! Particle swarm with constriction coefficients, Clerc and Kennedy 2002, doi:10.1109/4235.985692.
//!
//! v ← w v + c₁ r₁ (p_i − x) + c₂ r₂ (g − x) with r₁, r₂ uniform in [0, 1) for each component, p_i the
//! particle's best and g the swarm's best of the previous generation; |v| is clamped, x ← x + v. A particle
//! that would leave the box stops at the bound, with that velocity component 0. A generation moves all,
//! evaluates all, then updates the bests.

use super::OptimizeError;
use super::algorithm::{check_option, check_population};
use super::infinite_as_null;
use super::ledger::{Scratch, Search};
use super::points::Points;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Options of the particle swarm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PsoOptions {
    /// Particles, at least 1.
    pub population: usize,
    /// Inertia w, 0 ≤ w < 1.
    pub inertia: f64,
    /// Attraction c₁ to the particle's own best, ≥ 0.
    pub cognitive: f64,
    /// Attraction c₂ to the swarm's best, ≥ 0.
    pub social: f64,
    /// Largest step of a component as a fraction of the box, 0 < clamp ≤ 1.
    pub velocity_clamp: f64,
}

impl Default for PsoOptions {
    /// 50 particles, w = 0.7298, c₁ = c₂ = 1.49618, velocity clamp 0.5.
    fn default() -> Self {
        Self { population: 50, inertia: 0.7298, cognitive: 1.49618, social: 1.49618, velocity_clamp: 0.5 }
    }
}

impl PsoOptions {
    pub(super) fn validate(&self) -> Result<(), OptimizeError> {
        check_population(self.population, 1, "at least 1 particle")?;
        let clamp = self.velocity_clamp;
        check_option("inertia", self.inertia, (0.0..1.0).contains(&self.inertia), "0 ≤ w < 1")?;
        for (option, value) in [("cognitive", self.cognitive), ("social", self.social)] {
            check_option(option, value, value >= 0.0 && value.is_finite(), "at least 0")?;
        }
        check_option("velocity_clamp", clamp, clamp > 0.0 && clamp <= 1.0, "0 < clamp ≤ 1")
    }
}

/// Particles with their velocities and own bests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Swarm {
    positions: Points,
    /// Each component within ± the clamp.
    velocities: Points,
    own_best: Points,
    #[serde(with = "infinite_as_null::many")]
    own_costs: Vec<f64>,
}

impl Swarm {
    pub(super) fn new(options: &PsoOptions, search: &mut Search<'_>) -> Self {
        let (positions, own_costs) = search.initial_population(options.population);
        let mut velocities = positions.clone();
        for i in 0..velocities.len() {
            let mut random = search.stream();
            let clamp = options.velocity_clamp;
            velocities.get_mut(i).iter_mut().for_each(|v| *v = clamp * random.symmetric());
        }
        Self { own_best: positions.clone(), positions, velocities, own_costs }
    }

    pub(super) fn is_consistent(&self, population: usize, dimension: usize) -> bool {
        self.positions.are_in_unit_box(population, dimension)
            && self.own_best.are_in_unit_box(population, dimension)
            && self.velocities.are_within(1.0, population, dimension)
            && self.own_costs.len() == population
    }
}

/// One generation.
pub(super) fn generation(
    options: &PsoOptions,
    swarm: &mut Swarm,
    search: &mut Search<'_>,
    scratch: &mut Scratch,
) {
    scratch.clear();
    for i in 0..swarm.own_costs.len() {
        let mut random = search.stream();
        let position = scratch.candidates.push(swarm.positions.get(i));
        let own_best = swarm.own_best.get(i);
        for (j, v) in swarm.velocities.get_mut(i).iter_mut().enumerate() {
            let (r1, r2) = (random.unit(), random.unit());
            let own = options.cognitive * r1 * (own_best[j] - position[j]);
            let social = options.social * r2 * (search.ledger.best[j] - position[j]);
            let step = options.inertia * *v + own + social;
            *v = step.clamp(-options.velocity_clamp, options.velocity_clamp);
            let moved = position[j] + *v;
            position[j] = moved.clamp(0.0, 1.0);
            if position[j] != moved {
                *v = 0.0;
            }
        }
        swarm.positions.get_mut(i).copy_from_slice(position);
    }
    search.evaluate(&mut scratch.candidates, &mut scratch.costs);
    for (i, &cost) in scratch.costs.iter().enumerate() {
        if cost < swarm.own_costs[i] {
            swarm.own_best.get_mut(i).copy_from_slice(scratch.candidates.get(i));
            swarm.own_costs[i] = cost;
        }
    }
}
