//! A simulated two-axis stage with cross-coupling, hysteresis of each actuator, a mode and a delay of each
//! path: all branches are found in one fit, to within their standard errors.

use std::ops::ControlFlow;

use hysteron_identify::coupled::{Options, identify};
use hysteron_identify::{Event, IdentifyError, Watch};
use hysteron_model::axes::{AxesRecord, CoupledHammerstein, Path};
use hysteron_model::hysteresis::BoucWen;
use hysteron_model::record::{Channel, Record, TimeBase};

use crate::device::Random;

const RATE: f64 = 1000.0;
const SAMPLES: usize = 2500;
/// rms \[µm\], 0.2 % of the motion.
const NOISE: f64 = 0.004;

fn stage() -> CoupledHammerstein {
    let actuator = |alpha, beta, gamma| BoucWen { polynomial: vec![1.0], alpha, beta, gamma, n: 1.0 };
    let path =
        |gain, natural_frequency_hz, damping, delay_s| Path { gain, natural_frequency_hz, damping, delay_s };
    CoupledHammerstein {
        actuators: vec![actuator(0.25, 0.9, 0.2), actuator(0.32, 0.6, -0.15)],
        paths: vec![
            path(1.4, 70.0, 0.08, 0.8e-3),
            path(-0.3, 95.0, 0.15, 1.3e-3),
            path(0.2, 82.0, 0.12, 0.5e-3),
            path(1.1, 60.0, 0.10, 1.0e-3),
        ],
        offsets: vec![3.0, -2.0],
        sample_rate_hz: RATE,
    }
}

/// Both axes at once: a slow large wave and faster noise, low-passed, on each.
fn record(seed: u64, noise: f64) -> AxesRecord {
    let mut random = Random(seed);
    let mut drive = |slow_hz: f64| -> Vec<f64> {
        let (mut a, mut b) = (0.0, 0.0);
        (0..SAMPLES)
            .map(|k| {
                a += 0.35 * (random.normal() - a);
                b += 0.35 * (a - b);
                let t = k as f64 / RATE;
                1.5 * (std::f64::consts::TAU * slow_hz * t).sin() * (0.4 + 0.2 * t) + 0.8 * b
            })
            .collect()
    };
    let u = vec![drive(2.3), drive(3.1)];
    let y = stage().simulate(&u, RATE, None).unwrap();
    let mut channels: Vec<Channel> =
        u.into_iter().enumerate().map(|(n, u)| Channel::new(&format!("u{n}"), "V", u)).collect();
    for (m, y) in y.into_iter().enumerate() {
        let noisy = y.into_iter().map(|y| y + noise * random.normal()).collect();
        channels.push(Channel::new(&format!("y{m}"), "um", noisy));
    }
    let record = Record::new(&format!("seed {seed}"), TimeBase::uniform(RATE), channels).unwrap();
    AxesRecord::new(&record, &["u0".into(), "u1".into()], &["y0".into(), "y1".into()]).unwrap()
}

#[test]
fn every_parameter_of_a_coupled_stage_is_found_to_within_its_error() {
    let truth = stage();
    let found = identify(&[record(1, NOISE)], &Options::default(), &Watch::silent(), None).unwrap();
    let errors = found.errors.as_ref().unwrap();
    let check = |what: String, found: f64, truth: f64, error: f64| {
        println!("{what}: {found:.5} ± {error:.5}, truth {truth}");
        assert!((found - truth).abs() < 4.5 * error, "{what}: {found} ± {error}, truth {truth}");
    };
    for (n, ((found, truth), errors)) in
        found.model.actuators.iter().zip(&truth.actuators).zip(&errors.actuators).enumerate()
    {
        check(format!("alpha {n}"), found.alpha, truth.alpha, errors[0]);
        check(format!("beta {n}"), found.beta, truth.beta, errors[1]);
        check(format!("gamma {n}"), found.gamma, truth.gamma, errors[2]);
    }
    for (k, ((found, truth), errors)) in
        found.model.paths.iter().zip(&truth.paths).zip(&errors.paths).enumerate()
    {
        check(format!("gain {k}"), found.gain, truth.gain, errors[0]);
        check(format!("frequency {k}"), found.natural_frequency_hz, truth.natural_frequency_hz, errors[1]);
        check(format!("damping {k}"), found.damping, truth.damping, errors[2]);
        check(format!("delay {k}"), found.delay_s, truth.delay_s, errors[3]);
        // The errors are small enough to mean something.
        assert!(
            errors[0] < 0.1 * truth.gain.abs() && errors[1] < 0.05 * truth.natural_frequency_hz,
            "{errors:?}"
        );
    }
    assert!((found.records[0].rmse / NOISE - 1.0).abs() < 0.1, "{:?}", found.records[0].rmse);
    // A drive that the fit has not seen.
    let unseen = record(9, 0.0);
    let simulated = found.model.simulate(&unseen.u, RATE, None).unwrap();
    for (m, (simulated, y)) in simulated.iter().zip(&unseen.y).enumerate() {
        let square: f64 = simulated.iter().zip(y).map(|(a, b)| (a - b).powi(2)).sum();
        let error = (square / SAMPLES as f64).sqrt();
        println!("output {m}: {error:.5} um");
        assert!(error < 0.6 * NOISE, "output {m}: {error} um");
    }
}

#[test]
fn a_stopped_search_is_resumed_to_the_same_bits() {
    let records = [record(1, NOISE)];
    let straight = identify(&records, &Options::default(), &Watch::silent(), None).unwrap();
    let (mut told, mut last) = (0, 0.0);
    let watch = Watch::new(|event: &Event<'_>| {
        assert!(event.fraction >= last, "the fraction never falls");
        last = event.fraction;
        told += usize::from(event.stage == "branches");
        if told == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let stopped = identify(&records, &Options::default(), &watch, None).unwrap();
    drop(watch);
    assert!(stopped.interrupted && stopped.model != straight.model);
    let resumed = identify(&records, &Options::default(), &Watch::silent(), Some(stopped.resume)).unwrap();
    assert!(!resumed.interrupted);
    assert_eq!(resumed.model, straight.model);
}

#[test]
fn inputs_that_move_together_or_not_at_all_are_refused() {
    let mut together = record(1, NOISE);
    together.u[1] = vec![0.5; SAMPLES];
    assert!(matches!(
        identify(&[together], &Options::default(), &Watch::silent(), None),
        Err(IdentifyError::NoBranches)
    ));
    assert!(matches!(
        identify(&[], &Options::default(), &Watch::silent(), None),
        Err(IdentifyError::NoOutputs)
    ));
}
