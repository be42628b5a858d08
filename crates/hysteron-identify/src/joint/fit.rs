//! The joint fit from records to model: multi-start on reduced records, then all samples from the best.

use super::super::engine::Engine;
use super::super::options::{Choice, DynamicsChoice, Method, Options, RecordRole};
use super::super::result::{Identification, RecordFit, StructureChoice};
use super::super::sines::SineResponse;
use super::super::static_step::OFFSET;
use super::super::{IdentifyError, RecordFacts, findings};
use super::band::{self, OutputUncertainty};
use super::between;
use super::campaign::{JointMember, Rate};
use super::fitted::{ALL_SAMPLES, FittedOptimum, REDUCED};
use super::intervals::intervals;
use super::knowledge::{self, Covariance};
use super::model::assemble;
use super::parameter_layout::{DELAY, JointSolution};
use super::parameters;
use super::search::search;
use super::setup::{self, JointSetup, memory_name};
use super::smoothing::smoothed;
use crate::watch::Plan;
use hysteron_model::Start;
use hysteron_model::dynamics::DynamicForm;
use hysteron_model::hammerstein::Model;
use hysteron_model::model_file::polynomial_name;
use hysteron_model::validate::{Scoring, choose_start, mean_residual, score};
use hysteron_optimize::{OptimizeError, Problem};
use rayon::prelude::*;

/// Number of initial samples of a record on which a stopped fit is scored.
const BEGINNING: usize = 10_000;

/// Stages of a joint fit by least squares.
pub(in super::super) const PLAN: Plan = Plan(&[
    ("start of", 0.05),
    ("slowest record", 0.05),
    ("dynamics, start", 0.10),
    ("joint fit with creep", 0.10),
    ("joint fit without creep", 0.05),
    ("joint fit", 0.20),
    ("joint fit, other starts", 0.15),
    ("joint fit, population", 0.05),
    ("joint fit, polished", 0.02),
    ("joint fit, fractional orders", 0.02),
    ("degree", 0.08),
    (REDUCED, 0.03),
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
    (REDUCED, 0.02),
    (ALL_SAMPLES, 0.05),
    (ERRORS, 0.04),
]);
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
    let masked = left_out.iter().any(|samples| *samples > 0).then(|| -> Vec<RecordFacts> {
        facts.iter().zip(&left_out).map(|(facts, &samples)| facts.without_first(samples)).collect()
    });
    let facts = masked.as_deref().unwrap_or(facts);
    let members: Vec<JointMember<'_>> = members.iter().zip(facts).map(|(m, facts)| m.masked(facts)).collect();
    let scheme = Choice::Given(setup::scheme(options, &members));
    // Under slow drive alone a delay cannot be distinguished from loop width.
    let shows_delay = !is_static
        || roles.contains(&RecordRole::Dynamic)
        || options.demands.names().any(|name| name == DELAY);
    let asked_delay = options.delay_s;
    let delay_s = if shows_delay || asked_delay != Choice::Auto { asked_delay } else { Choice::Given(0.0) };
    let options = &Options { scheme, delay_s, ..options.clone() };
    let setup = JointSetup::new(&members, form, options).stopped_by(engine.stop());
    let reduced = members.iter().any(|member| member.factor_at(Rate::Reduced) > 1);
    let optimum = search(setup, reduced, &mut engine)?;
    let others = between::others(&optimum.setup, options);
    let fitted = FittedOptimum::on_all_samples(optimum, reduced, &others, &mut engine)?;
    let options = fitted.setup.options();
    let searched = fitted.problem.bounds().clone();
    let asked = Options { delay_s: Choice::Auto, ..options.clone() };
    let is_untold = !shows_delay && asked_delay == Choice::Auto;
    let fitted = if is_untold && !engine.is_stopped() { fitted.with_free_delay(&asked)? } else { fitted };
    let form = fitted.setup.form;
    let FittedOptimum { problem, x, thinned, search, degree, degrees, between, mut reduction, .. } = fitted;
    let certain = engine.enter(ERRORS);
    let smoothed = if certain { smoothed(&problem, &x) } else { None };
    let (linearisation, known_thinned) = rayon::join(
        || match &smoothed {
            Some((coefficients, _)) => problem.linearise_at(&x, coefficients, &mut problem.workspace()),
            None if certain => problem.linearise(&x),
            None => None,
        },
        || thinned.as_ref().filter(|_| certain).and_then(|(thinned, at)| knowledge::knowledge(thinned, at)),
    );
    problem.free_scratch();
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
    if let (Some(reduction), Some(own), Some((_, before))) = (&mut reduction, own, &thinned) {
        reduction.moved = moved(own, &x, before);
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
        between,
        family: None,
    };
    if let Some(known) = &known {
        let found = match (&thinned, &known_thinned) {
            // With a roughness penalty on the weights the cost is not the likelihood of the records.
            _ if structure.smoothing.is_some() => Vec::new(),
            (Some((thinned, _)), Some(at)) => intervals(thinned, at, &known.covariance, engine.stop()),
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
    between::admit_held_drive(options, &mut identification);
    findings::write(facts, options, &mut identification);
    Ok(identification)
}

/// The options for slow records alone, which determine no dynamics except, by a step from rest, a lag and the
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
                          their frequency, or name the record that is one"
                    .into(),
            });
        }
    };
    Ok(Options { dynamics, order, ..options.clone() })
}

