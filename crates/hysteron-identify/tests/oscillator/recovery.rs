//! Identification of simulated oscillators, noise added: what comes back, and what is refused. Every record
//! here is simulated.

use std::ops::ControlFlow;

use hysteron_identify::oscillator::{Identification, Options};
use hysteron_identify::{CampaignRecord, Event, FitRecords, IdentifyError, Initial, Task, Watch};
use hysteron_model::hysteresis::{InterSample, RecordEnds};
use hysteron_model::model_file::{Kind, Maker};
use hysteron_model::oscillator::{Drive, Oscillator, OscillatorState};
use hysteron_model::record::{InputOutput, TimeBase};
use hysteron_model::{Advice, Start};

use crate::oracles::{BENCHMARK, Random, multisine, rms};

fn identify(records: &[InputOutput], options: &Options) -> Result<Identification, IdentifyError> {
    hysteron_identify::oscillator::identify(records, options, &Watch::silent(), None)
}

const RATE: f64 = 750.0;

/// A softening loop, rounder than the benchmark's, in N, mm and s.
const DEVICE: Oscillator =
    Oscillator { mass: 1.5e-3, damping: 0.02, stiffness: 30.0, alpha: 40.0, beta: 4.0, gamma: 1.5, n: 1.4 };

/// Displacement at the samples, in steps of a sixteenth of those the identification takes.
fn simulate(p: &Oscillator, u: &[f64], start: Start<OscillatorState>) -> Vec<f64> {
    let ends = if start == Start::PERIODIC { RecordEnds::Periodic } else { RecordEnds::Open };
    let drive = Drive::new(u, RATE, InterSample::BandLimited, ends, 16 * p.steps(RATE)).unwrap();
    let mut y = vec![0.0; u.len()];
    p.simulate(&drive, start, &mut y).unwrap();
    y
}

/// A record under noise of this share of the motion, and a sensor's offset.
fn record(name: &str, u: Vec<f64>, y: &[f64], noise: f64, random: &mut Random) -> InputOutput {
    let size = rms(y.iter().copied());
    let y = y.iter().map(|y| y + size * (0.3 + noise * random.normal())).collect();
    InputOutput::new(name, TimeBase::uniform(RATE), u, y).unwrap()
}

/// A steady multisine record of some periods.
fn steady(p: &Oscillator, samples: usize, periods: usize, size: f64, seed: u64) -> InputOutput {
    let u: Vec<f64> = multisine(samples, seed).iter().map(|u| size * u).collect();
    let y = simulate(p, &u, Start::PERIODIC);
    record("simulated multisine", u.repeat(periods), &y.repeat(periods), 0.01, &mut Random::new(seed))
}

/// Every estimate with a standard error, within three of them of the truth; the number of them.
fn within_three(found: &Identification, truth: &Oscillator) -> usize {
    let truth = truth.values().into_iter().chain([truth.natural_frequency_hz(), truth.damping_ratio()]);
    let mut checked = 0;
    for (estimate, truth) in found.estimates.iter().zip(truth) {
        let Some(error) = estimate.std_error else { continue };
        let off = (estimate.value - truth) / error;
        println!("{:18} {:12.6} ± {error:.2e} truth {truth:.6}: {off:+.2}", estimate.name, estimate.value);
        assert!(off.abs() < 3.0, "{} = {} ± {error}, truth {truth}", estimate.name, estimate.value);
        checked += 1;
    }
    checked
}

#[test]
fn every_parameter_comes_back_within_three_standard_errors() {
    // Two amplitudes tell the exponent.
    let records = [steady(&DEVICE, 2048, 3, 0.02, 11), steady(&DEVICE, 2048, 3, 0.1, 12)];
    let found = identify(&records, &Options::default()).unwrap();
    assert_eq!(within_three(&found, &DEVICE), 9);
    assert!(found.estimates.iter().all(|e| !e.held && !e.at_limit));
    for fit in &found.records {
        // What is left is the noise.
        let noise = 0.01 * rms(fit.simulated.iter().copied());
        assert!((fit.scores.rmse / noise - 1.0).abs() < 0.05, "{} {noise}", fit.scores.rmse);
        assert!((fit.scores.offset - 30.0 * noise).abs() < noise);
        assert_eq!(fit.period_samples, Some(2048));
    }
}

