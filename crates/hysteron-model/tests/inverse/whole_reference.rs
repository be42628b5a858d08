//! The drive for a reference that is known as a whole.

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::Mutex;

use hysteron_model::Start;
use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, DriveLimits, Hysteresis};
use hysteron_model::invert::{InverseOptions, InversionError, LastRun};

use hysteron_model::record::{InterSample, Unit};
use hysteron_numeric::Listener;

use crate::plant::*;

#[test]
fn a_plant_in_continuous_time_follows_the_reference() {
    for (frequency_hz, amplitude, bound, held_alone) in
        [(20.0, 5.0, 0.001, 0.1), (100.0, 5.0, 0.03, 0.9), (500.0, 1.5, 0.2, 4.0)]
    {
        let samples = 4000;
        let wanted = sine(frequency_hz, amplitude, samples, RATE_HZ);
        let reference: Vec<f64> = (0..samples).map(wanted).collect();
        let found = model().invert(&reference, RATE_HZ, &options()).unwrap();
        assert_eq!([found.at_range, found.at_slew], [0, 0]);
        let error = tracking_error(&found.drive, rest_of(&found), frequency_hz, amplitude, samples);
        assert!(error <= bound, "{frequency_hz} Hz: {error} %");
        // The ideal drive: the reference through 1/G at its frequency, then through the inverse hysteresis.
        let s = TAU * frequency_hz / NATURAL;
        let (re, im) = (1.0 - s * s, 2.0 * DAMPING * s);
        let (gain, lead) = (re.hypot(im), im.atan2(re) + TAU * frequency_hz * DELAY_S);
        let v: Vec<f64> = (0..samples)
            .map(|k| {
                let t = k as f64 / RATE_HZ;
                5.1 + amplitude * gain * (TAU * frequency_hz * t + lead).sin()
            })
            .collect();
        let limits = DriveLimits { range: [-5.0, 25.0], step: f64::INFINITY, interval_s: None };
        let ideal = model().hysteresis.follow(&v, rest_of(&found), None, &limits).unwrap().drive;
        let part = samples * 3 / 10..samples * 9 / 10;
        let ratio = roughness(&found.drive[part.clone()]) / roughness(&ideal[part]);
        assert!((0.9..=1.1).contains(&ratio), "{frequency_hz} Hz: roughness {ratio}");
        // What the hold costs where nothing accounts for it: half a period of delay.
        let uncorrected = tracking_error(&ideal, rest_of(&found), frequency_hz, amplitude, samples);
        assert!(uncorrected > held_alone, "{frequency_hz} Hz, hold not corrected: {uncorrected} %");
        println!(
            "{frequency_hz} Hz: {error:.5} %, roughness {ratio:.3}; hold not corrected {uncorrected:.2} %"
        );
    }
}

#[test]
fn a_rounded_reference_does_not_ring() {
    let samples = 4000;
    let wanted = sine(100.0, 5.0, samples, RATE_HZ);
    let exact: Vec<f64> = (0..samples).map(wanted).collect();
    let rounded: Vec<f64> = exact.iter().map(|r| (r * 1e6).round() / 1e6).collect();
    let [a, b] = [&exact, &rounded].map(|r| model().invert(r, RATE_HZ, &options()).unwrap());
    let apart = rms(a.drive.iter().zip(&b.drive).map(|(a, b)| a - b));
    // Rounding is white noise of 1e-6/√12 µm; a volt moves the hysteresis by 0.7 to 1.3 µm.
    let gain = a.dynamics.unwrap().noise_gain;
    println!("noise gain {gain:.3}, drive apart by {apart:e} V");
    let hysteretic = gain * 1e-6 / 12_f64.sqrt();
    assert!((hysteretic / 1.3..hysteretic / 0.7).contains(&apart), "{apart}");
    assert!(gain < 5.0, "{gain}");
}

#[test]
fn what_is_predicted_is_what_the_model_does() {
    let samples = 3000;
    let reference: Vec<f64> = (0..samples).map(sine(80.0, 5.0, samples, RATE_HZ)).collect();
    let mut held = model();
    (held.scheme, held.inter_sample) = (Scheme::BandLimited, InterSample::Hold);
    for limits in [[-5.0, 25.0], [2.0, 7.5]] {
        let options =
            InverseOptions { slew_v_per_s: 3000.0, virgin_v: Some(2.5), ..InverseOptions::within(limits) };
        let found = held.invert(&reference, RATE_HZ, &options).unwrap();
        let y = held.simulate(&found.drive, Some(RATE_HZ), &found.rest.unwrap()).unwrap();
        for (a, b) in y.iter().zip(&found.predicted) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
        assert_eq!(found.at_range > 0, limits[0] > 0.0);
    }
}

#[test]
fn a_reference_that_repeats_is_followed_in_its_steady_state() {
    let samples = 500;
    let reference: Vec<f64> =
        (0..samples).map(|k| 5.5 + 5.0 * (TAU * k as f64 / samples as f64).sin()).collect();
    let found = model().invert(&reference, RATE_HZ, &InverseOptions { start: Start::PERIODIC, ..options() });
    let found = found.unwrap();
    assert!(found.rest.is_none());
    let drive = found.drive.repeat(8);
    let y = plant(&drive, 5.0);
    let last = 7 * samples;
    let error = rms((0..samples).map(|k| y[(last + k) * FINER] - reference[k]));
    assert!(error < 1e-4 * 10.0, "{error} µm");
}

