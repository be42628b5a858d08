use super::file::power_of_gain;
use super::*;
use hysteron_model::Memory;
use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hysteresis::{ArticleOperator, Hysteresis, examples};
use hysteron_model::model_file::{ModelFile, SignalUnits};
use hysteron_model::record::{InterSample, TimeBase, Timing};
use std::f64::consts::TAU;

/// A joint-fit result for the simulated bench: stack, 338 Hz resonance, 0.2 ms delay.
fn rig_like() -> Model {
    let c0 = (TAU * 338.0_f64).powf(1.97);
    let denominator = vec![Term::new(c0, 0.0), Term::new(0.9 * c0.sqrt(), 1.0), Term::new(1.0, 1.97)];
    Model {
        hysteresis: Hysteresis::from(
            ArticleOperator::new(vec![6.76, 0.0186], 2.15, 0.197, 0.0446, 1.0).unwrap(),
        ),
        dynamics: Dynamics::Fractional(TransferFunction::new(vec![Term::new(c0, 0.0)], denominator).unwrap()),
        offset: 1.5,
        delay_s: 2e-4,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Linear,
        sample_rate_hz: Some(10_000.0),
    }
}

/// The device after its gain and delay have changed.
fn changed(model: &Model, gain: f64, later_s: f64) -> Model {
    let hysteresis = model.hysteresis.scaled(gain).unwrap();
    Model { hysteresis, offset: -3.0, delay_s: model.delay_s + later_s, ..model.clone() }
}

/// Sum of twelve numbers of a linear congruence: nearly Gaussian with this standard deviation.
fn noise(samples: usize, seed: u64, deviation: f64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..samples).map(|_| deviation * ((0..12).map(|_| next()).sum::<f64>() - 6.0)).collect()
}

/// One second of a drive with content from 3 to 60 Hz.
fn drive(rate: f64) -> Vec<f64> {
    let at = |t: f64| {
        5.0 - 3.0 * (TAU * 3.0 * t).cos() + 1.2 * (TAU * 17.0 * t).sin() + 0.5 * (TAU * 60.0 * t).sin()
    };
    (0..rate as usize).map(|k| at(k as f64 / rate)).collect()
}

fn recording(device: &Model, rate: f64, start: Start, noise: Vec<f64>) -> Recording {
    let u = drive(rate);
    let y = device.simulate(&u, Some(rate), &start).unwrap();
    let y = y.iter().zip(noise).map(|(y, e)| y + e).collect();
    Recording {
        data: InputOutput::new("short", TimeBase::uniform(rate), u, y).unwrap(),
        start: Start::Rest { voltage_v: 0.0 },
        start_is_known: false,
        beginning: None,
    }
}

fn assert_within_errors(found: &Change, truth: f64, loosest: f64) {
    let error = found.std_error.unwrap();
    assert!(error > 0.0 && error < loosest, "{found:?}");
    assert!((found.value - truth).abs() < 3.0 * error, "{found:?}, truth {truth}");
}

#[test]
fn a_changed_gain_and_delay_come_back_from_one_second() {
    let old = rig_like();
    let prior = Prior { gain: Some(0.004), delay_s: Some(3e-6), correlation: 0.0, range_v: None };
    let starts = [
        Start::Rest { voltage_v: 0.0 },
        Start::Remembering { voltage_v: 2.0, memory: Memory::Displacement(-1.7) },
    ];
    for start in starts {
        let device = changed(&old, 1.03, 40e-6);
        let record = recording(&device, 5000.0, start, noise(5000, 3, 0.005));
        let found = recalibrate(&old, prior, &[record], 75.0).unwrap();
        assert_within_errors(&found.gain, 1.03, 1e-4);
        assert_within_errors(&found.delay, 240e-6, 1e-6);
        assert!(found.gain.is_significant() && found.delay.is_significant());
        let fit = &found.records[0];
        assert!(fit.before.rmse > 10.0 * fit.after.rmse, "{} {}", fit.before.rmse, fit.after.rmse);
        assert!((fit.after.rmse / 0.005 - 1.0).abs() < 0.05, "{}", fit.after.rmse);
        assert!((found.model.offset + 3.0).abs() < 0.001, "{}", found.model.offset);
        assert_eq!(fit.after.skipped_samples, 0);
    }
}

