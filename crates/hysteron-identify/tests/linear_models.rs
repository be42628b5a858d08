//! Promise: output error, Box–Jenkins and SRIVC return the parameters of noise-free data to 1e-8, and of data
//! with coloured noise on the output without bias, with standard errors that hold, where the equation error
//! of ARX is biased.

#![allow(clippy::unwrap_used)] // a test may fail

use hysteron_identify::linear::{
    PolynomialModel, PolynomialOrders, SrivcOrders, fit_polynomial, fit_srivc, select_polynomial,
    select_srivc,
};
use hysteron_model::dynamics::DynamicsError;
use hysteron_model::dynamics::arx::{ArxOrders, ArxRecord, fit};
use hysteron_model::record::InterSample;
use hysteron_numeric::Complex64;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Standard normal numbers.
fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    move || {
        let (a, b): (f64, f64) = (random.random(), random.random());
        (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }
}

/// Levels ±1 that may change every `clock` samples.
fn binary(samples: usize, clock: usize, seed: u64) -> Vec<f64> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut level = 1.0;
    (0..samples)
        .map(|k| {
            if k % clock == 0 {
                level = if random.random::<bool>() { 1.0 } else { -1.0 };
            }
            level
        })
        .collect()
}

/// First-order autoregression of deviation `size`.
fn coloured(samples: usize, memory: f64, size: f64, seed: u64) -> Vec<f64> {
    let mut next = normal(seed);
    let scale = size * (1.0 - memory * memory).sqrt();
    let mut x = size * next();
    (0..samples)
        .map(|_| {
            x = memory * x + scale * next();
            x
        })
        .collect()
}

fn truth() -> PolynomialModel {
    PolynomialModel { b: vec![0.3, 0.2], f: vec![-1.5, 0.7], nk: 2, c: Vec::new(), d: Vec::new() }
}

fn record<'a>(input: &'a [f64], output: &'a [f64]) -> ArxRecord<'a> {
    ArxRecord { input, output, valid: None }
}

fn plus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

#[test]
fn noise_free_records_return_the_output_error_model() {
    let inputs = [binary(400, 3, 1), coloured(300, 0.5, 1.0, 2)];
    let offsets = [2.0, -7.0];
    let outputs: Vec<Vec<f64>> = inputs
        .iter()
        .zip(offsets)
        .map(|(v, offset)| truth().simulate(v).iter().map(|y| y + offset).collect())
        .collect();
    let mut broken = outputs.clone();
    let mask: Vec<bool> = (0..400).map(|k| k % 50 != 7).collect();
    (0..400).filter(|&k| !mask[k]).for_each(|k| broken[0][k] = 1e3);
    let whole = [record(&inputs[0], &outputs[0]), record(&inputs[1], &outputs[1])];
    let masked = [ArxRecord { valid: Some(&mask), ..record(&inputs[0], &broken[0]) }, whole[1]];
    for records in [whole, masked] {
        let found = fit_polynomial(&records, PolynomialOrders::output_error(2, 2, 2)).unwrap();
        let flat = |m: &PolynomialModel| [m.b.clone(), m.f.clone()].concat();
        for (found, expected) in flat(&found.model).iter().zip(flat(&truth())) {
            assert!((found - expected).abs() < 1e-10, "{found} {expected}");
        }
        assert!(found.offsets.iter().zip(offsets).all(|(a, b)| (a - b).abs() < 1e-9), "{:?}", found.offsets);
        assert!(found.converged && found.rmse < 1e-10);
    }
}

/// G(s) = Σ r/(s − p) over poles and their conjugates, driven by a held or a straight input: each mode has a
/// closed form.
fn modes(poles: &[(Complex64, Complex64)], input: &[f64], h: f64, between: InterSample) -> Vec<f64> {
    let mut y = vec![0.0; input.len()];
    for &(p, r) in poles {
        let decay = (p * h).exp();
        let level = (decay - 1.0) / p;
        let rise = (level / h - 1.0) / p;
        let mut x = Complex64::ZERO;
        let mut before = 0.0;
        for (y, &now) in y.iter_mut().zip(input) {
            let change = if between == InterSample::Hold { 0.0 } else { now - before };
            x = decay * x + level * before + rise * change;
            *y += (r * x).re;
            before = now;
        }
    }
    y
}

/// Poles and residues of b/a, a monic of even degree given by its zeros in the upper half-plane; real parts
/// add up.
fn residues(numerator: &[f64], upper: &[Complex64]) -> Vec<(Complex64, Complex64)> {
    let all: Vec<Complex64> = upper.iter().flat_map(|p| [*p, p.conj()]).collect();
    upper
        .iter()
        .map(|&p| {
            let b = numerator.iter().rev().fold(Complex64::ZERO, |sum, &b| sum * p + b);
            let slope: Complex64 = all.iter().filter(|other| **other != p).map(|other| p - other).product();
            (p, b / slope * 2.0)
        })
        .collect()
}

fn pair(omega: f64, zeta: f64) -> Complex64 {
    Complex64::new(-zeta * omega, omega * (1.0 - zeta * zeta).sqrt())
}

