//! DE-ABC: the article's bee colony with differential mutation and chaotic scout, Eqs. 8–12 and Fig. 4.
//!
//! One generation of SN food sources, on the unit box; F is fixed at its beginning, x_best at the beginning
//! of each phase. (With x_best of the previous generation for the onlookers too, fewer runs succeed: on the
//! static problem of `hysteron_article::optimizer_study` 96.8 % instead of 99.0 % of 310 seeds, at the same
//! number of evaluations.)
//! 1. *Employed bees*, one a source: x' = x_best + F (x_i − x_k) with a random partner k ≠ i (Eq. 8) and F =
//!    1 − iter/Iter (Eq. 9; iter counts from 0, so F falls from 1 to 1/Iter). Clipped to the box; accepted if
//!    better, else the source's counter goes up.
//! 2. *Onlookers*: SN draws by roulette on 1/(1 + J), the same equation, the same acceptance.
//! 3. *Scout*: at most one a generation, for the source with the largest counter above L, never the best one:
//!    K points of a chaotic search (Eqs. 10–12), counter back to 0.
//!
//! A phase proposes all, evaluates all, then accepts in index order. So a generation costs 2·SN evaluations,
//! and K more with a scout. The article changes one random component, which fails ([`MovedComponents`]).

use super::algorithm::{check_option, check_population};
use super::colony::{Colony, Owners};
use super::ledger::{Scratch, Search};
use super::stream::Stream;
use super::{OptimizeError, Settings};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Options of DE-ABC.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DeAbcOptions {
    /// Food sources SN, at least 2.
    pub population: usize,
    /// Components that Eq. 8 moves.
    pub moved: MovedComponents,
    /// Failures L of a source that trigger the scout; `None`: SN·D.
    pub limit: Option<usize>,
    /// Action of the scout.
    pub scout: Scout,
}

/// Components changed by Eq. 8; the others stay those of x_i.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MovedComponents {
    /// One random component: the article's wording (j selected randomly). This fails for correlated
    /// parameters.
    One,
    /// Each with this probability, at least one.
    Binomial {
        /// Probability, 0 < rate ≤ 1.
        rate: f64,
    },
    /// All of them.
    #[default]
    All,
}

/// Action of the scout on an exhausted source.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scout {
    /// Nothing: no scout.
    Off,
    /// Replaces it by a uniformly random source, as in the standard bee colony. One evaluation.
    Random,
    /// Chaotic search around it.
    Chaotic {
        /// Number K of points.
        iterates: usize,
        /// Interpretation of Eq. 12.
        chaos: Chaos,
        /// Candidates to replace the source.
        keeps: ScoutKeeps,
    },
}

/// Interpretation of Eq. 12, x' = x_i + c (x_max − x_min), which as printed only increases and leaves the
/// box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Chaos {
    /// As printed, wrapped around into the box.
    #[default]
    Wrap,
    /// x' = x_min + c (x_max − x_min): the chaotic variable mapped onto the box.
    ChaoticMap,
}

/// Candidates to replace an exhausted source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ScoutKeeps {
    /// The best of the chaotic points and of the source itself (the article).
    #[default]
    Best,
    /// The best of the chaotic points, even if worse than the source.
    Replacement,
}

impl Default for DeAbcOptions {
    /// SN = 25, all components moved, L = SN·D, ten chaotic points wrapped into the box, the best kept.
    fn default() -> Self {
        let scout = Scout::Chaotic { iterates: 10, chaos: Chaos::Wrap, keeps: ScoutKeeps::Best };
        Self { population: 25, moved: MovedComponents::All, limit: None, scout }
    }
}

impl DeAbcOptions {
    pub(super) fn validate(&self) -> Result<(), OptimizeError> {
        check_population(self.population, 2, "at least 2 sources, for a partner")?;
        if let MovedComponents::Binomial { rate } = self.moved {
            check_option("moved.binomial.rate", rate, rate > 0.0 && rate <= 1.0, "0 < rate ≤ 1")?;
        }
        if let Scout::Chaotic { iterates, .. } = self.scout {
            check_option("scout.chaotic.iterates", iterates as f64, iterates > 0, "at least 1")?;
        }
        Ok(())
    }
}

