//! The sequence of searches, and the findings on their result.

use super::columns::Group;
use super::exponent::{Exponent, Origin};
use super::normal::residual;
use super::records::{Campaign, RecordPeriod};
use super::search::{From, Ledger, Stage, search};
use super::start::{add_feedback, linear_start, signals};
use super::uncertainty::with_standard_errors;
use super::{ModesIdentification, Options};
use crate::findings::say;
use crate::{Finding, FindingKind, IdentifyError, ModesCheckpoint, Searches, Watch, fingerprint};
use hysteron_model::Advice;
use hysteron_model::axes::{
    AxesRecord, FrequencyMatrix, InfluenceMatrix, Mode, ScheduledModes, SteadyPeriod,
};
use hysteron_model::model_file::{ModesFile, SignalUnits};
use hysteron_model::record::ends_of;
use hysteron_numeric::display::{short, short_to};

/// Fit of one record.
#[derive(Clone, Debug, PartialEq)]
pub struct ModesRecordFit {
    /// Path of the record, or its name.
    pub record: String,
    /// rms of its inputs \[V\].
    pub level: f64,
    /// Periods averaged.
    pub periods: usize,
    /// Samples of a period.
    pub period_samples: usize,
    /// rms error of its mean period, pooled over the outputs \[µm\].
    pub rmse: f64,
    /// rms error of every output \[µm\].
    pub output_rmse: Vec<f64>,
    /// 100 · (1 − rms error / rms output) \[%\].
    pub fit_percent: f64,
    /// The period fitted.
    pub steady: SteadyPeriod,
    /// Its error, measured less model, mean-free and interleaved as its outputs; empty where it could not be
    /// simulated \[µm\].
    pub error: Vec<f64>,
}

/// A mode at the lowest and the highest level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeShift {
    /// At the lowest level.
    pub low: Mode,
    /// At the highest level.
    pub high: Mode,
}

/// Influence matrix at a level.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelInfluence {
    /// Level \[V\].
    pub level: f64,
    /// The matrix, from the frequency response of the records of the level.
    pub matrix: InfluenceMatrix,
}

/// Reach of the laws of the strains over the largest drive and stress of the records: another record of the same
/// level goes a little further.
const REACH: f64 = 1.25;

/// Relative cost of an iteration: linear, hysteresis coefficients alone, all parameters.
const WORK: [u64; 3] = [2, 4, 20];

/// Free parameters without hysteresis, at the highest level alone.
const LINEAR: [Group; 4] = [Group::Transition, Group::Input, Group::Output, Group::Feedthrough];
const SCHEDULED: [Group; 7] = [
    Group::Transition,
    Group::Input,
    Group::Output,
    Group::Feedthrough,
    Group::TransitionSlopes,
    Group::OutputSlopes,
    Group::FeedthroughSlopes,
];
const LAWS: [Group; 4] = [Group::Coefficients, Group::Output, Group::Feedthrough, Group::StrainFeedthrough];
const NO_SLOPES: [Group; 8] = [
    Group::Transition,
    Group::Input,
    Group::StrainInput,
    Group::Stress,
    Group::Coefficients,
    Group::Output,
    Group::Feedthrough,
    Group::StrainFeedthrough,
];
/// All parameters of the model.
pub(super) const ALL: [Group; 11] = [
    Group::Transition,
    Group::Input,
    Group::StrainInput,
    Group::Stress,
    Group::Coefficients,
    Group::Output,
    Group::Feedthrough,
    Group::StrainFeedthrough,
    Group::TransitionSlopes,
    Group::OutputSlopes,
    Group::FeedthroughSlopes,
];

/// Fingerprint of records and options, for checkpoints.
pub(super) fn identity(records: &[AxesRecord], options: &Options) -> String {
    let values = records.iter().flat_map(|r| r.u.iter().chain(&r.y)).flatten().map(|x| x.to_bits());
    format!("modes {options:?} {:x}", fingerprint(values))
}

/// Checkpoint of an interrupted search of the same problem.
fn resumed(resume: Option<Searches>, problem: &str) -> Result<Option<Box<ModesCheckpoint>>, IdentifyError> {
    match resume {
        None => Ok(None),
        Some(Searches { modes: Some(state), .. }) if state.problem == problem => Ok(Some(state)),
        Some(_) => Err(IdentifyError::Resume),
    }
}

