//! Identification of a force from records.

use super::estimates::{Estimate, estimates};
use super::problem::{ForceLayout, ForceProblem, PreparedRecord};
use super::{ForceError, Identification, Options, RecordFit};
use crate::engine::Engine;
use crate::layout::Role;
use crate::watch::Plan;
use crate::{CampaignRecord, Correlation, Finding, FindingKind, IdentifyError, Searches, Watch, campaign};
use hysteron_model::Start;
use hysteron_model::force::{ForceModel, ForceModelError, Motion};
use hysteron_model::hysteresis::{DriveSpan, HysteresisForm, Search};
use hysteron_model::model_file::{ForceFile, SignalUnits};
use hysteron_model::record::{InputOutput, Swings, range_of};
use hysteron_model::validate::{Scoring, score};
use hysteron_numeric::display::short;
use hysteron_optimize::{Algorithm, Bounds, LeastSquaresOptions, Problem, Range, Settings};
use rayon::prelude::*;

/// Stages of the identification.
pub(crate) const PLAN: Plan = Plan(&[("force", 1.0)]);
/// Number of the default family that is held at 1.
const EXPONENT: &str = "exponent";
/// Largest degree of the polynomial of the displacement.
const HIGHEST_DEGREE: usize = 9;
/// Window of the rate as a share of the period of the fastest swings.
const RATE_WINDOW: f64 = 0.02;
/// Ends of the range of the dashpot's rate, as shares of the largest rate.
const RATES: [f64; 2] = [1e-3, 3.0];
/// Ends of the range of the reach of the compliance, as shares of the stroke.
const REACHES: [f64; 2] = [1e-5, 1.0];
/// Share of the smallest stroke within which the force turns, for the ranges of the shape.
const SHARE_OF_TURNING: f64 = 0.1;
/// Lattice of starts: rates of the dashpot, as shares of the largest rate.
const LATTICE_RATES: [f64; 3] = [0.02, 0.1, 0.5];
/// … and reaches of its compliance, as shares of the stroke.
const LATTICE_REACHES: [f64; 4] = [1e-3, 0.01, 0.05, 0.15];

/// Rates, ends, strokes and frequencies of the displacements, which set the ranges of the search.
struct Scales {
    fastest_rate: f64,
    ends: (f64, f64),
    /// Stroke of the record with the smallest.
    least_stroke: f64,
    /// Lowest and highest frequency of the swings.
    swings_hz: (f64, f64),
}

