//! Artificial bee colony, Karaboga and Basturk 2007, doi:10.1007/s10898-007-9149-x.
//!
//! Employed bees and onlookers (roulette on 1/(1 + J)) move one random component, v_j = x_j + φ (x_j − x_kj)
//! with φ uniform in [−1, 1] and a random partner k ≠ i; clipped to the box, accepted if better. A source
//! with more failures than its limit is replaced by a random one, at most one per generation. Phases propose
//! all, evaluate all, then accept in index order. A generation costs 2·SN evaluations, and one more with a
//! scout.

use super::OptimizeError;
use super::algorithm::check_population;
use super::colony::{Colony, Owners};
use super::ledger::{Scratch, Search};
use super::stream::Stream;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Options of the artificial bee colony.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AbcOptions {
    /// Food sources SN, at least 2.
    pub population: usize,
    /// Failures of a source after which a random one replaces it; `None`: SN·D.
    pub limit: Option<usize>,
}

impl Default for AbcOptions {
    /// SN = 25, limit SN·D.
    fn default() -> Self {
        Self { population: 25, limit: None }
    }
}

impl AbcOptions {
    pub(super) fn validate(&self) -> Result<(), OptimizeError> {
        check_population(self.population, 2, "at least 2 sources, for a partner")
    }
}

/// One generation: employed bees, onlookers, scout.
pub(super) fn generation(
    options: &AbcOptions,
    colony: &mut Colony,
    search: &mut Search<'_>,
    scratch: &mut Scratch,
) {
    let perturb = |colony: &Colony, i: usize, random: &mut Stream, candidate: &mut [f64]| {
        let k = random.index_except(colony.costs.len(), &[i]);
        let j = random.index(candidate.len());
        let step = random.symmetric() * (candidate[j] - colony.sources.get(k)[j]);
        candidate[j] = (candidate[j] + step).clamp(0.0, 1.0);
    };
    colony.phase(Owners::Each, search, scratch, perturb);
    colony.phase(Owners::Roulette, search, scratch, perturb);
    let limit = options.limit.unwrap_or(options.population * search.dimension());
    if let Some(i) = colony.most_exhausted(limit, None) {
        scratch.clear();
        let mut random = search.stream();
        scratch.candidates.push(colony.sources.get(i)).iter_mut().for_each(|t| *t = random.unit());
        search.evaluate(&mut scratch.candidates, &mut scratch.costs);
        if let Some(&cost) = scratch.costs.first() {
            colony.replace(i, scratch.candidates.get(0), cost);
            colony.scouts_fired += 1;
        }
    }
}
