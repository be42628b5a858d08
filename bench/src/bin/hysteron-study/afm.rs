//! An atomic force microscope's scanner (`piezo-afm-z15um`, measured): 13 s cycles of ramps of 3 µm, rests
//! with creep and sines of 10 nm at six frequencies, each segment at a rate of its own. Cycles are left out
//! in turn, and later cycles are run freely after a fit of the earlier ones: families of hysteresis and kinds
//! of creep, and the gain and phase at the sines. Another set, a year later, is of ramps of 0.2 s alone.

use std::env;
use std::io::{Write, stdout};
use std::path::PathBuf;

use hysteron_identify::{
    CampaignRecord, Choice, DynamicsChoice, FamilyChoice, FitRecords, Options, Task, Watch, fit,
};
use hysteron_io::{ReadOptions, read_record};
use hysteron_model::dynamics::Creep;
use hysteron_model::hysteresis::HysteresisForm;
use hysteron_model::model::{RunScore, Simulation};
use hysteron_model::model_file::Maker;
use hysteron_model::record::{ChannelChoice, InputOutput, MeasurementRun, Segment};
use hysteron_model::validate::Scoring;
use hysteron_model::{Model, Start};

use crate::Outcome;
use crate::table;

/// Cycles of each run that are at hand.
const CYCLES: usize = 8;

/// The cycles of a set, where the public data are.
fn cycles(set: &str) -> Outcome<Option<Vec<InputOutput>>> {
    let folder = env::var_os("HYSTERON_DATA").map_or_else(|| PathBuf::from("../shared/data"), PathBuf::from);
    let path = |cycle: usize| folder.join(format!("piezo-afm-z15um/{set}_{cycle:02}.csv"));
    if !path(0).is_file() {
        writeln!(stdout(), "skipped: no file {}; set HYSTERON_DATA to the public data", path(0).display())?;
        return Ok(None);
    }
    let options =
        ReadOptions { input: Some("u_V".into()), output: Some("y_um".into()), ..ReadOptions::default() };
    let choice = ChannelChoice { input: options.input.clone(), output: options.output.clone() };
    let read = |cycle: usize| Ok(read_record(&path(cycle), &options)?.input_output(&choice)?);
    (0..CYCLES).map(read).collect::<Outcome<Vec<_>>>().map(Some)
}

fn identified(records: &[InputOutput], options: &Options) -> Outcome<Model> {
    let records = records.iter().map(|data| CampaignRecord { data: data.clone(), role: None }).collect();
    let task = Task::Hammerstein(Box::new(Options { continued: true, ..options.clone() }));
    Ok(fit(&FitRecords::Single(records), &task, &Watch::silent(), None, &Maker::default())?.model)
}

/// Free run over the records as parts of one run, with one offset.
fn free_run(model: &Model, records: &[InputOutput]) -> Outcome<RunScore> {
    let runs = MeasurementRun::of(records)?;
    let run = runs.first().ok_or("no run")?;
    Ok(model.score_run(run, Start::AsIdentified, &Scoring::default())?)
}

fn percent(x: Option<f64>) -> String {
    x.map_or("-".into(), |x| format!("{x:.3}"))
}

fn errors(score: &RunScore) -> [String; 2] {
    let whole = score.whole.outputs.first();
    [whole.and_then(|s| s.rmse_percent_of_stroke), whole.and_then(|s| s.max_percent_of_stroke)].map(percent)
}

/// Sines of a record, measured or simulated.
fn sines(record: &InputOutput) -> Vec<Segment> {
    record.segments().into_iter().filter(|segment| segment.gain.is_some()).collect()
}

fn simulated(record: &InputOutput, simulation: &Simulation) -> InputOutput {
    InputOutput { y: simulation.outputs.first().cloned().unwrap_or_default(), ..record.clone() }
}

