//! Structure of the static part that the records choose: reach of the plays, and degree of the polynomial.

use super::super::engine::{Engine, Search, rough};
use super::super::facts::amplitudes;
use super::super::static_step::{BIC_FALL, HIGHEST_AUTOMATIC_DEGREE};
use super::super::{DegreeTried, HIGHEST_DEGREE, IdentifyError};
use super::campaign::Rate;
use super::normalised::{fit_with_its_memory, resolved_fit};
use super::problem::JointProblem;
use super::resolution::{self, COARSE, NEAR, resolved};
use super::setup::{JointSetup, memory_name};
use hysteron_model::model_file::polynomial_name;
use hysteron_optimize::{LeastSquaresOptions, OptimizeError, Problem};
use rayon::prelude::*;

/// Polynomial degree of the starts where the degree is chosen from the data.
pub(super) const DEGREE_OF_STARTS: usize = 3;
/// Reaches of the plays that are tried, in shares of the largest half-width that the drives may move.
const REACHES: [f64; 5] = [0.9, 0.8, 0.7, 0.6, 0.5];

/// A memory whose rough fit costs more than this many times the best is wrong.
const FAR: f64 = 3.0;
/// Degrees within this many times [`BIC_FALL`] of the best may be chosen.
const CLOSE: f64 = 10.0;
/// Iterations after which a fit shows whether it may still matter, and shares of the costs at its start and
/// then that it cannot come below.
const BRIEF: usize = 3;
const OF_START: f64 = 0.25;
const OF_BRIEF: f64 = 0.5;
/// Of a fit that starts too high, the relative fall of the squared cost at which it ends for the time being, and the
/// share of the cost then that going on cannot come below.
const ROUGHLY: f64 = 1e-2;
const OF_ROUGH: f64 = 0.95;

/// The setup with the reach of the plays that fits the records best at the optimum of a search, where a density
/// of plays is searched: its corners are then where the device has plays. `None` where the present one is.
pub(super) fn with_reach<'a>(
    setup: &JointSetup<'a>,
    (problem, rate): (&JointProblem, Rate),
    search: &mut Search,
    engine: &mut Engine<'_, '_>,
) -> Result<Option<JointSetup<'a>>, IdentifyError> {
    if problem.hysteresis() == setup.options.family() || engine.is_stopped() {
        return Ok(None);
    }
    if problem.keeps_memory() {
        // Plays of another reach make up for another memory.
        let free = setup.problem(problem.degree(), rate)?.keeping_memory(false);
        let fit = resolved_fit(engine, "joint fit", &free, vec![search.outcome.best.clone()], None);
        search.take_better(engine.unless_stopped(fit)?);
    }
    // Not below half of the range: its loop moves these plays, and a polynomial would stand in for them.
    let shorter: Vec<JointSetup<'a>> =
        REACHES.into_iter().map_while(|share| setup.with_reach(share)).collect();
    let cost = |shorter: &JointSetup<'a>| -> Result<f64, IdentifyError> {
        let problem = shorter.problem(problem.degree(), rate)?;
        Ok(problem.cost(&search.outcome.best, &mut problem.workspace()))
    };
    let costs: Vec<_> = shorter.par_iter().map(cost).collect();
    let mut best: Option<(f64, JointSetup<'a>)> = None;
    for (cost, shorter) in costs.into_iter().zip(shorter) {
        let cost = cost?;
        if cost < best.as_ref().map_or(search.outcome.cost, |(cost, _)| *cost) {
            best = Some((cost, shorter));
        }
    }
    Ok(best.map(|(_, shorter)| shorter))
}

