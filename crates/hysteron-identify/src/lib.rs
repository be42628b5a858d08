//! Identification of hysteresis models from records: joint fit, or the article's two steps (§4.3).
//!
//! [`identify`] recognises which records are quasi-static and which carry dynamics, chooses what the user
//! left open (start, polynomial degree, delay and lag) from the data, runs the searches and returns an
//! [`Identification`]: the model, its parameters with standard errors, the fit of every record, and in plain
//! words the parameters that the records do not determine.

mod alike;
pub mod baselines;
mod campaign;
mod compared;
pub mod coupled;
mod defaults;
pub mod design;
pub mod difference;
mod dynamic_problem;
mod dynamic_step;
mod engine;
mod error;
mod facts;
mod findings;
mod fit;
pub mod force;
mod forecast;
pub mod frequency_response;
mod identifiability;
mod joint;
mod layout;
pub mod linear;
mod linear_step;
pub mod misfit;
pub mod modes;
mod normal;
pub mod online;
mod option_ranges;
mod options;
pub mod oscillator;
mod parameter;
mod precision;
mod prediction;
mod projection;
mod purpose;
pub mod recalibrate;
mod result;
mod searches;
mod sensitivity;
mod shown;
mod sines;
mod static_fit;
mod static_problem;
mod static_step;
pub mod structure;
mod treatment;
mod two_step;
mod uncertainty;
mod watch;
mod written;

pub use campaign::recognised_roles;
pub use compared::{
    BaselineSummary, CandidateCost, CandidateSummary, Compared, ComparisonSummary, FoldSummary,
};
pub use engine::Search;
pub use error::IdentifyError;
pub use fit::{
    Fit, FitDetails, FitParameter, FitRecords, FitSummary, ModeSummary, Place, ReductionSummary,
    SearchSummary, Task, fit, fit_on, usual_kind,
};
pub use forecast::{ForecastDrive, drive_for};
pub use hysteron_model::{Finding, FindingKind};
pub use joint::{
    Covariance, InterSampleChoice, Interval, IntervalMethod, JointObjective, JointScratch, OutputUncertainty,
    PredictionBand, Smoothing,
};
pub use layout::Demands;
pub use options::{
    CampaignRecord, Choice, DynamicsChoice, FamilyChoice, HIGHEST_DEGREE, Initial, Method, Options,
    RecordRole,
};
pub use parameter::{Equation13, LinearPart, Parameter, ParameterRole};
pub use result::{Correlation, DegreeTried, Identification, RecordFit, Reduction, StructureChoice};
pub use searches::{
    ModesCheckpoint, ModesComparisonCheckpoint, ModesFitCheckpoint, Searches, SearchesFormat,
};
pub use sines::{GainPhase, RecordSines, SineResponse};
pub use static_fit::StaticFit;
pub use static_step::BIC_FALL;
pub use structure::ComparisonCheckpoint;
pub(crate) use uncertainty::correlation_time;
pub use watch::{Event, Watch};

use std::sync::{Mutex, PoisonError};

use engine::Engine;
use facts::RecordFacts;
use hysteron_model::dynamics::{Creep, ParameterKind};
use hysteron_model::hysteresis::HysteresisForm;
pub use hysteron_numeric::Listener;
use hysteron_optimize::Settings;
pub use hysteron_optimize::Stop;
use static_step::OFFSET;

/// Stage of the choice of the family.
const FAMILIES: &str = "families";
/// Share of the progress of an identification that the choice of the family takes.
const OF_FAMILIES: f64 = 0.6;

/// Identifies a Hammerstein model from a campaign: by one joint fit, or by the article's two-step procedure
/// ([`Options::method`]), which also takes the sampled dynamics (ARX, OE, BJ) and SRIVC.
///
/// # Errors
/// [`IdentifyError`]: records without information, options that cannot be met, a model class that does not
/// describe the records.
pub fn identify(
    records: &[CampaignRecord],
    options: &Options,
    watch: &Watch<'_>,
    resume: Option<Searches>,
) -> Result<Identification, IdentifyError> {
    if options.hysteresis == FamilyChoice::Auto {
        options.validate()?;
        // What the families need to go on from is kept with the searches that follow.
        let families = Mutex::new(resume.as_ref().and_then(|searches| searches.comparison.clone()));
        let of_families = watch.keeping_comparison(FAMILIES, &families);
        let selection =
            structure::choose_family(records, options, &of_families.part(0.0, OF_FAMILIES), resume.clone())?;
        drop(of_families);
        let families = families.into_inner().unwrap_or_else(PoisonError::into_inner);
        let rest = watch.with_comparison(families.as_deref());
        let mut found = identify(records, &selection.applied(options), &rest.part(OF_FAMILIES, 1.0), resume)?;
        drop(rest);
        found.resume.comparison = families;
        let finding = Finding::new(FindingKind::Verdict, "hysteresis", selection.verdict.clone());
        found.findings.insert(0, finding);
        found.structure.family = Some(selection);
        return Ok(found);
    }
    let identify = |records: &[CampaignRecord]| {
        identify_records(records, options, watch, resume).map_err(|e| match e {
            // A search had not evaluated any point.
            IdentifyError::Optimize(_) if watch.is_stopped() => IdentifyError::Stopped,
            e => e,
        })
    };
    if !options.continued {
        return identify(records);
    }
    let runs = campaign::runs(records)?;
    let mut found = identify(&campaign::of_runs(records, &runs))?;
    let parts = found.records.iter().zip(&runs).map(|(fit, run)| fit.in_parts(run));
    let parts = parts.collect::<Result<Vec<_>, _>>()?.concat();
    found.runs = std::mem::replace(&mut found.records, parts);
    Ok(found)
}

