//! Promise: a loop keeps the margins that are stated, and does on a stage what is predicted of it.

#![allow(clippy::unwrap_used)] // A failure is a failed test.

use std::f64::consts::{PI, TAU};

use hysteron_model::compensator::{CompensatorOptions, Prediction};
use hysteron_model::control::*;
use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::realise::RealiseOptions;
use hysteron_model::record::InterSample;
use hysteron_numeric::Complex64;
use hysteron_rig::{Dac, RigStage, Truth};

const RATE_HZ: f64 = 1e4;
const RANGE_V: [f64; 2] = [0.0, 10.0];

fn term(coefficient: f64, order: f64) -> Term {
    Term { coefficient, order }
}

/// 2 µm/V, hysteresis of the size α, a resonance at 280 Hz with 2 % damping, 1.2 samples of delay.
fn model(alpha: f64) -> Model {
    let natural = TAU * 280.0;
    let square = natural * natural;
    let mode = TransferFunction::new(
        vec![term(square, 0.0)],
        vec![term(square, 0.0), term(0.04 * natural, 1.0), term(1.0, 2.0)],
    );
    Model {
        hysteresis: Hysteresis::from(BoucWen::new(vec![2.0], alpha, 0.5, 0.1, 1.0).unwrap()),
        dynamics: Dynamics::Integer(mode.unwrap()),
        offset: 1.0,
        delay_s: 1.2e-4,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Hold,
        sample_rate_hz: Some(RATE_HZ),
    }
}

fn settings() -> LoopSettings {
    LoopSettings {
        sample_rate_hz: RATE_HZ,
        range_v: RANGE_V,
        slew_v_per_s: f64::INFINITY,
        wanted: RequiredMargins::default(),
        realise: RealiseOptions::default(),
    }
}

fn inverse(preview: Option<usize>) -> Forward {
    Forward::Inverse(CompensatorOptions {
        preview,
        prediction: Prediction::Stays,
        ..CompensatorOptions::default()
    })
}

fn sine(frequency_hz: f64, samples: usize) -> Vec<f64> {
    let grown = |t: f64| (t / 0.05).min(1.0);
    let at = |k: usize| {
        let t = k as f64 / RATE_HZ;
        9.0 + 4.0 * grown(t) * grown(t) * (3.0 - 2.0 * grown(t)) * (TAU * frequency_hz * t).sin()
    };
    (0..samples).map(at).collect()
}

/// L = k e^(−sτ)/s: |L| = 1 at k, where the angle is 90° + kτ; −180° at π/2τ, where |L| = 2kτ/π; least |1 +
/// L| by search.
#[test]
fn an_integral_behind_a_delay_has_the_margins_of_its_formula() {
    let late = 1e-3;
    for (k, stable) in [(200.0, true), (1000.0, true), (2000.0, false)] {
        let at = |f: f64| {
            let s = Complex64::new(0.0, TAU * f);
            k * (-s * late).exp() / s
        };
        let points: Vec<_> =
            (0..200_000).map(|i| 1e-3 * 10f64.powf(7.0 * f64::from(i) / 2e5)).map(|f| (f, at(f))).collect();
        let margins = Margins::of(&points);
        assert_eq!(margins.is_stable, stable, "{k}");
        assert!((margins.crossover_hz - k / TAU).abs() < 1e-4 * k);
        if stable {
            assert!((margins.gain - PI / (2.0 * k * late)).abs() < 1e-3 * margins.gain, "{margins:?}");
            assert!((margins.gain_at_hz - 0.25 / late).abs() < 0.1);
            assert!((margins.phase_deg - (90.0 - (k * late).to_degrees())).abs() < 1e-2, "{margins:?}");
        }
    }
}

#[test]
fn a_fractional_integral_is_what_its_formula_says_and_an_integral_below() {
    for order in [0.3, 0.7] {
        let law = FeedbackLaw::new(FeedbackKind::FractionalPi { corner_hz: 20.0, order }, RATE_HZ).unwrap();
        // A held error is half a sample late.
        for f in [1.0, 5.0, 20.0, 100.0] {
            let s = Complex64::new(0.0, TAU * f);
            let hold = Complex64::from_polar(1.0, -PI * f / RATE_HZ);
            let exact = 1.0 + (TAU * 20.0 / s).powf(order) * hold;
            let apart = (law.response(f) - exact).norm() / exact.norm();
            // The integral that goes on below adds (1 Hz/20 mHz)^(λ−1) at 1 Hz.
            let added = (f / 0.02_f64).powf(order - 1.0);
            assert!(apart < 1.1 * added + 2e-3, "{order} {f} Hz: {apart} {added}");
        }
        let slow = law.response(1e-5).norm() / law.response(1e-4).norm();
        assert!((slow - 10.0).abs() < 0.5, "{slow}");
    }
}

