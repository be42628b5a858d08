//! Optimisers in the comparison.

use hysteron_optimize::{
    AbcOptions, Algorithm, CmaEsOptions, DeAbcOptions, DeOptions, LeastSquaresOptions, MovedComponents,
    Observer, OptimizeError, Outcome, PsoOptions, Scout, Settings, minimize,
};
use hysteron_optimize::{LeastSquaresProblem, StopReason};
use serde::{Deserialize, Serialize};

/// Evaluations of a generation of every population method of a fixed size.
pub(super) const GENERATION: usize = 50;
/// Limit at which the scout of the early variants fires; the default, SN·D = 125, is rarely reached.
const EAGER_LIMIT: usize = 10;
/// Share of the budget that the hybrid gives to DE-ABC.
const GLOBAL_SHARE: f64 = 0.05;

/// One row of the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Competitor {
    /// DE-ABC as interpreted here: all components moved, chaotic scout, L = SN·D.
    DeAbc,
    /// DE-ABC by the article's wording: one random component moved.
    DeAbcOneDimension,
    /// DE-ABC without the scout.
    DeAbcNoScout,
    /// DE-ABC with a limit so low (10) that the chaotic scout fires.
    DeAbcEagerScout,
    /// DE-ABC with that limit and a random scout instead of the chaotic one.
    DeAbcEagerRandomScout,
    /// Differential evolution rand/1/bin.
    De,
    /// Particle swarm.
    Pso,
    /// Artificial bee colony.
    Abc,
    /// Covariance matrix adaptation with restarts.
    CmaEs,
    /// Multi-start Levenberg–Marquardt until the budget is spent.
    LeastSquares,
    /// DE-ABC for 5 % of the budget, then least squares from its best point.
    DeAbcThenLeastSquares,
}

impl Competitor {
    /// Every competitor, in the order of the tables.
    pub const ALL: [Self; 11] = [
        Self::DeAbc,
        Self::DeAbcOneDimension,
        Self::DeAbcNoScout,
        Self::DeAbcEagerScout,
        Self::DeAbcEagerRandomScout,
        Self::De,
        Self::Pso,
        Self::Abc,
        Self::CmaEs,
        Self::LeastSquares,
        Self::DeAbcThenLeastSquares,
    ];

    /// Name for a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::DeAbc => "DE-ABC, all dimensions",
            Self::DeAbcOneDimension => "DE-ABC, one dimension",
            Self::DeAbcNoScout => "DE-ABC, no scout",
            Self::DeAbcEagerScout => "DE-ABC, chaotic scout, L = 10",
            Self::DeAbcEagerRandomScout => "DE-ABC, random scout, L = 10",
            Self::De => "DE/rand/1/bin",
            Self::Pso => "PSO",
            Self::Abc => "ABC",
            Self::CmaEs => "CMA-ES (IPOP)",
            Self::LeastSquares => "multi-start least squares",
            Self::DeAbcThenLeastSquares => "DE-ABC 5 %, then least squares",
        }
    }

    fn algorithm(self, budget: usize) -> Algorithm {
        let de_abc = DeAbcOptions::default();
        let eager = Some(EAGER_LIMIT);
        match self {
            Self::DeAbc | Self::DeAbcThenLeastSquares => Algorithm::DeAbc(de_abc),
            Self::DeAbcOneDimension => {
                Algorithm::DeAbc(DeAbcOptions { moved: MovedComponents::One, ..de_abc })
            }
            Self::DeAbcNoScout => Algorithm::DeAbc(DeAbcOptions { scout: Scout::Off, ..de_abc }),
            Self::DeAbcEagerScout => Algorithm::DeAbc(DeAbcOptions { limit: eager, ..de_abc }),
            Self::DeAbcEagerRandomScout => {
                Algorithm::DeAbc(DeAbcOptions { limit: eager, scout: Scout::Random, ..de_abc })
            }
            Self::De => Algorithm::De(DeOptions::default()),
            Self::Pso => Algorithm::Pso(PsoOptions::default()),
            Self::Abc => Algorithm::Abc(AbcOptions::default()),
            Self::CmaEs => Algorithm::CmaEs(CmaEsOptions::default()),
            // Enough starts to spend the budget: each takes at least one evaluation.
            Self::LeastSquares => Algorithm::LeastSquares(LeastSquaresOptions {
                starts: budget,
                agreement: None,
                ..LeastSquaresOptions::default()
            }),
        }
    }

    /// One run of `budget` evaluations on one thread.
    pub(super) fn run(
        self,
        problem: &impl LeastSquaresProblem,
        budget: usize,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<Outcome, OptimizeError> {
        let run = |algorithm: &Algorithm, budget: usize, starts, observer: &mut dyn Observer| {
            let settings = Settings {
                seed,
                // CMA-ES chooses its population size itself.
                generations: match self {
                    Self::CmaEs => budget,
                    _ => (budget / GENERATION).saturating_sub(1).max(1),
                },
                budget: Some(budget),
                starts,
                threads: Some(1),
                ..Settings::default()
            };
            minimize(problem, algorithm, &settings, observer, None)
        };
        if self != Self::DeAbcThenLeastSquares {
            return run(&self.algorithm(budget), budget, Vec::new(), observer);
        }
        let share = (GLOBAL_SHARE * budget as f64) as usize;
        let global = run(&self.algorithm(share), share, Vec::new(), observer)?;
        if global.stopped == StopReason::Cancelled {
            return Ok(global);
        }
        let options = LeastSquaresOptions { starts: 1, ..LeastSquaresOptions::default() };
        let rest = budget - global.evaluations;
        let local = run(&Algorithm::LeastSquares(options), rest, vec![global.best.clone()], observer)?;
        Ok(joined(global, local))
    }
}

/// Joins the two stages of a hybrid run.
fn joined(global: Outcome, local: Outcome) -> Outcome {
    let mut joined = Outcome { evaluations: global.evaluations + local.evaluations, ..local };
    let before = global.improvements.last().map_or(f64::INFINITY, |i| i.cost);
    let later = joined.improvements.into_iter().filter(|i| i.cost < before);
    joined.improvements = global.improvements;
    joined.improvements.extend(later.map(|mut i| {
        i.evaluation += global.evaluations;
        i
    }));
    if global.cost < joined.cost {
        (joined.best, joined.cost) = (global.best, global.cost);
    }
    joined.scouts_fired = global.scouts_fired;
    joined
}
