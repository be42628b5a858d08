//! Figure 6 and Table 1: the article's optimisers on the static fit, many seeds instead of one.

use super::measurements::Measurements;
use super::progress::{Stage, Stages};
use super::static_block::article_options;
use super::{ArticleError, Plan, printed};
use hysteron_identify::{IdentifyError, StaticFit};
use hysteron_model::Start;
use hysteron_optimize::{
    AbcOptions, Algorithm, DeAbcOptions, DeOptions, LeastSquaresOptions, MovedComponents, Outcome, Problem,
    Progress, Scout, Settings, Unobserved, minimize, minimize_cost,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Runs of several optimisers on one problem at equal numbers of generations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OptimizerStudy {
    /// Samples of the record that is fitted.
    pub samples: usize,
    /// Parameters searched: name, lower and upper end of the box.
    pub search_box: Vec<(String, f64, f64)>,
    /// RMSE of the best fit (multi-start least squares) \[µm\].
    pub reachable_um: f64,
    /// Evaluations that least squares took for it, all starts together.
    pub reachable_evaluations: usize,
    /// The contenders, the three of Table 1 first.
    pub contenders: Vec<Contender>,
}

/// One algorithm with its runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contender {
    /// Short name.
    pub name: String,
    /// Its distinguishing feature.
    pub variant: String,
    /// The article's best fitness, where Table 1 has it.
    pub printed: Option<f64>,
    /// Best RMSE of each run after the last generation \[µm\].
    pub best_um: Vec<f64>,
    /// Median of `best_um`.
    pub median_um: f64,
    /// Lower and upper quartile.
    pub quartiles_um: (f64, f64),
    /// Runs within 1 % of the best reachable RMSE \[%\].
    pub success_percent: f64,
    /// Median number of evaluations to reach 1 %, over all runs; `None` where fewer than half do.
    pub evaluations_to_1_percent: Option<f64>,
    /// Median number of evaluations of a run.
    pub evaluations: f64,
    /// Scouts sent out, all runs together.
    pub scouts: usize,
    /// Best RMSE so far \[µm\] after each generation (from 0), one list a run.
    pub histories_um: Vec<Vec<f64>>,
}

/// Factor to the best reachable RMSE within which a run is successful.
const FOUND: f64 = 1.01;
/// Failures after which the scout is sent in the variant that shows its effect: at the default of SN·D it
/// hardly fires.
const EARLY_SCOUT: usize = 10;

fn contenders() -> Vec<(&'static str, &'static str, Algorithm)> {
    let colony = DeAbcOptions::default;
    vec![
        ("DE", "rand/1/bin, 50 members, F 0.5, CR 0.9", Algorithm::De(DeOptions::default())),
        ("ABC", "25 sources, one component moved", Algorithm::Abc(AbcOptions::default())),
        ("DE-ABC", "25 sources, all components moved, chaotic scout", Algorithm::DeAbc(colony())),
        (
            "DE-ABC, no scout",
            "as DE-ABC, scout off",
            Algorithm::DeAbc(DeAbcOptions { scout: Scout::Off, ..colony() }),
        ),
        (
            "DE-ABC, early scout",
            "as DE-ABC, chaotic scout after 10 failures",
            Algorithm::DeAbc(DeAbcOptions { limit: Some(EARLY_SCOUT), ..colony() }),
        ),
        (
            "DE-ABC, one component",
            "as the text reads: one random component moved",
            Algorithm::DeAbc(DeAbcOptions { moved: MovedComponents::One, ..colony() }),
        ),
    ]
}

