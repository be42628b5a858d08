//! The whole state of a run.

use super::cma_es::Distribution;
use super::colony::Colony;
use super::de::Members;
use super::least_squares::MultiStart;
use super::ledger::Ledger;
use super::pso::Swarm;
use super::{Algorithm, Bounds, OptimizeError, Settings, StopReason};
use serde::{Deserialize, Serialize};

const FORMAT: &str = "hysteron-optimizer-checkpoint";
const VERSION: u32 = 1;
/// Largest relative difference of the cost at the best point on resuming: the FFT's last bits differ between
/// processors, another record's cost differs by far more.
const SAME_COST: f64 = 1e-6;

/// The whole state of a run, serialisable: problem, search box, algorithm, settings, population, the position
/// in the random streams and the history. [`minimize`](super::minimize()) resumes from it with a
/// bit-identical result.
///
/// Get one from [`Progress::checkpoint`](super::Progress::checkpoint) each generation or from
/// [`Outcome::checkpoint`](super::Outcome::checkpoint) at the end. JSON needs `serde_json` with
/// `float_roundtrip`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Checkpoint {
    format: String,
    version: u32,
    pub(super) problem: String,
    pub(super) bounds: Bounds,
    pub(super) algorithm: Algorithm,
    pub(super) settings: Settings,
    pub(super) ledger: Ledger,
    pub(super) state: State,
    /// Reason why the run ended by itself; `None` while it can be resumed.
    pub(super) finished: Option<StopReason>,
}

/// State of the algorithm itself between generations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum State {
    NotStarted,
    Colony(Colony),
    Members(Members),
    Swarm(Swarm),
    Distribution(Distribution),
    Starts(MultiStart),
}

impl Checkpoint {
    pub(super) fn new(problem: String, bounds: &Bounds, algorithm: &Algorithm, settings: &Settings) -> Self {
        Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            problem,
            bounds: bounds.clone(),
            algorithm: algorithm.clone(),
            settings: settings.clone(),
            ledger: Ledger::new(bounds.dimension()),
            state: State::NotStarted,
            finished: None,
        }
    }

    /// The problem's [`identity`](super::Problem::identity).
    pub fn problem(&self) -> &str {
        &self.problem
    }

    /// The search box.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// The algorithm with its options.
    pub fn algorithm(&self) -> &Algorithm {
        &self.algorithm
    }

    /// The settings, without the number of threads.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Generations done.
    pub fn generation(&self) -> usize {
        self.ledger.generation
    }

    /// Cost evaluations done.
    pub fn evaluations(&self) -> usize {
        self.ledger.evaluations
    }

    /// Best cost so far; +∞ while no candidate could be simulated.
    pub fn best_cost(&self) -> f64 {
        self.ledger.best_cost
    }

    /// Rejects a problem, box, algorithm or settings other than those of this run.
    pub(super) fn check_same_run(
        &self,
        problem: &str,
        bounds: &Bounds,
        algorithm: &Algorithm,
        settings: &Settings,
    ) -> Result<(), OptimizeError> {
        if self.format != FORMAT || self.version != VERSION {
            return Err(OptimizeError::CheckpointFormat {
                format: self.format.clone(),
                version: self.version,
                expected: FORMAT,
                expected_version: VERSION,
            });
        }
        if self.problem != problem {
            return Err(OptimizeError::CheckpointProblem {
                found: self.problem.clone(),
                expected: problem.to_owned(),
            });
        }
        if &self.bounds != bounds {
            let mut pairs = self.bounds.ranges.iter().zip(&bounds.ranges);
            let parameter = match pairs.find(|(a, b)| a != b) {
                Some((_, range)) => range.name.clone(),
                None => "the number of parameters".to_owned(),
            };
            return Err(OptimizeError::CheckpointBounds { parameter });
        }
        if &self.algorithm != algorithm {
            return Err(OptimizeError::CheckpointAlgorithm {
                found: format!("{:?}", self.algorithm),
                expected: format!("{algorithm:?}"),
            });
        }
        let (there, here) = (&self.settings, settings);
        let differing = [
            ("seed", there.seed.to_string(), here.seed.to_string()),
            ("number of generations", there.generations.to_string(), here.generations.to_string()),
            ("budget", format!("{:?}", there.budget), format!("{:?}", here.budget)),
            ("target", format!("{:?}", there.target), format!("{:?}", here.target)),
            ("stagnation rule", format!("{:?}", there.stagnation), format!("{:?}", here.stagnation)),
            ("list of starts", format!("{:?}", there.starts), format!("{:?}", here.starts)),
        ];
        match differing.into_iter().find(|(_, found, expected)| found != expected) {
            Some((setting, found, expected)) => {
                Err(OptimizeError::CheckpointSettings { setting, found, expected })
            }
            None => self.check_consistent(),
        }
    }

    /// Rejects a cost `now` at the best point that differs from the stored one.
    pub(super) fn check_cost(&self, now: f64) -> Result<(), OptimizeError> {
        let stored = self.ledger.best_cost;
        let same = if stored.is_finite() { (now - stored).abs() <= SAME_COST * stored.abs() } else { true };
        if same { Ok(()) } else { Err(OptimizeError::CheckpointCost { stored, now }) }
    }

    /// Rejects an inconsistent state: a damaged file must not cause a panic.
    fn check_consistent(&self) -> Result<(), OptimizeError> {
        let dimension = self.bounds.dimension();
        let best = &self.ledger.best;
        if best.len() != dimension || !best.iter().all(|t| (0.0..=1.0).contains(t)) {
            return Err(OptimizeError::CheckpointDamaged { what: "its best point is not in the search box" });
        }
        let consistent = match (&self.algorithm, &self.state) {
            (_, State::NotStarted) => self.ledger.evaluations == 0,
            (Algorithm::DeAbc(options), State::Colony(colony)) => {
                colony.is_consistent(options.population, dimension)
            }
            (Algorithm::Abc(options), State::Colony(colony)) => {
                colony.is_consistent(options.population, dimension)
            }
            (Algorithm::De(options), State::Members(members)) => {
                members.is_consistent(options.population, dimension)
            }
            (Algorithm::Pso(options), State::Swarm(swarm)) => {
                swarm.is_consistent(options.population, dimension)
            }
            (Algorithm::CmaEs(options), State::Distribution(distribution)) => {
                distribution.is_consistent(options, dimension)
            }
            (Algorithm::LeastSquares(_), State::Starts(starts)) => starts.is_consistent(dimension),
            _ => false,
        };
        if consistent {
            Ok(())
        } else {
            Err(OptimizeError::CheckpointDamaged {
                what: "its population does not fit its options or its search box",
            })
        }
    }
}
