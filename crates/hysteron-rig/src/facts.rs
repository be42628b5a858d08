//! Tests of the whole bench: accuracy of the computation, and realism of the default stage.

use std::f64::consts::TAU;

use rustfft::num_complex::Complex64;

use super::*;
use crate::excitation::{Excitation, ExcitationSpec, SweepLaw, Waveform};

fn sine(fs: f64, frequency_hz: f64, periods: f64) -> Excitation {
    ExcitationSpec::new(fs, 0.0, 10.0, Waveform::Sine { frequency_hz, periods }).generate().unwrap()
}

fn stroke(y: &[f64]) -> f64 {
    let (low, high) = y.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| (l.min(x), h.max(x)));
    high - low
}

/// Opening of the last period's loop at mid-range drive, % of stroke; positive: counter-clockwise (down
/// branch above).
fn opening_percent(truth: &Truth, frequency_hz: f64, periods: f64) -> f64 {
    let per_period = 2000;
    let run =
        measure(truth, &sine(frequency_hz * f64::from(per_period), frequency_hz, periods), 1, 0).unwrap();
    let last = &run.y_true_um[run.y_true_um.len() - per_period as usize..];
    let quarter = per_period as usize / 4;
    100.0 * (last[3 * quarter] - last[quarter]) / stroke(last)
}

fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max) / stroke(b)
}

#[test]
fn default_stage_moves_about_30_um_and_opens_about_15_percent_at_1_hz() {
    let run = measure(&Truth::default(), &sine(1000.0, 1.0, 3.0), 1, 0).unwrap();
    let stroke = stroke(&run.y_true_um[2000..]);
    assert!((28.0..32.0).contains(&stroke), "stroke {stroke}");
    let opening = opening_percent(&Truth::default(), 1.0, 3.0);
    println!("stroke {stroke:.3} µm, opening {opening:.2} % at 1 Hz");
    assert!((13.5..16.5).contains(&opening), "opening {opening}");
}

#[test]
fn loops_hardly_change_below_5_hz_and_clearly_by_100_hz() {
    let at = |f: f64| opening_percent(&Truth::default(), f, 4.0);
    let (one, five, hundred) = (at(1.0), at(5.0), at(100.0));
    println!(
        "opening % of stroke: 1 Hz {one:.2}, 5 Hz {five:.2}, 20 Hz {:.2}, 50 Hz {:.2}, 100 Hz {hundred:.2}",
        at(20.0),
        at(50.0)
    );
    // Distance of whole loops, not only of their openings: at equal phase, each about its own mean.
    let last_period = |f: f64| {
        let y = measure(&Truth::default(), &sine(2000.0 * f, f, 4.0), 1, 0).unwrap().y_true_um;
        let last = y[y.len() - 2000..].to_vec();
        let mean = last.iter().sum::<f64>() / 2000.0;
        last.into_iter().map(|v| v - mean).collect::<Vec<f64>>()
    };
    let slow = last_period(1.0);
    let apart = |f: f64| 100.0 * relative_difference(&last_period(f), &slow);
    let (five_apart, hundred_apart) = (apart(5.0), apart(100.0));
    println!(
        "largest distance from the 1 Hz loop, % of stroke: 2 Hz {:.2}, 5 Hz {five_apart:.2}, 10 Hz {:.2}, \
         100 Hz {hundred_apart:.2}",
        apart(2.0),
        apart(10.0)
    );
    assert!(five_apart < 1.5 && hundred_apart > 5.0);
    assert!((five - one).abs() < 1.0, "1 Hz {one}, 5 Hz {five}");
    assert!(hundred - one > 8.0, "1 Hz {one}, 100 Hz {hundred}");
}

#[test]
fn four_times_the_oversampling_changes_the_default_bench_by_less_than_1e_6_of_stroke() {
    let spec = Waveform::Sweep { law: SweepLaw::Linear, start_hz: 1.0, end_hz: 100.0, duration_s: 0.4 };
    let drive = ExcitationSpec::new(10_000.0, 0.0, 10.0, spec).generate().unwrap();
    let at = |truth: Truth, oversampling| {
        measure(&Truth { oversampling, ..truth }, &drive, 1, 0).unwrap().y_true_um
    };
    for (name, truth) in [("default", Truth::default()), ("article", Truth::article())] {
        let change = relative_difference(&at(truth.clone(), 20), &at(truth, 80));
        println!("{name}: 20 to 80 changes {change:.2e}");
        assert!(change < 1e-6, "{name}: {change:e}");
    }
}