fn is_joint(options: &Options) -> bool {
    options.method == Method::Joint && !options.dynamics.takes_two_steps()
}

/// The stages of an identification with these options.
pub(crate) fn plan(options: &Options) -> watch::Plan {
    match &options.algorithm {
        _ if !is_joint(options) => two_step::PLAN,
        Some(algorithm) if algorithm.name() != "least-squares" => joint::POPULATION_PLAN,
        _ => joint::PLAN,
    }
}

/// [`identify`] for records that are not parts of one run.
fn identify_records(
    records: &[CampaignRecord],
    options: &Options,
    watch: &Watch<'_>,
    resume: Option<Searches>,
) -> Result<Identification, IdentifyError> {
    options.validate()?;
    let facts = campaign::usable(records)?;
    let options = &defaults::resolved(&facts, options);
    let roles = campaign::roles(records, &facts);
    let settings = Settings {
        seed: options.seed,
        generations: options.generations,
        threads: options.threads,
        ..Settings::default()
    };
    let joint = is_joint(options);
    let plan = plan(options);
    let engine = Engine::new(options.algorithm.as_ref(), settings.clone(), watch, plan, resume);
    if !joint {
        if options.creep != Creep::None {
            return Err(IdentifyError::CreepTakesJointFit);
        }
        if options.family() != HysteresisForm::default() {
            return Err(IdentifyError::FamilyTakesJointFit);
        }
        return two_step::identify(&facts, &roles, options, engine);
    }
    let found = joint::identify(&facts, &roles, options, engine)?;
    if options.dynamics != DynamicsChoice::Auto || found.cancelled || !beyond_the_records(&found) {
        return Ok(found);
    }
    let without = Options { dynamics: DynamicsChoice::None, ..options.clone() };
    let engine = Engine::new(options.algorithm.as_ref(), settings, watch, plan, None);
    let mut other = joint::identify(&facts, &roles, &without, engine)?;
    if other.cancelled || !as_good(&other, &found) {
        return Ok(found);
    }
    let text = "A resonance would lie outside the band of these records and does not improve the fit of the \
                loops: the model has none. Add a sweep that approaches it.";
    other.findings.push(Finding::new(FindingKind::Advice, "resonance", text));
    Ok(other)
}

/// True if the resonance ended at its upper bound, beyond the excited band, where the records do not
/// determine it.
fn beyond_the_records(found: &Identification) -> bool {
    let is_resonance = |p: &&Parameter| match p.role {
        ParameterRole::Dynamics(form) => form.kind == ParameterKind::NaturalFrequency(1),
        _ => false,
    };
    let Some(resonance) = found.parameters.iter().find(is_resonance) else { return false };
    let mut ranges = found.bounds.iter().flat_map(|bounds| &bounds.ranges);
    let range = ranges.find(|range| range.name == resonance.name);
    range.is_some_and(|range| range.is_upper_end(resonance.value))
}

/// True if the fit with fewer parameters is as good by the Bayesian information criterion, n ln Σ e² + p ln
/// n, with n the independent samples of the richer fit's residual (few where the model class is wrong).
fn as_good(fewer: &Identification, richer: &Identification) -> bool {
    let residual = |fit: &RecordFit| -> Vec<f64> {
        let modelled = fit.simulated.iter().map(|y| y + fit.scores.offset);
        let left = fit.data.y.iter().zip(modelled).map(|(measured, modelled)| measured - modelled);
        let scored = |k: usize| fit.data.is_valid(k);
        left.enumerate().filter(|(k, e)| scored(*k) && e.is_finite()).map(|(_, e)| e).collect()
    };
    let of = |found: &Identification| -> (f64, f64) {
        let residuals = found.records.iter().map(residual);
        let sums =
            residuals.map(|e| (e.iter().map(|e| e * e).sum::<f64>(), e.len() as f64 / correlation_time(&e)));
        sums.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))
    };
    let (square, independent) = of(richer);
    let searched = |found: &Identification| found.parameters.iter().filter(|p| !p.held).count() as f64;
    let saved = (searched(richer) - searched(fewer)) * independent.max(2.0).ln();
    independent * (of(fewer).0 / square.max(f64::MIN_POSITIVE)).ln() <= saved
}

/// Demands on the offset and on n.
fn check_common_demands(options: &Options) -> Result<(), IdentifyError> {
    if options.demands.bounded(OFFSET).is_some() {
        return Err(IdentifyError::Demand {
            name: OFFSET.into(),
            wanted: "a fixed value (it is eliminated, not searched)",
        });
    }
    let n = options.demands.bounded("n").map_or(options.demands.fixed("n"), |(low, _)| Some(low));
    if n.is_some_and(|n| !(1.0..=10.0).contains(&n)) {
        return Err(IdentifyError::Demand { name: "n".into(), wanted: "1 ≤ n ≤ 10" });
    }
    Ok(())
}

/// FNV-1a over 64-bit words: detects the checkpoint of another problem.
fn fingerprint(values: impl Iterator<Item = u64>) -> u64 {
    values.fold(0xcbf2_9ce4_8422_2325, |hash, value| (hash ^ value).wrapping_mul(0x0100_0000_01b3))
}