#[test]
fn a_notch_takes_off_the_resonance_it_is_made_for() {
    let notch = Notch { frequency_hz: 280.0, zeros: 0.02, poles: 0.7 };
    let law = FeedbackLaw::new(FeedbackKind::NotchIntegral { notch }, RATE_HZ).unwrap();
    for f in [1.0, 100.0, 250.0, 280.0, 400.0] {
        let (s, w) = (Complex64::new(0.0, TAU * f), TAU * 280.0);
        let exact = (s * s + 0.04 * w * s + w * w) / (s * s + 1.4 * w * s + w * w) / s;
        // The integral is a sum from the present sample on, the pair is held: half a sample ahead and half
        // late.
        let apart = (law.response(f) - exact).norm() * TAU * f;
        assert!(apart < 3.0 * PI * f / RATE_HZ, "{f} Hz: {apart}");
    }
}

/// In the time domain the controller answers a sine as its response says.
#[test]
fn the_controller_does_what_its_response_says() {
    let notch = Notch { frequency_hz: 280.0, zeros: 0.02, poles: 0.7 };
    for kind in [
        FeedbackKind::Pi { corner_hz: 30.0 },
        FeedbackKind::FractionalPi { corner_hz: 30.0, order: 0.6 },
        FeedbackKind::NotchIntegral { notch },
    ] {
        let law = FeedbackLaw::new(kind, RATE_HZ).unwrap();
        let mut parts = FeedbackParts::<f64>::new(&law);
        let mut feedback = parts.feedback().unwrap();
        let f = 50.0;
        let own: Vec<f64> = (0..20_000)
            .map(|k| feedback.step((TAU * f * f64::from(k) / RATE_HZ).cos(), hysteron_rt::HeldBack::No))
            .collect();
        // Over whole periods at the end; what a slow pole still remembers is a level and a slope.
        let periods = &own[10_000..20_000];
        let sum: Complex64 = periods
            .iter()
            .enumerate()
            .map(|(k, c)| *c * Complex64::from_polar(1.0, -TAU * f * k as f64 / RATE_HZ))
            .sum();
        let found = sum / 5000.0;
        let apart = (found - law.response(f)).norm() / law.response(f).norm();
        assert!(apart < 5e-3, "{kind:?}: {apart}");
    }
}

#[test]
fn tuned_loops_keep_their_margins_and_use_them_up() {
    let (model, wanted) = (model(0.0), RequiredMargins::default());
    let line = Strategy::new("line", Forward::Line);
    let dynamics = Loop::new(&model, &settings(), &line).unwrap().dynamics;
    let late = |f: f64| Complex64::from_polar(1.0, -TAU * f / RATE_HZ);
    let plant: Vec<_> = loop_frequencies(&dynamics, RATE_HZ)
        .into_iter()
        .map(|f| (f, dynamics.response(f, RATE_HZ) * late(f)))
        .collect();
    let mut left = Vec::new();
    for family in [LawFamily::Pi, LawFamily::FractionalPi, LawFamily::NotchIntegral] {
        let tuned = tune(family, &plant, &dynamics, RATE_HZ, &wanted, &|| Ok(())).unwrap();
        let with = |gain: f64| {
            let law = tuned.law.clone().scaled(gain);
            Margins::of(&plant.iter().map(|(f, p)| (*f, law.response(*f) * p)).collect::<Vec<_>>())
        };
        let m = with(1.0);
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs() || a == b;
        assert!(close(m.gain, tuned.margins.gain) && close(m.modulus, tuned.margins.modulus));
        let keeps = |m: &Margins| m.is_stable && m.gain >= 2.0 && m.phase_deg >= 60.0 && m.modulus >= 0.5;
        assert!(keeps(&m), "{family:?}: {m:?}");
        assert!(!keeps(&with(1.01)), "{family:?}: {:?}", with(1.01));
        // The gain margin is the gain at which the loop begins to swing.
        assert!(with(0.99 * m.gain).is_stable && !with(1.01 * m.gain).is_stable, "{family:?}");
        left.push(tuned.left);
    }
    // With the notch the resonance no longer limits the integral.
    assert!(left[2] < 0.5 * left[0], "{left:?}");
}

