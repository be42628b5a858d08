//! Search of a joint fit, on reduced records where possible: multi-start, then tests for creep and the
//! polynomial degree.

use super::super::engine::{Engine, Search, Show, rough};
use super::super::options::{Choice, DynamicsChoice, Options};
use super::super::static_step::BIC_FALL;
use super::super::{DegreeTried, IdentifyError};
use super::campaign::Rate;
use super::degree::{DEGREE_OF_STARTS, choose_degree, fit_unless_hopeless, with_reach};
use super::model::shown;
use super::normalised::{fit_with_its_memory, local_fits, resolved_fit};
use super::problem::JointProblem;
use super::resolution::{COARSE, NEAR, information, resolved};
use super::setup::JointSetup;
use super::starts::{Places, Starts};
use hysteron_model::dynamics::{Creep, DynamicForm};
use hysteron_optimize::{Algorithm, DeAbcOptions, LeastSquaresOptions, LocalStatus, OptimizeError, Problem};

/// Residuals with an effective sample size below this share of their samples are far from white.
const WHITE: f64 = 0.5;
/// A rough fit whose cost is within this many times the best leads to the same optimum.
const SAME: f64 = 1.001;
/// Evidence for creep beyond doubt, relative to very strong evidence, and the least ratio of the costs.
const EVIDENT: f64 = 4.0;
const EVIDENT_RATIO: f64 = 1.5;
/// Fits that must come near the best optimum.
const AGREEMENT: usize = 3;
/// Number of first starts with fitted dynamics, in addition to the best unfitted one.
const FIRST_STARTS: usize = 2;

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
    let mut problem = setup.problem(first_degree, rate)?;
    let creep_is_open = options.dynamics == DynamicsChoice::Auto && options.creep == Creep::None;
    let with_creep = DynamicForm { creep: Creep::Fractional, ..setup.form };
    let is_free = options.algorithm.is_none() && options.start.is_none();
    let (mut first, mut found) = (None, None);
    if creep_is_open && is_free && problem.bounds().dimension() > 0 {
        let creeping = setup.with(with_creep, options);
        let mut begun = begin_with_creep(&problem, &creeping, rate, engine)?;
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
    let finer = if rate == Rate::Coarse { Rate::Reduced } else { rate };
    let is_final = shorter.is_none() && finer == rate;
    let setup = shorter.unwrap_or(setup);
    let (problem, rate, search) = if is_final || engine.is_stopped() {
        (problem, rate, search)
    } else {
        let finer_problem = setup.problem(problem.degree(), finer)?;
        let grown = |x: &[f64]| shown(&finer_problem, x, &setup);
        // The memory of the records hardly moves, and another one costs as much as all else.
        let start = search.outcome.best.clone();
        let start = if finer_problem.holding_memory(&start).is_some() {
            let options = resolved(COARSE);
            let held = fit_with_its_memory(
                engine,
                "joint fit",
                &finer_problem,
                start.clone(),
                options,
                Some(&grown),
            );
            engine.where_feasible(held)?.map_or(start, |held| held.outcome.best)
        } else {
            start
        };
        let fit = resolved_fit(engine, "joint fit", &finer_problem, vec![start], Some(&grown));
        match engine.unless_stopped(fit)? {
            Some(mut fit) => {
                fit.outcome.evaluations += search.outcome.evaluations;
                fit.outcome.generations += search.outcome.generations;
                (finer_problem, finer, fit)
            }
            None => (problem, rate, search),
        }
    };
    let mut degrees = Vec::new();
    let (degree, best) = if setup.options.degree == Choice::Auto && !engine.is_stopped() {
        choose_degree(&setup, rate, &search, engine, &mut degrees)?
    } else {
        (problem.degree(), search.outcome.best.clone())
    };
    Ok(Optimum { setup, problem, search, degree, best, degrees })
}

/// Candidate starts of a search, and the first few to fit from.
struct FirstPoints {
    places: Places,
    points: Vec<Vec<f64>>,
    /// Evaluations spent on finding them.
    evaluations: usize,
}