/// Step response of Eq. 13, the step held from t = 0, against the values of `step_response.rs` in
/// `hysteron-model`.
#[test]
fn article_plant_stepped_on_the_grid_gives_the_reference_step_response() {
    let mut truth = Truth::article().with_ideal_sensor();
    let Plant::BoucWenFractional(plant) = &mut truth.plant else { panic!("article truth") };
    (plant.polynomial, plant.alpha, plant.beta, plant.gamma) = (vec![1.0], 0.0, 0.0, 0.0);
    truth.dac = Dac::Hold;
    // At rest at 0 V for one sample, then 1 V: the response at sample 1 + t·fs.
    let mut drive = sine(10_000.0, 10.0, 1.1);
    drive.samples_v = (0..1002).map(|k| if k == 0 { 0.0 } else { 1.0 }).collect();
    let reference = [
        (10, 0.6425473727342575),
        (50, 0.9669591601584735),
        (100, 0.9609188729670224),
        (500, 0.9575970251960186),
        (1000, 0.9572563930286222),
    ];
    let y = measure(&truth, &drive, 1, 0).unwrap().y_true_um;
    for (k, expected) in reference {
        let error = y[1 + k] / expected - 1.0;
        assert!(error.abs() < 1e-8, "sample {k}: {error:e}");
    }
    // Through a delay of 3.7 samples, the output is the response 3.7 samples earlier.
    let Plant::BoucWenFractional(plant) = &mut truth.plant else { panic!("article truth") };
    plant.delay_s = 3.7e-4;
    let delayed = measure(&truth, &drive, 1, 0).unwrap().y_true_um;
    assert!(delayed[..4].iter().all(|y| y.abs() < 1e-9));
    let g = truth.plant.dynamics(5e-6).unwrap();
    for k in [5, 13, 200, 1001] {
        let expected = g.step_response((k as f64 - 1.0 - 3.7) * 1e-4);
        assert!((delayed[k] - expected).abs() < 1e-10, "sample {k}");
    }
}

/// Without hysteresis the bench is linear: its steady sine is amplifier × creep × modes × delay, times sinc²
/// of the straight lines between the samples of the command.
#[test]
fn a_linear_bench_has_the_frequency_response_of_its_parts() {
    let Plant::PlayStack(stack) = Truth::default().plant else { panic!("default truth") };
    let (fs, f) = (10_000.0, 100.0);
    for creep in [None, stack.creep] {
        let linear = PlayStack {
            plays: Vec::new(),
            linear_um_per_v: 3.0,
            quadratic_per_um: 0.0,
            cubic_per_um2: 0.0,
            creep,
            ..stack.clone()
        };
        let truth = Truth { plant: Plant::PlayStack(linear), ..Truth::default() };
        let y = measure(&truth, &sine(fs, f, 80.0), 1, 0).unwrap().y_true_um;
        // Fundamental of the last period (the mode's transient has decayed by e^−71), with the creep drift
        // over it removed.
        let (before, last) = (&y[y.len() - 200..y.len() - 100], &y[y.len() - 100..]);
        let drift = last.iter().zip(before).map(|(a, b)| a - b).sum::<f64>() / 100.0;
        let mut fundamental = Complex64::ZERO;
        for (k, value) in last.iter().enumerate() {
            let level = value - drift * k as f64 / 100.0;
            fundamental += Complex64::from_polar(level / 50.0, -TAU * k as f64 / 100.0);
        }
        let s = Complex64::new(0.0, TAU * f);
        let modes: Complex64 = [(475.0, 0.03, 0.93), (1100.0, 0.02, 0.07)]
            .iter()
            .map(|&(hz, damping, share)| {
                let w = TAU * hz;
                (s * s + s * (2.0 * damping * w) + w * w).inv() * (w * w * share)
            })
            .sum();
        let slow =
            creep.map_or(Complex64::ONE, |c| (s + TAU * c.corner_hz).powf(-c.order) * c.strength + 1.0);
        let amplifier = (s / (TAU * 2000.0) + 1.0).inv();
        let x = std::f64::consts::PI * f / fs;
        let straight = (x.sin() / x).powi(2);
        // The drive is 5 V − 5 V cos.
        let expected = modes * slow * amplifier * (-s * 1.23e-4).exp() * (-15.0 * straight);
        let error = (fundamental / expected - 1.0).norm();
        assert!(error < 3e-6, "creep {creep:?}: {error:e}");
    }
}

