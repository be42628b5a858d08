//! Entry points: one call runs any algorithm.

use super::checkpoint::State;
use super::evaluate::Evaluator;
use super::jacobian::UnitResiduals;
use super::least_squares::MultiStart;
use super::ledger::{Scratch, Search};
use super::outcome::Advance;
use super::{
    Algorithm, Bounds, Checkpoint, LeastSquaresProblem, Observer, OptimizeError, Outcome, Problem, Progress,
    Settings, Stop, StopReason, abc, cma_es, de, de_abc, pso,
};

/// Minimises the root mean square of the residuals of `problem` over its box with any algorithm.
///
/// `resume`: a checkpoint of the same run to resume from, with a bit-identical result.
///
/// # Errors
/// [`OptimizeError`]: an invalid search box, option or start; a checkpoint of another run; no candidate that
/// could be simulated.
pub fn minimize<P: LeastSquaresProblem>(
    problem: &P,
    algorithm: &Algorithm,
    settings: &Settings,
    observer: &mut dyn Observer,
    resume: Option<Checkpoint>,
) -> Result<Outcome, OptimizeError> {
    if problem.bounds().ranges.is_empty() {
        return evaluate_alone(problem, algorithm, settings, observer);
    }
    let Algorithm::LeastSquares(options) = algorithm else {
        return minimize_cost(problem, algorithm, settings, observer, resume);
    };
    if problem.residual_count() == 0 {
        return Err(OptimizeError::NoResiduals);
    }
    let (checkpoint, mut evaluator) = prepare(problem, algorithm, settings, observer.stop(), resume)?;
    let bounds = problem.bounds();
    let mut residuals = UnitResiduals::new(bounds, &mut evaluator);
    drive(checkpoint, bounds, observer, &mut |checkpoint| {
        let Checkpoint { ledger, state, settings, .. } = checkpoint;
        match state {
            State::Starts(starts) => starts.iterate(options, settings, ledger, &mut residuals),
            _ => {
                let mut starts = MultiStart::new(ledger, settings);
                let advance = starts.begin_next(options, settings, ledger, &mut residuals);
                *state = State::Starts(starts);
                advance
            }
        }
    })
}

/// Minimises the cost of `problem` over its box with a population method.
///
/// `resume`: a checkpoint of the same run to resume from, with a bit-identical result.
///
/// # Errors
/// Those of [`minimize`]; [`OptimizeError::NeedsResiduals`] for least squares.
pub fn minimize_cost<P: Problem>(
    problem: &P,
    algorithm: &Algorithm,
    settings: &Settings,
    observer: &mut dyn Observer,
    resume: Option<Checkpoint>,
) -> Result<Outcome, OptimizeError> {
    if matches!(algorithm, Algorithm::LeastSquares(_)) {
        return Err(OptimizeError::NeedsResiduals);
    }
    let (checkpoint, mut evaluator) = prepare(problem, algorithm, settings, observer.stop(), resume)?;
    let bounds = problem.bounds();
    let mut scratch = Scratch::new(bounds.dimension());
    drive(checkpoint, bounds, observer, &mut |checkpoint| {
        let Checkpoint { ledger, state, settings, algorithm, .. } = checkpoint;
        let mut search = Search { ledger, settings, bounds, evaluator: &mut evaluator };
        match (algorithm, state) {
            (Algorithm::DeAbc(options), State::Colony(colony)) => {
                de_abc::generation(options, colony, &mut search, &mut scratch);
            }
            (Algorithm::Abc(options), State::Colony(colony)) => {
                abc::generation(options, colony, &mut search, &mut scratch);
            }
            (Algorithm::De(options), State::Members(members)) => {
                de::generation(options, members, &mut search, &mut scratch);
            }
            (Algorithm::Pso(options), State::Swarm(swarm)) => {
                pso::generation(options, swarm, &mut search, &mut scratch);
            }
            (Algorithm::CmaEs(options), State::Distribution(distribution)) => {
                cma_es::generation(options, distribution, &mut search, &mut scratch);
            }
            (algorithm, state) => *state = initial_state(algorithm, &mut search),
        }
        Advance::Continue
    })
}

fn initial_state(algorithm: &Algorithm, search: &mut Search<'_>) -> State {
    match algorithm {
        Algorithm::DeAbc(options) => State::Colony(super::colony::Colony::new(options.population, search)),
        Algorithm::Abc(options) => State::Colony(super::colony::Colony::new(options.population, search)),
        Algorithm::De(options) => State::Members(de::Members::new(options, search)),
        Algorithm::Pso(options) => State::Swarm(pso::Swarm::new(options, search)),
        Algorithm::CmaEs(options) => State::Distribution(cma_es::Distribution::new(options, search)),
        Algorithm::LeastSquares(_) => State::NotStarted,
    }
}

