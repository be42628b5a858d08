//! Options of a study of optimisers.

use super::Competitor;
use crate::ArticleError;
use serde::{Deserialize, Serialize};

/// Scope and budget of the comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyOptions {
    /// Problems, one table each.
    pub problems: Vec<StudyProblem>,
    /// Competitors, one row each.
    pub competitors: Vec<Competitor>,
    /// Runs of each competitor; their seeds are `first_seed`, `first_seed` + 1, …
    pub seeds: usize,
    /// Seed of the first run.
    pub first_seed: u64,
    /// Cost evaluations of a run, at least 200. A population method makes 50 a generation, so 7 550 are an
    /// initial population and the article's 150 generations.
    pub budget: usize,
    /// Seed of the measurement noise, the same for all runs.
    pub noise_seed: u64,
    /// Threads the runs are spread over; `None`: those of the current `rayon` pool. The result does not
    /// depend on it.
    #[serde(skip)]
    pub threads: Option<usize>,
}

impl Default for StudyOptions {
    /// Both problems, every competitor, 31 seeds, 7 550 evaluations.
    fn default() -> Self {
        Self {
            problems: StudyProblem::ALL.to_vec(),
            competitors: Competitor::ALL.to_vec(),
            seeds: 31,
            first_seed: 1,
            budget: 7550,
            noise_seed: 1,
            threads: None,
        }
    }
}

/// An identification problem of the study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StudyProblem {
    /// The five parameters of the improved Bouc–Wen model ([`StaticBlock`](super::StaticBlock)).
    StaticBlock,
    /// Orders and coefficients of the fractional transfer function
    /// ([`FractionalBlock`](super::FractionalBlock)).
    FractionalBlock,
}

impl StudyProblem {
    /// Both problems.
    pub const ALL: [Self; 2] = [Self::StaticBlock, Self::FractionalBlock];

    /// Title for a table.
    pub fn title(self) -> &'static str {
        match self {
            Self::StaticBlock => "Static Bouc-Wen fit",
            Self::FractionalBlock => "Fractional block, orders and coefficients at once",
        }
    }

    /// Data, truth and noise in one sentence.
    pub fn description(self) -> &'static str {
        match self {
            Self::StaticBlock => super::StaticBlock::DESCRIPTION,
            Self::FractionalBlock => super::FractionalBlock::DESCRIPTION,
        }
    }
}

impl StudyOptions {
    pub(super) fn validate(&self) -> Result<(), ArticleError> {
        let checks = [
            ("problems", self.problems.len(), 1, "at least one"),
            ("competitors", self.competitors.len(), 1, "at least one"),
            ("seeds", self.seeds, 1, "at least 1"),
            ("budget", self.budget, 200, "at least 200 evaluations"),
            ("threads", self.threads.unwrap_or(1), 1, "at least 1"),
        ];
        match checks.into_iter().find(|&(_, value, least, _)| value < least) {
            Some((option, value, _, wanted)) => Err(ArticleError::StudyOption { option, value, wanted }),
            None => Ok(()),
        }
    }
}