#[test]
fn the_errors_are_those_of_repeated_records() {
    let old = Model { dynamics: Dynamics::None, ..rig_like() };
    let device = changed(&old, 0.98, 60e-6);
    let mut squares = (0.0, 0.0);
    for seed in 0..40 {
        let noise = noise(1000, seed + 1, 0.05);
        let mut record = recording(&device, 1000.0, Start::Rest { voltage_v: 0.0 }, noise);
        record.start_is_known = true;
        let found = recalibrate(&old, Prior::default(), &[record], 75.0).unwrap();
        squares.0 += ((found.gain.value - 0.98) / found.gain.std_error.unwrap()).powi(2);
        squares.1 += ((found.delay.value - 260e-6) / found.delay.std_error.unwrap()).powi(2);
    }
    // χ² with 40 degrees of freedom: 16.9 to 73.4 but for one in a thousand either way, over 40.
    for mean in [squares.0 / 40.0, squares.1 / 40.0] {
        assert!((0.42..1.84).contains(&mean), "{mean}");
    }
}

#[test]
fn an_unchanged_device_stays_the_old_one() {
    let old = rig_like();
    let record = recording(&old, 5000.0, Start::Rest { voltage_v: 0.0 }, noise(5000, 5, 0.005));
    // Prior much more precise than the record.
    let prior = Prior { gain: Some(1e-6), delay_s: Some(1e-9), correlation: 0.3, range_v: None };
    let found = recalibrate(&old, prior, std::slice::from_ref(&record), 75.0).unwrap();
    assert!(!found.gain.is_significant() && !found.delay.is_significant());
    assert!(
        (found.gain.value - 1.0).abs() < 3e-6 && found.gain.std_error.unwrap() < 1.001e-6,
        "{:?}",
        found.gain
    );
    assert!((found.delay.value - 2e-4).abs() < 3e-9, "{:?}", found.delay);
    // Vague prior: the record's estimate stands.
    let prior = Prior { gain: Some(0.5), delay_s: Some(1.0), correlation: 0.0, range_v: None };
    let vague = recalibrate(&old, prior, &[record], 75.0).unwrap();
    assert!((vague.gain.value - vague.gain.measured).abs() < 1e-3 * vague.gain.std_error.unwrap());
}

#[test]
fn a_gaussian_prior_is_combined_as_the_textbook_says() {
    // Two measurements of equal weight: their mean, and an error smaller by √2. The other unknown follows its
    // correlation 0.5.
    let c = DMatrix::from_row_slice(2, 2, &[1e-4, 0.5e-5, 0.5e-5, 1e-6]);
    let (x, c) = with_prior(&[1.02, 7.0], &c, &[(0, 1.0, 0.01)], 0.0).unwrap();
    assert!((x[0] - 1.01).abs() < 1e-12 && (c[(0, 0)] - 0.5e-4).abs() < 1e-16, "{x:?}");
    assert!((x[1] - (7.0 - 0.5e-5 / 1e-4 * 0.01)).abs() < 1e-12, "{x:?}");
    assert!((c[(1, 1)] - (1e-6 - 0.5e-5 * 0.5e-5 / 2e-4)).abs() < 1e-18);
    // Two correlated measurements of both, of the same covariance: the mean of the means, and half the
    // covariance.
    let both = DMatrix::from_row_slice(2, 2, &[1e-4, 0.5e-5, 0.5e-5, 1e-6]);
    let (x, c) = with_prior(&[1.02, 7.0], &both, &[(0, 1.0, 1e-2), (1, 7.004, 1e-3)], 0.5).unwrap();
    assert!((x[0] - 1.01).abs() < 1e-12 && (x[1] - 7.002).abs() < 1e-12, "{x:?}");
    assert!((&c * 2.0 - both).iter().all(|d| d.abs() < 1e-16), "{c}");
}

