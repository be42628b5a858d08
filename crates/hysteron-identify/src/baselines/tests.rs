//! Properties of every baseline.

use hysteron_optimize::Stop;
use std::f64::consts::TAU;

use proptest::prelude::*;

use super::free_run::{Divergence, free_run};
use super::regressors::directions;
use super::*;
use crate::structure::Fold;
use hysteron_model::Start;
use hysteron_model::dynamics::{Dynamics, Scheme};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{ArticleOperator, Hysteresis};
use hysteron_model::record::{InterSample, TimeBase};

const RATE_HZ: f64 = 400.0;
const NOISE_UM: f64 = 0.01;

/// A hysteresis loop: rate-independent, so that a polynomial can approximate it and no linear model can.
fn device() -> Model {
    Model {
        hysteresis: Hysteresis::from(ArticleOperator::new(vec![3.0, -0.08], 0.9, 0.9, 0.3, 1.0).unwrap()),
        dynamics: Dynamics::None,
        offset: 1.0,
        delay_s: 0.0,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    }
}

fn measured(name: &str, seconds: f64, drive: impl Fn(f64) -> f64) -> InputOutput {
    let u: Vec<f64> = (0..(seconds * RATE_HZ) as usize).map(|k| drive(k as f64 / RATE_HZ)).collect();
    let mut y = device().simulate(&u, Some(RATE_HZ), &Start::Rest { voltage_v: 0.0 }).unwrap();
    // Reproducible noise, uniform: a linear congruential generator (Knuth's MMIX constants).
    let mut state = 1 + name.len() as u64;
    for y in &mut y {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *y += NOISE_UM * 12f64.sqrt() * ((state >> 11) as f64 / (1u64 << 53) as f64 - 0.5);
    }
    InputOutput::new(name, TimeBase::uniform(RATE_HZ), u, y).unwrap()
}

fn sine(name: &str, amplitude: f64, f: f64, seconds: f64) -> InputOutput {
    measured(name, seconds, move |t| amplitude * (1.0 - (TAU * f * t).cos()))
}

fn records() -> Vec<InputOutput> {
    vec![sine("slow", 2.5, 2.0, 1.5), sine("half", 1.3, 5.0, 1.0), sine("quick", 2.0, 10.0, 1.0)]
}

fn rmse(trained: &Trained, record: &InputOutput) -> f64 {
    let simulated = trained.simulate(record).unwrap();
    let square: f64 = simulated.iter().zip(&record.y).map(|(s, y)| (s - y).powi(2)).sum();
    (square / simulated.len() as f64).sqrt()
}

/// rms error of the regression line: the least of any static linear model.
fn about_the_line(record: &InputOutput) -> f64 {
    let columns = [vec![1.0; record.len()], record.u.clone()];
    let c = kernel_narx::least_squares(&columns, &record.y);
    let square: f64 = record.u.iter().zip(&record.y).map(|(u, y)| (y - c[0] - c[1] * u).powi(2)).sum();
    (square / record.len() as f64).sqrt()
}

#[test]
fn each_follows_an_unseen_loop_far_closer_than_a_line() {
    let unseen = sine("unseen", 1.8, 4.0, 1.0);
    let line = about_the_line(&unseen);
    let intervals = lag_intervals(&records()).unwrap();
    for (kind, share) in [(Baseline::Polynomial, 0.2), (Baseline::Kernel, 0.6), (Baseline::Neural, 0.2)] {
        let trained = train(kind, &records(), &intervals).unwrap();
        let error = rmse(&trained, &unseen);
        println!("{}: {error:.4} µm, line {line:.4} µm, {} parameters", kind.name(), trained.parameters());
        assert!(error < share * line, "{}: {error} {line}", kind.name());
    }
}

