//! Promise: weights that adapt come close to the best there are, and swing beyond the step that is stated,
//! not below.

#![allow(clippy::unwrap_used)] // A failure is a failed test.

use std::f64::consts::TAU;

use hysteron_model::compensator::CompensatorOptions;
use hysteron_model::control::*;
use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::realise::RealiseOptions;
use hysteron_model::record::InterSample;
use hysteron_numeric::Complex64;
use hysteron_rt::{FilteredLms, LmsFilter, LmsMemory, LmsSettings};

const RATE_HZ: f64 = 1e4;
/// Two periods of 500 Hz: what varies with time in the loop of a sine adds up to 0.
const WEIGHTS: usize = 40;
const SINE_HZ: f64 = 500.0;

fn response(taps: &[f64], f: f64) -> Complex64 {
    taps.iter().enumerate().map(|(k, s)| *s * Complex64::from_polar(1.0, -TAU * f * k as f64 / RATE_HZ)).sum()
}

fn path(taps: &[f64]) -> Vec<(f64, Complex64)> {
    std::iter::once(1e-6)
        .chain((1..=20_000).map(|k| 0.5 * RATE_HZ * f64::from(k) / 2e4))
        .map(|f| (f, response(taps, f)))
        .collect()
}

/// A disturbance of one frequency along `taps`, learnt through `modelled`: rms of the error of the last
/// thousandth of it over the first.
fn left(taps: &[f64], modelled: &[f64], frequency_hz: f64, rate: f64) -> f64 {
    const SAMPLES: usize = 100_000;
    let mut weights = [0.0; WEIGHTS];
    let (mut references, mut filtered, mut turned) = ([0.0; WEIGHTS], [0.0; WEIGHTS], [0.0; WEIGHTS]);
    let filter = LmsFilter { weights: &mut weights, secondary: modelled, whitening: &[], stride: 1 };
    let memory = LmsMemory { references: &mut references, filtered: &mut filtered, turned: &mut turned };
    let settings = LmsSettings { rate, leak: 0.0, floor: 1e-9 };
    let mut lms = FilteredLms::new(filter, memory, settings).unwrap();
    let mut put = Vec::with_capacity(SAMPLES);
    let mut errors = Vec::with_capacity(SAMPLES);
    let mut error = 0.0;
    for k in 0..SAMPLES {
        let theta = TAU * frequency_hz * k as f64 / RATE_HZ;
        put.push(lms.step(theta.cos(), error));
        let done: f64 = taps.iter().enumerate().filter_map(|(j, s)| Some(s * put[k.checked_sub(j)?])).sum();
        error = (theta - 1.0).cos() - done;
        errors.push(error);
    }
    let rms = |e: &[f64]| (e.iter().map(|e| e * e).sum::<f64>() / e.len() as f64).sqrt();
    let left = rms(&errors[SAMPLES - 100..]) / rms(&errors[..100]);
    if left.is_finite() { left } else { f64::INFINITY }
}

/// 6 samples late and then a pole; a sample is 18° of the sine: models 2, 4 and 6 samples off are 36°, 72°
/// and 108° off.
#[test]
fn weights_swing_beyond_their_limit_and_not_below() {
    let late = |samples: usize| -> Vec<f64> {
        std::iter::repeat_n(0.0, samples).chain((0..20).map(|k| 0.6 * 0.4_f64.powi(k))).collect()
    };
    let taps = late(6);
    for (modelled, frequency_hz, learns) in [
        (late(6), SINE_HZ, true),
        (late(4), SINE_HZ, true),
        (late(8), SINE_HZ, true),
        (late(10), SINE_HZ, true),
        (late(12), SINE_HZ, false),
        (late(2), SINE_HZ, true),
        (late(0), SINE_HZ, false),
        (late(6), 0.0, true),
        (late(0), 0.0, true),
        (late(6).iter().map(|s| -s).collect(), 0.0, false),
    ] {
        let limit = step_limit(&path(&taps), response(&modelled, frequency_hz), frequency_hz, RATE_HZ);
        let off = modelled.len() as f64 - taps.len() as f64;
        if learns {
            let (below, beyond) = (0.97 * limit, 1.03 * limit);
            let kept = left(&taps, &modelled, frequency_hz, below);
            let lost = left(&taps, &modelled, frequency_hz, beyond);
            assert!(kept < 1e-2 && lost > 1e2, "{frequency_hz} Hz, {off} late, limit {limit}: {kept} {lost}");
        } else {
            assert_eq!(limit, 0.0, "{frequency_hz} Hz, {off} late");
            assert!(left(&taps, &modelled, frequency_hz, 0.01) > 1e2, "{frequency_hz} Hz, {off} late");
        }
    }
}

