//! A damper simulated by code of its own, in tiny explicit steps, is recovered; bad input is refused.

use std::f64::consts::TAU;

use hysteron_identify::IdentifyError;
use hysteron_identify::force::{ForceError, Options};
use hysteron_model::record::{InputOutput, TimeBase, Unit};

use crate::identify;

/// N, mm, s.
const OFFSET: f64 = 12.0;
const STIFFNESS: f64 = 3.0;
const FRICTION: f64 = 150.0;
const FRICTION_REACH: f64 = 0.8;
const VISCOUS: f64 = 2.0;
const YIELD: f64 = 400.0;
const YIELD_RATE: f64 = 20.0;
const YIELD_REACH: f64 = 0.1;

/// Rows: amplitude \[mm\], frequency \[Hz\], sample rate \[Hz\].
const RECORDS: [[f64; 3]; 3] = [[20.0, 0.2, 400.0], [8.0, 1.0, 1000.0], [3.0, 3.0, 2000.0]];

/// A record of five growing periods, its force by forward Euler of friction and dashpot in 200 steps a
/// sample; the noise is a fixed pattern of `noise` in N.
fn record([amplitude, frequency, rate]: [f64; 3], noise: f64) -> InputOutput {
    const STEPS: usize = 200;
    let samples = (5.0 * rate / frequency) as usize;
    let x = |t: f64| amplitude * (1.0 - (-t * frequency).exp()) * (TAU * frequency * t).sin();
    let interval = 1.0 / (rate * STEPS as f64);
    let (mut friction, mut share) = (0.0_f64, 0.0_f64);
    let (mut displacement, mut force) = (Vec::new(), Vec::new());
    let mut pattern = 1u64;
    for k in 0..samples {
        let t = k as f64 / rate;
        let v = (x(t + interval) - x(t - interval)) / (2.0 * interval);
        pattern = pattern.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let unit = (pattern >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        displacement.push(x(t));
        force.push(
            OFFSET + STIFFNESS * x(t) + FRICTION * friction + VISCOUS * v + YIELD * share + noise * unit,
        );
        for step in 0..STEPS {
            let now = t + step as f64 * interval;
            let moved = x(now + interval) - x(now);
            friction += (moved - moved.abs() * friction) / FRICTION_REACH;
            share += (moved - interval * YIELD_RATE * share.atanh()) / YIELD_REACH;
        }
    }
    let mut data = InputOutput::new("damper", TimeBase::uniform(rate), displacement, force).unwrap();
    (data.u_unit, data.y_unit) = (Unit::new("mm"), Unit::new("N"));
    data
}

#[test]
fn a_damper_of_independent_code_is_recovered() {
    let records = RECORDS.map(|row| record(row, 4.0));
    let found = identify(&records, &Options::default()).unwrap();
    let truth = [
        ("offset", OFFSET),
        ("linear", STIFFNESS),
        ("reach", FRICTION_REACH),
        ("weight_1", FRICTION / FRICTION_REACH),
        ("viscous", VISCOUS),
        ("saturating_force", YIELD),
        ("saturating_rate", YIELD_RATE),
        ("saturating_reach", YIELD_REACH),
    ];
    for (name, truth) in truth {
        let estimate = found.estimates.iter().find(|e| e.name == name).unwrap();
        let error = estimate.std_error.unwrap();
        let off = (estimate.value - truth).abs();
        // Rate and discretisation leave a few parts in a thousand on top of the noise.
        assert!(off < 4.0 * error + 0.01 * truth, "{name}: {} ± {error}, truth {truth}", estimate.value);
        assert!(error < 0.05 * truth, "{name}: ± {error}");
    }
    for fit in &found.records {
        assert!(fit.scores.rmse < 3.0, "{}", fit.scores.rmse);
    }
    let unseen = record([12.0, 0.6, 500.0], 0.0);
    let motion = hysteron_model::force::Motion { x: &unseen.u, rate: None, time: &unseen.time };
    let force = found.model.simulate(&motion, hysteron_model::Start::AsIdentified).unwrap();
    let square = force.iter().zip(&unseen.y).map(|(f, y)| (f - y).powi(2)).sum::<f64>();
    assert!((square / force.len() as f64).sqrt() < 3.0);
}

#[test]
fn held_numbers_are_held_and_a_dry_friction_needs_no_rate() {
    let records = [record(RECORDS[1], 0.0)];
    let fixed = |pairs: &[(&str, f64)]| Options {
        fixed: pairs.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
        ..Options::default()
    };
    let found = identify(&records, &fixed(&[("viscous", 2.0), ("saturating_reach", 0.1)])).unwrap();
    assert_eq!((found.model.viscous, found.model.saturating[0].reach), (2.0, 0.1));
    let dry = identify(&records, &fixed(&[("viscous", 0.0), ("saturating_force", 0.0)])).unwrap();
    assert!(!dry.model.needs_rate());
    assert!(dry.findings.iter().any(|finding| finding.text.contains("no force saturates")));
}

#[test]
fn bad_input_is_refused_with_the_reason() {
    let good = record(RECORDS[1], 0.0);
    let refused = |record: &InputOutput, options: &Options| {
        identify(std::slice::from_ref(record), options).unwrap_err()
    };
    let still = InputOutput { u: vec![1.0; good.len()], ..good.clone() };
    assert!(matches!(refused(&still, &Options::default()), IdentifyError::Constant { signal: "input", .. }));
    let timeless = InputOutput { time: TimeBase::Unknown, ..good.clone() };
    let error = refused(&timeless, &Options::default());
    assert!(matches!(error, IdentifyError::Force(ForceError::NoTimes { .. })), "{error}");
    let constant = Options { degree: 0, ..Options::default() };
    assert!(refused(&good, &constant).to_string().contains("degree"));
    let mass = Options { fixed: vec![("mass".into(), 1.0)], ..Options::default() };
    let message = refused(&good, &mass).to_string();
    assert!(message.contains("mass") && message.contains("saturating_rate"), "{message}");
    let other = InputOutput { y_unit: Unit::new("kN"), ..good.clone() };
    let error = identify(&[good.clone(), other], &Options::default()).unwrap_err();
    assert!(matches!(error, IdentifyError::Units { .. }), "{error}");
    let noise: Vec<f64> = (0..good.len()).map(|k| ((k * k) % 97) as f64).collect();
    let unrelated = InputOutput { y: noise, ..good };
    let error = refused(&unrelated, &Options::default());
    assert!(matches!(error, IdentifyError::Force(ForceError::Class { .. })), "{error}");
}
