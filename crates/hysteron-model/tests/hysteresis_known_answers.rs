//! The hysteresis block against independent numbers: a Runge–Kutta prototype of the article's Table 2, closed
//! forms, an oracle.
#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use std::f64::consts::PI;

use hysteron_model::Start;
use hysteron_model::hysteresis::{
    Admissibility, BoucWen, BoucWenState, Hysteresis, HysteresisError, InterSample, RecordEnds, UnitShape,
};
use hysteron_model::record::{LoopSense, loop_shape};

/// Table 2 of the article, n = 1.
fn table_2() -> BoucWen {
    BoucWen::new(vec![2.0, 0.0031], -1.2039, 0.1111, 0.0024, 1.0).unwrap()
}

/// u = 5 − 5 cos 2πt \[V\], `periods` periods of `per_period` samples.
fn sine(per_period: usize, periods: usize) -> Vec<f64> {
    (0..per_period * periods).map(|k| 5.0 - 5.0 * (2.0 * PI * k as f64 / per_period as f64).cos()).collect()
}

#[test]
fn table_2_gives_a_clockwise_loop() {
    // 400 samples a period: samples 100 and 300 are at 5 V.
    let u = sine(400, 3);
    let mut v = vec![0.0; u.len()];
    table_2().simulate(&u, Start::Rest { voltage_v: 0.0 }, &mut v).unwrap();
    assert!((v[900] - 11.59).abs() < 0.005, "up {}", v[900]);
    assert!((v[1100] - 8.61).abs() < 0.005, "down {}", v[1100]);
    let (u, v) = (&u[800..], &v[800..]);
    let shape = loop_shape(u, v).unwrap();
    assert_eq!(shape.sense, Some(LoopSense::Clockwise));
    assert!((shape.opening - (8.61 - 11.59)).abs() < 0.01);
    assert!(table_2().admissibility().is_bounded());
}

/// Difference of explicit Euler, scored on the second and third period: (root mean square, maximum), % of
/// stroke.
fn euler_error(model: &BoucWen, per_period: usize) -> (f64, f64) {
    let u = sine(per_period, 3);
    let mut v = vec![0.0; u.len()];
    model.simulate(&u, Start::Rest { voltage_v: 0.0 }, &mut v).unwrap();
    let (mut z, mut last, mut sum, mut largest) = (0.0_f64, 0.0, 0.0, 0.0_f64);
    for (k, &u) in u.iter().enumerate() {
        let du = u - last;
        last = u;
        z += model.alpha * du - model.beta * du.abs() * z - model.gamma * du * z.abs();
        if k >= per_period {
            let error = model.polynomial_at(u) - z - v[k];
            sum += error * error;
            largest = largest.max(error.abs());
        }
    }
    let tail = &v[per_period..];
    let stroke =
        tail.iter().copied().fold(f64::MIN, f64::max) - tail.iter().copied().fold(f64::MAX, f64::min);
    (100.0 * (sum / (2 * per_period) as f64).sqrt() / stroke, 100.0 * largest / stroke)
}

#[test]
fn explicit_euler_errs_by_a_per_cent_and_converges_to_the_exact_step() {
    let model = table_2();
    let (coarse, middle, fine) =
        (euler_error(&model, 20), euler_error(&model, 100), euler_error(&model, 10_000));
    // Largest error, in per cent of stroke, at 100 and at 20 samples a period (docs/theory/bouc-wen.md).
    assert!((middle.1 - 0.23).abs() < 0.01, "{middle:?}");
    assert!((coarse.1 - 1.3).abs() < 0.05, "{coarse:?}");
    // Root mean square, as an independent Runge–Kutta prototype of the same drive has it.
    assert!((middle.0 - 0.1649).abs() < 1e-4, "{middle:?}");
    assert!((coarse.0 - 0.8890).abs() < 1e-4, "{coarse:?}");
    // First order: a hundredth of the step, a hundredth of the error.
    assert!((middle.0 / fine.0 - 100.0).abs() < 5.0, "{fine:?}");
}

