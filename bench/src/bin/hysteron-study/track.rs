//! What does the loop add? The default bench, which lies outside the model class, behind a converter that holds, identified from nested loops and a sweep;
//! references that nobody has measured are followed sample by sample, without compensation, by feedforward, by feedback, and by both. The reading of one
//! period makes the drive of the next. Errors as in `follow`.

use std::f64::consts::TAU;

use hysteron::compensator::{CompensatorOptions, Prediction};
use hysteron::control::{
    Adaptive, FeedbackKind, Forward, LawFamily, Loop, LoopSettings, Stage, Strategy, TrackingScore, Wanted,
    play, reach, slew_of_current,
};
use hysteron::hysteresis::HysteresisForm;
use hysteron::identify::{Options, Unwatched, identify};
use hysteron::realise::RealiseOptions;
use hysteron::record::InterSample;

use crate::Outcome;
use crate::follow::{RANGE_V, RATE_HZ, SAMPLES, campaign, random, reference, truth};
use crate::table;

/// Highest frequency of the random reference, up to which it is predicted, and the noise it is taken to carry.
const BAND: Prediction = Prediction::Band { highest_hz: 100.0, noise: 1e-3 };
/// Creep that never ends is followed down to this frequency \[Hz\].
const LOWEST_HZ: f64 = 0.01;
/// The amplifier of the last table: 5 mA into 10 µF.
const CURRENT_A: f64 = 5e-3;
const CAPACITANCE_F: f64 = 10e-6;

pub fn strategies() -> Vec<Strategy> {
    let inverse = |preview, prediction| {
        Forward::Inverse(CompensatorOptions { preview, prediction, ..CompensatorOptions::default() })
    };
    let whole = || inverse(None, Prediction::Stays);
    let predicted = || inverse(Some(0), BAND);
    let causal = || inverse(Some(0), Prediction::Stays);
    let line = || Forward::Line;
    vec![
        Strategy::new("straight line", line()),
        Strategy::new("PI alone", line()).with_feedback(LawFamily::Pi),
        Strategy::new("PI^λ alone", line()).with_feedback(LawFamily::FractionalPi),
        Strategy::new("notch + integral alone", line()).with_feedback(LawFamily::NotchIntegral),
        Strategy::new("inverse, preview", whole()),
        Strategy::new("inverse, causal, predictor", predicted()),
        Strategy::new("inverse, causal", causal()),
        Strategy::new("inverse, preview + PI", whole()).with_feedback(LawFamily::Pi),
        Strategy::new("inverse, preview + PI^λ", whole()).with_feedback(LawFamily::FractionalPi),
        Strategy::new("inverse, preview + observer", whole()).with_observer(),
        Strategy::new("inverse, causal, predictor + PI", predicted()).with_feedback(LawFamily::Pi),
        Strategy::new("inverse, causal, predictor + observer", predicted()).with_observer(),
        Strategy::new("inverse, preview + filtered-x LMS", whole()).with_adaptive(Adaptive::default()),
        Strategy::new("inverse, causal + filtered-x LMS", causal()).with_adaptive(Adaptive::default()),
    ]
}

fn law(made: &Loop) -> String {
    let Some(tuned) = &made.feedback else {
        return made.observer.map_or("–".to_owned(), |(gain, _)| format!("gain {gain:.4}"));
    };
    let (proportional, integral) = (tuned.law.proportional, tuned.law.integral_per_s);
    match tuned.law.kind {
        FeedbackKind::Integral => format!("{integral:.1}/s"),
        FeedbackKind::Pi { corner_hz } => format!("{proportional:.4} (1 + 2π {corner_hz:.3}/s)"),
        FeedbackKind::FractionalPi { corner_hz, order } => {
            format!("{proportional:.4} (1 + (2π {corner_hz:.3}/s)^{order})")
        }
        FeedbackKind::NotchIntegral { notch } => {
            format!("{integral:.1}/s, notch {:.1} Hz {:.4}/{}", notch.frequency_hz, notch.zeros, notch.poles)
        }
    }
}