/// Trains on the first cycles, then runs freely over the others; `number` of the cycles are left out in turn.
pub fn study(number: usize) -> Outcome<()> {
    let (Some(cycles), Some(ramps)) = (cycles("cycle_1_300hz")?, cycles("ramps_0p2s")?) else {
        return Ok(());
    };
    let usual = Options::default();
    writeln!(
        stdout(),
        "Trained on the first cycles, one free run over the later ones, one offset; % of their stroke\n"
    )?;
    let mut rows = Vec::new();
    for first in [4, 5, 6] {
        let model = identified(&cycles[..first], &usual)?;
        let [rms, max] = errors(&free_run(&model, &cycles[first..])?);
        rows.push(vec![format!("00 to 0{}", first - 1), format!("0{first} to 07"), rms, max]);
    }
    table::print(&["trained on", "free run over", "rms [%]", "max [%]"], &rows)?;

    writeln!(
        stdout(),
        "Both sets in one model, trained on 00 to 05 of each, free run over 06 and 07 of each\n"
    )?;
    let model = identified(&[&cycles[..6], &ramps[..6]].concat(), &usual)?;
    let row = |(name, set): (&str, &[InputOutput])| {
        let [rms, max] = errors(&free_run(&model, &set[6..])?);
        Ok(vec![name.to_owned(), rms, max])
    };
    let sets = [("ramps, rests and sines", &cycles[..]), ("ramps of 0.2 s", &ramps[..])];
    let rows = sets.into_iter().map(row).collect::<Outcome<Vec<_>>>()?;
    table::print(&["set", "rms [%]", "max [%]"], &rows)?;

    writeln!(stdout(), "Families and kinds of creep, trained on 00 to 05, free run over 06 and 07\n")?;
    let mut rows = Vec::new();
    let named = |name: &str| HysteresisForm::usual().into_iter().find(|form| form.name() == name);
    let kelvin_voigt = Creep::KelvinVoigt { elements: 3 };
    let lag = (DynamicsChoice::Integer, 1);
    let candidates = [
        ("bouc-wen", kelvin_voigt, lag),
        ("dead-zone-plays", kelvin_voigt, lag),
        ("krasnoselskii-pokrovskii", kelvin_voigt, lag),
        ("preisach-density", kelvin_voigt, lag),
        ("prandtl-ishlinskii", Creep::None, lag),
        ("prandtl-ishlinskii", Creep::Logarithmic, lag),
        ("prandtl-ishlinskii", Creep::Fractional, lag),
        ("prandtl-ishlinskii", kelvin_voigt, lag),
        ("activated-plays", Creep::None, (DynamicsChoice::None, 1)),
        ("activated-plays", Creep::None, lag),
        ("activated-plays", Creep::None, (DynamicsChoice::Fractional, 2)),
    ];
    for (name, creep, (dynamics, order)) in candidates {
        let form = named(name).ok_or("no such family")?;
        // Of the plays with activated edges as by default, a cubic of the others.
        let degree = Choice::Given(if name == "activated-plays" { 2 } else { 3 });
        let hysteresis = FamilyChoice::Given(form);
        let options = Options { hysteresis, creep, dynamics, order, degree, ..usual.clone() };
        let scored = identified(&cycles[..6], &options).and_then(|model| free_run(&model, &cycles[6..]));
        let [rms, max] = match scored {
            Ok(score) => errors(&score),
            Err(error) => [error.to_string(), String::new()],
        };
        rows.push(vec![name.to_owned(), creep.name().to_owned(), dynamics.name().to_owned(), rms, max]);
    }
    table::print(&["hysteresis", "creep", "dynamics", "rms [%]", "max [%]"], &rows)?;

    writeln!(
        stdout(),
        "One cycle left out in turn, its error in a free run over all cycles; gain and phase at its sines\n"
    )?;
    let usual_answers = left_out_in_turn(&cycles, number, &usual, true)?;
    let lag = Options {
        hysteresis: FamilyChoice::Given(HysteresisForm::activated_plays()),
        degree: Choice::Given(2),
        dynamics: DynamicsChoice::Integer,
        order: 1,
        ..usual
    };
    let with_lag = left_out_in_turn(&cycles, number, &lag, false)?;
    let mut frequencies: Vec<f64> =
        usual_answers.iter().filter_map(|(m, _)| m.drive.high_hz).map(f64::round).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    let rows: Vec<Vec<String>> = frequencies
        .iter()
        .map(|&hz| {
            let (gain, phase, [gain_error, phase_error]) = at_sine(&usual_answers, hz);
            let (.., [gain_error_lag, phase_error_lag]) = at_sine(&with_lag, hz);
            let errors = [gain_error, gain_error_lag, phase_error, phase_error_lag];
            let errors = errors.map(|error| format!("{error:+.2}"));
            [format!("{hz}"), format!("{gain:.5}"), format!("{phase:.2}")].into_iter().chain(errors).collect()
        })
        .collect();
    table::print(
        &[
            "sine [Hz]",
            "gain measured [µm/V]",
            "phase measured [°]",
            "error of gain [%]",
            "with a lag instead [%]",
            "error of phase [°]",
            "with a lag instead [°]",
        ],
        &rows,
    )
}