/// A model that is wrong by what an identification never is.
fn wrong_model() -> Model {
    let term = |coefficient, order| Term { coefficient, order };
    let natural = 0.9 * NATURAL;
    let square = natural * natural;
    let denominator = vec![term(square, 0.0), term(1.5 * DAMPING * natural, 1.0), term(1.0, 2.0)];
    let hysteresis = BoucWen::new(vec![1.0, 0.01], 0.2, 0.2, -0.03, 1.0).unwrap();
    Model {
        hysteresis: Hysteresis::from(hysteresis),
        dynamics: Dynamics::Integer(TransferFunction::new(vec![term(square, 0.0)], denominator).unwrap()),
        offset: 0.0,
        delay_s: 1.0e-4,
        ..model()
    }
}

#[test]
fn what_repeats_is_learned_from_run_to_run() {
    let samples = 4000;
    let reference: Vec<f64> = (0..samples).map(sine(60.0, 3.0, samples, RATE_HZ)).collect();
    let model = wrong_model();
    let options =
        InverseOptions { start: Start::Rest { voltage_v: 4.0 }, bandwidth_hz: Some(300.0), ..options() };
    let mut run = model.invert(&reference, RATE_HZ, &options).unwrap();
    let mut errors = Vec::new();
    for _ in 0..8 {
        let measured: Vec<f64> = plant(&run.drive, 4.0).into_iter().step_by(FINER).collect();
        let left = || measured.iter().zip(&reference).map(|(y, r)| y - r);
        let zero = left().sum::<f64>() / samples as f64;
        errors.push(rms(left().skip(1200).take(2400).map(|e| e - zero)));
        let last = LastRun { drive: &run.drive, measured: &measured };
        run = model.learn(&reference, last, RATE_HZ, &options).unwrap();
    }
    println!("rms error from run to run: {errors:?} µm");
    assert!(errors[1] < 0.1 * errors[0] && errors[2] < 0.05 * errors[0], "{errors:?}");
    // The device rests half a micrometre beside the beginning of the reference, which no run can mend and
    // none makes worse.
    assert!(errors.windows(2).all(|w| w[1] < w[0]), "{errors:?}");
}

#[test]
fn progress_is_told_and_a_listener_ends_it() {
    let reference: Vec<f64> = (0..8000).map(sine(20.0, 5.0, 8000, RATE_HZ)).collect();
    let told = Mutex::new(Vec::new());
    let listen = |stage: &str, share: f64| {
        told.lock().unwrap().push((stage.to_owned(), share));
        ControlFlow::Continue(())
    };
    let heard = model().invert_told(&reference, RATE_HZ, &options(), Listener::new(&listen)).unwrap();
    assert_eq!(heard, model().invert(&reference, RATE_HZ, &options()).unwrap());
    let told = told.into_inner().unwrap();
    assert!(
        told.windows(2).all(|w| w[0].1 <= w[1].1) && told.iter().all(|(_, share)| *share <= 1.0),
        "{told:?}"
    );
    let of_hysteresis = told.iter().filter(|(stage, _)| stage == "inverse of the hysteresis").count();
    assert_eq!(of_hysteresis, 8000 / 1024, "{told:?}");
    let stop = |_: &str, share: f64| {
        if share > 0.5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let stopped = model().invert_told(&reference, RATE_HZ, &options(), Listener::new(&stop));
    assert_eq!(stopped, Err(InversionError::Stopped));
}

#[test]
fn messages_have_the_units_of_drive_and_output() {
    let refused = model().invert(&[500.0, 500.0], RATE_HZ, &options()).unwrap_err();
    let words = refused.in_units(&Unit::new("mA"), &Unit::new("urad"));
    assert!(words.starts_with("the reference begins at 500 µrad, which no drive from "), "{words}");
    assert!(words.contains(" mA holds: at rest these give ") && words.ends_with(" µrad"), "{words}");
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let model = model();
    let invert = |reference: &[f64], options: &InverseOptions| model.invert(reference, RATE_HZ, options);
    assert!(matches!(invert(&[1.0], &options()), Err(InversionError::TooShort { samples: 1 })));
    let refused = invert(&[1.0, f64::NAN], &options());
    assert!(matches!(refused, Err(InversionError::NotFinite { index: 1 })));
    assert!(matches!(invert(&[500.0, 500.0], &options()), Err(InversionError::Begins { .. })));
    let last = LastRun { drive: &[1.0; 50], measured: &[1.0; 49] };
    assert!(matches!(
        model.learn(&[1.0; 50], last, RATE_HZ, &options()),
        Err(InversionError::LastRun { .. })
    ));
    let thirds = InverseOptions { start: Start::settled(20), ..options() };
    let refused = invert(&[1.0; 50], &thirds);
    assert!(
        matches!(refused, Err(InversionError::Period { samples: 50, period_samples: 20 })),
        "{refused:?}"
    );
    for bandwidth_hz in [0.0, -1.0, 5000.0, f64::NAN] {
        let options = InverseOptions { bandwidth_hz: Some(bandwidth_hz), ..options() };
        assert!(matches!(invert(&[1.0; 50], &options), Err(InversionError::Dynamics(_))), "{bandwidth_hz}");
    }
    for range in [[1.0, 1.0], [3.0, 2.0], [f64::NAN, 2.0], [0.0, f64::INFINITY]] {
        let refused = invert(&[1.0; 50], &InverseOptions::within(range));
        assert!(matches!(refused, Err(InversionError::Hysteresis(_))), "{range:?}: {refused:?}");
    }
}