pub(super) fn identify(
    records: &[AxesRecord],
    options: &Options,
    watch: &Watch<'_>,
    resume: Option<Searches>,
) -> Result<ModesIdentification, IdentifyError> {
    check(options)?;
    let campaign = Campaign::new(records, options)?;
    let scheduled = campaign.levels.len() > 1;
    let stages = stages(options, scheduled);
    let whole = stages.iter().map(|s| s.work * s.iterations as u64).sum();
    let file = |model: &ScheduledModes| {
        let (units, inputs, outputs) = records.first().map_or_else(Default::default, |r| {
            (SignalUnits::of(&r.u_unit, &r.y_unit), r.inputs.clone(), r.outputs.clone())
        });
        ModesFile::new(model, units, inputs, outputs)
    };
    let problem = identity(records, options);
    let resume = resumed(resume, &problem)?;
    let mut ledger = Ledger { watch, done: 0, whole, file: &file, problem: &problem, stage: 0, state: None };
    if !ledger.tell("frequency response", None, None) {
        return Err(IdentifyError::Stopped);
    }
    let exponent = Exponent::new(&campaign, options);
    let start = linear_start(&campaign, options, exponent.value, watch.stop())?;
    let mut model = start.model.clone();
    if !scheduled {
        model.transition_slopes.iter_mut().for_each(|slope| *slope = 0.0);
    }
    let all: Vec<&RecordPeriod> = campaign.pieces.iter().collect();
    let top = campaign.top();
    let mut parameters = 0;
    for (index, stage) in stages.iter().enumerate() {
        if ledger.is_stopped() {
            break;
        }
        ledger.stage = index;
        let mut from = From { iteration: 0, damping: stage.damping };
        match &resume {
            Some(state) if index < state.stage => {
                ledger.done += stage.work * stage.iterations as u64;
                continue;
            }
            Some(state) if index == state.stage => {
                model = state.model.to_model()?;
                from = From { iteration: state.iteration, damping: state.damping };
            }
            _ => {}
        }
        if stage.groups.contains(&Group::Coefficients) && model.feedback.is_none() {
            add_feedback(&start, &mut model, &top, options.plays);
        }
        let alone = stage.groups == LINEAR && scheduled;
        let pieces = if alone { &top } else { &all };
        (model, parameters) = search(model, stage, from, (&campaign, pieces), &mut ledger);
    }
    let last = stages.last().map_or(&[][..], |stage| stage.groups);
    if !ledger.is_stopped() {
        ledger.tell("standard errors", None, Some(&model));
    }
    let quantities = with_standard_errors(&model, (last, options.ridge), &all, watch.stop());
    set_reach(&mut model, &all);
    let fits = fits(&model, &campaign, records);
    for fit in &fits {
        // NaN fails the check. After a stop any fit is accepted.
        let enough = fit.fit_percent >= options.least_fit_percent;
        if !enough && !ledger.is_stopped() {
            return Err(IdentifyError::AxesClass {
                what: "modes",
                record: fit.record.clone(),
                fit_percent: fit.fit_percent,
                need: options.least_fit_percent,
            });
        }
    }
    model.validate()?;
    let modes = shifts(&model);
    let influence = influence(&campaign, &start.influence);
    let mut findings = findings(&model, &modes, &influence, &campaign, scheduled.then_some(exponent));
    findings.extend(unbounded(&model, records));
    if ledger.is_stopped() {
        let text = "the search was interrupted: this is the best so far.".to_owned();
        findings.push(Finding::new(FindingKind::Warning, "search", text));
    }
    Ok(ModesIdentification {
        parameters,
        records: fits,
        modes,
        quantities,
        influence,
        interrupted: ledger.is_stopped(),
        resume: Searches { modes: ledger.state, ..Searches::default() },
        findings,
        treatment: treatment(&campaign, start.pairs, model.modes),
        excited_hz: start.excited_hz,
        top_influence: start.influence,
        model,
    })
}

/// Lets the laws of the strains end a little beyond the records.
fn set_reach(model: &mut ScheduledModes, pieces: &[&RecordPeriod]) {
    let Some(feedback) = &model.feedback else { return };
    let (drive, stress) = signals(model, pieces, &feedback.drive_rows, &feedback.stress_rows);
    let reach = |z: &[Vec<f64>]| {
        let largest = z.iter().flatten().fold(0.0, |most: f64, z| most.max(z.abs()));
        if largest > 0.0 { REACH * largest } else { f64::INFINITY }
    };
    if let Some(feedback) = &mut model.feedback {
        feedback.drive.reach = reach(&drive);
        for (law, z) in feedback.stress.iter_mut().zip(&stress) {
            law.reach = reach(std::slice::from_ref(z));
        }
    }
}