#[test]
fn matches_the_runge_kutta_oracle_over_a_whole_record() {
    let u: Vec<f64> =
        (0..300).map(|k| 4.0 * (0.31 * k as f64).sin() + 3.0 * (0.083 * k as f64).cos()).collect();
    for (alpha, beta, gamma, n) in [(0.6, 0.3, -0.1, 1.0), (0.6, 0.3, 0.2, 2.0), (-0.6, 0.3, -0.2, 1.5)] {
        let model = BoucWen::new(vec![1.0, -0.02, 0.001], alpha, beta, gamma, n).unwrap();
        let mut v = vec![0.0; u.len()];
        let end = model.simulate(&u, Start::Rest { voltage_v: -1.0 }, &mut v).unwrap();
        let (mut z, mut last) = (0.0_f64, -1.0);
        for (&u, &v) in u.iter().zip(&v) {
            let s = f64::signum(u - last);
            let h = (u - last) / 400.0;
            let f = |z: f64| alpha - beta * s * z * z.abs().powf(n - 1.0) - gamma * z.abs().powf(n);
            for _ in 0..400 {
                let k1 = f(z);
                let k2 = f(z + 0.5 * h * k1);
                let k3 = f(z + 0.5 * h * k2);
                let k4 = f(z + h * k3);
                z += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            }
            last = u;
            let want = u - 0.02 * u * u + 0.001 * u * u * u - z;
            // The oracle's own error where it steps over the kink at z = 0.
            assert!((v - want).abs() < 1e-6, "n {n}: {v} {want}");
        }
        assert!((end.z - z).abs() < 1e-6 && end.u == last);
    }
}

#[test]
fn rest_voltage_is_not_the_first_sample() {
    let model = BoucWen::new(vec![1.0], 0.5, 0.2, 0.05, 1.0).unwrap();
    let mut v = [0.0; 2];
    model.simulate(&[3.0, 4.0], Start::Rest { voltage_v: 3.0 }, &mut v).unwrap();
    assert_eq!(v[0], 3.0);
    model.simulate(&[3.0, 4.0], Start::Rest { voltage_v: 0.0 }, &mut v).unwrap();
    // z = α/(β + γ) (1 − e^(−(β + γ) u)).
    assert!((v[0] - (3.0 - 2.0 * (1.0 - (-0.75_f64).exp()))).abs() < 1e-15);
    let state = BoucWenState { u: 3.0, z: 0.25 };
    model.simulate(&[3.0, 4.0], Start::from(state), &mut v).unwrap();
    assert_eq!(v[0], 2.75);
    assert_eq!(model.simulate(&[], Start::from(state), &mut []).unwrap(), state);
}

#[test]
fn steady_state_of_a_saturated_loop_is_the_closed_form() {
    // n = 1, γ = 0, u = ±a: z(a) = −z(−a) = (α/β) tanh(β a).
    let (alpha, beta, a) = (0.7, 0.13, 6.0);
    let u: Vec<f64> = (0..200).map(|k| a * (2.0 * PI * k as f64 / 200.0).cos()).collect();
    let model = BoucWen::new(vec![1.0], alpha, beta, 0.0, 1.0).unwrap();
    let mut v = vec![0.0; 200];
    model.simulate(&u, Start::PERIODIC, &mut v).unwrap();
    let want = alpha / beta * (beta * a).tanh();
    assert!(
        (u[0] - v[0] - want).abs() < 1e-12 && (u[100] - v[100] + want).abs() < 1e-12,
        "{} {want}",
        u[0] - v[0]
    );
    assert_eq!(loop_shape(&u, &v).unwrap().sense, Some(LoopSense::CounterClockwise));
    // So weak a contraction that repetition alone would need some 1e5 periods.
    let weak = BoucWen::new(vec![1.0], alpha, 1e-6, 3e-7, 1.5).unwrap();
    let end = weak.simulate(&u, Start::PERIODIC, &mut v).unwrap();
    let mut again = vec![0.0; 200];
    weak.simulate(&u, Start::from(end), &mut again).unwrap();
    assert!(v.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-12));
}

#[test]
fn a_drive_without_hysteresis_or_without_samples_is_no_special_case() {
    let line = BoucWen::new(vec![2.0], 0.0, 0.1, 0.0, 1.0).unwrap();
    let mut v = [0.0; 3];
    line.simulate(&[1.0, 2.0, 0.5], Start::PERIODIC, &mut v).unwrap();
    assert_eq!(v, [2.0, 4.0, 1.0]);
    assert!(line.simulate(&[], Start::PERIODIC, &mut []).is_ok());
}