/// The rig's model with a covariance: loop parameters compensate for each other, c₀ is b.
fn with_covariance() -> ModelFile {
    let mut file = ModelFile::from_model(&rig_like(), SignalUnits::default());
    let names = [
        "linear",
        "quadratic",
        "alpha",
        "beta",
        "numerator[0].coefficient",
        "denominator[0].coefficient",
        "denominator[2].order",
        "delay",
    ];
    // Linear and α to 5 %, their difference to 0.1 %; b and c₀ equal.
    let root = DMatrix::from_row_slice(
        8,
        6,
        &[
            0.1, 5e-3, 0.0, 0.0, 0.0, 0.0, //
            0.0, 1e-3, 1e-3, 0.0, 0.0, 0.0, //
            0.1, 0.0, 2e-3, 0.0, 0.0, 0.0, //
            1e-2, 0.0, 0.0, 1e-3, 0.0, 0.0, //
            0.0, 0.0, 0.0, 0.0, 1e4, 0.0, //
            0.0, 0.0, 0.0, 0.0, 1e4, 0.0, //
            0.0, 0.0, 0.0, 0.0, 1e-3, 0.0, //
            0.0, 1e-7, 0.0, 0.0, 2e-6, 1e-6,
        ],
    );
    file.set_covariance(&names.map(String::from), &(&root * root.transpose()));
    file
}

#[test]
fn the_prior_is_that_of_gain_and_delay_with_all_else_held() {
    // By hand: C = ½ [2 −1; −1 2]/100 has the inverse (200/3) [2 1; 1 2]; with D = (2, 1) it is (200/3) · 14.
    let block = ArticleOperator::new(vec![2.0], 1.0, 0.2, 0.0, 1.0).unwrap();
    let model = Model { hysteresis: Hysteresis::from(block), ..rig_like() };
    let mut file = ModelFile::from_model(&model, SignalUnits::default());
    let names = ["linear", "alpha"].map(String::from);
    file.set_covariance(&names, &DMatrix::from_row_slice(2, 2, &[0.01, -0.005, -0.005, 0.01]));
    let prior = Prior::of(&file);
    assert!((prior.gain.unwrap() - (3.0f64 / 2800.0).sqrt()).abs() < 1e-12, "{prior:?}");
    assert_eq!((prior.delay_s, prior.correlation), (None, 0.0));

    let file = with_covariance();
    let prior = Prior::of(&file);
    // Far more precise than `linear`, whose error is 1.5 %.
    assert!(prior.gain.unwrap() < 2e-3 && prior.delay_s.unwrap() < 2e-6, "{prior:?}");
    assert!(prior.correlation.abs() > 1e-3 && prior.correlation.abs() < 1.0, "{prior:?}");
}

#[test]
fn a_new_file_knows_gain_and_delay_as_the_recalibration_does() {
    let old = rig_like();
    let file = with_covariance();
    // Once changed, once not.
    for (gain, later_s) in [(1.05, 5e-5), (1.0, 0.0)] {
        let start = Start::Rest { voltage_v: 0.0 };
        let record = recording(&changed(&old, gain, later_s), 2000.0, start, noise(2000, 5, 0.05));
        let found = recalibrate(&old, Prior::of(&file), &[record], 75.0).unwrap();
        let new = found.file(&file);
        new.check().unwrap();
        let again = Prior::of(&new);
        // The new gain is normalised to 1 there.
        let expected = found.gain.std_error.unwrap() / found.gain.value;
        assert!((again.gain.unwrap() / expected - 1.0).abs() < 1e-6, "{again:?} {expected}");
        assert!((again.delay_s.unwrap() / found.delay.std_error.unwrap() - 1.0).abs() < 1e-6, "{again:?}");
        assert!((again.correlation - found.correlation).abs() < 1e-6, "{again:?} {}", found.correlation);
        // The relative precision of the other parameters is unchanged.
        let error = |file: &ModelFile, name: &str| file.number(name).unwrap().std_error.unwrap();
        for name in ["beta", "denominator[2].order"] {
            assert!(error(&new, name) <= error(&file, name) * (1.0 + 1e-9), "{name}");
        }
    }
}

