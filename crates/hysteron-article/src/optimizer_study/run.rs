//! The study itself.

use super::study::{Parameter, ProblemResult, Row, Study};
use super::{FractionalBlock, StaticBlock, StudyError, StudyOptions, StudyProblem, StudyProgress};
use hysteron_optimize::{
    Algorithm, Differences, LeastSquaresOptions, LeastSquaresProblem, OptimizeError, Outcome, Progress,
    Settings, Unobserved, minimize,
};
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Success is an RMSE within this factor of the best that can be reached.
const SUCCESS: f64 = 1.01;

/// Told after every run, from whichever thread made it; may stop the study.
type Callback<'a> = dyn FnMut(&StudyProgress) -> ControlFlow<()> + Send + 'a;

/// Runs every competitor on every problem from every seed, the runs spread over threads; the result does not depend on
/// their number. `progress` is told after every run and may stop the study.
///
/// With the default options (620 runs of up to 7 550 simulations of 2000 samples) this takes about two minutes on two
/// cores.
///
/// # Errors
/// [`StudyError::Option`]; [`StudyError::Cancelled`] if `progress` said so; [`StudyError::Optimize`] if a run failed.
pub fn run_study(options: &StudyOptions, progress: &mut Callback<'_>) -> Result<Study, StudyError> {
    options.validate()?;
    let ticker = Ticker {
        progress: Mutex::new((0, progress)),
        runs: options.problems.len() * options.competitors.len() * options.seeds,
        cancelled: AtomicBool::new(false),
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
) -> Result<ProblemResult, StudyError> {
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
) -> Result<ProblemResult, StudyError> {
    let reachable_rmse = polished_from(problem, truth)?;
    let target_rmse = SUCCESS * reachable_rmse;
    let jobs: Vec<(usize, u64)> = (0..options.competitors.len())
        .flat_map(|c| (0..options.seeds as u64).map(move |s| (c, options.first_seed.wrapping_add(s))))
        .collect();
    let one = |&(c, seed): &(usize, u64)| -> Result<(u64, Outcome), StudyError> {
        ticker.check()?;
        let mut observer = |_: &Progress<'_>| ticker.flow();
        let competitor = options.competitors[c];
        let outcome = competitor.run(problem, options.budget, seed, &mut observer);
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
fn polished_from(problem: &impl LeastSquaresProblem, truth: &[f64]) -> Result<f64, StudyError> {
    let options = LeastSquaresOptions {
        starts: 1,
        differences: Differences::central(),
        cost_tolerance: 1e-15,
        ..LeastSquaresOptions::default()
    };
    let settings = Settings { starts: vec![truth.to_vec()], threads: Some(1), ..Settings::default() };
    Ok(minimize(problem, &Algorithm::LeastSquares(options), &settings, &mut Unobserved, None)?.cost)
}

/// Counts the runs and carries the wish to stop.
struct Ticker<'a, 'b> {
    progress: Mutex<(usize, &'a mut Callback<'b>)>,
    runs: usize,
    cancelled: AtomicBool,
}

impl Ticker<'_, '_> {
    fn flow(&self) -> ControlFlow<()> {
        if self.cancelled.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    fn check(&self) -> Result<(), StudyError> {
        if self.flow().is_continue() {
            return Ok(());
        }
        let done = self.progress.lock().unwrap_or_else(PoisonError::into_inner).0;
        Err(StudyError::Cancelled { done, runs: self.runs })
    }

    fn tick(&self, problem: StudyProblem, competitor: super::Competitor) {
        let mut progress = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        progress.0 += 1;
        let told = StudyProgress { done: progress.0, runs: self.runs, problem, competitor };
        if (progress.1)(&told).is_break() {
            self.cancelled.store(true, Ordering::Relaxed);
        }
    }
}
