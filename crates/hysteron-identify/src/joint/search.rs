//! Search of a joint fit, on reduced records where possible: multi-start, then tests for creep and the
//! polynomial degree.

use super::super::engine::{Engine, Search, rough};
use super::super::options::{Choice, DynamicsChoice, Options};
use super::super::{DegreeTried, IdentifyError};
use super::campaign::Rate;
use super::creep_gain::{Gain, beaten};
use super::degree::{DEGREE_OF_STARTS, choose_degree, fit_unless_hopeless, with_reach};
use super::many_starts::{
    FIRST_STARTS, FirstPoints, first_or_best, fit_until_white, from_other, is_nearly_white,
    search_from_places, search_globally,
};
use super::model::shown;
use super::normalised::{fit_with_its_memory, nearer_with_its_memory, resolved_fit};
use super::orders::{self, Begun, Orders};
use super::problem::JointProblem;
use super::resolution::{COARSE, resolved};
use super::setup::JointSetup;
use super::starts::{Places, Starts, on_wider_band};
use hysteron_model::dynamics::{Creep, DynamicForm, Modes, ParameterKind};
use hysteron_optimize::{Problem, Range};

/// The best point of a search and its structure.
pub(super) struct Optimum<'a> {
    pub(super) setup: JointSetup<'a>,
    /// The problem that was searched, of the degree of the starts.
    pub(super) problem: JointProblem,
    pub(super) search: Search,
    /// The degree chosen, and the best point in it.
    pub(super) degree: usize,
    pub(super) best: Vec<f64>,
    /// Degrees tried, with cost and BIC.
    pub(super) degrees: Vec<DegreeTried>,
}

