//! The study itself.

use super::study::{Parameter, ProblemResult, Row, Study};
use super::{FractionalBlock, StaticBlock, StudyOptions, StudyProblem};
use crate::ArticleError;
use hysteron_identify::{Event, Watch};
use hysteron_optimize::{
    Algorithm, Differences, LeastSquaresOptions, LeastSquaresProblem, OptimizeError, Outcome, Settings,
    Unobserved, minimize,
};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Success is an RMSE within this factor of the best reachable one.
const SUCCESS: f64 = 1.01;

/// Runs every competitor on every problem from every seed, the runs spread over threads; the result does not
/// depend on their number. `watch` is told after every run.
///
/// With the default options (620 runs of up to 7 550 simulations of 2000 samples) this takes about two
/// minutes on two cores.
///
/// # Errors
/// [`ArticleError::StudyOption`]; [`ArticleError::StudyStopped`] if it was stopped;
/// [`ArticleError::Optimize`] if a run failed.
pub fn run_study(options: &StudyOptions, watch: &Watch<'_>) -> Result<Study, ArticleError> {
    options.validate()?;
    let ticker = Ticker {
        watch,
        done: AtomicUsize::new(0),
        runs: options.problems.len() * options.competitors.len() * options.seeds,
    };
    let all = || options.problems.iter().map(|&problem| table(problem, options, &ticker)).collect();
    let problems: Result<Vec<_>, _> = match options.threads {
        Some(threads) => rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| OptimizeError::Threads { threads, reason: e.to_string() })?
            .install(all),
        None => all(),
    };
    Ok(Study { options: StudyOptions { threads: None, ..options.clone() }, problems: problems? })
}

fn table(
    problem: StudyProblem,
    options: &StudyOptions,
    ticker: &Ticker<'_, '_>,
) -> Result<ProblemResult, ArticleError> {
    match problem {
        StudyProblem::StaticBlock => {
            let block = StaticBlock::new(options.noise_seed)?;
            compare(problem, &block, &StaticBlock::TRUTH, StaticBlock::noise_um(), options, ticker)
        }
        StudyProblem::FractionalBlock => {
            let block = FractionalBlock::new(options.noise_seed)?;
            compare(problem, &block, &FractionalBlock::TRUTH, FractionalBlock::noise_um(), options, ticker)
        }
    }
}

/// All competitors from all seeds on one problem.
fn compare(
    name: StudyProblem,
    problem: &impl LeastSquaresProblem,
    truth: &[f64],
    noise_um: f64,
    options: &StudyOptions,
    ticker: &Ticker<'_, '_>,
) -> Result<ProblemResult, ArticleError> {
    let reachable_rmse = polished_from(problem, truth)?;
    let target_rmse = SUCCESS * reachable_rmse;
    let jobs: Vec<(usize, u64)> = (0..options.competitors.len())
        .flat_map(|c| (0..options.seeds as u64).map(move |s| (c, options.first_seed.wrapping_add(s))))
        .collect();
    let one = |&(c, seed): &(usize, u64)| -> Result<(u64, Outcome), ArticleError> {
        ticker.check()?;
        let competitor = options.competitors[c];
        let outcome = competitor.run(problem, options.budget, seed, &mut ticker.watch.stop().clone());
        ticker.check()?;
        ticker.tick(name, competitor);
        Ok((seed, outcome?))
    };
    let outcomes: Vec<_> = jobs.par_iter().map(one).collect::<Result<_, _>>()?;
    let by_competitor = options.competitors.iter().zip(outcomes.chunks(options.seeds));
    let row = |(&competitor, outcomes)| Row::new(competitor, outcomes, target_rmse, options.budget);
    let parameter = |(range, &truth): (&hysteron_optimize::Range, &f64)| Parameter {
        name: range.name.clone(),
        low: range.low,
        high: range.high,
        logarithmic: range.logarithmic,
        truth,
    };
    Ok(ProblemResult {
        problem: name,
        title: name.title().to_owned(),
        description: name.description().to_owned(),
        parameters: problem.bounds().ranges.iter().zip(truth).map(parameter).collect(),
        noise_um,
        reachable_rmse,
        target_rmse,
        rows: by_competitor.map(row).collect(),
    })
}

/// Least cost near the truth.
fn polished_from(problem: &impl LeastSquaresProblem, truth: &[f64]) -> Result<f64, ArticleError> {
    let options = LeastSquaresOptions {
        starts: 1,
        differences: Differences::central(),
        cost_tolerance: 1e-15,
        ..LeastSquaresOptions::default()
    };
    let settings = Settings { starts: vec![truth.to_vec()], threads: Some(1), ..Settings::default() };
    Ok(minimize(problem, &Algorithm::LeastSquares(options), &settings, &mut Unobserved, None)?.cost)
}

/// Counts the finished runs and relays the stop request.
struct Ticker<'a, 'w> {
    watch: &'a Watch<'w>,
    done: AtomicUsize,
    runs: usize,
}

impl Ticker<'_, '_> {
    fn check(&self) -> Result<(), ArticleError> {
        if self.watch.is_stopped() {
            return Err(ArticleError::StudyStopped {
                done: self.done.load(Ordering::Relaxed),
                runs: self.runs,
            });
        }
        Ok(())
    }

    fn tick(&self, problem: StudyProblem, competitor: super::Competitor) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        let stage = format!("{}: {}", problem.title(), competitor.name());
        // The next step checks for a stop.
        let _ = self.watch.tell(Event::new(&stage, done as f64 / self.runs as f64, None));
    }
}