#[test]
fn units_change_nothing_but_units() {
    // Powers of two: no rounding, the same choices.
    let other = |r: &InputOutput| {
        let u = r.u.iter().map(|u| u * 1024.0).collect();
        let y = r.y.iter().map(|y| y / 4096.0).collect();
        InputOutput::new(&r.name, TimeBase::uniform(RATE_HZ), u, y).unwrap()
    };
    let intervals = [5.0 / RATE_HZ];
    let unseen = sine("unseen", 1.8, 4.0, 0.5);
    for kind in [Baseline::Polynomial, Baseline::Kernel] {
        let here = train(kind, &records(), &intervals).unwrap();
        let there = train(kind, &records().iter().map(other).collect::<Vec<_>>(), &intervals).unwrap();
        assert_eq!(here.model, there.model, "{}", kind.name());
        let scaled: Vec<f64> = here.simulate(&unseen).unwrap().iter().map(|y| y / 4096.0).collect();
        assert_eq!(there.simulate(&other(&unseen)).unwrap(), scaled);
    }
}

#[test]
fn a_model_that_grows_is_reported_and_not_a_number_is_none() {
    let interval_s = 5.0 / RATE_HZ;
    let mut trained = train(Baseline::Polynomial, &records(), &[interval_s]).unwrap();
    let terms = vec![Monomial(vec![0])];
    for (coefficient, must) in [(2.0, true), (f64::NAN, true), (0.5, false)] {
        let coefficients = vec![coefficient];
        trained.model = TrainedModel::Polynomial(PolynomialNarx { terms: terms.clone(), coefficients });
        let found = trained.simulate(&records()[0]);
        assert_eq!(matches!(found, Err(BaselineError::Diverged { .. })), must, "{coefficient}: {found:?}");
    }
    // y₁ doubles from −1 at the start: beyond 10 at the fourth step, the phase that starts first is reported.
    trained.model = TrainedModel::Polynomial(PolynomialNarx { terms, coefficients: vec![2.0] });
    let past = trained.start_samples(&records()[0]).unwrap() as f64;
    match trained.simulate(&records()[0]).unwrap_err() {
        BaselineError::Diverged { time_s } => {
            let expected = past / RATE_HZ + 3.0 * interval_s;
            assert!((time_s - expected).abs() < 1.5 * interval_s, "{time_s} {expected}");
        }
        other => panic!("{other}"),
    }
}

#[test]
fn records_that_cannot_be_used_are_refused() {
    let intervals = [5.0 / RATE_HZ];
    let refused = |records: &[InputOutput], intervals: &[f64]| {
        train(Baseline::Polynomial, records, intervals).unwrap_err()
    };
    assert_eq!(refused(&[], &intervals), BaselineError::NoRecords);
    assert_eq!(lag_intervals(&[]), Err(BaselineError::NoRecords));
    let mut timeless = records();
    timeless[1].time = TimeBase::Unknown;
    assert!(
        matches!(refused(&timeless, &intervals), BaselineError::NoSampleRate { record } if record == "half")
    );
    assert!(matches!(lag_intervals(&timeless), Err(BaselineError::NoSampleRate { .. })));
    assert!(matches!(refused(&records(), &[1.4 / RATE_HZ]), BaselineError::Interval { .. }));
    let mut flat = vec![records().remove(0)];
    flat[0].y.fill(2.0);
    assert_eq!(refused(&flat, &intervals), BaselineError::Constant { signal: "output" });
    let mut broken = records();
    broken[2].u[7] = f64::NAN;
    assert!(matches!(refused(&broken, &intervals), BaselineError::NotFinite { index: 7, .. }));
    let mut masked = records();
    masked.iter_mut().for_each(|r| *r = r.without_first(r.len() - 10));
    assert!(matches!(refused(&masked, &intervals), BaselineError::TooFewRows { .. }));
}

