//! Search of one structure from many starts.

use super::super::IdentifyError;
use super::super::engine::{Engine, Search, Show, rough};
use super::campaign::Rate;
use super::model::shown;
use super::normalised::{local_fits, resolved_fit};
use super::problem::JointProblem;
use super::record::JointRecord;
use super::resolution::{NEAR, correlation_times};
use super::setup::JointSetup;
use super::starts::{Places, Starts};
use hysteron_model::dynamics::{Creep, DynamicForm};
use hysteron_optimize::{Algorithm, DeAbcOptions, LeastSquaresOptions, LocalStatus, OptimizeError, Problem};

/// Residuals with an effective sample size below this share of that of white noise are far from white.
const WHITE: f64 = 0.5;
/// A rough fit whose cost is within this many times the best leads to the same optimum.
const SAME: f64 = 1.001;
/// Starts nearer to one another than this share of every range are alike.
const ALIKE: f64 = 5e-3;
/// Fits that must come near the best optimum.
const AGREEMENT: usize = 3;
/// Number of first starts with fitted dynamics, in addition to the best unfitted one.
pub(super) const FIRST_STARTS: usize = 2;

/// Candidate starts of a search, and the first few to fit from.
pub(super) struct FirstPoints {
    places: Places,
    pub(super) points: Vec<Vec<f64>>,
    /// Evaluations spent on finding them.
    pub(super) evaluations: usize,
}

impl FirstPoints {
    pub(super) fn new(
        problem: &JointProblem,
        setup: &JointSetup<'_>,
        engine: &mut Engine<'_, '_>,
    ) -> Result<Self, IdentifyError> {
        let places = setup.places(problem, engine)?;
        let before = places.evaluations;
        let mut first = Self::at(places, problem, setup, engine)?;
        first.evaluations += before;
        Ok(first)
    }

    /// First points from given places.
    pub(super) fn at(
        places: Places,
        problem: &JointProblem,
        setup: &JointSetup<'_>,
        engine: &mut Engine<'_, '_>,
    ) -> Result<Self, IdentifyError> {
        let Starts { mut points, evaluations } = setup.fitted(problem, &places, 0..FIRST_STARTS, engine)?;
        points.extend(setup.unfitted(problem, &places, 0..1));
        Ok(Self { places, points: first_or_best(problem, points, engine), evaluations })
    }
}

/// The given points; after a stop the best one so far.
pub(super) fn first_or_best(
    problem: &JointProblem,
    points: Vec<Vec<f64>>,
    engine: &mut Engine<'_, '_>,
) -> Vec<Vec<f64>> {
    if engine.is_stopped() { problem.best().into_iter().collect() } else { points }
}

