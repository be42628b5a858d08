//! What does the loop add? The default bench, which lies outside the model class, behind a converter that
//! holds, identified from nested loops and a sweep; references that nobody has measured are followed sample
//! by sample, without compensation, by feedforward, by feedback, and by both. The reading of one period makes
//! the drive of the next. Errors are of the true displacement, its mean taken off (the sensor has a zero of
//! its own), in per cent of the reference's stroke, rms, over the last three quarters.

use std::f64::consts::TAU;

use hysteron_identify::{CampaignRecord, Choice, FamilyChoice, Options, Watch, identify};
use hysteron_model::compensator::{CompensatorOptions, Prediction};
use hysteron_model::control::{
    Adaptive, Edge, FeedbackKind, Forward, LawFamily, Loop, LoopSettings, Plant, RequiredMargins, Sines,
    Strategy, TrackingScore, play, reach, slew_of_current,
};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::HysteresisForm;
use hysteron_model::invert::{InverseOptions, LastRun};
use hysteron_model::realise::RealiseOptions;
use hysteron_model::record::{ChannelChoice, InterSample};
use hysteron_rig::excitation::Excitation;
use hysteron_rig::{CampaignPlan, Dac, RigStage, Role, Truth, measure, run_campaign};
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use crate::Outcome;
use crate::table;

const RATE_HZ: f64 = 10_000.0;
const SAMPLES: usize = 20_000;
const CENTRE_UM: f64 = 14.0;
const AMPLITUDE_UM: f64 = 10.0;
/// Drive of the bench \[V\].
const RANGE_V: [f64; 2] = [0.0, 10.5];

/// Grows from rest to the full motion in 0.3 s.
fn reference(motion: impl Fn(f64) -> f64) -> Vec<f64> {
    let at = |k: usize| {
        let t = k as f64 / RATE_HZ;
        let grown = (t / 0.3).min(1.0);
        CENTRE_UM + AMPLITUDE_UM * grown * grown * (3.0 - 2.0 * grown) * motion(t)
    };
    (0..SAMPLES).map(at).collect()
}

/// 200 lines of one size from 0.5 to 100 Hz, phases at random, largest value 1.
fn random(seed: u64) -> impl Fn(f64) -> f64 {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut uniform = || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let lines: Vec<(f64, f64)> = (1..=200).map(|k| (0.5 * f64::from(k), TAU * uniform())).collect();
    let sum = move |t: f64| lines.iter().map(|(f, phase)| (TAU * f * t + phase).sin()).sum::<f64>();
    let largest = (0..SAMPLES).map(|k| sum(k as f64 / RATE_HZ).abs()).fold(0.0, f64::max);
    move |t| sum(t) / largest
}

fn truth() -> Truth {
    Truth { dac: Dac::Hold, ..Truth::default() }
}

fn campaign(seed: u64) -> Outcome<Vec<CampaignRecord>> {
    let plan = CampaignPlan { nested_amplitudes: vec![1.0, 0.75, 0.5, 0.25], ..CampaignPlan::default() };
    run_campaign(&truth(), &plan, seed)?
        .iter()
        .filter(|played| matches!(played.role, Role::NestedLoops | Role::Sweep))
        .map(|played| {
            let data = played.run.record.input_output(&ChannelChoice::default())?;
            Ok(CampaignRecord { data, role: None })
        })
        .collect()
}

/// Highest frequency of the random reference, up to which it is predicted, and the noise it is taken to
/// carry.
const BAND: Prediction = Prediction::Band { highest_hz: 100.0, noise: 1e-3 };
/// Creep that never ends is followed down to this frequency \[Hz\].
const LOWEST_HZ: f64 = 0.01;
/// The amplifier of the last table: 5 mA into 10 µF.
const CURRENT_A: f64 = 5e-3;
const CAPACITANCE_F: f64 = 10e-6;