/// Whether the model comes to rest within the range of its records.
fn unbounded(model: &ScheduledModes, records: &[AxesRecord]) -> Option<Finding> {
    let (low, high) = ends_of(records.iter().flat_map(|record| &record.u))?;
    let wave = model.goes_on_after([low, high])?;
    let unit = records.first().map_or_else(String::new, |record| record.u_unit.spaced());
    let text = format!(
        "after a square wave of ± {}{unit} at {} Hz on all inputs, within the range of the records, the \
         motion of the model does not come to rest: such drives are beyond what the records hold at a \
         resonance. Limit the slew rate, or add records with more drive there.",
        short_to(wave.amplitude, 2),
        short_to(wave.frequency_hz, 3)
    );
    Some(Finding::new(FindingKind::Warning, "stability", text))
}

fn stages(options: &Options, scheduled: bool) -> Vec<Stage> {
    let stage = |name, groups, damping, iterations, stop, work| Stage {
        name,
        groups,
        damping,
        iterations,
        stop,
        work,
        ridge: options.ridge,
    };
    let mut stages = Vec::new();
    if scheduled {
        stages.push(stage("linear modes, highest level", &LINEAR[..], 1e-5, 2, 1e-2, WORK[0]));
        stages.push(stage("linear modes, all levels", &SCHEDULED[..], 1e-4, 8, 1e-2, WORK[0]));
    } else {
        stages.push(stage("linear modes", &LINEAR[..], 1e-5, 8, 1e-2, WORK[0]));
    }
    if options.hysteresis {
        stages.push(stage("strains", &LAWS[..], 1e-4, 5, 1.5e-3, WORK[1]));
        let groups = if scheduled { &ALL[..] } else { &NO_SLOPES[..] };
        stages.push(stage("everything", groups, 1e-4, options.iterations, 1.5e-3, WORK[2]));
    }
    stages
}

fn check(options: &Options) -> Result<(), IdentifyError> {
    let refuse = |name, value: f64, expected| Err(IdentifyError::ModesOption { name, value, expected });
    if !(1..=8).contains(&options.steps) {
        return refuse("steps", options.steps as f64, "1 to 8 steps a sample");
    }
    if options.plays > 32 {
        return refuse("plays", options.plays as f64, "at most 32 plays");
    }
    if options.modes.is_some_and(|modes| modes == 0 || modes > 100) {
        return refuse("modes", options.modes.unwrap_or(0) as f64, "1 to 100 pairs of poles");
    }
    if !(options.ridge.is_finite() && options.ridge >= 0.0) {
        return refuse("ridge", options.ridge, "a finite number, at least 0");
    }
    for (name, value) in [
        ("lag_hz", options.lag_hz.unwrap_or(1.0)),
        ("exponent", options.exponent.unwrap_or(1.0)),
        ("time_constant_s", options.time_constant_s),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return refuse(name, value, "a finite number above 0");
        }
    }
    Ok(())
}

fn fits(model: &ScheduledModes, campaign: &Campaign, records: &[AxesRecord]) -> Vec<ModesRecordFit> {
    let fit = |(piece, record): (&RecordPeriod, &AxesRecord)| {
        let outputs = piece.period.outputs;
        let error = residual(model, piece);
        let e = error.clone().unwrap_or_else(|| vec![f64::NAN; piece.period.y.len()]);
        let rms = |e: &mut dyn Iterator<Item = f64>| {
            let (sum, count) = e.fold((0.0, 0.0), |(sum, count), e| (sum + e * e, count + 1.0));
            (sum / f64::max(count, 1.0)).sqrt()
        };
        let rmse = rms(&mut e.iter().copied());
        ModesRecordFit {
            record: record.label(),
            level: piece.period.level,
            periods: piece.period.averaged,
            period_samples: piece.period.samples(),
            rmse,
            output_rmse: (0..outputs).map(|m| rms(&mut e.iter().skip(m).step_by(outputs).copied())).collect(),
            fit_percent: 100.0 * (1.0 - rmse / piece.period.output_rms()),
            steady: piece.period.clone(),
            error: error.unwrap_or_default(),
        }
    };
    campaign.pieces.iter().zip(records).map(fit).collect()
}

fn shifts(model: &ScheduledModes) -> Vec<ModeShift> {
    let at = |level| model.modes_at(model.level.state(level));
    let both = at(model.level.lowest).into_iter().zip(at(model.level.highest));
    let mut shifts: Vec<ModeShift> = both.map(|(low, high)| ModeShift { low, high }).collect();
    shifts.sort_by(|a, b| a.high.frequency_hz.total_cmp(&b.high.frequency_hz));
    shifts
}

