//! The public Bouc–Wen benchmark (J. P. Noël, M. Schoukens, *Hysteretic benchmark with a dynamic
//! nonlinearity*, 2016).
//!
//! The data state no licence of their own: they are read through `HYSTERON_DATA` and the tests are skipped
//! without.

use std::path::{Path, PathBuf};

use hysteron_identify::IdentifyError;
use hysteron_identify::oscillator::{Identification, Options};
use hysteron_model::Start;
use hysteron_model::hysteresis::{InterSample, RecordEnds};
use hysteron_model::oscillator::{Drive, Oscillator};
use hysteron_model::record::{InputOutput, TimeBase};
use rayon::prelude::*;

use crate::oracles::{BENCHMARK, Random, rms};

fn identify(records: &[InputOutput], options: &Options) -> Result<Identification, IdentifyError> {
    hysteron_identify::oscillator::identify(records, options, &hysteron_identify::Watch::silent(), None)
}

const RATE: f64 = 750.0;
/// Integration rate of the benchmark over its sample rate.
const FINER: usize = 20;

/// Force \[N\] and displacement \[m\] of a record, or a word that the test is skipped.
pub fn record(name: &str) -> Option<(Vec<f64>, Vec<f64>)> {
    let folder = std::env::var_os("HYSTERON_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from);
    let Ok(text) = std::fs::read_to_string(folder.join("boucwen-benchmark").join(name)) else {
        println!("skipped: boucwen-benchmark/{name} not found (set HYSTERON_DATA)");
        return None;
    };
    let row = |line: &str| {
        let fields: Vec<f64> = line.split(',').map(|field| field.trim().parse().unwrap()).collect();
        (fields[1], fields[2])
    };
    Some(text.lines().skip(1).map(row).unzip())
}

/// Displacement at every step of Newmark's scheme (average acceleration: the trapezoidal rule, for z as
/// well), as the benchmark was made; over a force that repeats, the second period.
fn newmark(force: &[f64], ends: RecordEnds) -> Vec<f64> {
    let p = BENCHMARK;
    let h = 1.0 / (RATE * FINER as f64);
    let flow = |v: f64, z: f64| p.alpha * v - p.beta * v.abs() * z - p.gamma * v * z.abs();
    let (mut y, mut v, mut z, mut a) = (0.0, 0.0, 0.0, force[0] / p.mass);
    let periods = if ends == RecordEnds::Periodic { 2 } else { 1 };
    let mut out = Vec::new();
    for period in 0..periods {
        for step in 0..force.len() {
            if period + 1 == periods {
                out.push(y);
            }
            let u = force.get(step + 1).copied().unwrap_or(force[0]);
            let (mut y1, mut v1, mut z1, mut a1) = (y, v, z, a);
            // A contraction by h²(k + α)/4m = 6e-5.
            for _ in 0..6 {
                v1 = v + 0.5 * h * (a + a1);
                y1 = y + h * v + 0.25 * h * h * (a + a1);
                z1 = z + 0.5 * h * (flow(v, z) + flow(v1, z1));
                a1 = (u - p.damping * v1 - p.stiffness * y1 - z1) / p.mass;
            }
            (y, v, z, a) = (y1, v1, z1, a1);
        }
    }
    out
}

/// Every `factor`-th sample behind a low-pass of 31 taps, a Hamming-windowed sinc with half gain at the new
/// Nyquist frequency and gain 1 at 0: the way the benchmark's records were brought to their rate.
fn decimate(x: &[f64], factor: usize, ends: RecordEnds) -> Vec<f64> {
    let tap = |j: i64| {
        let t = std::f64::consts::PI * j as f64;
        let sinc = if j == 0 { 1.0 / factor as f64 } else { (t / factor as f64).sin() / t };
        sinc * (0.54 + 0.46 * (t / 15.0).cos())
    };
    let gain: f64 = (-15..=15).map(tap).sum();
    let count = x.len() as i64;
    let at = |i: i64| match ends {
        RecordEnds::Periodic => x[i.rem_euclid(count) as usize],
        RecordEnds::Open if i < 0 => 2.0 * x[0] - x[(-i) as usize],
        RecordEnds::Open => x.get(i as usize).copied().unwrap_or(0.0),
    };
    let sample = |k: i64| (-15..=15).map(|j| tap(j) / gain * at(k * factor as i64 + j)).sum();
    (0..count.div_euclid(factor as i64) + i64::from(count.rem_euclid(factor as i64) > 0))
        .map(sample)
        .collect()
}

/// The noise-free records, how their force goes on, and the steps in which they were brought to their rate:
/// what reproduces them.
const RECORDS: [(&str, RecordEnds, &[usize]); 2] = [
    ("test_multisine.csv", RecordEnds::Periodic, &[2, 2, 5]),
    ("test_sinesweep.csv", RecordEnds::Open, &[20]),
];

/// rms of the difference over the samples that no filter reads beyond the end for.
fn error(y: &[f64], measured: &[f64], ends: RecordEnds) -> f64 {
    let left_out = if ends == RecordEnds::Open { 2 } else { 0 };
    let count = measured.len() - left_out;
    rms(y.iter().zip(measured).take(count).map(|(a, b)| a - b))
}

#[test]
fn the_noise_free_records_are_newmarks_scheme_at_15_khz_behind_low_passes() {
    for (name, ends, stages) in RECORDS {
        let Some((u, y)) = record(name) else { return };
        let force = InterSample::BandLimited.upsample(&u, FINER, ends).unwrap();
        let raw = newmark(&force, ends);
        let filtered = stages.iter().fold(raw, |x, &factor| decimate(&x, factor, ends));
        let error = error(&filtered, &y, ends);
        println!("{name}: {error:.2e} m of {:.2e} m rms", rms(y.iter().copied()));
        // Nine digits in the file.
        assert!(error < 1e-11, "{name}: {error:e} m");
    }
}

#[test]
fn the_true_parameters_reproduce_the_noise_free_records() {
    // At the samples, and on the benchmark's fine time base behind its low-passes, where the error is that of
    // Newmark's scheme.
    for ((name, ends, stages), (plain, behind)) in
        RECORDS.into_iter().zip([(2.5e-7, 1.4e-7), (2.6e-6, 1.2e-7)])
    {
        let Some((u, y)) = record(name) else { return };
        let start = if ends == RecordEnds::Periodic { Start::PERIODIC } else { Start::AsIdentified };
        let simulate = |u: &[f64], rate: f64, steps: usize| {
            let drive = Drive::new(u, rate, InterSample::BandLimited, ends, steps).unwrap();
            let mut y = vec![0.0; u.len()];
            BENCHMARK.simulate(&drive, start, &mut y).unwrap();
            y
        };
        let at_samples = error(&simulate(&u, RATE, BENCHMARK.steps(RATE)), &y, ends);
        let fine = InterSample::BandLimited.upsample(&u, FINER, ends).unwrap();
        let raw = simulate(&fine, RATE * FINER as f64, 1);
        let filtered = stages.iter().fold(raw, |x, &factor| decimate(&x, factor, ends));
        let behind_filter = error(&filtered, &y, ends);
        println!("{name}: {at_samples:.3e} m at the samples, {behind_filter:.3e} m behind the low-passes");
        assert!(at_samples < plain, "{name}: {at_samples:e} m");
        assert!(behind_filter < behind, "{name}: {behind_filter:e} m");
    }
}

/// RMSE \[m\] of an oscillator on the two noise-free records, none of which any fit has seen.
fn test_errors(found: &Oscillator) -> Option<[f64; 2]> {
    let mut errors = [0.0; 2];
    for (slot, (name, ends, _)) in errors.iter_mut().zip(RECORDS) {
        let (u, y) = record(name)?;
        let start = if ends == RecordEnds::Periodic { Start::PERIODIC } else { Start::AsIdentified };
        let drive = Drive::new(&u, RATE, InterSample::BandLimited, ends, found.steps(RATE)).unwrap();
        let mut simulated = vec![0.0; u.len()];
        found.simulate(&drive, start, &mut simulated).unwrap();
        *slot = rms(simulated.iter().zip(&y).map(|(a, b)| a - b));
    }
    Some(errors)
}

/// What the identification has to reach on records it has not seen \[m\].
const WANTED: [f64; 2] = [4e-7, 3e-6];

fn training() -> Option<InputOutput> {
    let (u, y) = record("train_multisine.csv")?;
    Some(InputOutput::new("train", TimeBase::uniform(RATE), u, y).unwrap())
}

#[test]
fn the_noisy_record_gives_an_oscillator_that_predicts_the_others() {
    let Some(training) = training() else { return };
    let found = identify(&[training], &Options::default()).unwrap();
    let Some(errors) = test_errors(&found.oscillator) else { return };
    println!("{:?}: {errors:?} m", found.oscillator);
    assert!(errors[0] <= WANTED[0] && errors[1] <= WANTED[1], "{errors:?}");
    // The noise is all that is left of the training record, 7e-6 m.
    assert!((found.records[0].scores.rmse - 7.4e-6).abs() < 2e-7, "{}", found.records[0].scores.rmse);
    for (estimate, truth) in found.estimates.iter().zip(BENCHMARK.values()) {
        let off = (estimate.value / truth - 1.0).abs();
        assert!(off < 6e-3, "{estimate:?}, truth {truth}");
    }
}

#[test]
fn twenty_of_twenty_random_starts_lead_there() {
    let Some(training) = training() else { return };
    let mut random = Random::new(20);
    let starts: Vec<Oscillator> = (0..20)
        .map(|_| {
            // A decade either way of everything but n and γ/β: natural frequencies from 3.6 to 360 Hz, loops
            // that saturate at a hundredth of the force or hardly ever.
            let mut around = |value: f64| random.logarithmic(0.1 * value, 10.0 * value);
            let [mass, damping, stiffness, alpha] = [2.0, 10.0, 5e4, 5e4].map(&mut around);
            let saturation = around(30.0);
            let n = 1.0 + 2.0 * random.unit();
            let beta = alpha * saturation.powf(-n);
            let gamma = beta * (3.0 * random.unit() - 1.5);
            Oscillator { mass, damping, stiffness, alpha, beta, gamma, n }
        })
        .collect();
    let identify_from = |start: &Oscillator| {
        let options = Options { start: Some(*start), ..Options::default() };
        identify(std::slice::from_ref(&training), &options).unwrap()
    };
    let found: Vec<Identification> = starts.par_iter().map(identify_from).collect();
    let Some(errors) = test_errors(&found[0].oscillator) else { return };
    assert!(errors[0] <= WANTED[0] && errors[1] <= WANTED[1], "{errors:?}");
    for (found_there, start) in found.iter().zip(&starts).skip(1) {
        for (estimate, first) in found_there.estimates.iter().zip(&found[0].estimates) {
            let same = (estimate.value - first.value).abs() <= 1e-3 * estimate.std_error.unwrap_or(1e-3);
            assert!(same, "{estimate:?} from {start:?}, {first:?} from {:?}", starts[0]);
        }
    }
}
