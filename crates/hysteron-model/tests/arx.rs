//! Promise: an ARX model is recovered from its own data, simulated from rest, and its orders are found.

#![allow(clippy::unwrap_used)]

use hysteron_model::dynamics::arx::{ArxOrders, ArxRecord, ArxSearch, OrderCriterion, fit, select_orders};
use hysteron_model::dynamics::{Arx, DynamicsError};
use hysteron_model::{LinearStart, Start};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

fn truth() -> Arx {
    Arx { a: vec![-1.5, 0.7], b: vec![0.0, 0.0, 0.3, 0.2] }
}

fn noise(count: usize, seed: u64) -> Vec<f64> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    (0..count).map(|_| random.random_range(-1.0..1.0)).collect()
}

fn simulate(model: &Arx, input: &[f64], initial: LinearStart) -> Vec<f64> {
    let mut output = vec![0.0; input.len()];
    model.simulate(input, initial, &mut output).unwrap();
    output
}

#[test]
fn the_difference_equation_is_what_is_written() {
    let y = simulate(&truth(), &[1.0, 0.0, 0.0, 0.0, 0.0], Start::ZERO);
    // By hand: y₂ = 0.3; y₃ = 1.5·0.3 + 0.2; y₄ = 1.5·0.65 − 0.7·0.3.
    for (found, expected) in y.iter().zip([0.0, 0.0, 0.3, 0.65, 0.765]) {
        assert!((found - expected).abs() < 1e-15);
    }
    let rest = simulate(&truth(), &[4.0; 6], Start::AsIdentified);
    assert!(rest.iter().all(|y| (y - 4.0 * 0.5 / 0.2).abs() < 1e-13));
    // At rest at 3, of gain 2.5, and a step by 1 from there.
    let moved = simulate(&truth(), &[4.0; 5], Start::Rest { voltage_v: 3.0 });
    let step = simulate(&truth(), &[1.0; 5], Start::ZERO);
    assert!(moved.iter().zip(&step).all(|(y, step)| (y - 3.0 * 2.5 - step).abs() < 1e-13));
    let refused = truth().simulate(&[1.0; 5], Start::settled(4), &mut [0.0; 5]);
    assert_eq!(refused, Err(DynamicsError::Length { what: "period", expected: 5, found: 4 }));
    let period = noise(30, 1);
    let repeated: Vec<f64> = period.iter().cycle().take(300).copied().collect();
    let settled = simulate(&truth(), &repeated, Start::ZERO);
    let steady = simulate(&truth(), &period, Start::PERIODIC);
    assert!(settled[270..].iter().zip(&steady).all(|(a, b)| (a - b).abs() < 1e-12));
}

#[test]
fn its_own_data_return_the_coefficients_and_offsets() {
    let inputs = [noise(400, 2), noise(300, 3)];
    let outputs: Vec<Vec<f64>> = inputs
        .iter()
        .zip([2.0, -7.0])
        .map(|(v, offset)| simulate(&truth(), v, Start::AsIdentified).iter().map(|y| y + offset).collect())
        .collect();
    let records: Vec<ArxRecord> =
        inputs.iter().zip(&outputs).map(|(input, output)| ArxRecord { input, output, valid: None }).collect();
    let fit = fit(&records, ArxOrders { na: 2, nb: 2, nk: 2 }).unwrap();
    let flat = |model: &Arx| [model.a.clone(), model.b.clone()].concat();
    for (found, expected) in flat(&fit.model).iter().zip(flat(&truth())) {
        assert!((found - expected).abs() < 1e-11, "{fit:?}");
    }
    assert!((fit.offsets[0] - 2.0).abs() < 1e-10 && (fit.offsets[1] + 7.0).abs() < 1e-10);
    assert!(fit.prediction_rmse < 1e-12);
    let predicted =
        fit.model.predict(&inputs[0], &simulate(&truth(), &inputs[0], Start::AsIdentified)).unwrap();
    let simulated = simulate(&truth(), &inputs[0], Start::AsIdentified);
    assert!(predicted[4..].iter().zip(&simulated[4..]).all(|(a, b)| (a - b).abs() < 1e-10));
}