/// G. P. Rao and H. Garnier's plant, simulated here: (−6400 s + 1600)/(s⁴ + 5 s³ + 408 s² + 416 s + 1600),
/// pairs at 2 rad/s with damping 0.25 and at 20 rad/s with 0.1, and a zero in the right half-plane.
const NUMERATOR: [f64; 2] = [1600.0, -6400.0];
const DENOMINATOR: [f64; 5] = [1600.0, 416.0, 408.0, 5.0, 1.0];

fn rao_garnier(input: &[f64], h: f64, between: InterSample) -> Vec<f64> {
    modes(&residues(&NUMERATOR, &[pair(2.0, 0.25), pair(20.0, 0.1)]), input, h, between)
}

#[test]
fn noise_free_records_return_the_continuous_model() {
    let h = 0.01;
    for (between, clock) in [(InterSample::Hold, 20), (InterSample::Linear, 7)] {
        let inputs = [binary(4000, clock, 3), binary(1500, clock, 4)];
        let outputs: Vec<Vec<f64>> = inputs
            .iter()
            .map(|u| {
                // Three samples late, over an offset.
                let late = [&[0.0; 3], &u[..u.len() - 3]].concat();
                rao_garnier(&late, h, between).iter().map(|y| y + 11.0).collect()
            })
            .collect();
        let records = [record(&inputs[0], &outputs[0]), record(&inputs[1], &outputs[1])];
        let orders = SrivcOrders { zeros: 1, poles: 4, delay: 3 };
        let found = fit_srivc(&records, orders, 1.0 / h, between).unwrap();
        let pairs = found.numerator.iter().zip(&NUMERATOR).chain(found.denominator.iter().zip(&DENOMINATOR));
        for (found, expected) in pairs {
            assert!((found - expected).abs() < 1e-8 * expected.abs(), "{between:?} {found} {expected}");
        }
        assert!(found.converged, "{}", found.iterations);
        assert!(found.offsets.iter().all(|o| (o - 11.0).abs() < 1e-8));
        assert_eq!(found.transfer_function().denominator[4].coefficient, 1.0);
    }
}

/// Mean and standard deviation of each column.
fn moments(runs: &[Vec<f64>]) -> Vec<(f64, f64)> {
    let n = runs.len() as f64;
    (0..runs[0].len())
        .map(|j| {
            let mean = runs.iter().map(|r| r[j]).sum::<f64>() / n;
            let square = runs.iter().map(|r| (r[j] - mean).powi(2)).sum::<f64>() / (n - 1.0);
            (mean, square.sqrt())
        })
        .collect()
}

/// Means within three standard errors, and predicted errors that are those seen.
fn assert_unbiased(runs: &[Vec<f64>], predicted: &[Vec<f64>], expected: &[f64]) {
    let (seen, errors) = (moments(runs), moments(predicted));
    // What is seen in forty runs is known to 11 %.
    let uncertainty = 1.0 / (2.0 * runs.len() as f64).sqrt();
    for (j, (&(mean, deviation), truth)) in seen.iter().zip(expected).enumerate() {
        let z = (mean - truth) / (deviation / (runs.len() as f64).sqrt());
        let ratio = deviation / errors[j].0;
        assert!(z.abs() < 3.0, "{j}: {mean} of {truth}, {z}");
        assert!((ratio - 1.0).abs() < 4.0 * uncertainty, "{j}: {ratio}");
    }
}

const RUNS: u64 = 40;

#[test]
fn coloured_noise_biases_arx_but_not_the_output_error() {
    let input = binary(1500, 3, 10);
    let clean = truth().simulate(&input);
    let expected = [0.3, 0.2, -1.5, 0.7];
    let (mut found, mut errors, mut equation) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 0..RUNS {
        let output = plus(&clean, &coloured(1500, 0.9, 0.15, 100 + seed));
        let records = [record(&input, &output)];
        let of_arx = fit(&records, ArxOrders { na: 2, nb: 2, nk: 2 }).unwrap().model;
        equation.push([&of_arx.b[2..], &of_arx.a].concat());
        let oe = fit_polynomial(&records, PolynomialOrders::output_error(2, 2, 2)).unwrap();
        errors.push(oe.std_error().unwrap());
        found.push([oe.model.b, oe.model.f].concat());
    }
    assert_unbiased(&found, &errors, &expected);
    for (j, (mean, deviation)) in moments(&equation).into_iter().enumerate().skip(2) {
        let z = (mean - expected[j]) / (deviation / (RUNS as f64).sqrt());
        println!("arx {j}: {mean:.4} of {}, {z:.1} standard errors of the mean", expected[j]);
        assert!(z.abs() > 10.0, "{j}: {z}");
    }
}