/// A linear stage under PI: the error of a sine is what the formula of the closed loop says.
#[test]
fn what_is_predicted_of_a_linear_loop_is_what_it_does() {
    let strategies = [
        Strategy::new("PI", Forward::Line).with_feedback(LawFamily::Pi),
        Strategy::new("both", inverse(Some(0))).with_feedback(LawFamily::Pi),
    ];
    for strategy in strategies {
        let made = Loop::new(&model(0.0), &settings(), &strategy).unwrap();
        let (f, samples) = (20.0, 20_000);
        let reference = sine(f, samples);
        let played = play(&made, &reference, Plant::Model, None).unwrap();
        assert_eq!((played.at_range, played.at_slew), (0, 0));
        let score = TrackingScore::of(&played.displacement, &reference, samples / 2);
        let law = &made.feedback.as_ref().unwrap().law;
        let (forward, correction) = match &made.inverse {
            Some(inverse) => (inverse.tracking(f), inverse.correction(f)),
            None => [made.dynamics.response(f, RATE_HZ) / made.dynamics.response(0.0, RATE_HZ); 2].into(),
        };
        let open = law.response(f) * correction * Complex64::from_polar(1.0, -TAU * f / RATE_HZ);
        let expected = 4.0 * (1.0 - (forward + open) / (1.0 + open)).norm() / 2f64.sqrt();
        assert!(
            (score.rms - expected).abs() < 0.01 * expected,
            "{}: {} {expected}",
            strategy.name,
            score.rms
        );
    }
}

#[test]
fn on_the_model_itself_the_inverse_follows_and_an_observer_changes_nothing() {
    let reference = sine(50.0, 4000);
    let strategies =
        [Strategy::new("inverse", inverse(None)), Strategy::new("observer", inverse(None)).with_observer()];
    for strategy in strategies {
        let made = Loop::new(&model(-0.8), &settings(), &strategy).unwrap();
        let played = play(&made, &reference, Plant::Model, Some(0.0)).unwrap();
        // It ends with a jerk, which the inverse sees coming.
        let compared = ..reference.len() - 200;
        let score = TrackingScore::of(&played.displacement[compared], &reference[compared], 1000);
        assert!(score.max_percent < 2e-3, "{}: {score:?}", strategy.name);
    }
}

/// On the bench the observer takes off what creep and a wrong model leave.
#[test]
fn on_the_bench_feedback_leaves_less_than_feedforward_alone() {
    let truth = Truth { dac: Dac::Hold, ..Truth::default() }.with_ideal_sensor();
    let slow = Model { delay_s: 1.2e-4, ..model(-0.8) };
    let reference: Vec<f64> = sine(2.0, 10_000);
    let own = |strategy: Strategy| {
        let made = Loop::new(&slow, &settings(), &strategy).unwrap();
        let stage = RigStage { truth: &truth, seed: 1, stream: 0 };
        let played = play(&made, &reference, Plant::Stage(&stage), Some(0.0)).unwrap();
        TrackingScore::of(&played.displacement, &reference, 2500).rms_percent
    };
    let alone = own(Strategy::new("inverse", inverse(None)));
    let with = own(Strategy::new("PI alone", Forward::Line).with_feedback(LawFamily::Pi));
    assert!(with < alone, "{with} {alone}");
}