/// Searches with the delays, creep and degree that the options leave open: from many starts on records of the
/// lowest rate, where they are `reduced`.
pub(super) fn search<'a>(
    mut setup: JointSetup<'a>,
    reduced: bool,
    engine: &mut Engine<'_, '_>,
) -> Result<Optimum<'a>, IdentifyError> {
    let options: &Options = setup.options;
    let first_degree = match options.degree {
        Choice::Given(degree) => degree,
        Choice::Auto => DEGREE_OF_STARTS,
    };
    let rate = match options.algorithm {
        None if reduced => Rate::Coarse,
        Some(_) if reduced => Rate::Reduced,
        _ => Rate::Own,
    };
    let creep_is_open = options.dynamics == DynamicsChoice::Auto && options.creep == Creep::None;
    let mut begun = None;
    if setup.chooses_orders() {
        let creep = if creep_is_open { Creep::Fractional } else { setup.form.creep };
        let (modes, first) = orders::compared(&setup, creep, (first_degree, rate), engine)?;
        setup.form.modes = modes;
        begun = Some(first);
    }
    let with_creep = DynamicForm { creep: Creep::Fractional, ..setup.form };
    let is_free = options.algorithm.is_none() && options.start.is_none();
    let (mut first, mut found) = (None, None);
    let mut problem = match begun.take_if(|_| !creep_is_open) {
        Some(Begun { problem, places, starts }) => {
            let before = places.evaluations + starts.evaluations;
            let mut points = FirstPoints::at(places, &problem, &setup, engine)?;
            points.evaluations += before;
            first = Some(points);
            problem
        }
        None => setup.problem(first_degree, rate)?,
    };
    if creep_is_open && is_free && problem.bounds().dimension() > 0 {
        let creeping = setup.with(with_creep, options);
        let mut begun = begin_with_creep(&problem, (&creeping, begun), rate, engine)?;
        begun.search.outcome.evaluations += begun.evaluations();
        let shows_creep = begun.shows_creep(&problem) && begun.delay_is_inside(&creeping);
        if shows_creep && !begun.dynamics_are_inside(&creeping) && !engine.is_stopped() {
            // An optimum at an edge of the search may be a local one.
            let first = FirstPoints::at(begun.places, &begun.problem, &creeping, engine)?;
            let places = (&creeping, Some(first));
            let others = search_from_places(&begun.problem, places, engine, (f64::INFINITY, None));
            let others = engine.unless_stopped(others.map(|(others, _)| others))?;
            begun.search.take_better(others);
            return with_degree(creeping, (begun.problem, rate), begun.search, engine);
        }
        if shows_creep || engine.is_stopped() {
            return with_degree(creeping, (begun.problem, rate), begun.search, engine);
        }
        if let Some(plain) = &begun.plain
            && is_nearly_white(&problem, &plain.outcome.best)
        {
            // Nothing is left to explain: other starts, and creep, cannot do better.
            let grown = |x: &[f64]| shown(&problem, x, &setup);
            let fit =
                resolved_fit(engine, "joint fit", &problem, vec![plain.outcome.best.clone()], Some(&grown));
            if let Some(mut fit) = engine.unless_stopped(fit)? {
                fit.outcome.evaluations += begun.search.outcome.evaluations;
                return with_degree(setup, (problem, rate), fit, engine);
            }
        }
        let mut from_places = FirstPoints::at(begun.places, &problem, &setup, engine)?;
        from_places.points.splice(0..0, begun.plain.map(|plain| plain.outcome.best));
        (first, found) = (Some(from_places), Some((begun.problem, begun.search)));
    }
    let grown = |x: &[f64]| shown(&problem, x, &setup);
    let hopeless = found.as_ref().map_or(f64::INFINITY, |(richer, found)| beaten(&problem, (richer, found)));
    let mut search = search_globally((&problem, rate), (&setup, first), engine, (hopeless, Some(&grown)))?;
    if let Some(longer) =
        setup.with_longer_delays(&problem, &search.outcome.best).filter(|_| !engine.is_stopped())
    {
        let wide = longer.problem(first_degree, rate)?;
        let grown = |x: &[f64]| shown(&wide, x, &longer);
        let wider = search_globally((&wide, rate), (&longer, None), engine, (hopeless, Some(&grown)));
        if let Some(mut wider) = engine.unless_stopped(wider)? {
            let from_edge = resolved_fit(engine, "joint fit", &wide, vec![search.outcome.best.clone()], None);
            wider.take_better(engine.unless_stopped(from_edge)?);
            (setup, problem, search, found) = (longer, wide, wider, None);
        }
    }
    if creep_is_open {
        let creeping = setup.with(with_creep, options);
        let plain = (&problem, &search.outcome.best[..]);
        if let Some((richer, found)) = try_creep(plain, &creeping, rate, found, engine)?
            && Gain::new((&problem, search.outcome.cost), (&richer, &found)).is_strong()
        {
            return with_degree(creeping, (richer, rate), found, engine);
        }
    }
    with_degree(setup, (problem, rate), search, engine)
}

/// The best point of a search with the chosen degree.
fn with_degree<'a>(
    setup: JointSetup<'a>,
    (problem, rate): (JointProblem, Rate),
    mut search: Search,
    engine: &mut Engine<'_, '_>,
) -> Result<Optimum<'a>, IdentifyError> {
    search.outcome.best = problem.in_order(search.outcome.best);
    let shorter = with_reach(&setup, (&problem, rate), &mut search, engine)?;
    let mut in_doubt = None;
    if setup.chooses_orders() {
        let nearer = shorter.as_ref().map(|shorter| shorter.problem(problem.degree(), rate)).transpose()?;
        let (own, found) = (shorter.as_ref().unwrap_or(&setup), nearer.as_ref().unwrap_or(&problem));
        match orders::weighed(own, (found, rate), &search, engine)? {
            Orders::Whole => {}
            Orders::Fractional => {
                return with_fractional_orders(&setup.clone(), rate, (setup, problem, search), engine);
            }
            Orders::InDoubt(point) => in_doubt = Some((setup.clone(), point)),
        }
    }
    let finer = if rate == Rate::Coarse { Rate::Reduced } else { rate };
    let is_final = shorter.is_none() && finer == rate;
    let setup = shorter.unwrap_or(setup);
    let finer_problem = if is_final || engine.is_stopped() {
        None
    } else {
        engine.unless_stopped(setup.problem(problem.degree(), finer))?
    };
    let (problem, rate, search) = if let Some(finer_problem) = finer_problem {
        let grown = |x: &[f64]| shown(&finer_problem, x, &setup);
        let (start, tried) = on_wider_band(&finer_problem, search.outcome.best.clone(), engine.stop());
        let options = resolved(COARSE);
        let start =
            nearer_with_its_memory(engine, "joint fit", &finer_problem, start, options, Some(&grown))?;
        let fit = resolved_fit(engine, "joint fit", &finer_problem, vec![start], Some(&grown));
        match engine.unless_stopped(fit)? {
            Some(mut fit) => {
                fit.outcome.evaluations += search.outcome.evaluations + tried;
                fit.outcome.generations += search.outcome.generations;
                problem.free_scratch();
                (finer_problem, finer, fit)
            }
            None => (problem, rate, search),
        }
    } else {
        (problem, rate, search)
    };
    if let Some((longest, point)) = in_doubt.filter(|_| !engine.is_stopped())
        && orders::fractional_are_better(&setup, (&problem, rate), &search, point, engine)?
    {
        let coarsest = if rate == Rate::Reduced { Rate::Coarse } else { rate };
        return with_fractional_orders(&longest, coarsest, (setup, problem, search), engine);
    }
    let mut degrees = Vec::new();
    let (degree, best) = if setup.options.degree == Choice::Auto && !engine.is_stopped() {
        choose_degree(&setup, rate, &search, engine, &mut degrees)?
    } else {
        (problem.degree(), search.outcome.best.clone())
    };
    Ok(Optimum { setup, problem, search, degree, best, degrees })
}