#[test]
fn a_delay_of_whole_samples_shifts_the_record() {
    let with = |delay_s| {
        let Plant::PlayStack(stack) = Truth::default().plant else { panic!("default truth") };
        let truth = Truth { plant: Plant::PlayStack(PlayStack { delay_s, ..stack }), ..Truth::default() };
        measure(&truth, &sine(10_000.0, 50.0, 2.0), 1, 0).unwrap().y_true_um
    };
    let (now, later) = (with(0.0), with(3e-4));
    assert_eq!(later[..3], [0.0; 3]);
    assert_eq!(later[3..], now[..now.len() - 3]);
    // A delay half a grid step away gives an output between its neighbours.
    let between = with(3e-4 - 2.5e-6);
    let (a, b, m) = (now[60], now[61], between[63]);
    assert!(m > a.min(b) && m < a.max(b));
}

#[test]
fn a_held_drive_lags_a_linear_one_by_half_a_sample() {
    let Plant::PlayStack(stack) = Truth::default().plant else { panic!("default truth") };
    let with = |dac, delay_s| {
        let plant = Plant::PlayStack(PlayStack { delay_s, ..stack.clone() });
        measure(&Truth { plant, dac, ..Truth::default() }, &sine(10_000.0, 20.0, 2.0), 1, 0)
            .unwrap()
            .y_true_um
    };
    let difference = relative_difference(&with(Dac::Hold, 1e-4), &with(Dac::Linear, 1.5e-4));
    let unshifted = relative_difference(&with(Dac::Hold, 1e-4), &with(Dac::Linear, 1e-4));
    assert!(difference < 2e-4 && unshifted > 2e-3, "{difference:e} {unshifted:e}");
}

#[test]
fn a_bench_resting_at_a_voltage_stays_there() {
    let mut drive = sine(1000.0, 10.0, 1.0);
    drive.samples_v = vec![4.0; 300];
    for truth in [Truth::default(), Truth::article()] {
        let run = measure(&truth.with_ideal_sensor(), &drive, 1, 0).unwrap();
        let y = &run.record.channels[1].samples;
        assert!(y[0] > 5.0);
        assert!(y.iter().all(|v| (v - y[0]).abs() < 1e-9 * y[0]), "{:?}", &y[..3]);
    }
    // With unbounded creep, rest is possible at 0 V only.
    let Plant::PlayStack(mut stack) = Truth::default().plant else { panic!("default truth") };
    stack.creep = Some(Creep { strength: 0.08, order: 0.15, corner_hz: 0.0 });
    let truth = Truth { plant: Plant::PlayStack(stack), ..Truth::default() };
    assert_eq!(measure(&truth, &drive, 1, 0).unwrap_err(), RigError::NoRest { drive_v: 4.0 });
    drive.samples_v[0] = 0.0;
    assert!(measure(&truth, &drive, 1, 0).is_ok());
}

