//! Results of a study of optimisers.

use super::competitor::GENERATION;
use super::{Competitor, Quartiles, StudyOptions, StudyProblem, quartiles};
use hysteron_optimize::{Improvement, Outcome, StopReason, infinite_as_null};
use serde::{Deserialize, Serialize};

/// All results of a study. JSON writes +∞ as `null`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// Options of the study.
    pub options: StudyOptions,
    /// One table a problem.
    pub problems: Vec<ProblemResult>,
}

/// One table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProblemResult {
    /// Which problem.
    pub problem: StudyProblem,
    /// Its title.
    pub title: String,
    /// Data, truth and noise in one sentence.
    pub description: String,
    /// The search box and the truth.
    pub parameters: Vec<Parameter>,
    /// Standard deviation of the noise \[µm\].
    pub noise_um: f64,
    /// Best reachable RMSE \[µm\], by a least-squares fit started at the truth.
    pub reachable_rmse: f64,
    /// RMSE that counts as success \[µm\]: 1 % above.
    pub target_rmse: f64,
    /// One row a competitor.
    pub rows: Vec<Row>,
}

/// One sought parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Name.
    pub name: String,
    /// Lower end of the search box.
    pub low: f64,
    /// Upper end of the search box.
    pub high: f64,
    /// Whether it is scaled logarithmically.
    pub logarithmic: bool,
    /// Value the record was made with.
    pub truth: f64,
}

/// One row: all runs of a competitor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Optimiser.
    pub competitor: Competitor,
    /// Its name.
    pub name: String,
    /// Median over the runs of the best RMSE at the end \[µm\].
    #[serde(with = "infinite_as_null::one")]
    pub median_best_rmse: f64,
    /// Share of runs that came within 1 % of the best reachable RMSE \[%\].
    pub success_percent: f64,
    /// Evaluations needed for it, over the successful runs; `None` if there were none.
    pub evaluations_to_target: Option<Quartiles>,
    /// Median over the runs of all evaluations made.
    pub median_evaluations: f64,
    /// Number of scouts sent out, over all runs.
    pub scouts_fired: usize,
    /// Runs in which the scout fired.
    pub runs_with_scouts: usize,
    /// Best RMSE against evaluations.
    pub curve: Curve,
    /// The runs, in the order of their seeds.
    pub runs: Vec<StudyRun>,
}

/// Best RMSE so far against evaluations, over the runs, every 50 evaluations (a generation of the population
/// methods). A run that has ended stays at its last value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Evaluations.
    pub evaluations: Vec<usize>,
    /// First quartile \[µm\].
    #[serde(with = "infinite_as_null::many")]
    pub lower: Vec<f64>,
    /// Median \[µm\].
    #[serde(with = "infinite_as_null::many")]
    pub median: Vec<f64>,
    /// Third quartile \[µm\].
    #[serde(with = "infinite_as_null::many")]
    pub upper: Vec<f64>,
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StudyRun {
    /// Seed.
    pub seed: u64,
    /// Best RMSE \[µm\].
    #[serde(with = "infinite_as_null::one")]
    pub best_rmse: f64,
    /// Parameters there.
    pub best: Vec<f64>,
    /// Evaluations made.
    pub evaluations: usize,
    /// Evaluations to come within 1 % of the best reachable RMSE; `None` if it did not.
    pub evaluations_to_target: Option<usize>,
    /// Number of scouts sent out.
    pub scouts_fired: usize,
    /// Why it ended.
    pub stopped: StopReason,
}

impl Row {
    /// The row of a competitor from its runs and their seeds.
    pub(super) fn new(
        competitor: Competitor,
        outcomes: &[(u64, Outcome)],
        target: f64,
        budget: usize,
    ) -> Self {
        let run = |(seed, outcome): &(u64, Outcome)| StudyRun {
            seed: *seed,
            best_rmse: outcome.cost,
            best: outcome.best.clone(),
            evaluations: outcome.evaluations,
            evaluations_to_target: outcome.evaluations_to(target),
            scouts_fired: outcome.scouts_fired,
            stopped: outcome.stopped,
        };
        let runs: Vec<StudyRun> = outcomes.iter().map(run).collect();
        let successes: Vec<f64> =
            runs.iter().filter_map(|run| run.evaluations_to_target).map(|n| n as f64).collect();
        let median = |values: Vec<f64>| quartiles(&values).map_or(f64::NAN, |q| q.median);
        Self {
            competitor,
            name: competitor.name().to_owned(),
            median_best_rmse: median(runs.iter().map(|run| run.best_rmse).collect()),
            success_percent: 100.0 * successes.len() as f64 / runs.len() as f64,
            evaluations_to_target: quartiles(&successes),
            median_evaluations: median(runs.iter().map(|run| run.evaluations as f64).collect()),
            scouts_fired: runs.iter().map(|run| run.scouts_fired).sum(),
            runs_with_scouts: runs.iter().filter(|run| run.scouts_fired > 0).count(),
            curve: Curve::new(outcomes.iter().map(|(_, outcome)| outcome.improvements.as_slice()), budget),
            runs,
        }
    }
}

impl Curve {
    fn new<'a>(histories: impl Iterator<Item = &'a [Improvement]>, budget: usize) -> Self {
        let histories: Vec<&[Improvement]> = histories.collect();
        let mut curve =
            Self { evaluations: Vec::new(), lower: Vec::new(), median: Vec::new(), upper: Vec::new() };
        for evaluations in (1..=budget / GENERATION).map(|g| g * GENERATION) {
            let best = |history: &&[Improvement]| {
                let done = history.partition_point(|i| i.evaluation <= evaluations);
                history[..done].last().map_or(f64::INFINITY, |i| i.cost)
            };
            let Some(q) = quartiles(&histories.iter().map(best).collect::<Vec<_>>()) else { continue };
            curve.evaluations.push(evaluations);
            curve.lower.push(q.lower);
            curve.median.push(q.median);
            curve.upper.push(q.upper);
        }
        curve
    }
}