pub fn study(seed: usize) -> Outcome<()> {
    let seed = seed as u64;
    let records = campaign(seed)?;
    let options = Options {
        hysteresis: HysteresisForm::PrandtlIshlinskii { plays: 20 },
        inter_sample: InterSample::Hold,
        ..Options::default()
    };
    let model = identify(&records, &options, &mut Unwatched, None)?.model;
    let truth = truth();
    let settings = LoopSettings {
        sample_rate_hz: RATE_HZ,
        range_v: RANGE_V,
        slew_v_per_s: f64::INFINITY,
        // The sweep ends there.
        wanted: Wanted { trusted_to_hz: Some(100.0), ..Wanted::default() },
        realise: RealiseOptions { lowest_frequency_hz: Some(LOWEST_HZ), ..RealiseOptions::default() },
    };
    let sines = [1.0, 10.0, 20.0, 50.0, 100.0];
    let mut references: Vec<(String, Vec<f64>)> =
        sines.iter().map(|f| (format!("{f} Hz"), reference(|t| (TAU * f * t).sin()))).collect();
    references.push(("random 0.5–100 Hz".to_owned(), reference(random(seed))));
    let mut errors = Vec::new();
    let mut loops = Vec::new();
    let number = |x: f64| if x.is_finite() { format!("{x:.2}") } else { "∞".to_owned() };
    for strategy in strategies() {
        let made = Loop::new(&model, &settings, &strategy)?;
        let mut line = vec![strategy.name.clone()];
        let mut last = None;
        for (_, reference) in &references {
            let stage = Stage::Rig { truth: &truth, seed, stream: 0 };
            let played = play(&made, reference, stage, Some(0.0))?;
            let score = TrackingScore::of(&played.displacement, reference, SAMPLES / 4);
            line.push(format!("{:.3}", score.rms_percent));
            last = Some(score);
        }
        line.push(last.map_or(String::new(), |score| format!("{:.3}", score.max_percent)));
        errors.push(line);
        let mut line = vec![strategy.name.clone(), law(&made)];
        match made.margins() {
            Some(m) => {
                line.extend([number(m.gain), number(m.phase_deg), number(m.modulus), number(m.crossover_hz)])
            }
            None => line.extend(std::iter::repeat_n("–".to_owned(), 4)),
        }
        line.extend([number(made.bandwidth.minus_3_db_hz), number(made.bandwidth.one_percent_hz)]);
        loops.push(line);
    }
    let header: Vec<&str> = ["error, % of stroke rms"]
        .into_iter()
        .chain(references.iter().map(|(name, _)| name.as_str()))
        .chain(["largest, random"])
        .collect();
    table::print(&header, &errors)?;
    let header = [
        "on the model",
        "law",
        "gain margin",
        "phase margin, °",
        "modulus margin",
        "crossover, Hz",
        "−3 dB, Hz",
        "1 %, Hz",
    ];
    table::print(&header, &loops)?;
    limits(&model, &settings, seed)
}

/// Highest frequency by formula of a sine within an amplifier's current, and the share of samples that it holds back just below and just above.
fn limits(model: &hysteron::hammerstein::Model, settings: &LoopSettings, seed: u64) -> Outcome<()> {
    let slew_v_per_s = slew_of_current(CURRENT_A, CAPACITANCE_F);
    let settings = LoopSettings { slew_v_per_s, ..*settings };
    let forward = Forward::Inverse(CompensatorOptions::default());
    let made = Loop::new(model, &settings, &Strategy::new("inverse, preview", forward))?;
    let truth = truth();
    let mut rows = Vec::new();
    for amplitude in [1.0, 2.0, 5.0, 10.0] {
        let own = reach(&made.line, &made.dynamics, RATE_HZ, RANGE_V, slew_v_per_s, amplitude);
        let mut row =
            vec![format!("{amplitude}"), format!("{:.2}", own.amplitude_v), format!("{:.1}", own.highest_hz)];
        for share in [0.9, 1.2] {
            let frequency = share * own.highest_hz;
            let reference = reference(|t| 0.1 * amplitude * (TAU * frequency * t).sin());
            let played = play(&made, &reference, Stage::Rig { truth: &truth, seed, stream: 0 }, Some(0.0))?;
            let score = TrackingScore::of(&played.displacement, &reference, SAMPLES / 4);
            row.push(format!("{:.1}", 100.0 * played.at_slew as f64 / SAMPLES as f64));
            row.push(format!("{:.3}", score.rms_percent));
        }
        rows.push(row);
    }
    let header = [
        "amplitude, µm",
        "V",
        "highest, Hz",
        "held back at 0.9 of it, %",
        "error, %",
        "held back at 1.2, %",
        "error, %",
    ];
    table::print(&header, &rows)
}