#[test]
fn a_scaled_block_has_a_scaled_output_for_every_exponent() {
    for (alpha, n) in [(2.1, 1.0), (2.1, 1.7), (-0.8, 2.5)] {
        let block = Hysteresis::from(ArticleOperator::new(vec![6.0, 0.2], alpha, 0.3, -0.1, n).unwrap());
        let one = Model { hysteresis: block.clone(), dynamics: Dynamics::None, delay_s: 0.0, ..rig_like() };
        let more = Model { hysteresis: block.scaled(1.37).unwrap(), ..one.clone() };
        let start = Start::Rest { voltage_v: 0.0 };
        let v = one.simulate_hysteresis(&drive(500.0), Timing::Unknown, &start).unwrap();
        let scaled = more.simulate_hysteresis(&drive(500.0), Timing::Unknown, &start).unwrap();
        for (v, s) in v.iter().zip(scaled) {
            assert!((s - 1.37 * v).abs() < 1e-9 * 80.0, "{n}: {s} {v}");
        }
    }
}

#[test]
fn the_numbers_of_every_family_scale_with_the_power_of_the_output_in_their_unit() {
    let power = ArticleOperator::new(vec![6.0, 0.2], -0.8, 0.3, -0.1, 2.5).unwrap().into();
    let families = examples([-1.0, 9.0], 10.0, 1.0).unwrap();
    for block in families.into_iter().chain([power]) {
        let scaled = block.scaled(1.37).unwrap();
        for ((name, old), (_, new)) in block.numbers().into_iter().zip(scaled.numbers()) {
            let expected = old * 1.37f64.powf(power_of_gain(&name, &block));
            assert!((new - expected).abs() <= 1e-14 * old.abs(), "{name} of {block:?}: {new} {expected}");
        }
    }
}

#[test]
fn a_record_of_another_device_is_refused() {
    let old = rig_like();
    let mut record = recording(&old, 2000.0, Start::Rest { voltage_v: 0.0 }, noise(2000, 5, 0.005));
    for (k, y) in record.data.y.iter_mut().enumerate() {
        *y = 10.0 * (TAU * k as f64 / 173.0).sin();
    }
    match recalibrate(&old, Prior::default(), &[record], 75.0) {
        Err(IdentifyError::OtherDevice { fit_percent, need, .. }) => assert!(fit_percent < need),
        other => panic!("{other:?}"),
    }
    assert!(matches!(recalibrate(&old, Prior::default(), &[], 75.0), Err(IdentifyError::NoRecords)));
}

#[test]
fn a_record_without_time_leaves_the_delay_of_a_static_model() {
    let old = Model { dynamics: Dynamics::None, delay_s: 0.0, ..rig_like() };
    let device = changed(&old, 1.1, 0.0);
    let mut record = recording(&device, 1000.0, Start::Rest { voltage_v: 0.0 }, noise(1000, 5, 0.005));
    record.data.time = TimeBase::Unknown;
    let found = recalibrate(&old, Prior::default(), &[record], 75.0).unwrap();
    assert_within_errors(&found.gain, 1.1, 1e-3);
    assert_eq!((found.delay.value, found.delay.std_error, found.delay.is_significant()), (0.0, None, false));
}

#[test]
fn the_file_keeps_what_was_held_and_carries_the_errors() {
    let old = rig_like();
    let mut file = ModelFile::from_model(&old, SignalUnits::default());
    file.hysteresis.parameters.get_mut("linear").unwrap().std_error = Some(0.0676);
    assert_eq!(
        Prior::of(&file),
        Prior { gain: Some(0.0676 / 6.76), delay_s: None, correlation: 0.0, range_v: None }
    );
    let record =
        recording(&changed(&old, 1.05, 0.0), 2000.0, Start::Rest { voltage_v: 0.0 }, noise(2000, 5, 0.005));
    let found = recalibrate(&old, Prior::of(&file), &[record], 75.0).unwrap();
    let new = found.file(&file);
    assert_eq!(new.to_model().unwrap(), found.model);
    assert_eq!((&new.dynamics, &new.valid_range), (&file.dynamics, &file.valid_range));
    let (g, s) = (found.gain.value, found.gain.std_error.unwrap());
    let linear = new.hysteresis.parameters.get("linear").unwrap();
    assert!((linear.std_error.unwrap() - (g * 0.0676).hypot(6.76 * s)).abs() < 1e-12);
    assert_eq!(new.hysteresis.parameters.get("alpha").unwrap().std_error, None);
}