/// The cost of a problem without search parameters, as all its unknowns are linear.
fn evaluate_alone<P: Problem>(
    problem: &P,
    algorithm: &Algorithm,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Outcome, OptimizeError> {
    let mut evaluator = Evaluator::new(problem, settings.threads, observer.stop())?;
    let bounds = problem.bounds();
    let checkpoint = Checkpoint::new(problem.identity(), bounds, algorithm, settings);
    drive(checkpoint, bounds, observer, &mut |checkpoint| {
        let cost = evaluator.cost(&[]);
        checkpoint.ledger.count(&[], cost);
        Advance::Finished(StopReason::StartsDone)
    })
}

/// Checks the arguments, and creates the initial (or resumed) checkpoint and the evaluator.
fn prepare<'p, P: Problem>(
    problem: &'p P,
    algorithm: &Algorithm,
    settings: &Settings,
    stop: Option<Stop>,
    resume: Option<Checkpoint>,
) -> Result<(Checkpoint, Evaluator<'p, P>), OptimizeError> {
    let bounds = problem.bounds();
    bounds.validate()?;
    settings.validate(bounds.dimension())?;
    algorithm.validate()?;
    let identity = problem.identity();
    if let Some(checkpoint) = &resume {
        checkpoint.check_same_run(&identity, bounds, algorithm, settings)?;
    }
    let mut evaluator = Evaluator::new(problem, settings.threads, stop)?;
    let checkpoint = match resume {
        // Stopped before the end of its first generation.
        Some(checkpoint) if matches!(checkpoint.state, State::NotStarted) => checkpoint,
        Some(checkpoint) => {
            checkpoint.check_cost(evaluator.cost(&checkpoint.ledger.best))?;
            checkpoint
        }
        None => {
            let settings = Settings { threads: None, ..settings.clone() };
            Checkpoint::new(identity, bounds, algorithm, &settings)
        }
    };
    Ok((checkpoint, evaluator))
}

/// Calls `step` generation by generation until the run ends: the first call makes generation 0.
fn drive(
    mut checkpoint: Checkpoint,
    bounds: &Bounds,
    observer: &mut dyn Observer,
    step: &mut dyn FnMut(&mut Checkpoint) -> Advance,
) -> Result<Outcome, OptimizeError> {
    let mut best = vec![0.0; bounds.dimension()];
    let stop = observer.stop();
    // Checkpoint to resume from where a generation is interrupted.
    let mut before = None;
    let stopped = loop {
        let started = !matches!(checkpoint.state, State::NotStarted);
        if started {
            checkpoint.finished = checkpoint.finished.or_else(|| reason_to_stop(&checkpoint));
        }
        if let Some(reason) = checkpoint.finished {
            break reason;
        }
        let whole = stop.as_ref().filter(|_| before.is_none()).map(|_| checkpoint.clone());
        let advance = step(&mut checkpoint);
        if stop.as_ref().is_some_and(Stop::is_requested) {
            before = before.or(whole);
            if checkpoint.ledger.best_cost.is_finite() {
                break StopReason::Cancelled;
            }
        }
        if let Advance::Finished(reason) = advance {
            checkpoint.finished = Some(reason);
        }
        checkpoint.ledger.generation += usize::from(started);
        checkpoint.ledger.close_generation();
        if observer.generation(&Progress::of(&checkpoint, bounds, &mut best)).is_break() {
            break StopReason::Cancelled;
        }
    };
    let ledger = &checkpoint.ledger;
    if !ledger.best_cost.is_finite() {
        return Err(OptimizeError::NoFeasiblePoint { evaluations: ledger.evaluations });
    }
    bounds.from_unit(&ledger.best, &mut best);
    let (scouts_fired, starts) = match &checkpoint.state {
        State::Colony(colony) => (colony.scouts_fired, Vec::new()),
        State::Starts(starts) => (0, starts.results(bounds)),
        _ => (0, Vec::new()),
    };
    Ok(Outcome {
        best,
        cost: ledger.best_cost,
        evaluations: ledger.evaluations,
        generations: ledger.generation,
        history: ledger.history.clone(),
        improvements: ledger.improvements.clone(),
        stopped,
        scouts_fired,
        starts,
        checkpoint: before.unwrap_or(checkpoint),
    })
}

/// The reason, if any, to stop before another generation.
fn reason_to_stop(checkpoint: &Checkpoint) -> Option<StopReason> {
    let Checkpoint { ledger, settings, algorithm, .. } = checkpoint;
    if settings.target.is_some_and(|target| ledger.best_cost <= target) {
        return Some(StopReason::Target);
    }
    if ledger.generation >= algorithm.planned_generations(settings) {
        return Some(StopReason::Generations);
    }
    if ledger.remaining(settings) == 0 {
        return Some(StopReason::Budget);
    }
    let stagnation = settings.stagnation?;
    let before = ledger.history.len().checked_sub(1 + stagnation.generations)?;
    let before = ledger.history.get(before)?.best_cost;
    let stagnated = before.is_finite() && before - ledger.best_cost <= stagnation.relative * before;
    stagnated.then_some(StopReason::Stagnation)
}

#[cfg(test)]
mod tests;