#[test]
fn box_jenkins_finds_the_noise_model_and_gains_by_it() {
    let input = binary(1500, 3, 11);
    let clean = truth().simulate(&input);
    let (mut found, mut errors, mut of_oe) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 0..RUNS {
        // (1 + 0.5 z⁻¹)/(1 − 0.8 z⁻¹) e.
        let mut next = normal(300 + seed);
        let (mut e, mut w) = (0.0, 0.0);
        let noise: Vec<f64> = (0..1500)
            .map(|_| {
                let new = 0.1 * next();
                w = 0.8 * w + new + 0.5 * e;
                e = new;
                w
            })
            .collect();
        let output = plus(&clean, &noise);
        let records = [record(&input, &output)];
        let orders = PolynomialOrders { nb: 2, nf: 2, nk: 2, nc: 1, nd: 1 };
        let bj = fit_polynomial(&records, orders).unwrap();
        assert!((bj.rmse / 0.1 - 1.0).abs() < 0.1, "{}", bj.rmse);
        errors.push(bj.std_error().unwrap());
        let m = bj.model;
        found.push([m.b, m.f, m.c, m.d].concat());
        let oe = fit_polynomial(&records, PolynomialOrders::output_error(2, 2, 2)).unwrap().model;
        of_oe.push([oe.b, oe.f].concat());
    }
    assert_unbiased(&found, &errors, &[0.3, 0.2, -1.5, 0.7, 0.5, -0.8]);
    for (bj, oe) in moments(&found).iter().zip(moments(&of_oe)) {
        assert!(bj.1 < oe.1, "{} {}", bj.1, oe.1);
    }
}

#[test]
fn coloured_noise_does_not_bias_srivc() {
    let h = 0.01;
    // Pair at 6 rad/s with damping 0.2 and gain 2: 72/(s² + 2.4 s + 36).
    let input = binary(3000, 20, 12);
    let clean = modes(&residues(&[72.0], &[pair(6.0, 0.2)]), &input, h, InterSample::Hold);
    let (mut found, mut errors) = (Vec::new(), Vec::new());
    for seed in 0..RUNS {
        let output = plus(&clean, &coloured(3000, 0.9, 0.3, 500 + seed));
        let orders = SrivcOrders { zeros: 0, poles: 2, delay: 0 };
        let srivc = fit_srivc(&[record(&input, &output)], orders, 1.0 / h, InterSample::Hold).unwrap();
        assert!(srivc.converged);
        errors.push(srivc.std_error().unwrap());
        found.push(vec![srivc.numerator[0], srivc.denominator[0], srivc.denominator[1]]);
    }
    assert_unbiased(&found, &errors, &[72.0, 36.0, 2.4]);
}

#[test]
fn orders_and_delay_are_found() {
    let input = binary(1500, 3, 20);
    let output = plus(&truth().simulate(&input), &coloured(1500, 0.9, 0.02, 21));
    let records = [record(&input, &output)];
    let best = select_polynomial(&records, 4, 5, (1, 1)).unwrap().swap_remove(0).fit;
    let PolynomialModel { b, f, nk, c, d } = &best.model;
    assert_eq!((b.len(), f.len(), *nk, c.len(), d.len()), (2, 2, 2, 1, 1));
    let arx = best.model.deterministic();
    assert_eq!((arx.b.len(), arx.a.len()), (4, 2));

    let (h, input) = (0.01, binary(3000, 20, 22));
    let late = [&[0.0; 4], &input[..2996]].concat();
    let clean = modes(&residues(&[72.0], &[pair(6.0, 0.2)]), &late, h, InterSample::Hold);
    let output = plus(&clean, &coloured(3000, 0.5, 0.02, 23));
    let list = select_srivc(&[record(&input, &output)], 3, 5, 1.0 / h, InterSample::Hold).unwrap();
    assert_eq!(list[0].fit.orders, SrivcOrders { zeros: 0, poles: 2, delay: 4 });
}

#[test]
fn bad_data_are_typed_errors() {
    let (input, output) = (binary(50, 3, 1), vec![1.0; 50]);
    let records = [record(&input, &output)];
    let none = PolynomialOrders::output_error(0, 1, 0);
    assert_eq!(fit_polynomial(&records, none), Err(DynamicsError::NoInputCoefficients));
    let large = PolynomialOrders::output_error(30, 30, 0);
    assert!(matches!(fit_polynomial(&records, large), Err(DynamicsError::TooFewSamples { .. })));
    let hole = [record(&input, &[f64::NAN; 50])];
    let orders = PolynomialOrders::output_error(1, 1, 0);
    assert!(matches!(fit_polynomial(&hole, orders), Err(DynamicsError::InputNotFinite { .. })));
    let short = [record(&input, &output[..40])];
    assert!(matches!(fit_polynomial(&short, orders), Err(DynamicsError::Length { .. })));
    let silent = [record(&[0.0; 50], &output)];
    assert!(fit_polynomial(&silent, orders).is_err());
    let of = |zeros, poles| SrivcOrders { zeros, poles, delay: 0 };
    for (records, orders, rate) in [
        (&records, of(2, 2), 100.0),
        (&records, of(0, 0), 100.0),
        (&records, of(0, 99), 100.0),
        (&records, of(1, 2), 0.0),
        (&hole, of(1, 2), 100.0),
        (&silent, of(1, 2), 100.0),
    ] {
        assert!(fit_srivc(records, orders, rate, InterSample::Hold).is_err(), "{orders:?}");
    }
}
