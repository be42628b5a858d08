use super::*;
use crate::record::Swings;
use proptest::prelude::*;
use std::f64::consts::TAU;

fn words(data: &InputOutput) -> String {
    inspect(data).findings.into_iter().map(|f| f.text + "\n").collect()
}

fn sine(y: impl Fn(f64) -> f64) -> InputOutput {
    let u: Vec<f64> = (0..2000).map(|k| 50.0 + 50.0 * (TAU * f64::from(k) / 200.0).sin()).collect();
    let y = (0..2000).map(|k| y(f64::from(k))).collect();
    InputOutput::new("r", TimeBase::uniform(200.0), u, y).unwrap()
}

#[test]
fn a_constant_input_is_said_to_be_one() {
    let data = InputOutput::new("r", TimeBase::uniform(10.0), vec![3.0; 50], vec![1.0; 50]).unwrap();
    let found = inspect(&data);
    assert_eq!(found.kind, ExcitationKind::Constant);
    assert!(found.findings[0].is_warning());
    let text = words(&data);
    assert!(
        text.contains("input `u` is constant (3 V)") && text.contains("output `y` is constant"),
        "{text}"
    );
}

#[test]
fn a_saturated_sensor_is_said_to_be_one() {
    let data = sine(|k| (10.0 * (TAU * k / 200.0 - 0.2).sin()).min(8.0));
    let found = inspect(&data);
    assert!(found.output_clipping.at_high > 300, "{:?}", found.output_clipping);
    assert_eq!(found.input_clipping.total(), 0);
    assert!(words(&data).contains("output `y` looks saturated"), "{}", words(&data));
}

#[test]
fn a_clockwise_loop_is_a_warning_and_a_lagging_one_is_not() {
    assert!(words(&sine(|k| (TAU * k / 200.0 + 0.2).sin())).contains("runs clockwise"));
    let text = words(&sine(|k| (TAU * k / 200.0 - 0.2).sin()));
    assert!(!text.contains("runs clockwise") && text.contains("counter-clockwise"), "{text}");
    assert!(
        text.contains("cannot be distinguished from loop width") && text.contains("sine of 1.0000 Hz"),
        "{text}"
    );
}

#[test]
fn missing_times_are_said_to_be_missing() {
    let mut data = sine(|k| (TAU * k / 200.0 - 0.2).sin());
    data.time = TimeBase::Unknown;
    let found = inspect(&data);
    assert_eq!((found.sample_rate_hz, found.delay, found.frequency_span_hz), (None, None, None));
    assert!(found.findings[0].text.contains("Give the sample rate"));
}

/// A spike marked as not valid counts in nothing.
#[test]
fn masked_samples_are_in_neither_stroke_nor_opening_nor_noise() {
    let clean = sine(|k| 10.0 * (TAU * k / 200.0 - 0.2).sin());
    let mut spoiled = clean.clone();
    let hit = [3, 450, 1333];
    hit.iter().for_each(|&k| spoiled.y[k] = 1e4);
    spoiled.valid = Some((0..2000).map(|k| !hit.contains(&k)).collect());
    let (clean, found) = (inspect(&clean), inspect(&spoiled));
    let (a, b) = (clean.loop_shape.unwrap(), found.loop_shape.unwrap());
    assert!((b.stroke / a.stroke - 1.0).abs() < 1e-3 && (b.opening / a.opening - 1.0).abs() < 1e-3, "{b:?}");
    assert!(found.noise_floor.unwrap().rms < 1e-9 * a.stroke, "{:?}", found.noise_floor);
    assert!((found.output_range.1 - 10.0).abs() < 0.01);
}

#[test]
fn one_loop_is_taken_to_repeat_and_said_so() {
    let wave = |k: u32, lag: f64| 5.0 - 5.0 * (TAU * f64::from(k) / 100.0 - lag).cos();
    let (u, y) = (0..=100).map(|k| (wave(k, 0.0), wave(k, 0.2))).unzip();
    let one = InputOutput::new("r", TimeBase::uniform(10_000.0), u, y).unwrap();
    let text = words(&one);
    assert!(
        text.contains("run through once and is taken to repeat") && text.contains("(1 reversal)"),
        "{text}"
    );
    assert!(!words(&sine(|k| (TAU * k / 200.0 - 0.2).sin())).contains("taken to repeat"));
    // A single period of 100 Hz is no swing of 50 Hz.
    assert_eq!(Swings::of(&one.u, &one.time).unwrap().fastest_hz.round(), 100.0);
}

#[test]
fn noise_below_the_converter_s_step_is_its_rounding() {
    let text = words(&sine(|k| (20.0 * (TAU * k / 200.0 - 0.2).sin()).round()));
    let rounding = 1.0 / 12f64.sqrt();
    assert!(text.contains(&format!("Noise floor of the output {} ", short_to(rounding, 3))), "{text}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_record_can_be_inspected(
        samples in prop::collection::vec(
            (-1e3..1e3f64, prop_oneof![Just(0.0), Just(1.0), -1e100..1e100f64]),
            2..120,
        ),
        rate in prop::option::of(1e-3..1e6f64),
    ) {
        let (u, y): (Vec<f64>, Vec<f64>) = samples.into_iter().unzip();
        let time = rate.map_or(TimeBase::Unknown, TimeBase::uniform);
        // Either channel as the input: one is broadband, the other mostly held.
        for (u, y) in [(u.clone(), y.clone()), (y, u)] {
            let data = InputOutput::new("r", time.clone(), u, y).unwrap();
            prop_assert!(!inspect(&data).findings.is_empty());
        }
    }
}