/// Matrices of the levels whose records determine one.
fn influence(campaign: &Campaign, top: &InfluenceMatrix) -> Vec<LevelInfluence> {
    let last = campaign.levels.len() - 1;
    let of = |level: usize| -> Option<InfluenceMatrix> {
        if level == last {
            return Some(top.clone());
        }
        let pieces = campaign.of_level(level);
        let periods: Vec<_> = pieces.iter().map(|piece| &piece.period).collect();
        FrequencyMatrix::local_polynomial(&periods).ok().map(|g| InfluenceMatrix::of_response(&g))
    };
    let levels = campaign.levels.iter().enumerate();
    levels.filter_map(|(k, &level)| Some(LevelInfluence { level, matrix: of(k)? })).collect()
}

fn treatment(campaign: &Campaign, pairs: usize, modes: usize) -> Vec<String> {
    let mut lines: Vec<String> = campaign
        .pieces
        .iter()
        .map(|piece| {
            let p = &piece.period;
            format!(
                "{}: {} inputs of {}{} rms repeat every {} samples; the fit sees the mean of {} settled \
                 periods",
                p.name,
                p.inputs,
                short(p.level),
                campaign.unit.spaced(),
                p.samples(),
                p.averaged
            )
        })
        .collect();
    lines.push(format!("{modes} modes were found from {pairs} pairs of poles"));
    lines
}

/// Condition number of an influence matrix above which a warning is given.
const ILL_CONDITIONED: f64 = 30.0;

fn findings(
    model: &ScheduledModes,
    modes: &[ModeShift],
    influence: &[LevelInfluence],
    campaign: &Campaign,
    scheduled: Option<Exponent>,
) -> Vec<Finding> {
    let mut all = Vec::new();
    let unit = campaign.unit.spaced();
    if let Some(exponent) = scheduled {
        let fall = |m: &ModeShift| 100.0 * (1.0 - m.high.frequency_hz / m.low.frequency_hz);
        let mut falls: Vec<f64> = modes.iter().map(fall).collect();
        falls.sort_by(f64::total_cmp);
        // Two digits, as the table has them.
        let percent = |x: f64| short(format!("{x:.1e}").parse().unwrap_or(x));
        let median = falls[falls.len() / 2];
        let (least, most) = (falls.first().copied().unwrap_or(0.0), falls.last().copied().unwrap_or(0.0));
        say(
            &mut all,
            FindingKind::Verdict,
            "levels",
            format!(
                "from {} to {}{unit} rms the resonances {} by {} % in the median of the modes (falls of {} to {} \
                 %{}).",
                short(model.level.lowest),
                short(model.level.highest),
                if median < 0.0 { "rise" } else { "fall" },
                percent(median.abs()),
                percent(least),
                percent(most),
                if least < 0.0 { ", below 0 where they rise" } else { "" }
            ),
        );
        let p = short(exponent.value);
        let law = match exponent.origin {
            Origin::Given => String::new(),
            Origin::Responses => format!(" The modes follow level^{p}, by the responses of the levels."),
            Origin::Assumed => format!(
                " The records do not determine how the modes follow the level: level^{p} is assumed unless \
                 the exponent is given."
            ),
        };
        let levels = say(
            &mut all,
            FindingKind::Advice,
            "levels",
            format!(
                "levels measured at different times do not distinguish a change with the drive from one with \
                 time or temperature.{law}"
            ),
        );
        if exponent.origin == Origin::Assumed {
            levels.advise(Advice::GiveExponent);
        }
    } else {
        say(
            &mut all,
            FindingKind::Advice,
            "levels",
            format!(
                "all records have one level, {}{unit} rms: the amplitude dependence of the modes is not \
                 determined and left out. Add records at a third of it.",
                short(model.level.highest)
            ),
        );
    }
    for level in influence {
        let condition = level.matrix.condition_number();
        let kind = if condition > ILL_CONDITIONED { FindingKind::Warning } else { FindingKind::Verdict };
        let remark = if condition > ILL_CONDITIONED {
            ": some directions take far more voltage than others, and their errors are as much larger"
        } else {
            ""
        };
        say(
            &mut all,
            kind,
            "influence",
            format!(
                "influence matrix at {}{unit} rms: condition number {}{remark}.",
                short(level.level),
                short(condition)
            ),
        );
    }
    all
}
