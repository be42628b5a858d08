//! Orders of the dynamics where they are not asked for: whole ones, a resonance and a lag, or fractional ones.
//!
//! Stages have a resonance, an amplifier that lags, and a delay; creep is a factor of its own. Orders of a little
//! more than 2 and 1 can stand in for the lag within the band of the records, sometimes with a slightly smaller
//! error there, and part from the device above it (`docs/theory/joint.md`). So they must be worth it.

use super::super::IdentifyError;
use super::super::engine::{Engine, Search, rough};
use super::super::static_step::BIC_FALL;
use super::campaign::Rate;
use super::many_starts::{from_other, is_nearly_white};
use super::normalised::{local_fits, resolved_fit};
use super::parameter_layout::DELAY;
use super::problem::JointProblem;
use super::resolution::information;
use super::setup::JointSetup;
use super::starts::{Places, Starts};
use hysteron_model::dynamics::{Creep, DynamicForm, Modes, ParameterKind};
use hysteron_optimize::{Problem, Range};

/// Cost of whole orders over that of fractional ones from which on these are chosen.
const WORTH: f64 = 1.25;
/// Name of the fits with fractional orders.
const STEP: &str = "joint fit, fractional orders";

/// Where a search begins, and its first start, the dynamics fitted.
pub(super) struct Begun {
    pub(super) problem: JointProblem,
    pub(super) places: Places,
    pub(super) starts: Starts,
}

/// Whole orders, or fractional ones where these cost far less, both with this creep and fitted behind the loop of
/// the slowest record; and where the search with them begins.
pub(super) fn compared(
    setup: &JointSetup<'_>,
    creep: Creep,
    (degree, rate): (usize, Rate),
    engine: &mut Engine<'_, '_>,
) -> Result<(Modes, Begun), IdentifyError> {
    let [whole, fractional] = [setup.form.modes, Modes::Fractional]
        .map(|modes| setup.with(DynamicForm { modes, creep }, setup.options()));
    let problem = whole.problem(degree, rate)?;
    let places = whole.places(&problem, engine)?;
    let starts = whole.fitted(&problem, &places, 0..1, engine)?;
    let mut begun = Begun { problem, places, starts };
    if engine.is_stopped() {
        return Ok((whole.form.modes, begun));
    }
    let problem = fractional.problem(degree, rate)?;
    let places = fractional.places_of_loops(&problem, &begun.places);
    let mut starts = fractional.fitted(&problem, &places, 0..1, engine)?;
    if engine.is_stopped() || WORTH * least(&problem, &starts) >= least(&begun.problem, &begun.starts) {
        begun.starts.evaluations += starts.evaluations;
        return Ok((whole.form.modes, begun));
    }
    starts.evaluations += begun.places.evaluations + begun.starts.evaluations;
    Ok((fractional.form.modes, Begun { problem, places, starts }))
}

/// The least cost of the starts; infinite without one.
fn least(problem: &JointProblem, starts: &Starts) -> f64 {
    let mut ws = problem.workspace();
    starts.points.iter().map(|x| problem.cost(x, &mut ws)).fold(f64::INFINITY, f64::min)
}

/// What a fit with fractional orders from the optimum of whole ones shows.
pub(super) enum Orders {
    Whole,
    Fractional,
    /// Fractional ones at this point leave nothing to explain at this rate, but cost little less.
    InDoubt(Vec<f64>),
}

/// Fits fractional orders from the optimum `found` with whole ones.
pub(super) fn weighed(
    setup: &JointSetup<'_>,
    (problem, rate): (&JointProblem, Rate),
    found: &Search,
    engine: &mut Engine<'_, '_>,
) -> Result<Orders, IdentifyError> {
    let best = &found.outcome.best;
    if !setup.chooses_orders() || engine.is_stopped() || is_nearly_white(problem, best) {
        return Ok(Orders::Whole);
    }
    let fractional = engine.unless_stopped(with_fractional(setup).problem(problem.degree(), rate))?;
    let Some(fractional) = fractional else { return Ok(Orders::Whole) };
    let start = with_orders((problem, best), &fractional);
    let fit = local_fits(engine, STEP, &fractional, vec![start], rough(), None);
    let Some(fit) = engine.where_feasible(fit)?.filter(|_| !engine.is_stopped()) else {
        return Ok(Orders::Whole);
    };
    Ok(if WORTH * fit.outcome.cost < problem.cost(best, &mut problem.workspace()) {
        Orders::Fractional
    } else if is_nearly_white(&fractional, &fit.outcome.best) {
        Orders::InDoubt(fit.outcome.best)
    } else {
        Orders::Whole
    })
}

/// True if fractional orders, fitted from `start`, are better than the optimum `found` with whole ones by the
/// Bayesian information criterion.
pub(super) fn fractional_are_better(
    setup: &JointSetup<'_>,
    (problem, rate): (&JointProblem, Rate),
    found: &Search,
    start: Vec<f64>,
    engine: &mut Engine<'_, '_>,
) -> Result<bool, IdentifyError> {
    let fractional = engine.unless_stopped(with_fractional(setup).problem(problem.degree(), rate))?;
    let Some(fractional) = fractional else { return Ok(false) };
    let fit = resolved_fit(engine, STEP, &fractional, vec![start], None);
    let Some(fit) = engine.where_feasible(fit)?.filter(|_| !engine.is_stopped()) else { return Ok(false) };
    let samples = information(&fractional, &fit.outcome.best);
    let more = fractional.bounds().dimension() as f64 - problem.bounds().dimension() as f64;
    let fall = 2.0 * samples * (found.outcome.cost / fit.outcome.cost).ln();
    Ok(fall > BIC_FALL + more * samples.ln())
}

fn with_fractional<'a>(setup: &JointSetup<'a>) -> JointSetup<'a> {
    setup.with(DynamicForm { modes: Modes::Fractional, ..setup.form }, setup.options())
}

/// The point of the problem with orders 2 and 1, and the lag as part of the delay.
fn with_orders((whole, best): (&JointProblem, &[f64]), fractional: &JointProblem) -> Vec<f64> {
    let lag = whole.layout().role(&whole.form(), ParameterKind::Lag).and_then(|role| role.value(best));
    let form = fractional.form().parameters();
    let guess = |range: &Range| match form.iter().find(|parameter| parameter.name == range.name) {
        Some(parameter) if matches!(parameter.kind, ParameterKind::HighestOrder(_)) => 2.0,
        _ => 1.0,
    };
    let ranges = &fractional.bounds().ranges;
    let guess: Vec<f64> = ranges.iter().map(guess).collect();
    let mut start = from_other(whole, best, fractional, &guess);
    if let Some(delay) = ranges.iter().position(|range| range.name == DELAY) {
        start[delay] += lag.unwrap_or_default();
    }
    ranges.iter().zip(start).map(|(range, x)| x.clamp(range.low, range.high)).collect()
}