/// Degree by BIC over the independent samples, from one warm-started fit each (of plays also from the memory
/// of a settled loop), and its best point.
pub(super) fn choose_degree(
    setup: &JointSetup<'_>,
    rate: Rate,
    found: &Search,
    engine: &mut Engine<'_, '_>,
    tried: &mut Vec<DegreeTried>,
) -> Result<(usize, Vec<f64>), IdentifyError> {
    let demanded = (1..=HIGHEST_DEGREE)
        .filter(|&d| setup.options.demands.names().any(|n| n == polynomial_name(d)))
        .max()
        .unwrap_or(1);
    let mut fits: Vec<DegreeFit> = Vec::new();
    // At a stop the residuals are unknown; nothing is fitted then.
    let searched = setup.problem(DEGREE_OF_STARTS, rate)?;
    let fine = resolution::resolution(&searched, &found.outcome.best);
    let so_far = resolution::information(&searched, &found.outcome.best);
    let unknowns = |problem: &JointProblem| problem.bounds().dimension() + problem.layout().linear().count();
    let own = bic(found.outcome.cost, unknowns(&searched), so_far);
    let highest = highest_degree(setup).max(demanded);
    let mut information = 2.0;
    let mut settled_may_be_better = setup.hysteresis.description().is_written_as_plays() && {
        let settled = with_settled_memory(setup, &searched, &found.outcome.best);
        OF_START * searched.cost(&settled, &mut searched.workspace()) < FAR * found.outcome.cost
    };
    for degree in 1..=highest {
        let problem = setup.problem(degree, rate)?;
        let parameters = unknowns(&problem);
        let start = found.outcome.best.clone();
        let is_hopeless = |cost: f64| bic(cost, parameters, so_far) > own + CLOSE * BIC_FALL;
        let mut ends: Vec<(f64, Vec<f64>)> = if degree == DEGREE_OF_STARTS {
            vec![(found.outcome.cost, start)]
        } else {
            let step = format!("degree {degree}");
            let fit = fit_unless_hopeless(engine, &step, &problem, start, resolved(COARSE), is_hopeless);
            ended(engine, fit)?.into_iter().collect()
        };
        if settled_may_be_better {
            let settled = with_settled_memory(setup, &problem, &found.outcome.best);
            let own = ends.first().map_or(f64::INFINITY, |(cost, _)| *cost);
            let rough = fitted(engine, &problem, settled, rough())?;
            // The memory of the records is the same at every degree.
            settled_may_be_better = rough.as_ref().is_some_and(|(cost, _)| *cost < FAR * own);
            let fit = rough
                .filter(|(cost, _)| *cost < NEAR * own)
                .map(|(_, x)| fitted(engine, &problem, x, resolved(COARSE)));
            ends.extend(fit.transpose()?.flatten());
        }
        let best = ends.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((cost, x)) = best.filter(|_| !engine.is_stopped()) else { break };
        if degree == highest {
            // That of the richest fit is used: its residual is the least structured.
            information = resolution::information(&problem, &x);
        }
        fits.push(DegreeFit { degree, cost, parameters, x });
    }
    // Those that may be chosen are fitted to the end.
    let lowest = fits.iter().map(|fit| fit.bic(information)).fold(f64::INFINITY, f64::min);
    for fit in fits.iter_mut().filter(|_| fine < COARSE) {
        let is_near = fit.bic(information) < lowest + CLOSE * BIC_FALL;
        if !is_near || fit.degree == DEGREE_OF_STARTS && fit.x == found.outcome.best || engine.is_stopped() {
            continue;
        }
        let problem = setup.problem(fit.degree, rate)?;
        if let Some((cost, x)) = fitted(engine, &problem, fit.x.clone(), resolved(fine))? {
            (fit.cost, fit.x) = (cost, x);
        }
    }
    let mut chosen: Option<(usize, f64, Vec<f64>)> = None;
    for fit in fits {
        let (degree, bic) = (fit.degree, fit.bic(information));
        tried.push(DegreeTried {
            degree,
            rmse: fit.cost,
            bic,
            is_demanded: degree <= demanded && demanded > 1,
            is_bounded: true,
        });
        let better = chosen.as_ref().is_none_or(|(_, before, _)| bic < before - BIC_FALL);
        if better || degree <= demanded {
            chosen = Some((degree, bic, fit.x));
        }
    }
    let Some((degree, _, best)) = chosen else { return Ok((demanded, found.outcome.best.clone())) };
    Ok((degree, best))
}

/// The best fit of one degree.
struct DegreeFit {
    degree: usize,
    cost: f64,
    parameters: usize,
    x: Vec<f64>,
}

impl DegreeFit {
    fn bic(&self, information: f64) -> f64 {
        bic(self.cost, self.parameters, information)
    }
}

fn bic(cost: f64, parameters: usize, information: f64) -> f64 {
    let square = (cost * cost).max(f64::MIN_POSITIVE);
    information * square.ln() + parameters as f64 * information.ln()
}

/// Cost and end of a fit of one degree; `None` after a stop.
fn fitted(
    engine: &mut Engine<'_, '_>,
    problem: &JointProblem,
    start: Vec<f64>,
    options: LeastSquaresOptions,
) -> Result<Option<(f64, Vec<f64>)>, IdentifyError> {
    let step = format!("degree {}", problem.degree());
    let fit = fit_with_its_memory(engine, &step, problem, start, options, None);
    ended(engine, fit)
}

/// Cost and end of a fit; `None` after a stop.
fn ended(
    engine: &mut Engine<'_, '_>,
    fit: Result<Search, OptimizeError>,
) -> Result<Option<(f64, Vec<f64>)>, IdentifyError> {
    let fit = engine.unless_stopped(fit)?.filter(|_| !engine.is_stopped());
    Ok(fit.map(|fit| (fit.outcome.cost, fit.outcome.best)))
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
    if of_plays && amplitudes(setup.members.iter().map(|member| member.facts.drive())) <= 1 {
        DEGREE_OF_STARTS
    } else {
        HIGHEST_AUTOMATIC_DEGREE
    }
}

/// [`fit_with_its_memory`], ended after a few iterations where a cost far below that reached then would still
/// be hopeless, and early where one a little below would be.
pub(super) fn fit_unless_hopeless(
    engine: &mut Engine<'_, '_>,
    step: &str,
    problem: &JointProblem,
    start: Vec<f64>,
    options: LeastSquaresOptions,
    is_hopeless: impl Fn(f64) -> bool,
) -> Result<Search, OptimizeError> {
    let at_start = problem.cost(&start, &mut problem.workspace());
    if !at_start.is_finite() || !is_hopeless(at_start) {
        return fit_with_its_memory(engine, step, problem, start, options, None);
    }
    let (first, share) = if is_hopeless(OF_START * at_start) {
        (LeastSquaresOptions { iterations: BRIEF, ..options.clone() }, OF_BRIEF)
    } else {
        (
            LeastSquaresOptions { cost_tolerance: ROUGHLY.max(options.cost_tolerance), ..options.clone() },
            OF_ROUGH,
        )
    };
    let fit = fit_with_its_memory(engine, step, problem, start, first, None)?;
    if is_hopeless(share * fit.outcome.cost) || engine.is_stopped() {
        return Ok(fit);
    }
    let (evaluations, from) = (fit.outcome.evaluations, fit.outcome.best);
    let mut fit = fit_with_its_memory(engine, step, problem, from, options, None)?;
    fit.outcome.evaluations += evaluations;
    Ok(fit)
}