/// A level behind a delay of d samples: an integral whose error is d + 1 samples old swings at 2 sin(π/(2 (2
/// d + 1))) (its characteristic roots meet the unit circle there), a sine, each of its two directions having
/// half of the power, at about twice that.
#[test]
fn behind_a_delay_the_limit_is_that_of_the_formula() {
    for delay in [0_usize, 1, 5, 20] {
        let taps: Vec<f64> = (0..=delay).map(|k| f64::from(u8::from(k == delay))).collect();
        let limit = |f: f64| step_limit(&path(&taps), response(&taps, f), f, RATE_HZ);
        let formula = 2.0 * (TAU / (4.0 * (2.0 * delay as f64 + 1.0))).sin();
        assert!((limit(0.0) / formula - 1.0).abs() < 1e-3, "{delay}: {} {formula}", limit(0.0));
        if delay == 20 {
            assert!((limit(2500.0) / formula - 2.0).abs() < 0.1, "{} {formula}", limit(2500.0));
        }
    }
}

/// 2 µm/V, no hysteresis, a resonance at 280 Hz with 2 % damping, 1.2 samples of delay.
fn model() -> Model {
    let natural = TAU * 280.0;
    let square = natural * natural;
    let term = |coefficient, order| Term { coefficient, order };
    let mode = TransferFunction::new(
        vec![term(square, 0.0)],
        vec![term(square, 0.0), term(0.04 * natural, 1.0), term(1.0, 2.0)],
    );
    Model {
        hysteresis: Hysteresis::from(BoucWen::new(vec![2.0], 0.0, 0.5, 0.1, 1.0).unwrap()),
        dynamics: Dynamics::Integer(mode.unwrap()),
        offset: 1.0,
        delay_s: 1.2e-4,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Hold,
        sample_rate_hz: Some(RATE_HZ),
    }
}

fn made(strategy: Strategy) -> Loop {
    let settings = LoopSettings {
        sample_rate_hz: RATE_HZ,
        range_v: [0.0, 10.0],
        slew_v_per_s: f64::INFINITY,
        wanted: RequiredMargins::default(),
        realise: RealiseOptions::default(),
    };
    Loop::new(&model(), &settings, &strategy).unwrap()
}

fn causal() -> Forward {
    Forward::Inverse(CompensatorOptions { preview: Some(0), ..CompensatorOptions::default() })
}