/// The model's simulation of every record; after a stop only of its beginning. Where the offset is free, the
/// model's is that of its first record.
fn simulated(
    model: &mut Model,
    solution: &JointSolution,
    members: &[JointMember<'_>],
    roles: &[RecordRole],
    (options, stopped): (&Options, bool),
) -> Result<Vec<RecordFit>, IdentifyError> {
    let range_v = members
        .iter()
        .map(|m| m.facts.ends)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
    let simulate = |(index, member): (usize, &JointMember<'_>)| {
        let data = &member.facts.data;
        let mut start = member.start(&solution.hysteresis, solution.memory[index]);
        if let Some(cycle) = member.facts.first_of_several_cycles()
            && !stopped
        {
            // The start is chosen as in a validation: the fit did not use the past of the record.
            let first = data.cropped(0..cycle)?;
            start = choose_start(model, &first, start, Some(range_v), &Scoring::default())?.0;
        }
        let is_whole = !stopped || matches!(start, Start::Settled { .. });
        let samples = if is_whole { data.len() } else { member.facts.beginning(BEGINNING) };
        let mut simulated = if samples == data.len() {
            model.simulate(&data.u, &data.time, &start)?
        } else {
            let part = data.cropped(0..samples)?;
            model.simulate(&part.u, &part.time, &start)?
        };
        // A copy of a long record is made once the buffers of its simulation are gone.
        let mut data = data.clone();
        if samples < data.len() {
            simulated.resize(data.len(), f64::NAN);
            data.valid.get_or_insert_with(|| vec![true; simulated.len()])[samples..].fill(false);
        }
        Ok((data, start, simulated, samples))
    };
    // The first error in the order of the records, independently of the threads.
    let outputs: Vec<Result<_, IdentifyError>> = members.par_iter().enumerate().map(simulate).collect();
    let mut outputs = outputs.into_iter().collect::<Result<Vec<_>, _>>()?;
    if options.demands.fixed(OFFSET).is_none() {
        model.offset = mean_residual(&outputs[0].0, &outputs[0].2)?;
        outputs.iter_mut().flat_map(|(_, _, simulated, _)| simulated).for_each(|y| *y += model.offset);
    }
    let fits: Vec<_> = outputs
        .into_par_iter()
        .zip(roles)
        .map(|((data, start, simulated, samples), role)| {
            let scores = if samples < data.len() {
                score(&data.cropped(0..samples)?, &simulated[..samples], &Scoring::default())?
            } else {
                score(&data, &simulated, &Scoring::default())?
            };
            let sines = SineResponse::of_record(&data, &simulated);
            Ok(RecordFit { data, role: *role, start, scores, simulated, band: None, sines })
        })
        .collect();
    fits.into_iter().collect()
}

/// Largest change of a searched number from reduced to whole records, in standard errors.
fn moved(own: &Covariance, x: &[f64], before: &[f64]) -> f64 {
    let eliminated = own.values.len() - x.len();
    x.iter()
        .zip(before)
        .enumerate()
        .filter_map(|(j, (now, then))| own.std_error(eliminated + j).map(|error| (now - then).abs() / error))
        .fold(0.0, f64::max)
}

/// Rejects demands that this fit cannot meet.
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
