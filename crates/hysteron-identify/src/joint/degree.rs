//! Structure of the static part that the records choose: reach of the plays, and degree of the polynomial.

use super::super::engine::{Engine, Search, rough};
use super::super::facts::amplitudes;
use super::super::static_step::{BIC_FALL, HIGHEST_AUTOMATIC_DEGREE};
use super::super::{HIGHEST_DEGREE, IdentifyError};
use super::normalised::{local_fits, resolved_fit};
use super::problem::JointProblem;
use super::resolution;
use super::search::NEAR;
use super::setup::{JointSetup, memory_name};
use hysteron_model::model_file::polynomial_name;
use hysteron_optimize::{LeastSquaresOptions, OptimizeError, Problem};

/// Polynomial degree of the starts where the degree is chosen from the data.
pub(super) const DEGREE_OF_STARTS: usize = 3;
/// Reaches of the plays that are tried, in shares of the largest half-width that the drives may move.
const REACHES: [f64; 5] = [0.9, 0.8, 0.7, 0.6, 0.5];

/// The search continued with the reach of the plays that fits the records best, where a density of plays is
/// searched: its corners are then where the device has plays.
pub(super) fn with_reach<'a>(
    setup: JointSetup<'a>,
    (problem, reduced): (JointProblem, bool),
    mut search: Search,
    engine: &mut Engine<'_, '_>,
) -> Result<(JointSetup<'a>, JointProblem, Search), IdentifyError> {
    if problem.hysteresis() == setup.options.family() || engine.is_stopped() {
        return Ok((setup, problem, search));
    }
    let mut best: Option<(f64, JointSetup<'a>)> = None;
    for share in REACHES {
        // Not below half of the range: its loop moves these plays, and a polynomial would stand in for them.
        let Some(shorter) = setup.with_reach(share) else { break };
        let problem = shorter.problem(problem.degree(), reduced)?;
        let cost = problem.cost(&search.outcome.best, &mut problem.workspace());
        if cost < best.as_ref().map_or(search.outcome.cost, |(cost, _)| *cost) {
            best = Some((cost, shorter));
        }
    }
    let Some((_, setup)) = best else { return Ok((setup, problem, search)) };
    let problem = setup.problem(problem.degree(), reduced)?;
    let fit = resolved_fit(engine, "joint fit", &problem, vec![search.outcome.best.clone()], None);
    search.take_better(engine.unless_stopped(fit)?);
    Ok((setup, problem, search))
}

/// Degree by BIC over the independent samples, from one warm-started fit each (of plays also from the memory
/// of a settled loop), and its best point.
pub(super) fn choose_degree(
    setup: &JointSetup<'_>,
    reduced: bool,
    found: &Search,
    engine: &mut Engine<'_, '_>,
    tried: &mut Vec<(usize, f64, f64)>,
) -> Result<(usize, Vec<f64>), IdentifyError> {
    let demanded = (1..=HIGHEST_DEGREE)
        .filter(|&d| setup.options.demands.names().any(|n| n == polynomial_name(d)))
        .max()
        .unwrap_or(1);
    let mut fits = Vec::new();
    let mut information = 2.0;
    // At a stop the residuals are unknown; nothing is fitted then.
    let own = setup.problem(DEGREE_OF_STARTS, reduced)?;
    let options = resolution::resolved(resolution::resolution(&own, &found.outcome.best));
    let highest = highest_degree(setup).max(demanded);
    for degree in 1..=highest {
        let problem = setup.problem(degree, reduced)?;
        let parameters = problem.bounds().dimension() + problem.layout().linear().count();
        let step = format!("degree {degree}");
        let mut fitted = |start: Vec<f64>, options: &LeastSquaresOptions| -> Result<_, IdentifyError> {
            let fit = fit_with_its_memory(engine, &step, &problem, start, options.clone());
            let fit = engine.unless_stopped(fit)?.filter(|_| !engine.is_stopped());
            Ok(fit.map(|fit| (fit.outcome.cost, fit.outcome.best)))
        };
        let own = found.outcome.best.clone();
        let mut ends: Vec<(f64, Vec<f64>)> = if degree == DEGREE_OF_STARTS {
            vec![(found.outcome.cost, own)]
        } else {
            fitted(own, &options)?.into_iter().collect()
        };
        if setup.hysteresis.description().is_written_as_plays() {
            let settled = with_settled_memory(setup, &problem, &found.outcome.best);
            let near = ends.first().map_or(f64::INFINITY, |(cost, _)| cost * NEAR);
            let rough = fitted(settled, &rough())?.filter(|(cost, _)| *cost < near);
            ends.extend(rough.map(|(_, x)| fitted(x, &options)).transpose()?.flatten());
        }
        let best = ends.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((cost, best)) = best.filter(|_| !engine.is_stopped()) else { break };
        if degree == highest {
            // That of the richest fit is used: its residual is the least structured.
            information = resolution::information(&problem, &best);
        }
        fits.push((degree, cost, parameters, best));
    }
    let mut chosen: Option<(usize, f64, Vec<f64>)> = None;
    for (degree, cost, parameters, best) in fits {
        let bic =
            information * (cost * cost).max(f64::MIN_POSITIVE).ln() + parameters as f64 * information.ln();
        tried.push((degree, cost, bic));
        let better = chosen.as_ref().is_none_or(|(_, before, _)| bic < before - BIC_FALL);
        if better || degree <= demanded {
            chosen = Some((degree, bic, best));
        }
    }
    let Some((degree, _, mut best)) = chosen else { return Ok((demanded, found.outcome.best.clone())) };
    let problem = setup.problem(degree, reduced)?;
    let is_moved = degree != DEGREE_OF_STARTS || best != found.outcome.best;
    if is_moved && problem.holding_memory(&best).is_some() && !engine.is_stopped() {
        let fit = resolved_fit(engine, &format!("degree {degree}"), &problem, vec![best.clone()], None);
        best = engine.unless_stopped(fit)?.map_or(best, |fit| fit.outcome.best);
    }
    Ok((degree, best))
}

/// The point `x` with the memory of every record that of a loop which has settled: with a polynomial in the
/// place of plays, a search may end in a local optimum with another memory.
fn with_settled_memory(setup: &JointSetup<'_>, problem: &JointProblem, x: &[f64]) -> Vec<f64> {
    let shape = problem.candidate(x).map_or_else(Vec::new, |candidate| candidate.shape);
    let ranges = problem.bounds().ranges.iter().zip(x);
    let record = |name: &str| (0..setup.members.len()).find(|&record| name == memory_name(record));
    let settled = |record| setup.first_memory(&shape, true, record);
    ranges.map(|(range, &x)| record(&range.name).map_or(x, settled).clamp(range.low, range.high)).collect()
}

/// Highest degree tried. Loops of one amplitude do not tell a polynomial from a density of plays: what a
/// higher one adds at their ends is wrong for minor loops.
fn highest_degree(setup: &JointSetup<'_>) -> usize {
    let of_plays = setup.hysteresis.description().is_written_as_plays();
    if of_plays && amplitudes(setup.members.iter().map(|member| member.facts)) <= 1 {
        DEGREE_OF_STARTS
    } else {
        HIGHEST_AUTOMATIC_DEGREE
    }
}

/// A local fit with the memory held where this spares rerunning the operators, else with all free.
pub(in super::super) fn fit_with_its_memory(
    engine: &mut Engine<'_, '_>,
    step: &str,
    problem: &JointProblem,
    start: Vec<f64>,
    options: LeastSquaresOptions,
) -> Result<Search, OptimizeError> {
    let Some(held) = problem.holding_memory(&start) else {
        return local_fits(engine, step, problem, vec![start], options, None);
    };
    let (searched, memory) = start.split_at(held.bounds().dimension());
    let mut fit = local_fits(engine, step, &held, vec![searched.to_vec()], options, None)?;
    fit.outcome.best.extend(memory);
    Ok(fit)
}
