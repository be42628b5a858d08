//! From records to a model in one fit: reduced records from many starts, then all samples from the best.

use super::super::engine::{Engine, Search, Show};
use super::super::options::{Choice, DynamicsChoice, Method, Options, RecordRole};
use super::super::result::{Identification, RecordFit, Reduction, StructureChoice};
use super::super::sines::SineResponse;
use super::super::static_step::{BIC_FALL, HIGHEST_AUTOMATIC_DEGREE, OFFSET};
use super::super::uncertainty::correlation_time;
use super::super::{IdentifyError, RecordFacts, findings};
use super::band::{self, OutputUncertainty};
use super::between;
use super::campaign::JointMember;
use super::intervals::intervals;
use super::knowledge::{self, Covariance};
use super::parameters;
use super::problem::{JointProblem, JointSolution};
use super::setup::{self, JointSetup, memory_name};
use super::smoothing::smoothed;
use super::starts::Starts;
use crate::watch::Plan;
use hysteron_model::Start;
use hysteron_model::dynamics::{Creep, DynamicForm, Dynamics, Modes};
use hysteron_model::hammerstein::Model;
use hysteron_model::model_file::{ModelFile, SignalUnits, polynomial_name};
use hysteron_model::record::range_of;
use hysteron_model::validate::{Scoring, choose_start, mean_residual, score};
use hysteron_optimize::{Algorithm, DeAbcOptions, LeastSquaresProblem, OptimizeError, Problem};
use rayon::prelude::*;

/// Degree that the starts are tried with where it is chosen from the data.
pub(super) const DEGREE_OF_STARTS: usize = 3;
/// Residuals worth less than this share of their samples are far from white.
const WHITE: f64 = 0.5;
/// Starts that must end in the same optimum.
const AGREEMENT: usize = 3;
/// Starts with fitted dynamics, beside the best one as it is, before any other.
const FIRST_STARTS: usize = 2;

/// The delay's name among the parameters.
const DELAY: &str = "delay";
/// Samples at the beginning of a record that a stopped fit is scored on.
const BEGINNING: usize = 10_000;

/// Stages of a joint fit by least squares.
pub(in super::super) const PLAN: Plan = Plan(&[
    ("start of", 0.05),
    ("slowest record", 0.05),
    ("dynamics, start", 0.10),
    ("joint fit", 0.25),
    ("joint fit, other starts", 0.15),
    ("joint fit, population", 0.05),
    ("joint fit, polished", 0.02),
    ("joint fit with creep", 0.05),
    ("degree", 0.08),
    (ALL_SAMPLES, 0.05),
    ("between samples", 0.05),
    (ERRORS, 0.10),
]);
/// Stages of a joint fit by a population method.
pub(in super::super) const POPULATION_PLAN: Plan = Plan(&[
    ("start of", 0.02),
    ("joint fit", 0.80),
    ("joint fit, polished", 0.02),
    ("joint fit with creep", 0.02),
    ("degree", 0.05),
    (ALL_SAMPLES, 0.05),
    (ERRORS, 0.04),
]);
const ALL_SAMPLES: &str = "all samples";
const ERRORS: &str = "standard errors and intervals";