fn strategies() -> Vec<Strategy> {
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
        Strategy::new("inverse, preview + filtered-x LMS", whole()).with_adaptive(Adaptive::up_to(100.0)),
        Strategy::new("inverse, causal + filtered-x LMS", causal()).with_adaptive(Adaptive::up_to(100.0)),
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

/// Errors of a run with the drive that a whole run left to learn from.
fn learned(model: &Model, reference: &[f64], seed: u64) -> Outcome<TrackingScore> {
    const RESTED: usize = 1000;
    let options = InverseOptions { virgin_v: Some(0.0), ..InverseOptions::within(RANGE_V) };
    let made = model.invert(reference, RATE_HZ, &options)?;
    let rest_v = made.rest.and_then(|start| start.voltage_v()).ok_or("a reference begins at rest")?;
    let play = |drive: &[f64], run: usize| -> Outcome<(Vec<f64>, Vec<f64>)> {
        let rested = std::iter::repeat_n(rest_v, RESTED).chain(drive.iter().copied()).collect();
        let excitation =
            Excitation::of_samples("drive".into(), "drive for a reference".into(), rested, RATE_HZ);
        let run = measure(&truth(), &excitation, seed, run)?;
        let reading = run.record.channels.get(1).ok_or("a run has a reading")?;
        Ok((reading.samples[RESTED..].to_vec(), run.y_true_um[RESTED..].to_vec()))
    };
    let (measured, _) = play(&made.drive, 0)?;
    let last = LastRun { drive: &made.drive, measured: &measured };
    let (_, true_um) = play(&model.learn(reference, last, RATE_HZ, &options)?.drive, 1)?;
    Ok(TrackingScore::of(&true_um, reference, SAMPLES / 4))
}

pub fn study(seed: usize) -> Outcome<()> {
    let seed = seed as u64;
    let records = campaign(seed)?;
    let fit = |hysteresis| -> Outcome<Model> {
        let options = Options {
            hysteresis: FamilyChoice::Given(hysteresis),
            inter_sample: Choice::Given(InterSample::Hold),
            ..Options::default()
        };
        Ok(identify(&records, &options, &Watch::silent(), None)?.model)
    };
    let model = fit(HysteresisForm::plays(20))?;
    let truth = truth();
    let stage = RigStage { truth: &truth, seed, stream: 0 };
    let plant = Plant::Stage(&stage);
    let settings = LoopSettings {
        sample_rate_hz: RATE_HZ,
        range_v: RANGE_V,
        slew_v_per_s: f64::INFINITY,
        // The sweep ends there.
        wanted: RequiredMargins { trusted_to_hz: Some(100.0), ..RequiredMargins::default() },
        realise: RealiseOptions { lowest_frequency_hz: Some(LOWEST_HZ), ..RealiseOptions::default() },
    };
    let sines = [1.0, 10.0, 20.0, 50.0, 100.0];
    let mut references: Vec<(String, Vec<f64>)> =
        sines.iter().map(|f| (format!("{f} Hz"), reference(|t| (TAU * f * t).sin()))).collect();
    references.push(("random 0.5–100 Hz".to_owned(), reference(random(seed))));
    let scored = |made: &Loop| -> Outcome<Vec<TrackingScore>> {
        let scores = references.iter().map(|(_, reference)| {
            let played = play(made, reference, plant, Some(0.0))?;
            Ok(TrackingScore::of(&played.displacement, reference, SAMPLES / 4))
        });
        scores.collect()
    };
    let row = |name: &str, scores: &[TrackingScore]| {
        let mut line = vec![name.to_owned()];
        line.extend(scores.iter().map(|score| format!("{:.3}", score.rms_percent)));
        line.extend(scores.last().map(|score| format!("{:.3}", score.max_percent)));
        line
    };
    let number = |x: f64| if x.is_finite() { format!("{x:.2}") } else { "∞".to_owned() };
    let edge = |edge: Edge| match edge {
        Edge::Below(f) => format!("< {f:.0}"),
        Edge::At(f) => format!("{f:.1}"),
        Edge::Above(f) => format!("> {f:.0}"),
    };
    let swept = Sines { level: CENTRE_UM, amplitude: AMPLITUDE_UM, range_hz: [1.0, 1000.0] };
    let (mut errors, mut loops, mut learning) = (Vec::new(), Vec::new(), Vec::new());
    for strategy in strategies() {
        let made = Loop::new(&model, &settings, &strategy)?;
        let scores = scored(&made)?;
        errors.push(row(&strategy.name, &scores));
        let mut line = vec![strategy.name.clone(), law(&made)];
        match made.margins() {
            Some(m) => {
                line.extend([number(m.gain), number(m.phase_deg), number(m.modulus), number(m.crossover_hz)])
            }
            None => line.extend(std::iter::repeat_n("–".to_owned(), 4)),
        }
        let followed = made.sines(&swept, plant, Some(0.0))?;
        line.extend([number(made.bandwidth.minus_3_db_hz), edge(followed.minus_3_db)]);
        line.extend([number(made.bandwidth.one_percent_hz), edge(followed.one_percent)]);
        loops.push(line);
        if let (Some(filter), Some((_, reference)), Some(score)) =
            (&made.adaptive, references.last(), scores.last())
        {
            let alone = made.without_adaptation();
            let phase = made.phase_error(&alone.sines(&swept, plant, Some(0.0))?.answers);
            let (degrees, at_hz) = phase.ok_or("sines below the highest frequency")?;
            let left = play(&alone, reference, plant, Some(0.0))?.displacement;
            let left: Vec<f64> = reference.iter().zip(&left).map(|(r, y)| r - y).collect();
            let ahead = made.inverse.as_ref().map_or(0, |inverse| inverse.preview);
            let known: Vec<f64> =
                (0..SAMPLES).map(|k| reference[(k + ahead).min(SAMPLES - 1)] - reference[0]).collect();
            let best = filter.optimum(&known, &left, SAMPLES / 4) * score.rms_percent / score.rms;
            learning.push(vec![
                strategy.name.clone(),
                format!("{:.4}", filter.rate),
                format!("{:.4} at {:.0} Hz", filter.limit, filter.limit_at_hz),
                format!("{:.2}", filter.limit / filter.rate),
                format!("{degrees:.1} at {at_hz:.0} Hz"),
                format!("{:.1}", 90.0 - degrees),
                format!("{:.3}", score.rms_percent),
                format!("{best:.3}"),
            ]);
        }
    }
    let whole = Strategy::new("whole", Forward::Inverse(CompensatorOptions::default()));
    let bouc_wen = Loop::new(&fit(HysteresisForm::bouc_wen())?, &settings, &whole)?;
    errors.push(row("inverse of a Bouc–Wen model, preview", &scored(&bouc_wen)?));
    let runs = references.iter().map(|(_, reference)| learned(&model, reference, seed));
    errors.push(row("inverse, whole reference, one run learned", &runs.collect::<Outcome<Vec<_>>>()?));
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
        "−3 dB, Hz: formula",
        "played",
        "1 %, Hz: formula",
        "played",
    ];
    table::print(&header, &loops)?;
    let header = [
        "adaptive weights",
        "step",
        "largest stable",
        "margin",
        "phase, stage to model, °",
        "margin to 90°",
        "random, % of stroke",
        "best weights, %",
    ];
    table::print(&header, &learning)?;
    limits(&model, &settings, seed)
}