#[test]
fn a_stopped_search_is_resumed_to_the_same_bits() {
    let records = [steady(&DEVICE, 2048, 3, 0.1, 12)];
    let straight = identify(&records, &Options::default()).unwrap();
    let mut models = 0;
    let watch = Watch::new(|event: &Event<'_>| {
        models += usize::from(event.stage == "output error" && event.model().is_some());
        if models == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let of = hysteron_identify::oscillator::identify;
    let stopped = of(&records, &Options::default(), &watch, None).unwrap();
    drop(watch);
    assert!(stopped.interrupted && stopped.oscillator != straight.oscillator);
    let resumed = of(&records, &Options::default(), &Watch::silent(), Some(stopped.resume)).unwrap();
    assert!(!resumed.interrupted);
    assert_eq!(resumed.oscillator, straight.oscillator);
}

#[test]
fn a_hardening_loop_with_n_1_comes_back_and_is_said_to_be_unbounded() {
    let found = identify(&[steady(&BENCHMARK, 4096, 2, 1.0, 13)], &Options::default()).unwrap();
    assert!(within_three(&found, &BENCHMARK) >= 8);
    assert!(
        found.findings.iter().any(|f| f.text.contains("not bounded (hardening)")),
        "{:?}",
        found.findings
    );
}

#[test]
fn a_record_from_rest_and_one_cut_from_motion_serve_as_well() {
    let u: Vec<f64> = multisine(6000, 14).iter().map(|u| 0.08 * u).collect();
    let y = simulate(&DEVICE, &u, Start::AsIdentified);
    let n = Options { fixed: vec![("n".into(), DEVICE.n)], ..Options::default() };
    let random = &mut Random::new(14);
    let rest = record("simulated from rest", u.clone(), &y, 0.01, random);
    let found = identify(&[rest], &n).unwrap();
    assert_eq!(found.records[0].start, Start::AsIdentified);
    assert_eq!(within_three(&found, &DEVICE), 8);
    assert!(found.estimates[6].held && found.estimates[6].value == DEVICE.n);
    let cut = record("simulated, cut", u[1500..].to_vec(), &y[1500..], 0.01, random);
    let found = identify(&[cut], &Options { initial: Initial::Free, ..n }).unwrap();
    assert!(matches!(found.records[0].start, Start::Remembering { .. }));
    assert_eq!(within_three(&found, &DEVICE), 8);
}

#[test]
fn of_two_periods_from_rest_the_second_is_fitted_and_scored() {
    let u: Vec<f64> = multisine(2048, 17).iter().map(|u| 0.08 * u).collect::<Vec<_>>().repeat(2);
    let y = simulate(&DEVICE, &u, Start::AsIdentified);
    let n = Options { fixed: vec![("n".into(), DEVICE.n)], ..Options::default() };
    let rest = record("simulated from rest", u, &y, 0.01, &mut Random::new(17));
    let found = identify(&[rest], &n).unwrap();
    assert_eq!(within_three(&found, &DEVICE), 8);
    let scores = &found.records[0].scores;
    assert_eq!((scores.skipped_samples, scores.samples), (2048, 2048));
    assert!(scores.fit_percent.unwrap() > 98.5, "{scores:?}");
}

#[test]
fn a_mass_that_is_known_stays() {
    let options = Options { fixed: vec![("mass".into(), DEVICE.mass)], ..Options::default() };
    let found = identify(&[steady(&DEVICE, 2048, 2, 0.08, 15)], &options).unwrap();
    assert_eq!(found.oscillator.mass, DEVICE.mass);
    assert!(found.estimates[0].held && found.estimates[0].std_error.is_none());
    assert_eq!(within_three(&found, &DEVICE), 8);
}

#[test]
fn a_linear_oscillator_is_recognised() {
    let linear = Oscillator { alpha: 0.0, beta: 0.0, gamma: 0.0, stiffness: 70.0, ..DEVICE };
    let found = identify(&[steady(&linear, 2048, 2, 0.05, 16)], &Options::default()).unwrap();
    let (frequency, alpha) = (&found.estimates[7], &found.estimates[3]);
    println!("{frequency:?} {alpha:?} {:?}", found.findings);
    let error = frequency.std_error.unwrap();
    assert!((frequency.value - linear.natural_frequency_hz()).abs() < 3.0 * error, "{frequency:?}");
    assert!(found.findings.iter().any(|f| f.topic == "loop"), "{:?}", found.findings);
}

#[test]
fn what_is_no_oscillator_is_refused() {
    let u = multisine(2048, 17);
    let record = |y: Vec<f64>, time| InputOutput::new("r", time, u.clone(), y).unwrap();
    let uniform = || TimeBase::uniform(RATE);
    let of = |record: InputOutput, options: &Options| identify(&[record], options).unwrap_err();
    let plain = Options::default();
    // A sensor of the force itself: no mass.
    let error = of(record(u.iter().map(|u| -u).collect(), uniform()), &plain);
    assert!(matches!(error, IdentifyError::NoOscillator { .. }), "{error}");
    // Motion that has nothing to do with the force.
    let error = of(record(multisine(2048, 18), uniform()), &plain);
    let refused = matches!(error, IdentifyError::NoOscillator { .. } | IdentifyError::OscillatorClass { .. });
    assert!(refused, "{error}");
    let error = of(record(u.clone(), TimeBase::Unknown), &plain);
    assert!(matches!(error, IdentifyError::OscillatorNotUniform { .. }), "{error}");
    let error = of(record(vec![1.0; 2048], uniform()), &plain);
    assert!(matches!(error, IdentifyError::Constant { .. }), "{error}");
    let held = |name: &str, value| Options { fixed: vec![(name.into(), value)], ..Options::default() };
    for (name, value) in [("alpha", 1.0), ("mass", 0.0), ("n", 0.5), ("damping", f64::NAN)] {
        let error = of(record(u.clone(), uniform()), &held(name, value));
        assert!(matches!(error, IdentifyError::OscillatorFixed { .. }), "{error}");
    }
    assert!(matches!(identify(&[], &plain).unwrap_err(), IdentifyError::NoRecords));
}

#[test]
fn hysteresis_in_feedback_is_named_where_hysteresis_followed_by_dynamics_fails() {
    let records: Vec<_> =
        [steady(&DEVICE, 2048, 3, 0.1, 12)].map(|data| CampaignRecord { data, role: None }).into();
    let records = FitRecords::Single(records);
    let maker = Maker { program: "test".to_owned(), created: None, command: None };
    let of = |task: &Task| hysteron_identify::fit(&records, task, &Watch::silent(), None, &maker);
    let refused = of(&Task::of(Kind::Hammerstein)).unwrap_err();
    assert!(
        matches!(refused, IdentifyError::OtherKind { kind: Kind::Oscillator, fit_percent, other_percent, .. }
            if fit_percent < 90.0 && other_percent > 98.0),
        "{refused}"
    );
    let options = hysteron_identify::Options { least_fit_percent: 0.0, ..Default::default() };
    let found = of(&Task::Hammerstein(Box::new(options))).unwrap();
    let told = found.findings.iter().find(|finding| finding.topic == "kind of model").unwrap();
    assert_eq!(told.advice, Some(Advice::OtherKind { kind: Kind::Oscillator }));
}