/// Identifies both blocks from all records at once.
pub(in super::super) fn identify(
    facts: &[RecordFacts],
    roles: &[RecordRole],
    options: &Options,
    mut engine: Engine<'_, '_>,
) -> Result<Identification, IdentifyError> {
    let members: Vec<JointMember<'_>> =
        facts.iter().map(|facts| JointMember::new(facts, options, &mut engine)).collect::<Result<_, _>>()?;
    let is_slow = !roles.contains(&RecordRole::Dynamic);
    let options = &if is_slow { slow(options, &members)? } else { options.clone() };
    let form = setup::form(options);
    check_demands(options, &form, facts.len())?;
    let is_static = form.parameters().is_empty();
    let left_out: Vec<usize> = members.iter().map(|m| if is_static { m.unfollowed() } else { 0 }).collect();
    let masked: Vec<RecordFacts> =
        facts.iter().zip(&left_out).map(|(facts, &samples)| facts.without_first(samples)).collect();
    let members: Vec<JointMember<'_>> =
        members.iter().zip(&masked).map(|(m, facts)| m.masked(facts)).collect();
    let facts = &masked[..];
    let scheme = Choice::Given(setup::scheme(options, &members));
    // Slow drive alone does not tell a delay from the width of the loop.
    let shows_delay = !is_static
        || roles.contains(&RecordRole::Dynamic)
        || options.demands.names().any(|name| name == DELAY);
    let asked_delay = options.delay_s;
    let delay_s = if shows_delay || asked_delay != Choice::Auto { asked_delay } else { Choice::Given(0.0) };
    let options = &Options { scheme, delay_s, ..options.clone() };
    let mut setup = JointSetup::new(&members, form, options).stopped_by(engine.stop());
    let reduced = members.iter().any(|member| member.factor > 1);

    let first_degree = match options.degree {
        Choice::Given(degree) => degree,
        Choice::Auto => DEGREE_OF_STARTS,
    };
    let mut problem = setup.problem(first_degree, reduced)?;
    let grown = |x: &[f64]| shown(&problem, x, &setup);
    let mut search = search_globally((&problem, reduced), &setup, &mut engine, Some(&grown))?;
    if let Some(longer) =
        setup.with_longer_delays(&problem, &search.outcome.best).filter(|_| !engine.is_stopped())
    {
        setup = longer;
        problem = setup.problem(first_degree, reduced)?;
        let grown = |x: &[f64]| shown(&problem, x, &setup);
        let mut wider = search_globally((&problem, reduced), &setup, &mut engine, Some(&grown))?;
        let from_edge = vec![search.outcome.best.clone()];
        take_better(&mut wider, engine.quick_fit("joint fit", &problem, from_edge)?);
        search = wider;
    }
    if options.dynamics == DynamicsChoice::Auto && options.creep == Creep::None {
        let creeping = setup.with(DynamicForm { creep: Creep::Fractional, ..form }, options);
        if let Some(better) = try_creep(&problem, &search, &creeping, first_degree, reduced, &mut engine)? {
            (setup, (problem, search)) = (creeping, better);
        }
    }
    let form = setup.form;
    let mut degrees = Vec::new();
    let mut degree = first_degree;
    let mut best = search.outcome.best.clone();
    if options.degree == Choice::Auto && !engine.is_stopped() {
        (degree, best) = choose_degree(&setup, reduced, &search, &mut engine, &mut degrees)?;
    }
    let mut small = if reduced { Some(setup.problem(degree, true)?) } else { None };
    let mut at_small = best.clone();
    let mut polished = if engine.is_stopped() {
        None
    } else {
        let whole = setup.problem(degree, false)?;
        let (x, cost) = if reduced {
            let polished = engine.quick_fit(ALL_SAMPLES, &whole, vec![best.clone()]);
            engine
                .unless_stopped(polished)?
                .map_or((best, f64::INFINITY), |s| (s.outcome.best, s.outcome.cost))
        } else {
            let cost = whole.cost(&best, &mut whole.workspace());
            (best, cost)
        };
        cost.is_finite().then_some((whole, x, cost))
    };
    let others = between::others(&setup, options);
    let mut options = options;
    let mut told_between = None;
    if let Some((whole, x, cost)) = &polished {
        let independent = information(whole, x);
        let fitted = (whole, &x[..], *cost);
        if let Some((choice, better)) =
            between::compared(&setup, &others, fitted, (degree, independent), &mut engine)?
        {
            told_between = Some(choice);
            if let Some(better) = better {
                options = &others[better.index];
                if reduced {
                    let thinned = setup.anew(options).problem(degree, true)?;
                    let fit = engine.quick_fit(ALL_SAMPLES, &thinned, vec![better.x.clone()]);
                    if let Some(fit) = engine.unless_stopped(fit)? {
                        at_small = fit.outcome.best;
                    }
                    small = Some(thinned);
                }
                polished = Some((better.problem, better.x, better.cost));
            }
        }
    }
    let (problem, x, mut reduction) = if let Some((whole, x, cost)) = polished {
        (search.outcome.cost, search.outcome.best) = (cost, x.clone());
        let samples = whole.residual_count();
        let reduction =
            small.as_ref().map(|small| Reduction { samples, searched: small.valid(), moved: 0.0 });
        (whole, x, reduction)
    } else {
        degree = first_degree;
        (problem, search.outcome.best.clone(), None)
    };
    // Without a delay that slow drive does not tell.
    let searched = problem.bounds().clone();
    let (problem, x, small, at_small) = if shows_delay || asked_delay != Choice::Auto || engine.is_stopped() {
        (problem, x, small, at_small)
    } else {
        let asked = Options { delay_s: Choice::Auto, ..options.clone() };
        let setup = setup.with(form, &asked);
        let (problem, x) = with_no_delay(&setup, degree, false, &x)?;
        let small = small.map(|_| with_no_delay(&setup, degree, true, &at_small)).transpose()?;
        let (small, at_small) = small.map_or((None, at_small), |(small, x)| (Some(small), x));
        (problem, x, small, at_small)
    };
    let certain = engine.enter(ERRORS);
    let smoothed = if certain { smoothed(&problem, &x) } else { None };
    let (linearisation, known_small) = rayon::join(
        || match &smoothed {
            Some((coefficients, _)) => problem.linearise_at(&x, coefficients),
            None if certain => problem.linearise(&x),
            None => None,
        },
        || small.as_ref().filter(|_| certain).and_then(|small| knowledge::knowledge(small, &at_small)),
    );
    let solution = match &linearisation {
        Some(linearisation) => problem.solution(&x, &linearisation.coefficients),
        None => problem.solve(&x),
    }
    .ok_or(OptimizeError::NoFeasiblePoint { evaluations: search.outcome.evaluations })?;
    let mut model = assemble(&solution, &form, &members, options)?;
    let stop = engine.stop().clone();

    let (fits, known) = rayon::join(
        || simulated(&mut model, &solution, &members, roles, (options, stop.is_requested())),
        || linearisation.and_then(|linearisation| knowledge::knowledge_of(&problem, &x, linearisation)),
    );
    let mut fits = fits?;
    let known = known.filter(|_| !engine.is_stopped());
    if !engine.cancelled {
        findings::require_fit(&fits, facts, options)?;
    }
    let own = known.as_ref().map(|known| &known.covariance);
    if let (Some(reduction), Some(own)) = (&mut reduction, own) {
        reduction.moved = moved(own, &x, &at_small);
    }
    let output_uncertainty = known.as_ref().map(|known| {
        band::give(&problem, known, &mut fits);
        let samples: f64 = fits.iter().map(|fit| fit.scores.samples as f64).sum();
        let square: f64 = fits.iter().map(|fit| fit.scores.samples as f64 * fit.scores.rmse.powi(2)).sum();
        let schemes = (options.scheme(), options.inter_sample());
        OutputUncertainty::new(&problem, &form, &x, known, schemes, (square / samples).sqrt())
    });
    let covariance = own.map(|own| parameters::in_article_symbols(own, &problem, &solution));
    let of_numbers = own.and_then(|own| parameters::of_numbers(own, &problem, &solution, &form));
    let covariances = (covariance.as_ref(), of_numbers.as_ref());
    let mut parameters = parameters::parameters(&solution, &form, &problem, covariances, &model);
    let structure = StructureChoice {
        degrees,
        degree,
        creep: form.creep,
        delay_and_lag_from_start: is_slow && !is_static,
        creeps: Vec::new(),
        left_out: left_out
            .into_iter()
            .zip(roles)
            .filter(|(_, role)| **role == RecordRole::QuasiStatic)
            .map(|(samples, _)| samples)
            .collect(),
        smoothing: smoothed.map(|(_, smoothing)| smoothing),
        between: told_between,
    };
    if let Some(known) = &known {
        let found = match (&small, &known_small) {
            // The likelihood of weights that are drawn together is not that of the records.
            _ if structure.smoothing.is_some() => Vec::new(),
            (Some(small), Some(at_small)) => intervals(small, at_small, &known.covariance, engine.stop()),
            (Some(_), None) => Vec::new(),
            (None, _) => intervals(&problem, known, &known.covariance, engine.stop()),
        };
        parameters::give_intervals(&mut parameters, &known.covariance.names, &found, &solution);
    }
    let mut identification = Identification {
        method: Method::Joint,
        model,
        parameters,
        correlations: covariance.iter().filter_map(|c| c.correlation("joint fit")).collect(),
        bounds: vec![searched],
        searches: vec![search],
        records: fits,
        runs: Vec::new(),
        structure,
        covariance,
        of_numbers,
        output_uncertainty,
        reduction,
        findings: Vec::new(),
        treatment: Vec::new(),
        excited_hz: super::super::campaign::excited(facts),
        cancelled: engine.is_stopped(),
        resume: engine.searches(),
    };
    findings::write(facts, options, &mut identification);
    Ok(identification)
}

