//! The simulation against the linear response in closed form, and sample by sample.

use hysteron_model::axes::{AxesError, SteadyPeriod, Streaming, spectrum};
use hysteron_model::record::InterSample;
use hysteron_numeric::Complex64;

use crate::device::{HIGH, LOW, PERIOD, RATE, device, drive, record};

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt()
}

#[test]
fn without_hysteresis_the_steady_state_is_the_linear_response_line_by_line() {
    let mut linear = device();
    linear.feedback = None;
    for level in [LOW, 0.4, HIGH] {
        let u = drive(level, 3);
        let rows: Vec<f64> = (0..PERIOD).flat_map(|k| [u[0][k], u[1][k]]).collect();
        let y = linear.simulate_period(&rows).unwrap();
        let (of_u, of_y) = (spectrum(&rows, 2), spectrum(&y, 2));
        let s = linear.level.state(level);
        assert!((s - (level / HIGH - 1.0)).abs() < 1e-9);
        for line in 1..860 {
            let g = linear.linear_response(line as f64 * RATE / PERIOD as f64, s);
            for o in 0..2 {
                let expected: Complex64 = (0..2).map(|i| g[2 * o + i] * of_u[2 * line + i]).sum();
                let found = of_y[2 * line + o];
                assert!((found - expected).norm() < 1e-9, "line {line}: {found} {expected}");
            }
        }
    }
}

#[test]
fn sample_by_sample_is_the_same_as_at_once() {
    let device = device();
    let mut u = drive(HIGH, 5);
    u.iter_mut().for_each(|u| u.truncate(700));
    let y = device.simulate_after(&u, RATE, InterSample::Linear, 0.3).unwrap();
    let mut stream = Streaming::new(&device, &[u[0][0], u[1][0]], 0.3);
    let mut sample = [0.0; 2];
    for k in 0..700 {
        stream.step(&[u[0][k], u[1][k]], &mut sample);
        for o in 0..2 {
            // Shares of a straight line are rounded one way here and another there.
            assert!((sample[o] - y[o][k]).abs() < 1e-12, "sample {k}: {} {}", sample[o], y[o][k]);
        }
    }
}

#[test]
fn a_drive_that_is_held_stays_where_it_is() {
    let device = device();
    let u = vec![vec![0.4; 50], vec![-0.2; 50]];
    let rest = None;
    let y = device.simulate(&u, RATE, InterSample::BandLimited, rest).unwrap();
    for y in y {
        assert!(y.iter().all(|x| (x - y[0]).abs() < 1e-7), "{y:?}");
    }
}

#[test]
fn a_running_drive_reaches_the_steady_state_and_its_level() {
    let mut device = device();
    device.level.time_constant_s = 4.0;
    let period = drive(HIGH, 9);
    let u: Vec<Vec<f64>> = period.iter().map(|u| u.repeat(12)).collect();
    let y = device.simulate_after(&u, RATE, InterSample::BandLimited, LOW).unwrap();
    let settled = Some(PERIOD);
    let steady = device.simulate(&u, RATE, InterSample::BandLimited, settled).unwrap();
    for (y, steady) in y.iter().zip(&steady) {
        let off = |period: usize| {
            let part = period * PERIOD..(period + 1) * PERIOD;
            let e: Vec<f64> = y[part.clone()].iter().zip(&steady[part]).map(|(a, b)| a - b).collect();
            rms(&e) / rms(steady)
        };
        // The level rises over the first seconds; the last period ends at its end, where the drive is not
        // periodic any more.
        assert!(off(0) > 0.1 && off(10) < 0.02, "{} {}", off(0), off(10));
    }
}

#[test]
fn what_does_not_suit_the_model_is_refused() {
    let device = device();
    let rest = None;
    let run = |u: &[Vec<f64>], rate: f64, start| device.simulate(u, rate, InterSample::Linear, start);
    let two = vec![vec![0.0; 10]; 2];
    assert!(matches!(run(&two[..1], RATE, rest), Err(AxesError::Channels { model: 2, record: 1, .. })));
    assert!(matches!(run(&two, 2.0 * RATE, rest), Err(AxesError::SampleRate { .. })));
    assert!(matches!(run(&two, f64::NAN, rest), Err(AxesError::SampleRate { .. })));
    let settled = Some(11);
    assert!(matches!(run(&two, RATE, settled), Err(AxesError::Period { .. })));
    let loud = vec![vec![1e200; 10]; 2];
    assert_eq!(run(&loud, RATE, rest), Err(AxesError::RunsAway));

    let mut unstable = device.clone();
    unstable.transition_slopes[0] = 0.9;
    unstable.transition[0] = 1.01;
    assert!(matches!(unstable.validate(), Err(AxesError::Unstable { mode: 1, .. })));
    let mut short = device.clone();
    short.output.pop();
    assert!(matches!(short.validate(), Err(AxesError::Length { what: "output", .. })));
    let mut odd = device.clone();
    odd.feedthrough[1] = f64::NAN;
    assert!(matches!(odd.validate(), Err(AxesError::Value { what: "feedthrough", .. })));
}

#[test]
fn the_level_of_a_record_is_that_of_its_drive() {
    let steady = SteadyPeriod::find(&record(0.4, 3, 0.01), false).unwrap();
    assert!((steady.level - 0.4).abs() < 1e-9 && steady.samples() == PERIOD);
    assert!((steady.offset[0] - 3.0).abs() < 0.01);
}

#[test]
fn a_drive_that_leaves_its_period_is_followed_from_the_steady_state() {
    let mut device = device();
    // The level at the beginning is that of one period here, of many there.
    device.level.time_constant_s = 1e9;
    let period = drive(LOW, 9);
    let other = drive(HIGH, 11);
    let parts = |settling: usize| -> Vec<Vec<f64>> {
        let each = period.iter().zip(&other);
        each.map(|(period, other)| [period.repeat(settling), other.clone()].concat()).collect()
    };
    let found = device.simulate(&parts(2), RATE, InterSample::BandLimited, Some(PERIOD)).unwrap();
    // The reference settles under twenty periods of the same drive.
    let expected = device.simulate_after(&parts(20), RATE, InterSample::BandLimited, LOW).unwrap();
    for (found, expected) in found.iter().zip(&expected) {
        let expected = &expected[18 * PERIOD..];
        let largest = expected.iter().fold(0.0, |m: f64, y| m.max(y.abs()));
        let error = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{:.1e}", error / largest);
        assert!(error < 1e-4 * largest, "{error} of {largest}");
        assert!(rms(&found[2 * PERIOD..]) > 1.5 * rms(&found[..PERIOD]));
    }
}
