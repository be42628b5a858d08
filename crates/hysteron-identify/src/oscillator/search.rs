//! Identification of an oscillator from records.

use rayon::prelude::*;

use super::coordinates::{COUNT, Coordinates, LARGEST_N, N, ranges};
use super::equation_error::EquationError;
use super::knowledge::{Estimate, estimates};
use super::output_error::OutputError;
use super::preparation::{PreparedRecord, pieces};
use super::shapes::candidates;
use super::{Identification, Options, RecordFit};
use crate::engine::Engine;
use crate::watch::Plan;
use crate::{Correlation, Finding, FindingKind, IdentifyError, Searches, Watch};
use hysteron_model::Start;
use hysteron_model::hysteresis::{Admissibility, RecordEnds};
use hysteron_model::model_file::{OscillatorFile, SignalUnits};
use hysteron_model::oscillator::{Drive, Oscillator, OscillatorState};
use hysteron_model::record::InputOutput;
use hysteron_model::validate::{Scoring, score};
use hysteron_numeric::display::short;
use hysteron_optimize::{Algorithm, LeastSquaresOptions, OptimizeError, Settings};

/// Parameters that can be held: they are coordinates of the search.
const HOLDABLE: [(&str, usize); 3] = [("mass", 0), ("damping", 1), ("n", N)];

/// Stages of the identification.
pub(crate) const PLAN: Plan = Plan(&[("shapes", 0.2), ("output error", 0.8)]);