/// 200 lines from 0.5 to 100 Hz, and what nobody can predict: a thousandth of white noise. 2 s.
fn random() -> Vec<f64> {
    let phase = |k: usize| TAU * ((k * k) as f64 * 0.618_033_988_75).fract();
    let at = |t: f64| -> f64 { (1..=200).map(|k| (TAU * 0.5 * k as f64 * t + phase(k)).sin()).sum() };
    let grown = |t: f64| (t / 0.1).min(1.0);
    let mut seed = 1_u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        12f64.sqrt() * ((seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
    };
    // 200 sines of amplitude 1 have an rms of 10.
    let motion = |t: f64, noise: f64| 9.0 + 0.2 * grown(t).powi(2) * (at(t) + 1e-2 * noise);
    (0..20_000).map(|k| motion(k as f64 / RATE_HZ, noise())).collect()
}

#[test]
fn on_a_linear_stage_weights_come_close_to_the_best_there_are() {
    let adapting = made(Strategy::new("adapting", causal()).with_adaptive(Adaptive::up_to(100.0)));
    let reference = random();
    let from = 15_000;
    let rms = |made: &Loop| {
        let played = play(made, &reference, Plant::Model, None).unwrap();
        let error: Vec<f64> = reference.iter().zip(&played.displacement).map(|(r, y)| r - y).collect();
        (TrackingScore::of(&played.displacement, &reference, from).rms, error)
    };
    let (alone, error) = rms(&adapting.without_adaptation());
    let (learnt, _) = rms(&adapting);
    let known: Vec<f64> = reference.iter().map(|r| r - reference[0]).collect();
    let filter = adapting.adaptive.as_ref().unwrap();
    let optimum = filter.optimum(&known, &error, from);
    println!("alone {alone}, learnt {learnt}, best {optimum}; step {} of {}", filter.rate, filter.limit);
    assert!(optimum < 0.02 * alone, "{optimum} {alone}");
    assert!(learnt < 2.0 * optimum, "{learnt} {optimum}");
    // With nearly all of the margin used up it still learns.
    let mut eager = adapting.clone();
    if let Some(filter) = &mut eager.adaptive {
        filter.rate = 0.95 * filter.limit;
    }
    let (quick, _) = rms(&eager);
    assert!(quick < 0.2 * alone, "{quick} {alone}");
}

/// The stage is 5 samples later than the model: 18° at 100 Hz.
#[test]
fn sines_tell_by_how_much_the_stage_is_later_than_the_model() {
    let mut adapting = made(Strategy::new("adapting", causal()).with_adaptive(Adaptive::up_to(100.0)));
    let sines = Sines { level: 9.0, amplitude: 3.0, range_hz: [10.0, 100.0] };
    let error = |made: &Loop| {
        let alone = made.without_adaptation().sines(&sines, Plant::Model, None).unwrap();
        made.phase_error(&alone.answers).unwrap()
    };
    assert!(error(&adapting).0 < 0.2, "{:?}", error(&adapting));
    adapting.dynamics.delay_samples += 5;
    let (degrees, at_hz) = error(&adapting);
    assert!((degrees - 18.0).abs() < 0.3 && (at_hz - 100.0).abs() < 1.0, "{degrees} {at_hz}");
}

/// On a linear stage the bandwidths that sines find are those of the formula.
#[test]
fn sines_find_the_bandwidths_of_the_formula() {
    for strategy in [
        Strategy::new("PI", Forward::Line).with_feedback(LawFamily::Pi),
        Strategy::new("causal", causal()),
        Strategy::new("inverse", Forward::Inverse(CompensatorOptions::default())),
    ] {
        let made = made(strategy);
        let sines = Sines { level: 9.0, amplitude: 0.1, range_hz: [1.0, 1500.0] };
        let found = made.sines(&sines, Plant::Model, None).unwrap();
        for (edge, formula) in [
            (found.minus_3_db, made.bandwidth.minus_3_db_hz),
            (found.one_percent, made.bandwidth.one_percent_hz),
        ] {
            let at = edge.found().unwrap();
            assert!((at / formula - 1.0).abs() < 0.03, "{}: {edge:?} {formula}", made.strategy.name);
        }
        assert!(found.answers.windows(2).all(|a| a[0].frequency_hz < a[1].frequency_hz));
        // A sine's error is |1 − T| of its amplitude: over 2 √2 of it in shares of the stroke, rms.
        for a in &found.answers {
            let expected = 100.0 * (1.0 - a.followed).norm() / 8f64.sqrt();
            assert!((a.error_percent - expected).abs() < 0.02 * expected + 1e-3, "{a:?} {expected}");
        }
    }
    let made = made(Strategy::new("causal", causal()));
    let sines = |range_hz| Sines { level: 9.0, amplitude: 0.1, range_hz };
    let low = made.sines(&sines([0.5, 2.0]), Plant::Model, None).unwrap();
    assert_eq!((low.minus_3_db, low.one_percent), (Edge::Above(2.0), Edge::Above(2.0)));
    let high = made.sines(&sines([1200.0, 1500.0]), Plant::Model, None).unwrap();
    assert_eq!((high.minus_3_db, high.one_percent), (Edge::Below(1200.0), Edge::Below(1200.0)));
}