/// Highest frequency by formula of a sine within an amplifier's current, and the share of samples that it
/// holds back just below and just above.
fn limits(model: &Model, settings: &LoopSettings, seed: u64) -> Outcome<()> {
    let slew_v_per_s = slew_of_current(CURRENT_A, CAPACITANCE_F);
    let settings = LoopSettings { slew_v_per_s, ..*settings };
    let forward = Forward::Inverse(CompensatorOptions::default());
    let made = Loop::new(model, &settings, &Strategy::new("inverse, preview", forward))?;
    let truth = truth();
    let stage = RigStage { truth: &truth, seed, stream: 0 };
    let plant = Plant::Stage(&stage);
    let mut rows = Vec::new();
    for amplitude in [1.0, 2.0, 5.0, 10.0] {
        let own = reach(&made.line, &made.dynamics, RATE_HZ, RANGE_V, slew_v_per_s, amplitude);
        let mut row =
            vec![format!("{amplitude}"), format!("{:.2}", own.amplitude_v), format!("{:.1}", own.highest_hz)];
        for share in [0.9, 1.2] {
            let frequency = share * own.highest_hz;
            let reference = reference(|t| 0.1 * amplitude * (TAU * frequency * t).sin());
            let played = play(&made, &reference, plant, Some(0.0))?;
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
        "samples at the slew limit at 0.9 of it, %",
        "error, %",
        "samples at the slew limit at 1.2, %",
        "error, %",
    ];
    table::print(&header, &rows)
}