#[test]
fn what_is_left_out_is_scored_by_what_is_trained_on_the_rest_whatever_the_threads() {
    let mut records = records();
    records.push(sine("again", 2.5, 2.0, 1.2));
    let whole = |r: usize| Fold {
        label: records[r].name.clone(),
        content: String::new(),
        held: vec![(r, std::iter::once(0..records[r].len()).collect())],
        whole: true,
    };
    let part = Fold { held: vec![(0, std::iter::once(100..250).collect())], whole: false, ..whole(0) };
    let folds = [whole(3), part];
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| cross_validate(Baseline::Kernel, &records, &folds, &Stop::new())).unwrap()
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(one.fold_rmse, three.fold_rmse);
    assert_eq!(one.failures, three.failures);
    // An error or the reason why there is none.
    let missing = one.fold_rmse.iter().chain([&one.training_rmse]).filter(|e| e.is_none()).count();
    assert_eq!(one.failures.len(), missing, "{one:?}");
    assert_eq!(one.error().is_some(), one.fold_rmse.iter().all(Option::is_some));
    // The last record is held out: changing its output changes only the error.
    let mut other = records.clone();
    other[3].y.iter_mut().skip(100).for_each(|y| *y *= 2.0);
    let changed = cross_validate(Baseline::Kernel, &other, &folds[..1], &Stop::new()).unwrap();
    let trained = train(Baseline::Kernel, &records[..3], &lag_intervals(&records).unwrap());
    let trained = trained.unwrap();
    let simulated = trained.simulate(&other[3]).unwrap();
    let start = trained.start_samples(&other[3]).unwrap();
    let errors: Vec<f64> = (start..simulated.len()).map(|k| other[3].y[k] - simulated[k]).collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let expected = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / errors.len() as f64).sqrt();
    assert!((changed.fold_rmse[0].unwrap() / expected - 1.0).abs() < 1e-12);
    let stop = Stop::new();
    stop.request();
    assert!(cross_validate(Baseline::Kernel, &records, &folds, &stop).is_none());
}

/// y_k from the definition: lagged samples, binomial coefficients, one product after the other.
fn by_hand(model: &PolynomialNarx, lags: Lags, series: &Series) -> Vec<f64> {
    let choose = |n: usize, k: usize| (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
    let difference = |x: &[f64], k: usize, order: usize| -> f64 {
        (0..=order).map(|i| (-1f64).powi(i as i32) * choose(order, i) * x[k - 1 - i]).sum()
    };
    let mut y = series.y[..lags.past()].to_vec();
    for k in lags.past()..series.y.len() {
        let mut x: Vec<f64> = (0..lags.output).map(|order| difference(&y, k, order)).collect();
        x.extend((0..lags.input).map(|order| difference(&series.u, k, order)));
        x.extend([series.u[k] - series.u[k - 1], series.direction[k]]);
        y.push(
            model
                .terms
                .iter()
                .zip(&model.coefficients)
                .map(|(t, c)| c * t.0.iter().map(|&i| x[i]).product::<f64>())
                .sum(),
        );
    }
    y
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn a_simulation_is_step_after_step_of_the_definition_and_looks_at_no_later_sample(
        output in 1usize..4, input in 1usize..4, seed in 0u32..1000, cut in 5usize..60,
    ) {
        let lags = Lags { output, input };
        let wave = |k: usize, f: f64| (k as f64 * f + f64::from(seed)).sin();
        let u: Vec<f64> = (0..60).map(|k| 0.7 * wave(k, 0.31) + 0.3 * wave(k, 0.83)).collect();
        let y = (0..60).map(|k| wave(k, 0.2)).collect();
        let series = Series { direction: directions(&u, 0.01), u, y, valid: vec![true; 60] };
        let terms = Monomial::all(lags.count(), 2, lags.count() - 1);
        let coefficients = (0..terms.len()).map(|i| 0.05 * wave(i * i, 1.3)).collect();
        let model = PolynomialNarx { terms, coefficients };
        let regressors = Regressors::unscaled(lags);
        let expected = by_hand(&model, lags, &series);
        match free_run(&model, &regressors, &series) {
            Ok(simulated) => {
                for (s, e) in simulated.iter().zip(&expected) {
                    prop_assert!((s - e).abs() < 1e-9 * (1.0 + e.abs()), "{} {}", s, e);
                }
                let first = Series {
                    u: series.u[..cut].to_vec(),
                    y: series.y[..cut].to_vec(),
                    direction: directions(&series.u[..cut], 0.01),
                    valid: vec![true; cut],
                };
                prop_assert_eq!(&free_run(&model, &regressors, &first).unwrap()[..], &simulated[..cut]);
            }
            Err(Divergence(k)) => {
                prop_assert!(expected[k].abs() > 9.9 && expected[..k].iter().all(|e| e.abs() < 10.1));
            }
        }
    }
}