/// One generation: employed bees, onlookers, scout.
pub(super) fn generation(
    options: &DeAbcOptions,
    colony: &mut Colony,
    search: &mut Search<'_>,
    scratch: &mut Scratch,
) {
    let factor = mutation_factor(search.ledger.generation, search.settings);
    let mutate = |best: &[f64], colony: &Colony, i: usize, random: &mut Stream, candidate: &mut [f64]| {
        let k = random.index_except(colony.costs.len(), &[i]);
        let (own, partner) = (colony.sources.get(i), colony.sources.get(k));
        let forced = match options.moved {
            MovedComponents::All => 0,
            MovedComponents::One | MovedComponents::Binomial { .. } => random.index(candidate.len()),
        };
        for j in 0..candidate.len() {
            let moves = match options.moved {
                MovedComponents::All => true,
                MovedComponents::One => j == forced,
                MovedComponents::Binomial { rate } => random.unit() < rate || j == forced,
            };
            if moves {
                candidate[j] = (best[j] + factor * (own[j] - partner[j])).clamp(0.0, 1.0);
            }
        }
    };
    for owners in [Owners::Each, Owners::Roulette] {
        let best = search.ledger.best.clone();
        colony.phase(owners, search, scratch, |colony, i, random, candidate| {
            mutate(&best, colony, i, random, candidate);
        });
    }
    if options.scout != Scout::Off {
        let limit = options.limit.unwrap_or(options.population * search.dimension());
        if let Some(i) = colony.most_exhausted(limit, colony.best()) {
            send_scout(options.scout, i, colony, search, scratch);
        }
    }
}

/// F = 1 − iter/Iter (Eq. 9).
fn mutation_factor(generation: usize, settings: &Settings) -> f64 {
    1.0 - generation as f64 / settings.generations as f64
}

fn send_scout(scout: Scout, i: usize, colony: &mut Colony, search: &mut Search<'_>, scratch: &mut Scratch) {
    scratch.clear();
    let mut random = search.stream();
    let keeps = match scout {
        Scout::Off => return,
        Scout::Random => {
            scratch.candidates.push(colony.sources.get(i)).iter_mut().for_each(|t| *t = random.unit());
            ScoutKeeps::Replacement
        }
        Scout::Chaotic { iterates, chaos, keeps } => {
            let source = colony.sources.get(i);
            let mut c: Vec<f64> = source.iter().map(|&t| chaotic_start(t, &mut random)).collect();
            for _ in 0..iterates {
                let candidate = scratch.candidates.push(source);
                for (t, c) in candidate.iter_mut().zip(&mut c) {
                    *c = logistic(*c);
                    *t = match chaos {
                        Chaos::Wrap => wrap(*t + *c),
                        Chaos::ChaoticMap => *c,
                    };
                }
            }
            keeps
        }
    };
    search.evaluate(&mut scratch.candidates, &mut scratch.costs);
    colony.scouts_fired += 1;
    colony.trials[i] = 0;
    let found = (0..scratch.costs.len()).min_by(|&a, &b| scratch.costs[a].total_cmp(&scratch.costs[b]));
    if let Some(found) = found {
        let cost = scratch.costs[found];
        if keeps == ScoutKeeps::Replacement || cost < colony.costs[i] {
            colony.replace(i, scratch.candidates.get(found), cost);
        }
    }
}

/// C⁰ (Eq. 11), which on the unit box is the coordinate itself; a random number where the logistic map would
/// reach a fixed point.
fn chaotic_start(coordinate: f64, random: &mut Stream) -> f64 {
    let mut c = coordinate;
    while [0.0, 0.25, 0.5, 0.75, 1.0].contains(&c) {
        c = random.unit();
    }
    c
}

/// The logistic map, Eq. 10.
fn logistic(c: f64) -> f64 {
    4.0 * c * (1.0 - c)
}

/// Wraps a coordinate in [0, 2] into the box.
fn wrap(t: f64) -> f64 {
    if t > 1.0 { t - 1.0 } else { t }
}

#[cfg(test)]
mod tests;