pub(super) fn identify(
    records: &[InputOutput],
    options: &Options,
    watch: &Watch<'_>,
    resume: Option<Searches>,
) -> Result<Identification, IdentifyError> {
    let held = held(options)?;
    if let Some(start) = &options.start {
        start.validate()?;
    }
    let pieces = pieces(records, options)?;
    let regression = EquationError::new(&pieces, options)?;
    let mut engine = Engine::new(None, Settings::default(), watch, PLAN, resume);
    engine.enter("shapes");
    let (candidates, shapes) = candidates(&regression, options, &mut engine)?;
    let [mass, _, stiffness] = regression.linear;
    let linear = Oscillator::from_values([mass, 0.0, stiffness, 0.0, 0.0, 0.0, 1.0]);
    let drives = pieces
        .iter()
        .map(|piece| {
            let steps = options.steps.unwrap_or_else(|| linear.steps(piece.rate));
            Drive::new(&piece.u, piece.rate, options.inter_sample, piece.ends(), steps)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let problem = OutputError::new(
        (&pieces, &drives),
        held,
        &ranges(regression.linear),
        regression.size,
        regression.linear,
    );
    let starts: Vec<Vec<f64>> = candidates.iter().map(|c| problem.start(&c.coordinates)).collect();
    let algorithm = Algorithm::LeastSquares(LeastSquaresOptions {
        starts: starts.len(),
        agreement: Some(2),
        ..LeastSquaresOptions::default()
    });
    let shown = |x: &[f64]| {
        let first = records.first()?;
        let units = SignalUnits::of(&first.u_unit, &first.y_unit);
        let rate = first.sample_rate_hz()?;
        let file = OscillatorFile::new(&problem.oscillator(x), units, options.inter_sample, rate);
        hysteron_model::Model::try_from(file).ok()
    };
    let search =
        match (engine.run("output error", &problem, &algorithm, starts, Some(&shown)), options.start) {
            // The oscillator of its shape alone is not stable on these records.
            (Err(OptimizeError::NoFeasiblePoint { .. }), Some(start)) => {
                let start = problem.start(&Coordinates::of(&start, regression.size));
                engine.run("output error", &problem, &algorithm, vec![start], Some(&shown))?
            }
            (search, _) => search?,
        }
        .outcome;
    let oscillator = problem.oscillator(&search.best);
    let fits = problem.starts(&search.best);
    let fits = records
        .par_iter()
        .zip(&pieces)
        .zip(&drives)
        .zip(fits)
        .map(|(((data, piece), drive), (start, _))| record_fit(&oscillator, data, (piece, drive), start))
        .collect::<Result<Vec<_>, _>>()?;
    for fit in &fits {
        let fit_percent = fit.scores.fit_percent.unwrap_or(0.0);
        // After a stop any fit is accepted.
        if fit_percent < options.least_fit_percent && !engine.cancelled {
            return Err(IdentifyError::OscillatorClass {
                record: fit.data.name.clone(),
                fit_percent,
                need: options.least_fit_percent,
            });
        }
    }
    let names: Vec<&str> = options.fixed.iter().map(|(name, _)| name.as_str()).collect();
    let (estimates, correlation) = estimates(&problem, &search.best, &names);
    let findings = findings(&oscillator, &estimates, correlation.as_ref());
    Ok(Identification {
        oscillator,
        estimates,
        correlation,
        offset: fits.first().map_or(0.0, |fit| fit.scores.offset),
        inter_sample: options.inter_sample,
        records: fits,
        shapes,
        search,
        findings,
        treatment: pieces.iter().map(treatment).collect(),
        excited_hz: regression.band_hz,
        interrupted: engine.cancelled,
        resume: engine.searches(),
    })
}

/// Coordinates held by the options.
fn held(options: &Options) -> Result<[Option<f64>; COUNT], IdentifyError> {
    let mut held = [None; COUNT];
    for (name, value) in &options.fixed {
        let refuse = |wanted| IdentifyError::OscillatorFixed { name: name.clone(), value: *value, wanted };
        let Some((_, index)) = HOLDABLE.iter().find(|(known, _)| known == name) else {
            return Err(refuse("only mass, damping and n can be held: k and α, β and γ are coupled"));
        };
        match *index {
            N if !(1.0..=LARGEST_N).contains(value) => return Err(refuse("needs 1 ≤ n ≤ 5")),
            N => {}
            _ if !(*value > 0.0 && value.is_finite()) => return Err(refuse("needs a value above 0")),
            _ => {}
        }
        held[*index] = Some(*value);
    }
    Ok(held)
}

/// Simulation and scores of the whole record from the fitted start.
fn record_fit(
    oscillator: &Oscillator,
    data: &InputOutput,
    (piece, drive): (&PreparedRecord, &Drive),
    start: Start<OscillatorState>,
) -> Result<RecordFit, IdentifyError> {
    let mut one = vec![0.0; drive.len()];
    oscillator.simulate(drive, start, &mut one)?;
    let repeats = drive.ends() == RecordEnds::Periodic;
    let simulated: Vec<f64> = one.iter().cycle().take(data.len()).copied().collect();
    let data = data.without_first(piece.settling);
    let scores = score(&data, &simulated, &Scoring::default())?;
    let period_samples = repeats.then_some(piece.y.len());
    Ok(RecordFit { data, start, period_samples, simulated, scores })
}

fn treatment(piece: &PreparedRecord) -> String {
    let name = &piece.name;
    match piece.start {
        Start::Settled { .. } if piece.periods > 1 => format!(
            "{name}: the force repeats every {} samples; the fit sees the mean of {} settled periods",
            piece.y.len(),
            piece.periods
        ),
        Start::Settled { .. } if piece.settling > 0 => format!(
            "{name}: the force repeats every {} samples; the fit sees the last period, before which the \
             displacement settles",
            piece.y.len()
        ),
        Start::Settled { .. } => format!("{name}: one period of a steady state"),
        Start::AsIdentified | Start::Rest { .. } => format!("{name}: from rest"),
        Start::Remembering { .. } => {
            format!("{name}: displacement, velocity and z at the first sample were fitted")
        }
    }
}

/// Condition number of the correlation above which some of the parameters are hardly distinguishable.
const ILL_CONDITIONED: f64 = 1e4;
/// Relative standard error above which a parameter is hardly determined.
const VAGUE: f64 = 0.3;
/// Share of the hysteretic spring below which it is negligible.
const THIN: f64 = 0.02;
/// α in standard errors above which the loop is significant.
const SIGNIFICANT: f64 = 3.0;

fn findings(
    oscillator: &Oscillator,
    estimates: &[Estimate],
    correlation: Option<&Correlation>,
) -> Vec<Finding> {
    let mut all = Vec::new();
    let mut say = |kind, topic, text: String| all.push(Finding::new(kind, topic, text));
    let whole = oscillator.stiffness + oscillator.alpha;
    let admissibility = oscillator.admissibility();
    let small =
        format!("at small motion the natural frequency is {} Hz", short(oscillator.natural_frequency_hz()));
    let large = Oscillator { alpha: 0.0, ..*oscillator }.natural_frequency_hz();
    let resonance = match admissibility {
        Admissibility::Bounded { .. } | Admissibility::BoundedFromRest { .. } => {
            format!("{small}; it falls towards {} Hz as the loop saturates.", short(large))
        }
        _ => format!("{small}."),
    };
    say(FindingKind::Verdict, "resonance", resonance);
    let kind = match admissibility {
        Admissibility::Bounded { .. } | Admissibility::BoundedFromRest { .. } => FindingKind::Verdict,
        _ => FindingKind::Warning,
    };
    let verdict = match admissibility {
        Admissibility::Bounded { .. } => "bounded: the hysteretic force stays finite for every motion.",
        Admissibility::BoundedFromRest { .. } => {
            "bounded from rest: the hysteretic force stays finite for every motion that starts from rest."
        }
        Admissibility::Hardening => {
            "not bounded (hardening): the hysteretic force grows ever faster with the motion; do not use the \
             model beyond the motion it was identified on."
        }
        _ => "not bounded: the hysteretic force can run away beyond the motion it was identified on.",
    };
    say(kind, "boundedness", verdict.to_owned());
    let alpha_error = estimates.iter().find(|e| e.name == "alpha").and_then(|e| e.std_error);
    if oscillator.alpha < THIN * whole || alpha_error.is_some_and(|s| oscillator.alpha < SIGNIFICANT * s) {
        say(
            FindingKind::Advice,
            "loop",
            "the hysteretic force is small or hardly excited: a linear oscillator describes these records \
             almost as well."
                .to_owned(),
        );
    }
    if estimates.iter().any(|e| e.at_limit) {
        say(
            FindingKind::Verdict,
            "exponent",
            format!(
                "n ended at the limit of its range, {}; the other standard errors assume it known.",
                short(oscillator.n)
            ),
        );
    }
    match correlation {
        None => say(
            FindingKind::Warning,
            "parameters",
            "these records do not determine the parameters: there are no standard errors. A wider range of \
             amplitudes would help."
                .to_owned(),
        ),
        Some(c) if c.condition_number > ILL_CONDITIONED => say(
            FindingKind::Advice,
            "parameters",
            format!(
                "the parameters are strongly correlated{}: a wider range of amplitudes would separate them.",
                if c.condition_number.is_finite() {
                    format!(" (condition number of their correlation {})", short(c.condition_number))
                } else {
                    String::new()
                }
            ),
        ),
        Some(_) => {}
    }
    for e in estimates.iter().filter(|e| e.std_error.is_some_and(|s| s > VAGUE * e.value.abs())) {
        let text = format!(
            "{} is hardly determined: {} ± {}.",
            e.name,
            short(e.value),
            short(e.std_error.unwrap_or(0.0))
        );
        say(FindingKind::Advice, "parameters", text);
    }
    all
}