impl OptimizerStudy {
    pub(super) fn run(
        plan: &Plan,
        bench: &Measurements,
        stages: &Stages<'_, '_>,
    ) -> Result<Self, ArticleError> {
        stages.check(Stage::Optimizers, 0.0, "")?;
        let failed = |source: IdentifyError| ArticleError::Identify {
            model: "static block".into(),
            source: source.into(),
        };
        let options = article_options(plan);
        let start = Start::Rest { voltage_v: bench.loop_1hz.u.first().copied().unwrap_or(0.0) };
        let problem = StaticFit::new(&bench.loop_1hz, &start, &options).map_err(failed)?;
        let reachable = {
            let algorithm = Algorithm::LeastSquares(LeastSquaresOptions::default());
            let settings = Settings { seed: plan.seed, ..Settings::default() };
            minimize(&problem, &algorithm, &settings, &mut Unobserved, None)?
        };
        let list = contenders();
        let jobs: Vec<(usize, usize)> =
            (0..plan.runs).flat_map(|run| (0..list.len()).map(move |contender| (contender, run))).collect();
        let done = AtomicUsize::new(0);
        let outcomes: Vec<Result<Outcome, ArticleError>> = jobs
            .par_iter()
            .map(|&(contender, run)| {
                let share = || done.load(Ordering::Relaxed) as f64 / jobs.len() as f64;
                let mut observer = |_: &Progress<'_>| stages.at(Stage::Optimizers, share(), "");
                let settings = Settings {
                    seed: plan.seed.wrapping_add(run as u64),
                    generations: plan.generations,
                    threads: Some(1),
                    ..Settings::default()
                };
                let outcome = minimize_cost(&problem, &list[contender].2, &settings, &mut observer, None)?;
                done.fetch_add(1, Ordering::Relaxed);
                stages.check(Stage::Optimizers, share(), "")?;
                Ok(outcome)
            })
            .collect();
        let outcomes: Vec<Outcome> = outcomes.into_iter().collect::<Result<_, _>>()?;
        let of = |index: usize| -> Vec<&Outcome> {
            jobs.iter().zip(&outcomes).filter(|((c, _), _)| *c == index).map(|(_, outcome)| outcome).collect()
        };
        let contenders = list
            .iter()
            .enumerate()
            .map(|(index, (name, variant, _))| Contender::of(name, variant, &of(index), reachable.cost))
            .collect();
        Ok(Self {
            samples: bench.loop_1hz.len(),
            search_box: problem.bounds().ranges.iter().map(|r| (r.name.clone(), r.low, r.high)).collect(),
            reachable_um: reachable.cost,
            reachable_evaluations: reachable.evaluations,
            contenders,
        })
    }

    /// A contender by its name.
    pub fn contender(&self, name: &str) -> Option<&Contender> {
        self.contenders.iter().find(|c| c.name == name)
    }
}

impl Contender {
    fn of(name: &str, variant: &str, outcomes: &[&Outcome], reachable: f64) -> Self {
        let best_um: Vec<f64> = outcomes.iter().map(|o| o.cost).collect();
        let found = outcomes.iter().filter(|o| o.cost <= FOUND * reachable).count();
        // An unsuccessful run counts as infinitely many evaluations: the median is over all runs.
        let to_found: Vec<f64> = outcomes
            .iter()
            .map(|o| o.evaluations_to(FOUND * reachable).map_or(f64::INFINITY, |n| n as f64))
            .collect();
        let evaluations: Vec<f64> = outcomes.iter().map(|o| o.evaluations as f64).collect();
        Self {
            name: name.to_owned(),
            variant: variant.to_owned(),
            printed: printed::TABLE_1.iter().find(|(n, _)| *n == name).map(|(_, value)| *value),
            median_um: quantile(&best_um, 0.5),
            quartiles_um: (quantile(&best_um, 0.25), quantile(&best_um, 0.75)),
            success_percent: 100.0 * found as f64 / outcomes.len().max(1) as f64,
            evaluations_to_1_percent: Some(quantile(&to_found, 0.5)).filter(|n| n.is_finite()),
            evaluations: quantile(&evaluations, 0.5),
            scouts: outcomes.iter().map(|o| o.scouts_fired).sum(),
            histories_um: outcomes.iter().map(|o| o.history.iter().map(|g| g.best_cost).collect()).collect(),
            best_um,
        }
    }
}

/// The `p`-quantile by linear interpolation between order statistics (Hyndman and Fan type 7,
/// doi:10.1080/00031305.1996.10473566); NaN of nothing.
pub fn quantile(values: &[f64], p: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = p.clamp(0.0, 1.0) * sorted.len().saturating_sub(1) as f64;
    let (below, share) = (place.floor() as usize, place.fract());
    match (sorted.get(below), sorted.get(below + 1)) {
        (Some(a), _) if share == 0.0 => *a,
        (Some(a), Some(b)) => a + share * (b - a),
        (Some(a), None) => *a,
        _ => f64::NAN,
    }
}