/// A few good starts; if their optima disagree, all others; if these disagree, and the residuals are far from
/// white, a population search with a twentieth of its usual budget and local polishing. An optimum above the
/// cost `hopeless` is not sought any further.
pub(super) fn search_globally(
    (problem, rate): (&JointProblem, Rate),
    (setup, first): (&JointSetup<'_>, Option<FirstPoints>),
    engine: &mut Engine<'_, '_>,
    (hopeless, show): (f64, Show<'_>),
) -> Result<Search, IdentifyError> {
    if problem.bounds().dimension() == 0 {
        return Ok(engine.local_fits(
            "joint fit",
            problem,
            vec![Vec::new()],
            LeastSquaresOptions::default(),
            show,
        )?);
    }
    if let Some(algorithm) = &setup.options.algorithm {
        let mut search = engine.search("joint fit", problem, setup.guesses(problem)?, show)?;
        if algorithm.name() != "least-squares" && !engine.cancelled {
            let best = search.outcome.best.clone();
            let polished = resolved_fit(engine, "joint fit, polished", problem, vec![best], None)?.outcome;
            (search.outcome.best, search.outcome.cost) = (polished.best, polished.cost);
        }
        return Ok(search);
    }
    let (mut search, settled) = if setup.options.start.is_some() {
        let search = engine.search("joint fit", problem, setup.guesses(problem)?, show)?;
        let settled = is_settled(&search);
        (search, settled)
    } else {
        search_from_places(problem, (setup, first), engine, (hopeless, show))?
    };
    let is_over = settled || engine.cancelled || search.outcome.cost > hopeless;
    if is_over || is_nearly_white(problem, &search.outcome.best) {
        return Ok(search);
    }
    if setup.form.creep != Creep::None && setup.options.start.is_none() {
        // Creep is small: the optimum without it lies near that with it.
        let without = setup.with(DynamicForm { creep: Creep::None, ..setup.form }, setup.options);
        let plain = without.problem(problem.degree(), rate)?;
        let found = search_from_places(&plain, (&without, None), engine, (f64::INFINITY, None));
        let found = match found {
            Err(_) if engine.is_stopped() => return Ok(search),
            found => found?.0,
        };
        let Some(guesses) = engine.unless_stopped(setup.guesses(problem))? else { return Ok(search) };
        let from_found = |guess: &Vec<f64>| from_other(&plain, &found.outcome.best, problem, guess);
        let starts = distinct(problem, guesses.iter().map(from_found).collect()).0;
        let grown = |x: &[f64]| shown(problem, x, setup);
        let fit = resolved_fit(engine, "joint fit with creep", problem, starts, Some(&grown));
        let Some(fit) = engine.unless_stopped(fit)? else { return Ok(search) };
        search.take_better(Some(fit));
    }
    let population = Algorithm::DeAbc(DeAbcOptions::default());
    let generations = (setup.options.generations / 20).max(5);
    let starts = vec![search.outcome.best.clone()];
    let wide = engine.run_for("joint fit, population", problem, &population, starts, generations, show);
    let Some(wide) = engine.unless_stopped(wide)? else { return Ok(search) };
    search.outcome.evaluations += wide.outcome.evaluations;
    let polished =
        resolved_fit(engine, "joint fit, population polished", problem, vec![wide.outcome.best], None);
    search.take_better(engine.unless_stopped(polished)?);
    Ok(search)
}

/// Fits from the first few places; from all others unless these settle it, or end above the cost `hopeless`.
/// With the search, whether it is settled.
pub(super) fn search_from_places(
    problem: &JointProblem,
    (setup, first): (&JointSetup<'_>, Option<FirstPoints>),
    engine: &mut Engine<'_, '_>,
    (hopeless, show): (f64, Show<'_>),
) -> Result<(Search, bool), IdentifyError> {
    let FirstPoints { places, points, evaluations } = match first {
        Some(first) => first,
        None => FirstPoints::new(problem, setup, engine)?,
    };
    let mut search = raced_fit(engine, "joint fit", problem, points, (hopeless, show))?;
    search.outcome.evaluations += evaluations;
    // Where nothing is left to explain, no other optimum can be better.
    if is_settled(&search) || engine.is_stopped() || is_nearly_white(problem, &search.outcome.best) {
        return Ok((search, true));
    }
    if search.outcome.cost > hopeless {
        return Ok((search, false));
    }
    let others = setup.fitted(problem, &places, FIRST_STARTS..usize::MAX, engine)?;
    search.outcome.evaluations += others.evaluations;
    let best = search.outcome.cost;
    let others = raced_fit(engine, "joint fit, other starts", problem, others.points, (best, show));
    search.take_better(engine.where_feasible(others)?);
    let settled = is_settled(&search);
    Ok((search, settled))
}

/// Fits from the first start; from the others too unless its residuals are nearly white, when no other optimum
/// can be better.
pub(super) fn fit_until_white(
    engine: &mut Engine<'_, '_>,
    step: &str,
    problem: &JointProblem,
    mut starts: Vec<Vec<f64>>,
    show: Show<'_>,
) -> Result<Search, OptimizeError> {
    let rest = starts.split_off(starts.len().min(1));
    let first = resolved_fit(engine, step, problem, starts, show);
    let mut search = if rest.is_empty() {
        first?
    } else {
        let Some(first) = engine.where_feasible(first)? else {
            return resolved_fit(engine, step, problem, rest, show);
        };
        first
    };
    if !rest.is_empty() && !engine.is_stopped() && !is_nearly_white(problem, &search.outcome.best) {
        // The first optimum again, so that a fit that will not reach it is abandoned.
        let starts = std::iter::once(search.outcome.best.clone()).chain(rest).collect();
        let others = resolved_fit(engine, step, problem, starts, show);
        search.take_better(engine.where_feasible(others)?);
    }
    Ok(search)
}

/// Starts that differ, and for each of the others the index of that which it is like.
fn distinct(problem: &JointProblem, starts: Vec<Vec<f64>>) -> (Vec<Vec<f64>>, Vec<usize>) {
    let (mut different, mut others): (Vec<Vec<f64>>, _) = (Vec::new(), Vec::new());
    for start in starts {
        match different.iter().position(|other| problem.are_near(other, &start, ALIKE)) {
            Some(index) => others.push(index),
            None => different.push(start),
        }
    }
    (different, others)
}

/// Rough fits from all starts; the best is continued if it is near `known`, the best cost before, or better. Of
/// starts that are alike, since fits with the loop held led them to one place, one is fitted for all.
fn raced_fit(
    engine: &mut Engine<'_, '_>,
    step: &str,
    problem: &JointProblem,
    starts: Vec<Vec<f64>>,
    (known, show): (f64, Show<'_>),
) -> Result<Search, OptimizeError> {
    let (starts, others) = distinct(problem, starts);
    let count = starts.len();
    let mut search = local_fits(engine, step, problem, starts, rough(), show)?;
    let ends = &mut search.outcome.starts;
    if ends.len() == count {
        ends.extend(others.into_iter().map(|index| ends[index].clone()).collect::<Vec<_>>());
    }
    if search.outcome.cost <= known * NEAR && !engine.is_stopped() {
        let best = search.outcome.best.clone();
        let finished = resolved_fit(engine, step, problem, vec![best.clone()], show);
        if let Some(finished) = engine.unless_stopped(finished)? {
            search.outcome.starts.retain(|start| start.best != best);
            search.take_better(Some(finished));
        }
    }
    Ok(search)
}

/// True if no better optimum is to be expected: fits from several starts come near the best one, and none of
/// these stalled.
fn is_settled(search: &Search) -> bool {
    let best = search.outcome.cost;
    let near = || search.outcome.starts.iter().filter(|start| start.cost <= SAME * best);
    let ended = near().filter(|start| start.status != LocalStatus::Abandoned).count();
    ended >= AGREEMENT && near().all(|start| start.status != LocalStatus::Stalled)
}

/// True if the residuals at `x` are not far from white, or from what reduction makes of white noise: there is
/// little left to explain.
pub(super) fn is_nearly_white(problem: &JointProblem, x: &[f64]) -> bool {
    let independent = |(record, time): (&JointRecord, f64)| {
        record.valid as f64 * (record.correlation_time_of_white() / time).min(1.0)
    };
    let independent: f64 = problem.records().iter().zip(correlation_times(problem, x)).map(independent).sum();
    independent >= WHITE * problem.valid() as f64
}

/// A point of a problem with other parameters: those of `x` by their names, the others from `guess`.
pub(super) fn from_other(other: &JointProblem, x: &[f64], problem: &JointProblem, guess: &[f64]) -> Vec<f64> {
    let place = |name: &str| other.bounds().ranges.iter().position(|range| range.name == name);
    let ranges = problem.bounds().ranges.iter().zip(guess);
    ranges.map(|(range, &guess)| place(&range.name).map_or(guess, |at| x[at])).collect()
}