#[test]
fn unit_form_and_article_form_convert_both_ways() {
    for alpha in [0.8, -1.3] {
        let model = BoucWen::new(vec![1.0, 0.1], alpha, 0.3, 0.12, 2.5).unwrap();
        let shape = model.unit_shape();
        let back = BoucWen::from_unit(vec![1.0, 0.1], alpha, shape).unwrap();
        assert!((back.beta - 0.3).abs() < 1e-15 && (back.gamma - 0.12).abs() < 1e-15);
        let u = sine(50, 2);
        let (mut v, mut zeta) = (vec![0.0; 100], vec![0.0; 100]);
        model.simulate(&u, Start::Rest { voltage_v: 1.0 }, &mut v).unwrap();
        shape.simulate_every(1, &u, Start::Rest { voltage_v: 1.0 }, &mut zeta).unwrap();
        for ((&u, v), zeta) in u.iter().zip(v).zip(zeta) {
            assert!((v - (u + 0.1 * u * u - alpha * zeta)).abs() < 1e-13);
        }
    }
}

#[test]
fn verdicts_follow_the_article_symbols() {
    let verdict =
        |alpha, beta, gamma| BoucWen::new(vec![1.0], alpha, beta, gamma, 1.0).unwrap().admissibility();
    assert!(matches!(verdict(1.0, 0.5, 0.25),
        Admissibility::Bounded { saturation_v } if (saturation_v - 4.0 / 3.0).abs() < 1e-15));
    assert!(verdict(-1.0, 0.5, -0.4).is_bounded() && verdict(-1.0, 0.5, 0.4).is_bounded());
    // α < 0 needs β − γ > 0.
    assert_eq!(verdict(-1.0, 0.5, 0.6), Admissibility::Hardening);
    assert!(matches!(verdict(1.0, 0.5, 0.6), Admissibility::BoundedFromRest { .. }));
    assert_eq!(verdict(1.0, -0.1, 0.6), Admissibility::UnboundedAfterReversal);
    assert_eq!(verdict(1.0, 0.5, -0.5), Admissibility::NoSaturation);
    // The public benchmark: β = 800, γ = −1100.
    assert_eq!(verdict(5e4, 800.0, -1100.0), Admissibility::Hardening);
    assert!(verdict(5e4, 800.0, -1100.0).to_string().contains("hardening"));
}

#[test]
fn errors_carry_the_numbers() {
    let new = |polynomial: &[f64], n| BoucWen::new(polynomial.to_vec(), 1.0, 0.1, 0.0, n);
    assert_eq!(new(&[], 1.0), Err(HysteresisError::EmptyPolynomial));
    assert_eq!(
        new(&[1.0, f64::INFINITY], 1.0),
        Err(HysteresisError::Coefficient { power: 2, value: f64::INFINITY })
    );
    assert_eq!(new(&[1.0], 0.9), Err(HysteresisError::Exponent { n: 0.9 }));
    assert!(matches!(
        UnitShape { beta: f64::NAN, gamma: 0.0, n: 1.0 }.operator(),
        Err(HysteresisError::Parameter { name: "beta", .. })
    ));
    let model = new(&[1.0], 1.0).unwrap();
    let rest = Start::Rest { voltage_v: 0.0 };
    assert_eq!(
        model.simulate(&[1.0, 2.0], rest, &mut [0.0]),
        Err(HysteresisError::Lengths { expected: 2, found: 1 })
    );
    assert_eq!(
        model.simulate(&[1.0, f64::NAN, 3.0], rest, &mut [0.0; 3]),
        Err(HysteresisError::Drive { index: 1 })
    );
    let hard = BoucWen::new(vec![1.0], 1.0, -1.0, 0.0, 2.0).unwrap();
    let error = hard.simulate(&[1.0, 1.5, 1.6], rest, &mut [0.0; 3]).unwrap_err();
    assert!(matches!(error, HysteresisError::RunsAway { index: 2, .. }), "{error}");
    let hard = BoucWen::new(vec![1.0], 1.0, -1.0, 0.0, 1.0).unwrap();
    let error = hard.simulate(&[1.0, 900.0, 0.0], rest, &mut [0.0; 3]).unwrap_err();
    assert!(matches!(error, HysteresisError::RunsAway { index: 1, .. }), "{error}");
}