/// The options for slow records alone: they hold no dynamics but what a jump from rest shows, a lag and the
/// delay.
///
/// # Errors
/// [`IdentifyError::NoDynamicInformation`] where other dynamics are asked for.
fn slow(options: &Options, members: &[JointMember<'_>]) -> Result<Options, IdentifyError> {
    let jumps = members.iter().any(|member| member.unfollowed() > 0);
    let (dynamics, order) = match options.dynamics {
        DynamicsChoice::Auto if jumps && options.delay_s == Choice::Auto => (DynamicsChoice::Integer, 1),
        DynamicsChoice::Auto | DynamicsChoice::None => (DynamicsChoice::None, options.order),
        DynamicsChoice::Integer => (DynamicsChoice::Integer, options.order),
        wanted => {
            return Err(IdentifyError::NoDynamicInformation {
                wanted: wanted.name(),
                because: "the campaign holds quasi-static records only; add a sweep or sines well above \
                          their frequency, \
                          or name the record that is one"
                    .into(),
            });
        }
    };
    Ok(Options { dynamics, order, ..options.clone() })
}

/// The problem in which a delay is free, at the point `x` of one without a delay: what slow drive does not
/// tell is left out of the model, but not of the errors.
fn with_no_delay(
    setup: &JointSetup<'_>,
    degree: usize,
    reduced: bool,
    x: &[f64],
) -> Result<(JointProblem, Vec<f64>), IdentifyError> {
    let problem = setup.problem(degree, reduced)?;
    let place = problem.bounds().ranges.iter().position(|range| range.name == DELAY);
    let mut x = x.to_vec();
    x.insert(place.map_or(x.len(), |place| place.min(x.len())), 0.0);
    Ok((problem, x))
}

/// The model at a point of the search as it would be handed out, without errors and scores.
fn shown(problem: &JointProblem, x: &[f64], setup: &JointSetup<'_>) -> Option<hysteron_model::Model> {
    let solution = problem.solve(x)?;
    let law = assemble(&solution, &setup.form, setup.members, setup.options).ok()?;
    let first = &setup.members.first()?.facts.data;
    let units = SignalUnits::of(&first.u_unit, &first.y_unit);
    hysteron_model::Model::try_from(ModelFile::from_model(&law, units)).ok()
}

/// The model's simulation of every record; of a long one only the beginning where the fit was stopped. Where
/// the offset is free, the model's own is that of its first record.
fn simulated(
    model: &mut Model,
    solution: &JointSolution,
    members: &[JointMember<'_>],
    roles: &[RecordRole],
    (options, stopped): (&Options, bool),
) -> Result<Vec<RecordFit>, IdentifyError> {
    let range_v = members
        .iter()
        .map(|m| range_of(&m.facts.data.u))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
    let simulate = |(index, member): (usize, &JointMember<'_>)| {
        let mut data = member.facts.data.clone();
        let mut start = member.start(&solution.hysteresis, solution.memory[index]);
        if let Some(cycle) = member.facts.first_of_several_cycles()
            && !stopped
        {
            // As a validation of the same record would: the fit did without what was before it.
            let first = data.cropped(0..cycle)?;
            start = choose_start(model, &first, start, Some(range_v), &Scoring::default())?.0;
        }
        let is_whole = !stopped || matches!(start, Start::Settled { .. });
        let samples = if is_whole { data.len() } else { member.facts.beginning(BEGINNING) };
        let part = data.cropped(0..samples)?;
        let mut simulated = model.simulate(&part.u, &part.time, &start)?;
        if samples < data.len() {
            simulated.resize(data.len(), f64::NAN);
            data.valid.get_or_insert_with(|| vec![true; simulated.len()])[samples..].fill(false);
        }
        Ok((data, start, simulated))
    };
    // The first error in the order of the records, whatever the threads.
    let outputs: Vec<Result<_, IdentifyError>> = members.par_iter().enumerate().map(simulate).collect();
    let mut outputs = outputs.into_iter().collect::<Result<Vec<_>, _>>()?;
    if options.demands.fixed(OFFSET).is_none() {
        model.offset = mean_residual(&outputs[0].0, &outputs[0].2)?;
        outputs.iter_mut().flat_map(|(.., simulated)| simulated).for_each(|y| *y += model.offset);
    }
    let fits: Vec<_> = outputs
        .into_par_iter()
        .zip(roles)
        .map(|((data, start, simulated), role)| {
            let scores = score(&data, &simulated, &Scoring::default())?;
            let sines = SineResponse::of_record(&data, &simulated);
            Ok(RecordFit { data, role: *role, start, scores, simulated, band: None, sines })
        })
        .collect();
    fits.into_iter().collect()
}

/// A few good starts; where they disagree all others, and where these disagree a population search on a
/// twentieth of its usual budget, polished.
fn search_globally(
    (problem, reduced): (&JointProblem, bool),
    setup: &JointSetup<'_>,
    engine: &mut Engine<'_, '_>,
    show: Show<'_>,
) -> Result<Search, IdentifyError> {
    if problem.bounds().dimension() == 0 {
        return Ok(engine.fit_from("joint fit", problem, vec![Vec::new()], show)?);
    }
    if let Some(algorithm) = &setup.options.algorithm {
        let mut search = engine.search("joint fit", problem, setup.guesses(problem)?, show)?;
        if algorithm.name() != "least-squares" && !engine.cancelled {
            let best = search.outcome.best.clone();
            let polished = engine.quick_fit("joint fit, polished", problem, vec![best])?.outcome;
            (search.outcome.best, search.outcome.cost) = (polished.best, polished.cost);
        }
        return Ok(search);
    }
    let mut search = if setup.options.start.is_some() {
        engine.search("joint fit", problem, setup.guesses(problem)?, show)?
    } else {
        search_from_places(problem, setup, engine, show)?
    };
    if agreeing(&search) >= AGREEMENT || engine.cancelled {
        return Ok(search);
    }
    if setup.form.creep != Creep::None && setup.options.start.is_none() {
        // Creep is small: the optimum without it lies near that with it.
        let without = setup.with(DynamicForm { creep: Creep::None, ..setup.form }, setup.options);
        let plain = without.problem(problem.degree(), reduced)?;
        let found = search_from_places(&plain, &without, engine, None)?;
        let starts = from_plain(&plain, &found.outcome.best, problem, &setup.guesses(problem)?);
        take_better(&mut search, engine.quick_fit("joint fit with creep", problem, starts)?);
    }
    let population = Algorithm::DeAbc(DeAbcOptions::default());
    let generations = (setup.options.generations / 20).max(5);
    let starts = vec![search.outcome.best.clone()];
    let wide = engine.run_for("joint fit, population", problem, &population, starts, generations, show)?;
    search.outcome.evaluations += wide.outcome.evaluations;
    let starts = vec![wide.outcome.best];
    take_better(&mut search, engine.quick_fit("joint fit, population polished", problem, starts)?);
    Ok(search)
}

/// Fits from the first few places; from all others where these disagree.
fn search_from_places(
    problem: &JointProblem,
    setup: &JointSetup<'_>,
    engine: &mut Engine<'_, '_>,
    show: Show<'_>,
) -> Result<Search, IdentifyError> {
    let places = setup.places(problem, engine)?;
    let Starts { mut points, evaluations } = setup.fitted(problem, &places, 0..FIRST_STARTS, engine)?;
    points.extend(setup.unfitted(problem, &places));
    if engine.is_stopped() {
        points = problem.best().into_iter().collect();
    }
    let mut search = engine.fit_from("joint fit", problem, points, show)?;
    search.outcome.evaluations += places.evaluations + evaluations;
    if agreeing(&search) >= AGREEMENT || engine.cancelled {
        return Ok(search);
    }
    let others = setup.fitted(problem, &places, FIRST_STARTS..usize::MAX, engine)?;
    search.outcome.evaluations += others.evaluations;
    take_better(&mut search, engine.search("joint fit, other starts", problem, others.points, show)?);
    Ok(search)
}

/// Takes what `other` found where it is better, and its starts beside those of `search`.
fn take_better(search: &mut Search, other: Search) {
    search.outcome.evaluations += other.outcome.evaluations;
    search.outcome.generations += other.outcome.generations;
    search.outcome.starts.extend(other.outcome.starts);
    if other.outcome.cost < search.outcome.cost {
        (search.outcome.best, search.outcome.cost) = (other.outcome.best, other.outcome.cost);
    }
}

/// The same dynamics with a creep factor, where the residuals are far from white and the evidence for it is
/// very strong.
fn try_creep(
    plain: &JointProblem,
    found: &Search,
    setup: &JointSetup<'_>,
    degree: usize,
    reduced: bool,
    engine: &mut Engine<'_, '_>,
) -> Result<Option<(JointProblem, Search)>, IdentifyError> {
    let coloured = information(plain, &found.outcome.best) < WHITE * plain.valid() as f64;
    if !coloured || engine.is_stopped() {
        return Ok(None);
    }
    let problem = setup.problem(degree, reduced)?;
    let mut guesses = setup.guesses(&problem)?;
    guesses.extend(from_plain(plain, &found.outcome.best, &problem, &guesses[..1]));
    let search = engine.quick_fit("joint fit with creep", &problem, guesses);
    let Some(search) = engine.unless_stopped(search)?.filter(|_| !engine.is_stopped()) else {
        return Ok(None);
    };
    let information = information(&problem, &search.outcome.best);
    let gain = 2.0 * information * (found.outcome.cost / search.outcome.cost).ln();
    let parameters = problem.bounds().dimension() - plain.bounds().dimension();
    Ok((gain > BIC_FALL + parameters as f64 * information.ln()).then_some((problem, search)))
}

/// The guesses for a problem with more parameters, with those of a fit with fewer in their place.
fn from_plain(
    plain: &JointProblem,
    best: &[f64],
    problem: &JointProblem,
    guesses: &[Vec<f64>],
) -> Vec<Vec<f64>> {
    let place = |name: &str| plain.bounds().ranges.iter().position(|range| range.name == name);
    let moved = |guess: &Vec<f64>| {
        let ranges = problem.bounds().ranges.iter().zip(guess);
        ranges.map(|(range, &guess)| place(&range.name).map_or(guess, |at| best[at])).collect()
    };
    guesses.iter().map(moved).collect()
}

/// Number of independent samples that the residuals at `x` are worth.
fn information(problem: &JointProblem, x: &[f64]) -> f64 {
    let mut residual = vec![0.0; problem.residual_count()];
    problem.residuals(x, &mut problem.workspace(), &mut residual);
    (0..problem.records().len())
        .map(|r| problem.records()[r].valid as f64 / correlation_time(&residual[problem.rows(r)]))
        .sum::<f64>()
        .max(2.0)
}

/// Starts that ended in the best optimum found (to 1e-6 of its cost).
fn agreeing(search: &Search) -> usize {
    let best = search.outcome.cost;
    search
        .outcome
        .starts
        .iter()
        .filter(|start| start.status.converged() && start.cost <= best * (1.0 + 1e-6))
        .count()
}

/// Degree by BIC over the information that the residuals really hold, from one warm fit each.
fn choose_degree(
    setup: &JointSetup<'_>,
    reduced: bool,
    found: &Search,
    engine: &mut Engine<'_, '_>,
    tried: &mut Vec<(usize, f64, f64)>,
) -> Result<(usize, Vec<f64>), IdentifyError> {
    let demanded = (1..=super::super::HIGHEST_DEGREE)
        .filter(|&d| setup.options.demands.names().any(|n| n == polynomial_name(d)))
        .max()
        .unwrap_or(1);
    let mut fits = Vec::new();
    let mut information = 2.0;
    let highest = HIGHEST_AUTOMATIC_DEGREE.max(demanded);
    for degree in 1..=highest {
        let problem = setup.problem(degree, reduced)?;
        let parameters = problem.bounds().dimension() + problem.layout().linear().count();
        let (cost, best) = if degree == DEGREE_OF_STARTS {
            (found.outcome.cost, found.outcome.best.clone())
        } else {
            let start = found.outcome.best.clone();
            let fit = engine.quick_fit(&format!("degree {degree}"), &problem, vec![start]);
            match engine.unless_stopped(fit)? {
                Some(fit) if !engine.is_stopped() => (fit.outcome.cost, fit.outcome.best),
                _ => break,
            }
        };
        if degree == highest {
            // That of the richest fit counts: its residual is the least structured.
            information = self::information(&problem, &best);
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
    Ok(chosen.map_or((demanded, found.outcome.best.clone()), |(degree, _, best)| (degree, best)))
}

/// Largest move of a searched number between reduced and whole records, in standard errors.
fn moved(own: &Covariance, x: &[f64], before: &[f64]) -> f64 {
    let eliminated = own.values.len() - x.len();
    x.iter()
        .zip(before)
        .enumerate()
        .filter_map(|(j, (now, then))| own.std_error(eliminated + j).map(|error| (now - then).abs() / error))
        .fold(0.0, f64::max)
}

pub(in super::super) fn assemble(
    solution: &JointSolution,
    form: &DynamicForm,
    members: &[JointMember<'_>],
    options: &Options,
) -> Result<Model, IdentifyError> {
    let g = form.transfer_function(&solution.form)?;
    let dynamics = match form.modes {
        Modes::None if form.creep == Creep::None => Dynamics::None,
        Modes::None | Modes::Integer { .. } | Modes::Resonances { .. } if form.creep.has_whole_orders() => {
            Dynamics::Integer(g)
        }
        _ => Dynamics::Fractional(g),
    };
    let fastest = members.iter().map(|m| m.rate_hz).fold(0.0, f64::max);
    Ok(Model {
        hysteresis: solution.hysteresis.clone(),
        dynamics,
        offset: options.demands.fixed(OFFSET).unwrap_or(0.0),
        delay_s: solution.delay_s,
        scheme: options.scheme(),
        inter_sample: options.inter_sample(),
        sample_rate_hz: Some(fastest),
    })
}

/// Every demand must be one that this fit can meet: none is passed over in silence.
fn check_demands(options: &Options, form: &DynamicForm, records: usize) -> Result<(), IdentifyError> {
    let highest = match options.degree {
        Choice::Given(degree) => degree,
        Choice::Auto => super::super::HIGHEST_DEGREE,
    };
    let polynomial: Vec<_> = (1..=highest).map(polynomial_name).collect();
    let memory: Vec<String> = (0..records).map(memory_name).collect();
    let mut known: Vec<&str> = polynomial.iter().map(AsRef::as_ref).collect();
    let family: Vec<String> =
        options.family().weight_names().into_iter().chain(options.family().shape_names()).collect();
    known.extend(family.iter().map(String::as_str));
    known.push(OFFSET);
    if options.delay_s == Choice::Auto {
        known.push(DELAY);
    }
    let form = form.parameters();
    known.extend(form.iter().map(|p| p.name));
    known.extend(memory.iter().map(String::as_str));
    options.demands.check(&known)?;
    super::super::check_common_demands(options)
}