pub(super) fn identify(
    records: &[InputOutput],
    options: &Options,
    watch: &Watch<'_>,
    resume: Option<Searches>,
) -> Result<Identification, IdentifyError> {
    check(options)?;
    let campaign: Vec<CampaignRecord> =
        records.iter().map(|data| CampaignRecord { data: data.clone(), role: None }).collect();
    campaign::usable(&campaign)?;
    let swings_hz = swings(records)?;
    let window_s = options.rate_window_s.unwrap_or(RATE_WINDOW / swings_hz.1);
    let prepared = records
        .iter()
        .map(|data| PreparedRecord::new(data, window_s).map_err(|problem| of_record(data, problem)))
        .collect::<Result<Vec<_>, ForceError>>()?;
    let ends = records.iter().map(|record| range_of(&record.u));
    let strokes = ends.clone().map(|(low, high)| high - low);
    let scales = Scales {
        fastest_rate: prepared.iter().flat_map(|r| &r.rate).fold(0.0, |most, v| v.abs().max(most)),
        ends: ends.fold((f64::MAX, f64::MIN), |(low, high), (l, h)| (low.min(l), high.max(h))),
        least_stroke: strokes.fold(f64::INFINITY, f64::min),
        swings_hz,
    };
    let form = family(options);
    let span = drive_span(form, &scales, options);
    let fixed = fixed(options);
    let (layout, bounds, held) = layout(form, &span, &scales, &fixed)?;
    let shapes = form.starts(&span);
    let example = shapes.first().cloned().unwrap_or_else(|| form.example(&span));
    let problem = ForceProblem::new(prepared, (form, options.degree), window_s, (layout, bounds), &example);
    let starts = starts(&problem, &shapes, &scales);
    let algorithm = Algorithm::LeastSquares(LeastSquaresOptions {
        starts: starts.len(),
        agreement: None,
        cost_tolerance: 1e-9,
        step_tolerance: 1e-7,
        ..LeastSquaresOptions::default()
    });
    let mut engine = Engine::new(None, Settings::default(), watch, PLAN, resume);
    let shown = |x: &[f64]| {
        let first = records.first()?;
        let units = SignalUnits::of(&first.u_unit, &first.y_unit);
        let file = ForceFile::new(&problem.model(x)?, units, first.sample_rate_hz());
        hysteron_model::Model::try_from(file).ok()
    };
    let search = engine.run("force", &problem, &algorithm, starts, Some(&shown))?.outcome;
    let model = problem.model(&search.best).ok_or(IdentifyError::Stopped)?;
    let fits =
        problem.records.iter().map(|record| record_fit(&model, record)).collect::<Result<Vec<_>, _>>()?;
    for fit in &fits {
        let fit_percent = fit.scores.fit_percent.unwrap_or(0.0);
        // After a stop any fit is accepted.
        if fit_percent < options.least_fit_percent && !engine.cancelled {
            let (record, need) = (fit.data.name.clone(), options.least_fit_percent);
            return Err(ForceError::Class { record, fit_percent, need }.into());
        }
    }
    let (estimates, correlation) = estimates(&problem, &model, &held, &at_limit(&problem, &search.best));
    Ok(Identification {
        findings: findings(&model, &estimates, correlation.as_ref()),
        treatment: treatment(&problem),
        model,
        estimates,
        correlation,
        records: fits,
        search,
        fastest_rate: scales.fastest_rate,
        excited_hz: scales.swings_hz,
        interrupted: engine.cancelled,
        resume: engine.searches(),
    })
}

fn of_record(data: &InputOutput, problem: ForceModelError) -> ForceError {
    let record = data.name.clone();
    match problem {
        ForceModelError::NoTimes => ForceError::NoTimes { record },
        problem => ForceError::Record { record, problem },
    }
}

fn check(options: &Options) -> Result<(), ForceError> {
    let refuse = |option, value, expected| Err(ForceError::Option { option, value, expected });
    if !(1..=HIGHEST_DEGREE).contains(&options.degree) {
        return refuse("degree", options.degree as f64, "a whole number from 1 to 9");
    }
    match options.rate_window_s {
        Some(window_s) if !(window_s >= 0.0 && window_s.is_finite()) => {
            refuse("rate_window_s", window_s, "a finite number that is not negative")
        }
        _ => Ok(()),
    }
}

/// Lowest and highest frequency of the swings of the displacements.
fn swings(records: &[InputOutput]) -> Result<(f64, f64), ForceError> {
    records.iter().try_fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), record| {
        let swings = Swings::of(&record.u, &record.time)
            .ok_or_else(|| ForceError::NoTimes { record: record.name.clone() })?;
        Ok((low.min(swings.slowest_hz), high.max(swings.fastest_hz)))
    })
}

fn family(options: &Options) -> HysteresisForm {
    match options.hysteresis {
        Some(form) => form.searched(),
        None => HysteresisForm::dahl(),
    }
}

/// Numbers held, those of the default included.
fn fixed(options: &Options) -> Vec<(String, f64)> {
    let mut fixed = options.fixed.clone();
    if options.hysteresis.is_none() && fixed.iter().all(|(name, _)| name != EXPONENT) {
        fixed.push((EXPONENT.to_owned(), 1.0));
    }
    fixed
}

