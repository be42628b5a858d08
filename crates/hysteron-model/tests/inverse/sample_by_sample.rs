//! The drive made one sample at a time.

use std::f64::consts::TAU;

use hysteron_model::compensator::{Compensation, CompensatorOptions, CompensatorParts, Prediction};
use hysteron_model::invert::InverseOptions;
use hysteron_rt::{Limited, Real};

use crate::plant::*;

const RANGE_V: [f64; 2] = [-5.0, 15.0];
const SAMPLES: usize = 4000;
/// The 100 Hz of a reference that nobody knows ahead, and its noise.
const BAND: Prediction = Prediction::Band { highest_hz: 100.0, noise: 1e-3 };

fn options(preview: Option<usize>, prediction: Prediction) -> CompensatorOptions {
    CompensatorOptions { preview, prediction, ..CompensatorOptions::default() }
}

fn law(preview: Option<usize>, prediction: Prediction) -> Compensation {
    Compensation::new(&model(), RATE_HZ, &options(preview, prediction)).unwrap()
}

/// The drive along a reference from rest at `rest_v`; what is ahead of its end stays where it ends.
fn drive<T: Real>(law: &Compensation, reference: &[f64], rest_v: f64) -> Vec<T> {
    let mut parts = CompensatorParts::<T>::new(law, RANGE_V, f64::INFINITY).unwrap();
    let mut compensator = parts.compensator().unwrap();
    compensator.rest_at(T::of(rest_v)).unwrap();
    let ahead = |k: usize| T::of(*reference.get(k).or(reference.last()).unwrap());
    for k in 0..law.preview {
        compensator.know(ahead(k));
    }
    (0..reference.len())
        .map(|k| {
            let drive = compensator.step(ahead(k + law.preview));
            assert_eq!(drive.limited, Limited::No);
            drive.voltage
        })
        .collect()
}

fn reference(frequency_hz: f64, amplitude: f64) -> Vec<f64> {
    (0..SAMPLES).map(sine(frequency_hz, amplitude, SAMPLES, RATE_HZ)).collect()
}

fn rest(reference: &[f64]) -> f64 {
    rest_of(&model().invert(reference, RATE_HZ, &InverseOptions::within(RANGE_V)).unwrap())
}

#[test]
fn with_preview_it_is_the_inverse_of_the_whole_reference() {
    // The inverse of the whole reference leaves out the images of the sampled spectrum: 1e-4 of the answer at
    // 500 Hz.
    for (frequency_hz, amplitude, allowed) in [(20.0, 5.0, 1e-5), (100.0, 5.0, 1e-5), (500.0, 1.5, 1e-3)] {
        let reference = reference(frequency_hz, amplitude);
        let whole = model().invert(&reference, RATE_HZ, &InverseOptions::within(RANGE_V)).unwrap();
        // As long as the gains reach.
        let own: Vec<f64> = drive(&law(Some(4000), Prediction::Stays), &reference, rest_of(&whole));
        // The whole drive cannot begin before the record and does not know it; nor does it know that the
        // reference stays where it ends.
        let compared = 100..SAMPLES - 100;
        let pairs = whole.drive[compared.clone()].iter().zip(&own[compared]);
        let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{frequency_hz} Hz: drives apart by {apart:.2e} V");
        assert!(apart < allowed, "{frequency_hz} Hz: {apart} V");
    }
}

#[test]
fn a_plant_in_continuous_time_follows_with_a_short_preview_and_with_none() {
    let fast = Prediction::Band { highest_hz: 600.0, noise: 1e-3 };
    let cases: [(&str, CompensatorOptions, [f64; 3]); 4] = [
        ("all preview of use", options(None, Prediction::Stays), [0.001, 0.03, 0.2]),
        ("10 samples and a predictor", options(Some(10), fast), [0.001, 0.03, 0.2]),
        ("a predictor to 100 Hz", options(Some(0), BAND), [0.1, 0.3, f64::INFINITY]),
        ("neither", options(Some(0), Prediction::Stays), [2.5, 12.0, f64::INFINITY]),
    ];
    for (name, options, bounds) in cases {
        let law = Compensation::new(&model(), RATE_HZ, &options).unwrap();
        print!("{name}: {} samples ahead, noise {:.2}", law.preview, law.noise_gain);
        for ((frequency_hz, amplitude), bound) in
            [(20.0, 5.0), (100.0, 5.0), (500.0, 1.5)].into_iter().zip(bounds)
        {
            if bound.is_infinite() {
                continue;
            }
            let reference = reference(frequency_hz, amplitude);
            let rest_v = rest(&reference);
            let own: Vec<f64> = drive(&law, &reference, rest_v);
            let error = tracking_error(&own, rest_v, frequency_hz, amplitude, SAMPLES);
            print!("; {frequency_hz} Hz: {error:.5} %");
            assert!(error <= bound, "{name}, {frequency_hz} Hz: {error} %");
            // What the response promises is what the plant does.
            let promised = 100.0 * (law.tracking(frequency_hz) - 1.0).norm() / 8.0_f64.sqrt();
            assert!((error - promised).abs() <= 0.02 * promised + 0.003, "{error} {promised}");
        }
        println!();
    }
}

/// A voltage put out a time δ late is held from the one before for so long: with white jitter the error is
/// the motion of δ's rms, less what the stage filters away.
#[test]
fn a_jittering_clock_costs_no_more_than_the_motion_in_the_meantime() {
    let (frequency_hz, amplitude) = (100.0, 5.0);
    let reference = reference(frequency_hz, amplitude);
    let rest_v = rest(&reference);
    let own: Vec<f64> = drive(&law(None, Prediction::Stays), &reference, rest_v);
    let mut state = 12345_u64;
    let mut late = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        // 0 to 4 of 20 steps: a fifth of a period at most, 7.1 µs rms about the mean, which is a delay of 10
        // µs.
        (state >> 33) as usize % 5
    };
    let at: Vec<usize> = (0..SAMPLES).map(|k| k * FINER + late()).collect();
    let y = plant_with(&own, &at, rest_v);
    let mean = 2;
    let error = error_of(&y[mean..], frequency_hz, amplitude, SAMPLES);
    let motion = 100.0 * TAU * frequency_hz * 7.1e-6 / 8.0_f64.sqrt();
    println!("jitter of 7.1 µs rms at 100 Hz: {error:.4} %, motion in the meantime {motion:.4} %");
    assert!(error < motion, "{error} {motion}");
}

#[test]
fn single_precision_follows_as_well() {
    let (frequency_hz, amplitude) = (100.0, 5.0);
    let reference = reference(frequency_hz, amplitude);
    let rest_v = rest(&reference);
    let law = law(None, Prediction::Stays);
    let (double, single): (Vec<f64>, Vec<f32>) =
        (drive(&law, &reference, rest_v), drive(&law, &reference, rest_v));
    let single: Vec<f64> = single.into_iter().map(f64::from).collect();
    let apart = double.iter().zip(&single).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let error = tracking_error(&single, rest_v, frequency_hz, amplitude, SAMPLES);
    // Σ |gains| of some 30 times the rounding of 16 µm.
    println!("single precision: drive within {apart:.1e} V, error {error:.5} %");
    assert!(apart < 1e-4 && error < 0.002, "{apart} {error}");
}