impl FirstPoints {
    fn new(
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
    fn at(
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

    /// True if no parameter of the dynamics is at an edge of its range.
    fn dynamics_are_inside(&self, setup: &JointSetup<'_>) -> bool {
        let own = setup.form.parameters();
        let is_own = |name: &str| own.iter().any(|parameter| parameter.name == name);
        let mut ranges = self.problem.bounds().ranges.iter().zip(&self.search.outcome.best);
        !ranges.any(|(range, x)| is_own(&range.name) && range.is_end(*x))
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
    creeping: &JointSetup<'_>,
    rate: Rate,
    engine: &mut Engine<'_, '_>,
) -> Result<CreepFirst, IdentifyError> {
    let problem = creeping.problem(plain.degree(), rate)?;
    let places = creeping.places(&problem, engine)?;
    // A loop held at one without creep misleads the dynamics where shape numbers are searched.
    let Starts { points, evaluations } = if problem.searches_shape() {
        Starts { points: creeping.unfitted(&problem, &places, 0..FIRST_STARTS), evaluations: 0 }
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

/// The given points; after a stop the best one so far.
fn first_or_best(
    problem: &JointProblem,
    points: Vec<Vec<f64>>,
    engine: &mut Engine<'_, '_>,
) -> Vec<Vec<f64>> {
    if engine.is_stopped() { problem.best().into_iter().collect() } else { points }
}

/// A few good starts; if their optima disagree, all others; if these disagree, and the residuals are far from
/// white, a population search with a twentieth of its usual budget and local polishing. An optimum above the
/// cost `hopeless` is not sought any further.
fn search_globally(
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
        let guesses = setup.guesses(problem)?.into_iter();
        let starts = guesses.map(|guess| from_other(&plain, &found.outcome.best, problem, &guess)).collect();
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
fn search_from_places(
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
    if is_settled(&search) || engine.is_stopped() {
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
fn fit_until_white(
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

/// Rough fits from all starts; the best is continued if it is near `known`, the best cost before, or better.
fn raced_fit(
    engine: &mut Engine<'_, '_>,
    step: &str,
    problem: &JointProblem,
    starts: Vec<Vec<f64>>,
    (known, show): (f64, Show<'_>),
) -> Result<Search, OptimizeError> {
    let mut search = local_fits(engine, step, problem, starts, rough(), show)?;
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

/// True if the residuals at `x` are not far from white: there is little left to explain.
fn is_nearly_white(problem: &JointProblem, x: &[f64]) -> bool {
    information(problem, x) >= WHITE * problem.valid() as f64
}

/// Evidence for a creep factor: the fall of −2 ln of the likelihood, the BIC penalty of its parameters, and
/// the ratio of the cost without it to that with it.
struct Gain {
    likelihood: f64,
    price: f64,
    ratio: f64,
    /// Fall of −2 ln of the likelihood by a factor e of the cost.
    of_ratio: f64,
}

impl Gain {
    /// Gain from the cost of a fit without creep to that of a fit with it.
    fn new((plain, cost): (&JointProblem, f64), (creeping, found): (&JointProblem, &Search)) -> Self {
        let information = information(creeping, &found.outcome.best);
        let ratio = cost / found.outcome.cost;
        let parameters = creeping.bounds().dimension() - plain.bounds().dimension();
        let price = parameters as f64 * information.ln();
        let of_ratio = 2.0 * information;
        Self { likelihood: of_ratio * ratio.ln(), price, ratio, of_ratio }
    }

    /// True if the evidence for creep is very strong.
    fn is_strong(&self) -> bool {
        self.likelihood > BIC_FALL + self.price
    }

    /// True if creep is beyond doubt although the fit without it is not converged: on records with creep such
    /// fits converge slowly.
    fn is_evident(&self) -> bool {
        self.ratio > EVIDENT_RATIO && self.is_overwhelming()
    }

    /// True if creep is beyond doubt where the fit without it is converged.
    fn is_overwhelming(&self) -> bool {
        self.likelihood > EVIDENT * (BIC_FALL + self.price)
    }
}

/// Cost of a fit without creep above which the one with creep that is `found` is preferred beyond doubt.
fn beaten(plain: &JointProblem, (creeping, found): (&JointProblem, &Search)) -> f64 {
    let equal = Gain::new((plain, found.outcome.cost), (creeping, found));
    let wanted = EVIDENT * (BIC_FALL + equal.price);
    found.outcome.cost * (wanted / equal.of_ratio).exp()
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
    let guesses = setup.guesses(&problem)?;
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

/// A point of a problem with other parameters: those of `x` by their names, the others from `guess`.
fn from_other(other: &JointProblem, x: &[f64], problem: &JointProblem, guess: &[f64]) -> Vec<f64> {
    let place = |name: &str| other.bounds().ranges.iter().position(|range| range.name == name);
    let ranges = problem.bounds().ranges.iter().zip(guess);
    ranges.map(|(range, &guess)| place(&range.name).map_or(guess, |at| x[at])).collect()
}