/// Span of the displacements for the ranges of a family's shape. Force turns within a small share of the
/// stroke, where a displacement takes much of it: the state of a family without elements is searched over a
/// tenth of the smallest stroke, the plays or cells of another over all strokes.
fn drive_span(form: HysteresisForm, scales: &Scales, options: &Options) -> DriveSpan {
    let (low, high) = scales.ends;
    let stroke = match form.description().elements() {
        None => SHARE_OF_TURNING * scales.least_stroke,
        Some(_) => high - low,
    };
    let exponent = options.fixed.iter().find(|(name, _)| name == "n").map_or(1.0, |(_, n)| *n);
    DriveSpan {
        stroke,
        ends: [low, high],
        grid: [low, high],
        reach: high - low,
        fastest_rate: std::f64::consts::TAU * scales.swings_hz.1,
        exponent,
        holds_exponent: true,
        is_straight: false,
    }
}

/// Roles of the numbers that enter nonlinearly, their ranges, and the names of those that are held.
fn layout(
    form: HysteresisForm,
    span: &DriveSpan,
    scales: &Scales,
    fixed: &[(String, f64)],
) -> Result<(ForceLayout, Bounds, Vec<String>), ForceError> {
    let mut ranges = Vec::new();
    let mut held: Vec<String> = Vec::new();
    let demanded = |name: &str| fixed.iter().find(|(own, _)| own == name).map(|(_, value)| *value);
    let mut role = |name: &str, search: Search| {
        let searched = match (demanded(name), search) {
            (Some(value), _) => Err(value),
            (None, Search::Held(value) | Search::HeldUnlessBounded(value, _)) => Err(value),
            (None, Search::Linear(low, high)) => Ok(Range::linear(name, low, high)),
            (None, Search::Logarithmic(low, high)) => Ok(Range::logarithmic(name, low, high)),
        };
        match searched {
            Ok(range) => {
                ranges.push(range);
                Role::Searched(ranges.len() - 1)
            }
            Err(value) => {
                held.push(name.to_owned());
                Role::Fixed(value)
            }
        }
    };
    let numbers = form.shape_numbers(span);
    let shape: Vec<Role> = numbers.iter().map(|number| role(&number.name, number.search)).collect();
    let scaled = |[low, high]: [f64; 2], unit: f64| Search::Logarithmic(low * unit, high * unit);
    let (viscous, saturating_force) = (demanded("viscous"), demanded("saturating_force"));
    let [rates, reaches] = if saturating_force == Some(0.0) {
        [Search::Held(scales.fastest_rate), Search::Held(0.0)]
    } else {
        [scaled(RATES, scales.fastest_rate), scaled(REACHES, scales.ends.1 - scales.ends.0)]
    };
    let saturating_rate = role("saturating_rate", rates);
    let saturating_reach = role("saturating_reach", reaches);
    let coefficients = [("viscous", viscous), ("saturating_force", saturating_force)];
    held.extend(coefficients.iter().filter(|(_, value)| value.is_some()).map(|(name, _)| (*name).to_owned()));
    for (name, value) in fixed {
        let known = held.contains(name);
        let positive = name != "saturating_rate" || *value > 0.0;
        let not_negative = !name.starts_with("saturating_reach") || *value >= 0.0;
        if !known || !value.is_finite() || !positive || !not_negative {
            let own: Vec<&str> = numbers.iter().map(|number| number.name.as_str()).collect();
            let wanted = format!(
                "a force can hold {}, viscous, saturating_force, saturating_rate (above 0) and \
                 saturating_reach (0 or above) at a finite number",
                own.join(", ")
            );
            return Err(ForceError::Fixed { name: name.clone(), value: *value, wanted });
        }
    }
    let layout = ForceLayout { shape, viscous, saturating_force, saturating_rate, saturating_reach };
    Ok((layout, Bounds { ranges }, held))
}

