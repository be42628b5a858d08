use hysteron_model::record::RecordError;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::super::Core;
use super::*;
use crate::IdentifyError;
use hysteron_model::dynamics::{Term, TransferFunction};

fn sampled(tf: &TransferFunction, delay: f64, frequency_hz: Vec<f64>) -> FrequencyResponse {
    let values = tf.frequency_response(&frequency_hz, delay);
    FrequencyResponse::new("exact", frequency_hz, values).unwrap()
}

fn spaced(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| low * (high / low).powf(k as f64 / (count - 1) as f64)).collect()
}

fn near(fit: &ResponseFit, name: &str, expected: f64, relative: f64) {
    let value = fit.value(name);
    assert!((value / expected - 1.0).abs() < relative, "{name}: {value} instead of {expected}");
}

/// Two independent standard normal numbers (Box and Muller).
fn normal(random: &mut Xoshiro256PlusPlus) -> Complex64 {
    let (a, b): (f64, f64) = (random.random(), random.random());
    Complex64::from_polar((-2.0 * (1.0 - a).ln()).sqrt(), TAU * b)
}

#[test]
fn the_articles_stage_is_recovered_with_its_delay() {
    let response = sampled(&TransferFunction::article_eq13(), 2e-4, spaced(1.0, 2000.0, 150));
    let structure = Structure::of(Core::FractionalOscillator).with_delay();
    let fit = fit_structure(&response, &structure, Weighting::Relative).unwrap();
    near(&fit, "order2", 2.0384, 1e-6);
    near(&fit, "order1", 1.0523, 1e-6);
    near(&fit, "delay", 2e-4, 1e-6);
    let omega = 5.4955e6f64.powf(1.0 / 2.0384);
    near(&fit, "natural_frequency", omega / TAU, 1e-6);
    near(&fit, "gain", 5.2589 / 5.4955, 1e-6);
    let (tf, delay) = fit.to_transfer_function(&response).unwrap();
    let expected = TransferFunction::article_eq13();
    for (found, expected) in tf.denominator.iter().zip(&expected.denominator) {
        assert!((found.coefficient / expected.coefficient - 1.0).abs() < 1e-5, "{tf}");
    }
    assert!((delay / 2e-4 - 1.0).abs() < 1e-6);
}

#[test]
fn power_law_and_loss_angle_are_told_apart() {
    let frequency_hz = spaced(1.0, 30.0, 20);
    let values = frequency_hz
        .iter()
        .map(|f| Complex64::from_polar(0.13 * (TAU * f).powf(-0.036), -0.03 - 0.036 * TAU / 4.0))
        .collect();
    let response = FrequencyResponse::new("lossy", frequency_hz, values).unwrap();
    let fit = fit_structure(&response, &Structure::LOSS_ANGLE, Weighting::Relative).unwrap();
    near(&fit, "exponent", 0.036, 1e-9);
    near(&fit, "loss_angle", 0.03, 1e-9);
    near(&fit, "gain", 0.13, 1e-9);
    assert!(fit.relative_rms < 1e-10);
    assert!(matches!(fit.to_transfer_function(&response), Err(IdentifyError::NoTransferFunction { .. })));
    let plain = fit_structure(&response, &Structure::POWER_LAW, Weighting::Relative).unwrap();
    assert!(plain.relative_rms > 1e-3);
}

#[test]
fn modes_behind_a_power_law_and_a_delay_are_recovered() {
    let structure = Structure::of(Core::Modes { count: 2 }).with_power_law().with_delay();
    let x = [380.0, 0.02, 665.0, 0.04, 0.05, 1.2e-4];
    let c = [0.02, 0.03, 0.1];
    let frequency_hz = spaced(1.0, 1500.0, 200);
    let values = frequency_hz
        .iter()
        .map(|f| {
            let mut functions = vec![Complex64::ZERO; 3];
            structure.evaluate(TAU * f, &x, &mut functions, &mut [Complex64::ZERO; 18]);
            functions.iter().zip(c).map(|(f, c)| f * c).sum()
        })
        .collect();
    let response = FrequencyResponse::new("modes", frequency_hz, values).unwrap();
    let fit = fit_structure(&response, &structure, Weighting::Relative).unwrap();
    for (parameter, expected) in fit.parameters.iter().zip(x.iter().chain(&c)) {
        assert!((parameter.value / expected - 1.0).abs() < 1e-6, "{parameter:?} {expected}");
    }
    assert!(fit.agreeing >= 1 && fit.relative_rms < 1e-8);
    // to_transfer_function itself checks that the polynomials agree with the partial fractions.
    let (tf, _) = fit.to_transfer_function(&response).unwrap();
    assert_eq!((tf.numerator.len(), tf.denominator.len()), (5, 5));
    assert!((tf.denominator[0].order - 0.05).abs() < 1e-8);
}