#[test]
fn loop_measures_of_an_ellipse() {
    // u = 3 + 2 cos φ, v = 1e6 + 5 sin φ: counter-clockwise, opening 10.
    let angles = (0..10_000).map(|k| 2.0 * PI * k as f64 / 10_000.0);
    let (u, v): (Vec<f64>, Vec<f64>) = angles.map(|p| (3.0 + 2.0 * p.cos(), 1e6 + 5.0 * p.sin())).unzip();
    let shape = loop_shape(&u, &v).unwrap();
    assert_eq!(shape.sense, Some(LoopSense::CounterClockwise));
    assert!((shape.opening - 10.0).abs() < 1e-5);
    let (u, v): (Vec<f64>, Vec<f64>) = (u.into_iter().rev().collect(), v.into_iter().rev().collect());
    let shape = loop_shape(&u, &v).unwrap();
    assert_eq!(shape.sense, Some(LoopSense::Clockwise));
    assert!((shape.opening + 10.0).abs() < 1e-5);
    assert_eq!(loop_shape(&u, &u).unwrap().sense, None);
    assert!(loop_shape(&[0.0, 1.0, 2.0], &[0.0, 1.0, 2.0]).is_none());
}

#[test]
fn drive_between_samples() {
    let u = [0.0, 2.0, 1.0];
    let up = |rule: InterSample, ends| rule.upsample(&u, 2, ends).unwrap();
    assert_eq!(up(InterSample::Hold, RecordEnds::Open), [0.0, 0.0, 2.0, 2.0, 1.0]);
    assert_eq!(up(InterSample::Linear, RecordEnds::Open), [0.0, 1.0, 2.0, 1.5, 1.0]);
    assert_eq!(up(InterSample::Linear, RecordEnds::Periodic), [0.0, 1.0, 2.0, 1.5, 1.0, 0.5]);
    assert_eq!(InterSample::Linear.upsample(&u, 0, RecordEnds::Open), Err(HysteresisError::Factor));
    // A trigonometric polynomial below the Nyquist frequency is met between the samples, odd and even
    // lengths.
    let wave = |t: f64| 1.0 + (2.0 * PI * t).sin() - 0.3 * (6.0 * PI * t + 0.4).cos();
    for samples in [9_usize, 16] {
        let u: Vec<f64> = (0..samples).map(|k| wave(k as f64 / samples as f64)).collect();
        let fine = InterSample::BandLimited.upsample(&u, 5, RecordEnds::Periodic).unwrap();
        assert_eq!(fine.len(), 5 * samples);
        for (k, f) in fine.iter().enumerate() {
            assert!((f - wave(k as f64 / (5 * samples) as f64)).abs() < 1e-14);
        }
    }
    // An open record that is not periodic: exact at the samples, close between them away from the ends.
    let smooth = |t: f64| 0.4 * t + (0.7 * t).sin();
    let u: Vec<f64> = (0..200).map(|k| smooth(f64::from(k))).collect();
    let fine = InterSample::BandLimited.upsample(&u, 4, RecordEnds::Open).unwrap();
    assert_eq!(fine.len(), 199 * 4 + 1);
    for (k, f) in fine.iter().enumerate() {
        let error = (f - smooth(k as f64 / 4.0)).abs();
        assert!(error < if k % 4 == 0 { 1e-12 } else { 5e-2 }, "{k}: {error:e}");
        assert!(error < 1e-3 || k < 40 || k + 40 > fine.len(), "{k}: {error:e}");
    }
}

#[test]
fn band_limited_drive_finds_the_turning_points_between_samples() {
    // Seven samples a period; truth: the same drive at 7 000.
    let model = Hysteresis::from(BoucWen::new(vec![1.0], 0.7, 0.4, 0.1, 1.0).unwrap());
    let drive = |per_period: usize| -> Vec<f64> {
        (0..per_period).map(|k| 5.0 * (2.0 * PI * k as f64 / per_period as f64 + 0.2).cos()).collect()
    };
    let mut truth = vec![0.0; 7000];
    model.simulate(&drive(7000), Start::PERIODIC, &mut truth).unwrap();
    let (mut linear, mut band_limited) = ([0.0; 7], [0.0; 7]);
    model.simulate(&drive(7), Start::PERIODIC, &mut linear).unwrap();
    let fine = InterSample::BandLimited.upsample(&drive(7), 100, RecordEnds::Periodic).unwrap();
    model.simulate_every(100, &fine, Start::PERIODIC, &mut band_limited).unwrap();
    let worst =
        |v: &[f64]| v.iter().enumerate().map(|(k, v)| (v - truth[1000 * k]).abs()).fold(0.0, f64::max);
    assert!(worst(&linear) > 2e-2, "{}", worst(&linear));
    assert!(worst(&band_limited) < 1e-4, "{}", worst(&band_limited));
}