/// For every shape that the family starts from, the best rate and reach of the saturating force, of a
/// lattice. Starts from different shapes: either element can take the loop, and the other then fits what
/// remains.
fn starts(problem: &ForceProblem<'_>, shapes: &[Vec<f64>], scales: &Scales) -> Vec<Vec<f64>> {
    let stroke = scales.ends.1 - scales.ends.0;
    let layout = &problem.layout;
    let of = |shape: &[f64], rate: f64, reach: f64| {
        let mut x = vec![0.0; problem.bounds.ranges.len()];
        let roles = layout.shape.iter().chain([&layout.saturating_rate, &layout.saturating_reach]);
        let values = shape.iter().copied().chain([rate * scales.fastest_rate, reach * stroke]);
        for (role, value) in roles.zip(values) {
            if let Some(index) = role.index() {
                let range = &problem.bounds.ranges[index];
                x[index] = value.clamp(range.low, range.high);
            }
        }
        x
    };
    let best = |shape: &Vec<f64>| {
        let lattice =
            LATTICE_RATES.iter().flat_map(|rate| LATTICE_REACHES.map(|reach| of(shape, *rate, reach)));
        let costs = lattice.map(|x| (problem.cost(&x, &mut ()), x));
        costs.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, x)| x)
    };
    let mut starts: Vec<Vec<f64>> = shapes.par_iter().filter_map(best).collect();
    starts.dedup();
    starts
}

/// Names of the numbers that ended at a bound.
fn at_limit(problem: &ForceProblem<'_>, x: &[f64]) -> Vec<String> {
    let ranges = problem.bounds.ranges.iter().zip(x);
    ranges.filter(|(range, x)| range.is_end(**x)).map(|(range, _)| range.name.clone()).collect()
}

/// Simulation and scores of a whole record.
fn record_fit(model: &ForceModel, record: &PreparedRecord<'_>) -> Result<RecordFit, IdentifyError> {
    let simulated = model
        .simulate(&record.motion(), Start::AsIdentified)
        .map_err(|problem| of_record(record.data, problem))?;
    let scores = score(record.data, &simulated, &Scoring::default())?;
    Ok(RecordFit { data: record.data.clone(), simulated, scores })
}

fn treatment(problem: &ForceProblem<'_>) -> Vec<String> {
    let of_record = |record: &PreparedRecord<'_>| {
        let Motion { rate, .. } = record.motion();
        let source = match rate {
            Some(_) => "rate as measured".to_owned(),
            None => format!("rate of the displacement over {} s", short(problem.rate_window_s)),
        };
        format!("{}: from rest at its first sample; {source}", record.data.name)
    };
    problem.records.iter().map(of_record).collect()
}

/// Condition number of the correlation above which some of the numbers are hardly distinguishable.
const ILL_CONDITIONED: f64 = 1e4;

fn findings(model: &ForceModel, estimates: &[Estimate], correlation: Option<&Correlation>) -> Vec<Finding> {
    let mut all = Vec::new();
    let mut say = |kind, topic, text: String| all.push(Finding::new(kind, topic, text));
    if model.saturating.is_empty() {
        let text = "no force saturates with the rate of these records: hysteresis and viscous force describe \
                    them.";
        say(FindingKind::Verdict, "rate", text.to_owned());
    }
    let limits: Vec<&str> =
        estimates.iter().filter(|e| e.at_limit && e.value != 0.0).map(|e| e.name.as_str()).collect();
    if !limits.is_empty() {
        let text = format!(
            "{} ended at the limit of its range; the other standard errors assume it known.",
            limits.join(", ")
        );
        say(FindingKind::Verdict, "parameters", text);
    }
    match correlation {
        None => say(
            FindingKind::Warning,
            "parameters",
            "these records do not determine every parameter: there are no standard errors. Records of other \
             amplitudes and frequencies would help."
                .to_owned(),
        ),
        Some(c) if c.condition_number.is_nan() || c.condition_number > ILL_CONDITIONED => say(
            FindingKind::Advice,
            "parameters",
            "the parameters are strongly correlated: records of other amplitudes and frequencies would \
             separate them."
                .to_owned(),
        ),
        Some(_) => {}
    }
    all
}