#[test]
fn campaign_is_the_articles_and_depends_on_seed_but_not_on_threads() {
    let plan = CampaignPlan {
        sample_rate_hz: 1000.0,
        sweep_s: 1.0,
        loop_periods: 1.0,
        validation_s: 0.2,
        ..CampaignPlan::extended()
    };
    let with = |threads, seed| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run_campaign(&Truth::default(), &plan, seed)).unwrap()
    };
    let one = with(1, 11);
    assert_eq!(one, with(3, 11));
    let other = with(2, 12);
    assert_ne!(one[0].run.record, other[0].run.record);
    assert_eq!(one[0].run.y_true_um, other[0].run.y_true_um, "the seed changes the noise, not the plant");
    let names: Vec<&str> = one.iter().map(|r| r.run.record.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "simulated_loop_1hz",
            "simulated_sweep_1_100hz",
            "simulated_sine_10hz",
            "simulated_sine_20hz",
            "simulated_sine_50hz",
            "simulated_sine_100hz",
            "simulated_tracking",
            "simulated_nested_loops"
        ]
    );
    for run in &one {
        let record = run.run.record_with_truth();
        assert!(run.run.comments[0].starts_with("simulated"));
        assert_eq!(run.run.clipped_samples, 0);
        let n = record.channels[0].samples.len();
        assert!(
            record.channels.iter().all(|c| c.samples.len() == n && c.samples.iter().all(|x| x.is_finite()))
        );
        // Error of the sensor: 5 nm of noise and a step of 0.92 nm.
        let error: f64 = record.channels[1]
            .samples
            .iter()
            .zip(&run.run.y_true_um)
            .map(|(y, t)| (y - t).powi(2))
            .sum::<f64>()
            / n as f64;
        assert!((error.sqrt() / 0.005 - 1.0).abs() < 0.25, "{}: {}", record.name, error.sqrt());
    }
}

#[test]
fn truth_files_are_json_with_defaults_and_no_unknown_keys() {
    assert_eq!(serde_json::from_str::<Truth>("{}").unwrap(), Truth::default());
    for truth in [Truth::default(), Truth::article()] {
        let text = serde_json::to_string(&truth).unwrap();
        assert_eq!(serde_json::from_str::<Truth>(&text).unwrap(), truth);
    }
    let text = r#"{"plant": {"kind": "bouc_wen_fractional", "polynomial": [3.0],
        "alpha": 1, "beta": 0.2, "gamma": -0.1, "delay_s": 2e-4,
        "denominator": [{"coefficient": 1, "order": 0}, {"coefficient": 0.01, "order": 0.9}]},
        "sensor": {"noise_um": 0}}"#;
    let truth: Truth = serde_json::from_str(text).unwrap();
    assert_eq!((truth.delay_s(), truth.sensor.noise_um), (2e-4, 0.0));
    assert!(truth.sensor.adc.is_some());
    for bad in [r#"{"plants": {}}"#, r#"{"plant": {"kind": "play_stack", "delay": 1}}"#] {
        assert!(serde_json::from_str::<Truth>(bad).is_err(), "{bad}");
    }
}

#[test]
fn a_truth_that_makes_no_sense_is_refused_by_name() {
    let drive = sine(1000.0, 10.0, 1.0);
    let name_of = |text: &str| match measure(&serde_json::from_str(text).unwrap(), &drive, 1, 0).unwrap_err()
    {
        RigError::Parameter { parameter, .. } => parameter,
        RigError::EmptyList { parameter } => parameter.to_owned(),
        other => panic!("{other}"),
    };
    assert_eq!(name_of(r#"{"oversampling": 4}"#), "oversampling");
    assert_eq!(name_of(r#"{"sensor": {"noise_um": -1}}"#), "sensor.noise_um");
    assert_eq!(name_of(r#"{"plant": {"kind": "play_stack", "modes": []}}"#), "plant.modes");
    let mode =
        r#"{"plant": {"kind": "play_stack", "modes": [{"frequency_hz": 1, "damping": 1.0, "share": 1}]}}"#;
    assert_eq!(name_of(mode), "plant.modes[0].damping");
    let n = r#"{"plant": {"kind": "bouc_wen_fractional", "polynomial": [1],
        "alpha": 0, "beta": 0, "gamma": 0, "n": 0.5}}"#;
    assert_eq!(name_of(n), "plant.n");
    let blow_up = r#"{"plant": {"kind": "bouc_wen_fractional", "polynomial": [1],
        "alpha": 1, "beta": -0.5, "gamma": -0.5, "n": 2}}"#;
    let error = measure(&serde_json::from_str(blow_up).unwrap(), &drive, 1, 0).unwrap_err();
    assert!(matches!(error, RigError::Diverged { .. }), "{error}");
}
