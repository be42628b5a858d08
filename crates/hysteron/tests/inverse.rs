//! The drive of an inverse, played to a plant in continuous time that is not the library's: exact exponentials, hysteresis by
//! Runge–Kutta, each voltage held for a period of the controller.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A failure is a failed test; figures are printed.

use std::f64::consts::TAU;

use hysteron::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron::hammerstein::Model;
use hysteron::hysteresis::{BoucWen, DriveLimits, Hysteresis};
use hysteron::invert::{Before, InverseDrive, InverseOptions, InversionError, LastRun};
use hysteron::record::InterSample;

const RATE_HZ: f64 = 10_000.0;
/// Steps of the plant in a period of the controller.
const FINER: usize = 20;
const NATURAL: f64 = TAU * 280.0;
const DAMPING: f64 = 0.65;
const DELAY_S: f64 = 1.5e-4;
const ALPHA: f64 = 0.3;
const BETA: f64 = 0.12;
const GAMMA: f64 = -0.03;
const OFFSET: f64 = 0.4;

fn model() -> Model {
    let hysteresis = BoucWen::new(vec![1.1, 0.02, -0.001], ALPHA, BETA, GAMMA, 1.0).unwrap();
    let term = |coefficient, order| Term { coefficient, order };
    let numerator = vec![term(NATURAL * NATURAL, 0.0)];
    let denominator = vec![term(NATURAL * NATURAL, 0.0), term(2.0 * DAMPING * NATURAL, 1.0), term(1.0, 2.0)];
    Model {
        hysteresis: Hysteresis::BoucWen(hysteresis),
        dynamics: Dynamics::Integer(TransferFunction::new(numerator, denominator).unwrap()),
        offset: OFFSET,
        delay_s: DELAY_S,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: Some(2e4),
    }
}

/// Output of the plant [`FINER`] times a period, from rest, virgin, at `rest`.
fn plant(drive: &[f64], rest: f64) -> Vec<f64> {
    let mut z = 0.0;
    let mut u = rest;
    let v_of = |u: f64, z: f64| 1.1 * u + 0.02 * u * u - 0.001 * u * u * u - z;
    let mut held = Vec::new();
    for &next in drive {
        // z along the jump of the drive: dz/du = α − (β s sgn z + γ) |z|.
        let steps = 100;
        let du = (next - u) / f64::from(steps);
        let slope = |z: f64| ALPHA - (BETA * du.signum() * z.signum() + GAMMA) * z.abs();
        for _ in 0..steps {
            let a = slope(z);
            let b = slope(z + 0.5 * du * a);
            let c = slope(z + 0.5 * du * b);
            let d = slope(z + du * c);
            z += du / 6.0 * (a + 2.0 * b + 2.0 * c + d);
        }
        u = next;
        held.push(v_of(u, z));
    }
    let dt = 1.0 / (RATE_HZ * FINER as f64);
    let late = (DELAY_S / dt).round() as usize;
    let (sigma, omega) = (DAMPING * NATURAL, NATURAL * (1.0 - DAMPING * DAMPING).sqrt());
    let (mut x, mut rate) = (v_of(rest, 0.0), 0.0);
    let mut y = Vec::new();
    for k in 0..drive.len() * FINER {
        y.push(x + OFFSET);
        let v = if k < late { v_of(rest, 0.0) } else { held[(k - late) / FINER] };
        // Free motion about v over dt, in closed form.
        let (e, c, s) = ((-sigma * dt).exp(), (omega * dt).cos(), (omega * dt).sin());
        let from = x - v;
        let quadrature = (rate + sigma * from) / omega;
        x = v + e * (from * c + quadrature * s);
        rate = e * ((quadrature * omega - sigma * from) * c - (from * omega + sigma * quadrature) * s);
    }
    y
}

/// About 5.5 µm, `amplitude` \[µm\] to either side.
fn sine(frequency_hz: f64, amplitude: f64, samples: usize, per_second: f64) -> impl Fn(usize) -> f64 {
    let whole = samples as f64 / per_second;
    // Grows from rest to its full amplitude in the first fifth.
    move |k| {
        let t = k as f64 / per_second;
        let grown = (t / (0.2 * whole)).min(1.0);
        let grown = grown * grown * (3.0 - 2.0 * grown);
        5.5 + amplitude * grown * (TAU * frequency_hz * t).sin()
    }
}

fn rms(x: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = x.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    (sum / count).sqrt()
}

fn roughness(u: &[f64]) -> f64 {
    rms(u.windows(3).map(|w| w[2] - 2.0 * w[1] + w[0]))
}

fn rest_of(drive: &InverseDrive) -> f64 {
    drive.rest.unwrap().voltage_v().unwrap()
}

fn options() -> InverseOptions {
    InverseOptions::within([-5.0, 25.0])
}

/// Error of the plant over what follows the growth, rms in per cent of stroke.
fn tracking_error(drive: &InverseDrive, frequency_hz: f64, amplitude: f64, samples: usize) -> f64 {
    let y = plant(&drive.drive, rest_of(drive));
    let wanted = sine(frequency_hz, amplitude, samples * FINER, RATE_HZ * FINER as f64);
    let error = y.iter().enumerate().map(|(k, y)| y - wanted(k));
    let (from, to) = (samples * FINER * 3 / 10, samples * FINER * 9 / 10);
    100.0 * rms(error.skip(from).take(to - from)) / (2.0 * amplitude)
}

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
        let error = tracking_error(&found, frequency_hz, amplitude, samples);
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
        let limits = DriveLimits { range: [-5.0, 25.0], step: f64::INFINITY };
        let ideal = model().hysteresis.follow(&v, rest_of(&found), None, &limits).unwrap().drive;
        let part = samples * 3 / 10..samples * 9 / 10;
        let ratio = roughness(&found.drive[part.clone()]) / roughness(&ideal[part]);
        assert!((0.9..=1.1).contains(&ratio), "{frequency_hz} Hz: roughness {ratio}");
        // What the hold costs where nothing accounts for it: half a period of delay.
        let late = InverseDrive { drive: ideal, ..found };
        let uncorrected = tracking_error(&late, frequency_hz, amplitude, samples);
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
        let before = Before::Rest { voltage_v: None, virgin_v: Some(2.5) };
        let options = InverseOptions { slew_v_per_s: 3000.0, before, ..InverseOptions::within(limits) };
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
    let found =
        model().invert(&reference, RATE_HZ, &InverseOptions { before: Before::Periodic, ..options() });
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
        hysteresis: Hysteresis::BoucWen(hysteresis),
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
    let options = InverseOptions {
        before: Before::Rest { voltage_v: Some(4.0), virgin_v: None },
        bandwidth_hz: Some(300.0),
        ..options()
    };
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
    // The device rests half a micrometre beside the beginning of the reference, which no run can mend and none makes worse.
    assert!(errors.windows(2).all(|w| w[1] < w[0]), "{errors:?}");
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
    for bandwidth_hz in [0.0, -1.0, 5000.0, f64::NAN] {
        let options = InverseOptions { bandwidth_hz: Some(bandwidth_hz), ..options() };
        assert!(matches!(invert(&[1.0; 50], &options), Err(InversionError::Dynamics(_))), "{bandwidth_hz}");
    }
    for range in [[1.0, 1.0], [3.0, 2.0], [f64::NAN, 2.0], [0.0, f64::INFINITY]] {
        let refused = invert(&[1.0; 50], &InverseOptions::within(range));
        assert!(matches!(refused, Err(InversionError::Hysteresis(_))), "{range:?}: {refused:?}");
    }
}
