//! What the band of the records cannot carry is not put into the model.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use hysteron_identify::{CampaignRecord, Choice, FamilyChoice, Identification, Options, Watch, identify};
use hysteron_model::Start;
use hysteron_model::dynamics::{Dynamics, Scheme};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis, HysteresisForm};
use hysteron_model::record::{InputOutput, InterSample, TimeBase, Unit};
use std::f64::consts::TAU;

const RATE: f64 = 200.0;

/// A device without dynamics on a drive, and white noise.
fn record(name: &str, u: impl Fn(f64) -> f64, seconds: f64) -> CampaignRecord {
    late(name, u, seconds, 0.0)
}

/// The same behind a delay.
fn late(name: &str, u: impl Fn(f64) -> f64, seconds: f64, delay_s: f64) -> CampaignRecord {
    let model = Model {
        hysteresis: Hysteresis::from(BoucWen::new(vec![0.4, 0.004], 0.08, 0.3, 0.1, 1.0).unwrap()),
        dynamics: Dynamics::None,
        offset: 0.0,
        delay_s,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    };
    let u: Vec<f64> = (0..(seconds * RATE) as usize).map(|k| u(k as f64 / RATE)).collect();
    let mut y = model.simulate(&u, Some(RATE), &Start::Rest { voltage_v: 0.0 }).unwrap();
    // Uniform noise, by a linear congruence.
    let mut state = 1u64;
    for y in &mut y {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *y += 0.003 * ((state >> 11) as f64 / (1u64 << 52) as f64 - 1.0);
    }
    let mut data = InputOutput::new(name, TimeBase::uniform(RATE), u, y).unwrap();
    (data.u_unit, data.y_unit) = (Unit::new("V"), Unit::new("um"));
    CampaignRecord { data, role: None }
}

/// Loops of 0.2 Hz and a sweep to 2 Hz: a resonance would show in its flank up to a decade above, and there
/// is none.
#[test]
fn a_device_without_dynamics_gets_no_resonance_and_no_delay() {
    let loops = |t: f64| 5.0 * (1.0 - (TAU * 0.2 * t).cos()) * (1.0 - 0.02 * t);
    let sweep = |t: f64| 5.0 - 5.0 * (TAU * (0.2 * t + 0.045 * t * t)).cos();
    let campaign = [record("loops", loops, 20.0), record("sweep", sweep, 20.0)];
    let found = identify(&campaign, &Options::default(), &Watch::silent(), None).unwrap();
    let natural = found.parameters.iter().find(|p| p.name == "natural_frequency");
    // None at all, or one that is said not to be determined.
    assert!(natural.is_none_or(|p| p.std_error.is_none()), "{natural:?}");
    let delay = found.parameters.iter().find(|p| p.name == "delay").unwrap();
    let off = delay.value.abs();
    assert!(off < 1e-3 && delay.std_error.is_none_or(|error| off < 4.0 * error), "{delay:?}");
}

/// A delay of 1.5 ms, 19 nm of the loop at its steepest, is not told from the loop's own width: the model has
/// none, and the numbers of the hysteresis, which it moves by many times the error of the noise, have errors
/// that hold.
#[test]
fn a_delay_that_slow_drive_does_not_tell_is_in_the_errors() {
    let loops = |t: f64| 5.0 * (1.0 - (TAU * 0.2 * t).cos()) * (1.0 - 0.02 * t);
    let truth = [("linear", 0.4), ("quadratic", 0.004), ("alpha", 0.08), ("beta", 0.3), ("gamma", 0.1)];
    let of = |hysteresis: FamilyChoice, delay_s: f64| {
        let options =
            Options { n: Choice::Given(1.0), degree: Choice::Given(2), hysteresis, ..Options::default() };
        identify(&[late("loops", loops, 20.0, delay_s)], &options, &Watch::silent(), None).unwrap()
    };
    let number = |found: &Identification, name: &str| {
        let p = found.parameters.iter().find(|p| p.name == name).unwrap();
        (p.value, p.std_error)
    };
    let bouc_wen = FamilyChoice::Given(HysteresisForm::bouc_wen());
    let (late, prompt) = (of(bouc_wen, 1.5e-3), of(bouc_wen, 0.0));
    assert_eq!(number(&late, "delay"), (0.0, None));
    let mut moved = 0.0f64;
    for (name, truth) in truth {
        let ((value, error), (_, without)) = (number(&late, name), number(&prompt, name));
        let (error, without) = (error.unwrap(), without.unwrap());
        assert!((value - truth).abs() < 2.0 * error, "{name}: {value} ± {error}, truth {truth}");
        moved = moved.max((value - truth).abs() / without);
    }
    assert!(moved > 2.0, "the delay must matter: {moved}");

    // Plays, fitted jointly, by the same rule.
    let plays = FamilyChoice::Given(HysteresisForm::plays(4));
    let (late, prompt) = (of(plays, 1.5e-3), of(plays, 0.0));
    assert_eq!(number(&late, "delay"), (0.0, None));
    let ((value, error), (without, _)) = (number(&late, "linear"), number(&prompt, "linear"));
    assert!((value - without).abs() < 2.0 * error.unwrap(), "{value} {without} {error:?}");
}
