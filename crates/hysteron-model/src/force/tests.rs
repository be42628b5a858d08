use std::f64::consts::TAU;

use super::*;
use crate::hysteresis::HysteresisForm;
use crate::record::{Channel, ChannelChoice, InputOutput, Record, TimeBase};
use crate::start::Start;

const RATE_HZ: f64 = 500.0;

/// Dahl's operator of one millimetre beside a spring of 2 N/mm.
fn hysteresis() -> Hysteresis {
    let dahl: HysteresisForm = "dahl".parse().unwrap();
    dahl.operator(vec![2.0], &[50.0], &[1.0, 1.0]).unwrap()
}

fn model(saturating: Vec<Saturation>, viscous: f64) -> ForceModel {
    ForceModel { offset: 3.0, hysteresis: hysteresis(), viscous, saturating, rate_window_s: 0.0 }
}

/// Two sines, in mm.
fn displacement(samples: usize, rate_hz: f64) -> Vec<f64> {
    let at = |t: f64| 10.0 * (TAU * t).sin() + 2.0 * (TAU * 3.1 * t).sin();
    (0..samples).map(|k| at(k as f64 / rate_hz)).collect()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

fn shares(saturation: Saturation, x: &[f64], time: &TimeBase) -> Vec<f64> {
    let motion = Motion { x, rate: None, time };
    saturation.shares(&motion, &motion.rate(0.0).unwrap()).unwrap()
}

/// ρ ṡ = v − ν artanh s by forward Euler in tiny steps, the rate linear between samples.
fn slow_shares(saturation: Saturation, rate: &[f64], interval_s: f64) -> Vec<f64> {
    const STEPS: usize = 4000;
    let mut s = 0.0_f64;
    let mut all = vec![s];
    for two in rate.windows(2) {
        for step in 0..STEPS {
            let v = two[0] + (two[1] - two[0]) * (step as f64 + 0.5) / STEPS as f64;
            s += interval_s / STEPS as f64 / saturation.reach * (v - saturation.rate * s.atanh());
        }
        all.push(s);
    }
    all
}

#[test]
fn the_saturating_force_obeys_its_equation() {
    let time = TimeBase::uniform(RATE_HZ);
    let x = displacement(600, RATE_HZ);
    let saturation = Saturation { force: 1.0, rate: 8.0, reach: 0.4 };
    let rate = rate_of(&x, &time, 0.0).unwrap();
    let slow = slow_shares(saturation, &rate, 1.0 / RATE_HZ);
    let error = largest_difference(&shares(saturation, &x, &time), &slow);
    assert!(error < 5e-3, "{error}");
    // Second order: a quarter at half the interval.
    let fine_time = TimeBase::uniform(2.0 * RATE_HZ);
    let between =
        |k: usize| if k.is_multiple_of(2) { rate[k / 2] } else { 0.5 * (rate[k / 2] + rate[k / 2 + 1]) };
    let fine_rate: Vec<f64> = (0..2 * rate.len() - 1).map(between).collect();
    let fine_x = vec![0.0; fine_rate.len()];
    let motion = Motion { x: &fine_x, rate: Some(&fine_rate), time: &fine_time };
    let fine = saturation.shares(&motion, &fine_rate).unwrap();
    let fine: Vec<f64> = fine.into_iter().step_by(2).collect();
    assert!(largest_difference(&fine, &slow) < 0.4 * error);
}

#[test]
fn without_reach_the_force_is_a_hyperbolic_tangent_of_the_rate() {
    let time = TimeBase::uniform(RATE_HZ);
    let x = displacement(600, RATE_HZ);
    let tanh: Vec<f64> = rate_of(&x, &time, 0.0).unwrap().iter().map(|v| (v / 8.0).tanh()).collect();
    for (reach, tolerance) in [(0.0, 1e-15), (1e-7, 1e-5)] {
        let s = shares(Saturation { force: 1.0, rate: 8.0, reach }, &x, &time);
        assert!(largest_difference(&s[1..], &tanh[1..]) < tolerance, "{reach}");
    }
}

#[test]
fn without_dashpot_the_force_is_a_stop() {
    let time = TimeBase::uniform(RATE_HZ);
    let x = displacement(1500, RATE_HZ);
    let rate = rate_of(&x, &time, 0.0).unwrap();
    let reach = 0.7;
    let mut stop = 0.0_f64;
    let stops: Vec<f64> = std::iter::once(0.0)
        .chain(rate.windows(2).map(|two| {
            stop = (stop + 0.5 * (two[0] + two[1]) / RATE_HZ / reach).clamp(-1.0, 1.0);
            stop
        }))
        .collect();
    let s = shares(Saturation { force: 1.0, rate: 1e-6, reach }, &x, &time);
    // The two-stage method follows the corner to second order in the moves between samples.
    assert!(largest_difference(&s, &stops) < 0.02);
}

#[test]
fn without_terms_of_the_rate_the_force_depends_on_the_order_of_the_samples_alone() {
    let x = displacement(1000, RATE_HZ);
    let model = model(Vec::new(), 0.0);
    let of =
        |time: &TimeBase| model.simulate(&Motion { x: &x, rate: None, time }, Start::AsIdentified).unwrap();
    let slow = of(&TimeBase::uniform(1e-3));
    assert_eq!(of(&TimeBase::uniform(1e5)), slow);
    assert_eq!(of(&TimeBase::Unknown), slow);
}

#[test]
fn a_slow_motion_has_the_force_of_the_hysteresis_alone() {
    let x = displacement(2000, RATE_HZ);
    let rates = model(vec![Saturation { force: 40.0, rate: 8.0, reach: 0.4 }], 0.7);
    let time = TimeBase::uniform(1e-6);
    let of = |model: &ForceModel| {
        model.simulate(&Motion { x: &x, rate: None, time: &time }, Start::AsIdentified).unwrap()
    };
    assert!(largest_difference(&of(&rates), &of(&model(Vec::new(), 0.0))) < 1e-5);
}

#[test]
fn a_settled_start_repeats() {
    let samples = 500;
    let x: Vec<f64> = (0..2 * samples).map(|k| 5.0 * (TAU * k as f64 / samples as f64).sin()).collect();
    let model = model(vec![Saturation { force: 40.0, rate: 8.0, reach: 2.0 }], 0.1);
    let time = TimeBase::uniform(RATE_HZ);
    let rate: Vec<f64> = (0..2 * samples)
        .map(|k| 5.0 * TAU * RATE_HZ / samples as f64 * (TAU * k as f64 / samples as f64).cos())
        .collect();
    let motion = Motion { x: &x, rate: Some(&rate), time: &time };
    let force = model.simulate(&motion, Start::settled(samples)).unwrap();
    assert!(largest_difference(&force[..samples], &force[samples..]) < 1e-6);
}

#[test]
fn the_rate_of_a_parabola_is_exact_and_a_window_averages_noise() {
    let times: Vec<f64> = (0..40).map(|k| 0.1 * f64::from(k)).collect();
    let x: Vec<f64> = times.iter().map(|t| 1.0 + 3.0 * t - 2.0 * t * t).collect();
    let uniform = TimeBase::uniform(10.0);
    for window_s in [0.0, 0.2, 0.6] {
        let rate = rate_of(&x, &uniform, window_s).unwrap();
        for (k, t) in times.iter().enumerate().skip(3).take(34) {
            assert!((rate[k] - (3.0 - 4.0 * t)).abs() < 1e-12, "{window_s} {k}");
        }
    }
    let noisy: Vec<f64> =
        x.iter().enumerate().map(|(k, x)| x + if k % 2 == 0 { 0.01 } else { -0.01 }).collect();
    let rate = rate_of(&noisy, &uniform, 0.6).unwrap();
    assert!((10..30).all(|k| (rate[k] - (3.0 - 4.0 * times[k])).abs() < 0.02));
}

#[test]
fn every_number_can_be_read_and_set_by_its_name() {
    let saturation = Saturation { force: 40.0, rate: 8.0, reach: 0.4 };
    let mut model = model(vec![saturation, saturation], 0.7);
    let numbers = model.numbers();
    let names: Vec<&str> = numbers.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(&names[..5], ["offset", "linear", "reach", "exponent", "weight_1"]);
    assert_eq!(&names[5..9], ["viscous", "saturating_force", "saturating_rate", "saturating_reach"]);
    assert_eq!(names[9], "saturating_force_2");
    for (name, value) in &numbers {
        *model.number_mut(name).unwrap() += 1.0;
        assert!(model.numbers().contains(&(name.clone(), value + 1.0)), "{name}");
    }
    assert!(model.number_mut("mass").is_none());
}

#[test]
fn what_cannot_be_simulated_is_refused() {
    let x = displacement(10, RATE_HZ);
    let time = TimeBase::uniform(RATE_HZ);
    let model = model(vec![Saturation { force: 40.0, rate: 8.0, reach: 0.4 }], 0.7);
    let motion = Motion { x: &x, rate: None, time: &time };
    let refused = |motion: Motion<'_>, start| model.simulate(&motion, start).unwrap_err();
    let rest = Start::AsIdentified;
    assert_eq!(refused(Motion { time: &TimeBase::Unknown, ..motion }, rest), ForceModelError::NoTimes);
    let short = Motion { rate: Some(&x[1..]), ..motion };
    assert_eq!(refused(short, rest), ForceModelError::RateLength { expected: 10, found: 9 });
    let mut broken = x.clone();
    broken[4] = f64::NAN;
    assert!(matches!(
        refused(Motion { rate: Some(&broken), ..motion }, rest),
        ForceModelError::Sample { signal: "rate", index: 4, .. }
    ));
    assert!(model.simulate(&Motion { x: &broken, ..motion }, rest).is_err());
    assert_eq!(refused(motion, Start::Rest { voltage_v: 1.0 }), ForceModelError::Start);
    assert_eq!(
        refused(motion, Start::settled(11)),
        ForceModelError::Period { samples: 10, period_samples: 11 }
    );
    let standing =
        ForceModel { saturating: vec![Saturation { force: 1.0, rate: 0.0, reach: 0.4 }], ..model.clone() };
    assert!(standing.simulate(&motion, rest).unwrap_err().to_string().contains("saturating rate"));
}

#[test]
fn a_measured_rate_is_taken_in_the_unit_of_the_displacement_per_second() {
    let channel = |name: &str, unit: &str, samples: Vec<f64>| Channel::new(name, unit, samples);
    let record = Record::new(
        "damper",
        TimeBase::uniform(RATE_HZ),
        vec![
            channel("x", "mm", vec![0.0, 1.0, 2.0]),
            channel("F", "N", vec![0.0, 1.0, 1.0]),
            channel("v", "m_per_s", vec![0.1, 0.2, 0.3]),
            channel("w", "N_per_s", vec![0.1, 0.2, 0.3]),
        ],
    )
    .unwrap();
    let choice = ChannelChoice { input: Some("x".to_owned()), output: Some("F".to_owned()) };
    let data = record.input_output(&choice).unwrap();
    let rated = with_rate(data.clone(), &record, "v").unwrap();
    let rate = rated.rate.clone().unwrap();
    assert!(largest_difference(&rate, &[1e5, 2e5, 3e5]) < 1e-6, "{rate:?}");
    assert_eq!(rated.cropped(1..3).unwrap().rate.unwrap(), rate[1..]);
    let refused = |data: InputOutput, name: &str| with_rate(data, &record, name).unwrap_err();
    assert!(matches!(refused(data.clone(), "w"), ForceModelError::RateUnit { .. }));
    assert!(refused(data.clone(), "x").to_string().contains("um/s"));
    assert!(matches!(refused(data.clone(), "u"), ForceModelError::NoRateChannel { .. }));
    let shorter = data.cropped(0..2).unwrap();
    assert_eq!(refused(shorter, "v"), ForceModelError::RateLength { expected: 2, found: 3 });
}