/// The whole search again with fractional orders; after a stop what was found with whole ones.
fn with_fractional_orders<'a>(
    from: &JointSetup<'a>,
    rate: Rate,
    (setup, problem, found): (JointSetup<'a>, JointProblem, Search),
    engine: &mut Engine<'_, '_>,
) -> Result<Optimum<'a>, IdentifyError> {
    let form = DynamicForm { modes: Modes::Fractional, creep: from.options.creep };
    let again = search(from.with(form, from.options), rate == Rate::Coarse, engine);
    if engine.is_stopped() {
        let (degree, best) = (problem.degree(), found.outcome.best.clone());
        return Ok(Optimum { setup, problem, search: found, degree, best, degrees: Vec::new() });
    }
    let mut again = again?;
    again.search.outcome.evaluations += found.outcome.evaluations;
    Ok(again)
}

/// A fit with creep, and a rough fit without creep from its optimum.
struct CreepFirst {
    problem: JointProblem,
    search: Search,
    /// None after a stop, and where it cannot be simulated from there.
    plain: Option<Search>,
    /// The fit without creep is no longer a rough one.
    is_followed: bool,
    places: Places,
    /// Evaluations before the fit with creep.
    before: usize,
}

impl CreepFirst {
    /// Evaluations other than those of the fit with creep.
    fn evaluations(&self) -> usize {
        self.before + self.plain.as_ref().map_or(0, |plain| plain.outcome.evaluations)
    }

    /// True if creep is beyond doubt.
    fn shows_creep(&self, plain: &JointProblem) -> bool {
        self.plain.as_ref().is_some_and(|fit| {
            let gain = Gain::new((plain, fit.outcome.cost), (&self.problem, &self.search));
            if self.is_followed { gain.is_overwhelming() } else { gain.is_evident() }
        })
    }

    /// True if no parameter of the dynamics is at an edge of its range; the shortest lag is none, nor the lightest
    /// damping, which these records do not determine where the resonance is beyond their band.
    fn dynamics_are_inside(&self, setup: &JointSetup<'_>) -> bool {
        let own = setup.form.parameters();
        let is_at_edge = |(range, &x): (&Range, &f64)| match own.iter().find(|own| own.name == range.name) {
            Some(own) => match own.kind {
                ParameterKind::Lag | ParameterKind::Damping(_) => range.is_upper_end(x),
                _ => range.is_end(x),
            },
            None => false,
        };
        !self.problem.bounds().ranges.iter().zip(&self.search.outcome.best).any(is_at_edge)
    }