#[test]
fn standard_errors_cover_the_truth_under_equation_noise() {
    let (input, error) = (noise(5_000, 4), noise(5_000, 5));
    let mut output = vec![0.0; 5_000];
    for k in 3..5_000 {
        output[k] = 1.5 * output[k - 1] - 0.7 * output[k - 2]
            + 0.3 * input[k - 2]
            + 0.2 * input[k - 3]
            + 0.05 * error[k];
    }
    let record = ArxRecord { input: &input, output: &output, valid: None };
    let fit = fit(&[record], ArxOrders { na: 2, nb: 2, nk: 2 }).unwrap();
    let truth = truth();
    let pairs = fit.model.a.iter().zip(&truth.a).zip(&fit.a_std_error).map(|((a, b), s)| (a - b, *s));
    for (error, std_error) in pairs {
        assert!(std_error > 0.0 && error.abs() < 4.0 * std_error, "{error} {std_error}");
    }
    // Uniform on ±0.05 has this standard deviation.
    assert!((fit.prediction_rmse / (0.05 / 3f64.sqrt()) - 1.0).abs() < 0.03);
}

#[test]
fn every_criterion_finds_the_orders() {
    let (input, error) = (noise(3_000, 6), noise(3_000, 7));
    let mut output = vec![0.0; 3_000];
    for k in 3..3_000 {
        output[k] = 1.5 * output[k - 1] - 0.7 * output[k - 2]
            + 0.3 * input[k - 2]
            + 0.2 * input[k - 3]
            + 0.01 * error[k];
    }
    let records = [ArxRecord { input: &input, output: &output, valid: None }];
    let best = |criterion| {
        let search = ArxSearch { max_na: 3, max_nb: 3, max_nk: 3, criterion };
        select_orders(&records, &search).unwrap().swap_remove(0)
    };
    assert_eq!(best(OrderCriterion::Bic).orders, ArxOrders { na: 2, nb: 2, nk: 2 });
    // The other two do not punish superfluous coefficients as hard, but cannot do without the needed ones.
    for criterion in [OrderCriterion::Aic, OrderCriterion::SimulatedError] {
        let found = best(criterion);
        assert!(found.stable && found.orders.na >= 2 && found.orders.nk <= 2, "{found:?}");
        assert!(found.orders.nk + found.orders.nb >= 4, "{found:?}");
    }
}

#[test]
fn bad_data_are_typed_errors() {
    let (input, output) = (vec![1.0; 50], vec![2.0; 50]);
    let record = ArxRecord { input: &input, output: &output, valid: None };
    let orders = ArxOrders { na: 1, nb: 1, nk: 0 };
    assert!(matches!(fit(&[record], orders), Err(DynamicsError::Dependent { .. })));
    let none = ArxOrders { na: 1, nb: 0, nk: 0 };
    assert_eq!(fit(&[record], none), Err(DynamicsError::NoInputCoefficients));
    let large = ArxOrders { na: 30, nb: 30, nk: 0 };
    assert!(matches!(fit(&[record], large), Err(DynamicsError::TooFewSamples { .. })));
    let hole = ArxRecord { input: &input, output: &[f64::NAN; 50], valid: None };
    assert!(matches!(fit(&[hole], orders), Err(DynamicsError::InputNotFinite { .. })));
    let integrator = Arx { a: vec![-1.0], b: vec![1.0] };
    let result = integrator.simulate(&input, Start::AsIdentified, &mut vec![0.0; 50]);
    assert!(matches!(result, Err(DynamicsError::InfiniteDcGain { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Built from its poles, a denominator is stable exactly if all of them are inside.
    #[test]
    fn the_stability_verdict_is_that_of_the_poles(
        radius in prop::collection::vec(0.0f64..1.5, 2),
        angle in 0.0f64..3.1,
        real in -1.5f64..1.5,
    ) {
        let inside = radius[0] < 1.0 && real.abs() < 1.0 && radius[1] < 1.0;
        prop_assume!([radius[0], radius[1], real.abs()].iter().all(|r| (r - 1.0).abs() > 1e-6));
        // (1 − 2 r cos θ q + r² q²)(1 − p q)(1 − radius₁ q)
        let product = [
            vec![1.0, -2.0 * radius[0] * angle.cos(), radius[0] * radius[0]],
            vec![1.0, -real],
            vec![1.0, -radius[1]],
        ]
        .iter()
        .fold(vec![1.0], |product: Vec<f64>, factor| {
            let mut next = vec![0.0; product.len() + factor.len() - 1];
            for (i, p) in product.iter().enumerate() {
                for (j, f) in factor.iter().enumerate() {
                    next[i + j] += p * f;
                }
            }
            next
        });
        let model = Arx { a: product[1..].to_vec(), b: vec![1.0] };
        prop_assert_eq!(model.is_stable(), inside);
    }
}