#[test]
fn an_amplifier_holds_back_beyond_the_frequency_of_its_formula() {
    let slew = slew_of_current(0.05, 10e-6);
    assert_eq!(slew, 5000.0);
    let limited = LoopSettings { slew_v_per_s: slew, ..settings() };
    let made = Loop::new(&model(0.0), &limited, &Strategy::new("inverse", inverse(None))).unwrap();
    let own = reach(&made.line, &made.dynamics, RATE_HZ, RANGE_V, 2000.0, 4.0);
    // Towards the resonance less voltage is needed; beyond it, but for the damping, 4π f ((f/280 Hz)² − 1)
    // V/s reach 2000 V/s at 339.4 Hz.
    assert!((own.amplitude_v - 2.0).abs() < 1e-3 && (own.highest_hz / 339.4 - 1.0).abs() < 5e-3, "{own:?}");
    let made = Loop::new(
        &model(0.0),
        &LoopSettings { slew_v_per_s: 2000.0, ..settings() },
        &Strategy::new("inverse", inverse(None)),
    )
    .unwrap();
    // The jerk with which the reference ends takes a few samples more.
    for (share, held_back) in [(0.97, 0..30), (1.03, 300..3000)] {
        let reference = sine(share * own.highest_hz, 3000);
        let played = play(&made, &reference, Plant::Model, None).unwrap();
        assert!(held_back.contains(&played.at_slew), "{share}: {}", played.at_slew);
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let made = |strategy| Loop::new(&model(0.0), &settings(), &strategy);
    assert!(made(Strategy::new("observer", Forward::Line).with_observer()).is_err());
    let rigid = Model { dynamics: Dynamics::None, ..model(0.0) };
    let notch = Strategy::new("notch", Forward::Line).with_feedback(LawFamily::NotchIntegral);
    let refused = Loop::new(&rigid, &settings(), &notch);
    assert!(matches!(refused, Err(ControlError::NoResonance)), "{refused:?}");
    let line = made(Strategy::new("line", Forward::Line)).unwrap();
    for reference in [vec![], vec![1.0], vec![1.0, f64::NAN]] {
        let refused = play(&line, &reference, Plant::Model, None);
        assert!(matches!(refused, Err(ControlError::Reference)));
    }
    for (corner_hz, order) in [(0.0, 0.5), (6000.0, 0.5), (10.0, 0.0), (10.0, 1.0), (f64::NAN, 0.5)] {
        let kind = FeedbackKind::FractionalPi { corner_hz, order };
        assert!(FeedbackLaw::new(kind, RATE_HZ).is_err(), "{kind:?}");
    }
}

/// The same voltages from the readings alone, at the limits too, and from a saved state on.
#[test]
fn a_controller_away_from_its_plant_is_the_one_that_was_played() {
    let both = inverse(None);
    let truth = Truth { dac: Dac::Hold, ..Truth::default() };
    for strategy in [
        Strategy::new("PI", both).with_feedback(LawFamily::Pi),
        Strategy::new("fractional PI", both).with_feedback(LawFamily::FractionalPi),
        Strategy::new("observer", both).with_observer(),
        Strategy::new("alone", both),
    ] {
        let limited = LoopSettings { slew_v_per_s: 4e3, ..settings() };
        let made = Loop::new(&model(0.5), &limited, &strategy).unwrap();
        let reference: Vec<f64> = sine(60.0, 900).iter().map(|r| 9.0 + 2.6 * (r - 9.0)).collect();
        let stage = RigStage { truth: &truth, seed: 1, stream: 0 };
        let played = play(&made, &reference, Plant::Stage(&stage), None).unwrap();
        assert!(played.at_range > 0, "{}", strategy.name);
        let mut parts = ControllerParts::<f64>::new(&made).unwrap().unwrap();
        let mut twin = parts.clone();
        let (mut controller, mut twin) = (parts.controller().unwrap(), twin.controller().unwrap());
        controller.rest_after(played.rest_v, played.rest_v, reference[0]).unwrap();
        let preview = made.inverse.as_ref().unwrap().preview;
        let ahead = |k: usize| reference[k.min(reference.len() - 1)];
        (0..preview).for_each(|k| assert!(controller.know(ahead(k))));
        for (k, (voltage, reading)) in played.drive.iter().zip(&played.reading).enumerate() {
            let drive = controller.step(ahead(k + preview));
            assert_eq!(drive.voltage.to_bits(), voltage.to_bits(), "{} {k}", strategy.name);
            controller.measured(*reading);
            if k > 450 {
                assert_eq!(twin.step(ahead(k + preview)), drive, "{} {k}", strategy.name);
                twin.measured(*reading);
            } else if k == 450 {
                let mut bytes = vec![0; controller.saved_bytes()];
                controller.save(1, &mut bytes).unwrap();
                assert!(twin.restore(2, &bytes).is_err());
                twin.restore(1, &bytes).unwrap();
            }
        }
        assert!(!controller.measured(f64::NAN));
        assert!(controller.rest_after(0.0, 0.0, f64::NAN).is_err() && controller.trim(0.0, 1.0).is_err());
    }
}