/// Sines of a cycle that was left out, measured and as the model of the others has them.
type Answers = Vec<(Segment, Segment)>;

/// Leaves out each of the last `number` cycles in turn and runs the model of the others freely over all
/// cycles.
fn left_out_in_turn(
    cycles: &[InputOutput],
    number: usize,
    options: &Options,
    tell: bool,
) -> Outcome<Answers> {
    let (mut rows, mut answers) = (Vec::new(), Vec::new());
    for left_out in (0..CYCLES).rev().take(number) {
        let others: Vec<InputOutput> =
            cycles.iter().enumerate().filter(|(k, _)| *k != left_out).map(|(_, r)| r.clone()).collect();
        let model = identified(&others, options)?;
        let score = free_run(&model, cycles)?;
        let (record, own) = (&cycles[left_out], &score.records[left_out]);
        let scores = own.outputs.first();
        let residual: Vec<f64> =
            record.y.iter().zip(&own.simulation.outputs[0]).map(|(y, model)| y - model).collect();
        let mean = residual.iter().sum::<f64>() / residual.len() as f64;
        let about_mean = table::rms(residual.iter().map(|r| r - mean));
        rows.push(vec![
            format!("0{left_out}"),
            percent(scores.and_then(|s| s.rmse_percent_of_stroke)),
            percent(scores.and_then(|s| s.max_percent_of_stroke)),
            percent(scores.map(|s| 100.0 * about_mean / s.stroke)),
        ]);
        answers.extend(sines(record).into_iter().zip(sines(&simulated(record, &own.simulation))));
    }
    if tell {
        table::print(&["left out", "rms [%]", "max [%]", "rms about its mean [%]"], &rows)?;
    }
    Ok(answers)
}

/// Mean gain \[µm/V\] and phase \[°\] measured at a sine, and the model's mean errors \[%, °\].
fn at_sine(answers: &Answers, hz: f64) -> (f64, f64, [f64; 2]) {
    let own: Vec<_> =
        answers.iter().filter(|(m, _)| m.drive.high_hz.is_some_and(|f| f.round() == hz)).collect();
    let mean = |of: &dyn Fn(&(Segment, Segment)) -> f64| {
        own.iter().map(|pair| of(pair)).sum::<f64>() / own.len() as f64
    };
    let gain = |s: &Segment| s.gain.unwrap_or(f64::NAN);
    let phase = |s: &Segment| s.phase_deg.unwrap_or(f64::NAN);
    let errors = [mean(&|(m, s)| 100.0 * (gain(s) / gain(m) - 1.0)), mean(&|(m, s)| phase(s) - phase(m))];
    (mean(&|(m, _)| gain(m)), mean(&|(m, _)| phase(m)), errors)
}