    /// True if the delay is not at the upper end of its range.
    fn delay_is_inside(&self, setup: &JointSetup<'_>) -> bool {
        setup.with_longer_delays(&self.problem, &self.search.outcome.best).is_none()
    }
}

/// Fits with creep before any fit without it. Without creep the lowest order compensates for it, along a
/// valley that takes long to follow in either direction.
fn begin_with_creep(
    plain: &JointProblem,
    (creeping, begun): (&JointSetup<'_>, Option<Begun>),
    rate: Rate,
    engine: &mut Engine<'_, '_>,
) -> Result<CreepFirst, IdentifyError> {
    let (problem, places, starts) = match begun {
        Some(Begun { problem, places, starts }) => (problem, places, Some(starts)),
        None => {
            let problem = creeping.problem(plain.degree(), rate)?;
            let places = creeping.places(&problem, engine)?;
            (problem, places, None)
        }
    };
    // A loop held at one without creep misleads the dynamics where shape numbers are searched.
    let Starts { points, evaluations } = if problem.searches_shape() {
        let points = creeping.unfitted(&problem, &places, 0..FIRST_STARTS);
        Starts { points, evaluations: starts.map_or(0, |starts| starts.evaluations) }
    } else if let Some(starts) = starts {
        starts
    } else {
        creeping.fitted(&problem, &places, 0..1, engine)?
    };
    let before = places.evaluations + evaluations;
    let points =
        if points.is_empty() { creeping.unfitted(&problem, &places, 0..FIRST_STARTS) } else { points };
    let points = first_or_best(&problem, points, engine);
    let grown = |x: &[f64]| shown(&problem, x, creeping);
    let search = fit_until_white(engine, "joint fit with creep", &problem, points, Some(&grown))?;
    let start = from_other(&problem, &search.outcome.best, plain, &vec![0.0; plain.bounds().dimension()]);
    let (mut plain_fit, mut is_followed) = (None, false);
    if !engine.is_stopped() {
        let step = "joint fit without creep";
        let is_evident = |cost| Gain::new((plain, cost), (&problem, &search)).is_evident();
        let fit = fit_unless_hopeless(engine, step, plain, start, rough(), is_evident);
        plain_fit = engine.where_feasible(fit)?;
        if let Some(rough) = &mut plain_fit {
            let gain = Gain::new((plain, rough.outcome.cost), (&problem, &search));
            // A fit from other starts takes far longer than the end of this one.
            if gain.is_overwhelming() && !gain.is_evident() && !engine.is_stopped() {
                let start = rough.outcome.best.clone();
                let fit = fit_with_its_memory(engine, step, plain, start, resolved(COARSE), None);
                let fit = engine.unless_stopped(fit)?;
                is_followed = fit.is_some();
                rough.take_better(fit);
            }
        }
    }
    Ok(CreepFirst { problem, search, plain: plain_fit, is_followed, places, before })
}

/// A fit of the same dynamics with a creep factor, from the optimum without one, or the fit `found` before if
/// better; `None` where the residuals without creep are not far from white.
fn try_creep(
    (plain, best): (&JointProblem, &[f64]),
    setup: &JointSetup<'_>,
    rate: Rate,
    found: Option<(JointProblem, Search)>,
    engine: &mut Engine<'_, '_>,
) -> Result<Option<(JointProblem, Search)>, IdentifyError> {
    if engine.is_stopped() || is_nearly_white(plain, best) {
        return Ok(None);
    }
    let problem = setup.problem(plain.degree(), rate)?;
    let Some(guesses) = engine.unless_stopped(setup.guesses(&problem))? else { return Ok(None) };
    let mut starts: Vec<_> =
        guesses.first().map(|guess| from_other(plain, best, &problem, guess)).into_iter().collect();
    if found.is_none() {
        starts.extend(guesses);
    }
    let grown = |x: &[f64]| shown(&problem, x, setup);
    let search = resolved_fit(engine, "joint fit with creep", &problem, starts, Some(&grown));
    let search = engine.unless_stopped(search)?.filter(|_| !engine.is_stopped());
    Ok(search.map(|mut search| {
        search.take_better(found.map(|(_, found)| found));
        (problem, search)
    }))
}