#[test]
fn standard_errors_are_the_scatter_of_two_hundred_noisy_responses() {
    let tf = TransferFunction::new(
        vec![Term::new(2.0, 0.0)],
        vec![Term::new(1.0, 0.0), Term::new(TAU.powi(-1) / 20.0, 0.8)],
    )
    .unwrap();
    let exact = sampled(&tf, 0.0, spaced(1.0, 300.0, 120));
    let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
    for known in [false, true] {
        let (mut values, mut errors) = (vec![Vec::new(); 3], vec![0.0; 3]);
        let draws = 200;
        for _ in 0..draws {
            let mut noisy = exact.clone();
            // Relative noise for relative weights; of constant size for known uncertainties.
            let size = |g: &Complex64| if known { 0.02 } else { 0.02 * g.norm() };
            for value in &mut noisy.values {
                *value += normal(&mut random) * (size(value) / 2f64.sqrt());
            }
            noisy.std_dev = known.then(|| vec![0.02; noisy.len()]);
            let fit = fit_structure(&noisy, &Structure::FRACTIONAL_LAG, Weighting::of(&noisy)).unwrap();
            for (i, p) in fit.parameters.iter().enumerate() {
                values[i].push(p.value);
                errors[i] += p.std_error.unwrap() / f64::from(draws);
            }
        }
        for (list, error) in values.iter().zip(errors) {
            let mean = list.iter().sum::<f64>() / list.len() as f64;
            let square: f64 = list.iter().map(|v| (v - mean).powi(2)).sum();
            let scatter = (square / (list.len() - 1) as f64).sqrt();
            println!("known {known}: scatter {scatter:.3e}, standard error {error:.3e}");
            assert!((error / scatter - 1.0).abs() < 0.15, "{error} {scatter}");
        }
    }
}

#[test]
fn errors_reach_the_numbers_of_a_model_file() {
    // K/(1 + (s/ω)^α) with some noise: c₀ = ω^α, b = K c₀.
    let omega = TAU * 7.0;
    let term = |c: f64, order: f64| Term::new(c, order);
    let c0 = omega.powf(0.8);
    let tf = TransferFunction::new(vec![term(3.0 * c0, 0.0)], vec![term(c0, 0.0), term(1.0, 0.8)]).unwrap();
    let mut response = sampled(&tf, 0.0, spaced(1.0, 100.0, 60));
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    response.values.iter_mut().for_each(|g| *g += 0.01 * normal(&mut random));
    let fit = fit_structure(&response, &Structure::FRACTIONAL_LAG, Weighting::Relative).unwrap();
    let (names, covariance) = fit.covariance_of_numbers().unwrap();
    let variance = |name: &str| {
        let i = names.iter().position(|n| n == name).unwrap();
        covariance[(i, i)]
    };
    // By hand: d ln c₀ = α df/f + ln(2πf) dα, and d ln b = d ln c₀ + dK/K.
    let (f, alpha, k) = (fit.value("corner_frequency"), fit.value("order"), fit.value("gain"));
    let moves = [alpha / f, (TAU * f).ln(), 1.0 / k];
    let relative = |upto: usize| -> f64 {
        let c = &fit.covariance;
        (0..upto).map(|i| (0..upto).map(|j| moves[i] * c[(i, j)] * moves[j]).sum::<f64>()).sum()
    };
    let stiffness = (TAU * f).powf(alpha);
    for (name, expected) in [
        ("denominator[0].coefficient", relative(2) * stiffness * stiffness),
        ("numerator[0].coefficient", relative(3) * (k * stiffness).powi(2)),
        ("denominator[1].order", fit.covariance[(1, 1)]),
        ("denominator[1].coefficient", 0.0),
        ("delay", 0.0),
    ] {
        assert!(
            (variance(name) - expected).abs() <= 1e-5 * expected,
            "{name}: {} {expected}",
            variance(name)
        );
    }
}

#[test]
fn what_cannot_be_fitted_is_refused_and_an_edge_is_told() {
    let response = sampled(&TransferFunction::article_eq13(), 0.0, vec![1.0]);
    let refused = fit_structure(&response, &Structure::FRACTIONAL_LAG, Weighting::Relative);
    assert!(matches!(refused, Err(IdentifyError::TooFewPoints { need: 2, found: 1, .. })));
    let mut zero = sampled(&TransferFunction::article_eq13(), 0.0, spaced(1.0, 9.0, 9));
    zero.values[4] = Complex64::ZERO;
    let refused = fit_structure(&zero, &Structure::POWER_LAW, Weighting::Relative);
    assert!(matches!(refused, Err(IdentifyError::Record(RecordError::ResponseValue { .. }))));
    // A response with phase lead has no delay: it ends at the bound 0, without a standard error.
    let lead = |f: &f64| Complex64::from_polar(1.0, 1e-3 * f);
    let frequency_hz = spaced(1.0, 100.0, 30);
    let values = frequency_hz.iter().map(lead).collect();
    let leading = FrequencyResponse::new("lead", frequency_hz, values).unwrap();
    let fit =
        fit_structure(&leading, &Structure::of(Core::Constant).with_delay(), Weighting::Relative).unwrap();
    let delay = fit.parameter("delay").unwrap();
    assert!(delay.on_edge && delay.std_error.is_none() && delay.value == 0.0, "{delay:?}");
    assert!(fit.parameter("gain").unwrap().std_error.is_some());
}
