//! Promise: a model whose device changes is followed to near the noise, a jump is found within the stated
//! delay and nothing is found where nothing changes.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test may fail
use hysteron_identify::IdentifyError;
use hysteron_identify::online::{Adapter, Correction, Estimator, Regressors, Row, Term};
use hysteron_model::Start;
use hysteron_model::dynamics::{Dynamics, Scheme, Term as Power, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::record::{InputOutput, InterSample, TimeBase};
use hysteron_rig::excitation::Excitation;
use hysteron_rig::{BoucWenFractional, Plant, PowerTerm, Truth, measure};
use hysteron_rt::{
    FitMonitor, Misfit, MonitorSettings, Nlms, NlmsSettings, ParameterError, Rls, RlsSettings, SampleError,
    Unexcited,
};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

const RATE_HZ: f64 = 1000.0;
/// Standard deviation of the sensor's noise \[µm\].
const NOISE_UM: f64 = 0.02;
const REST: Start = Start::Rest { voltage_v: 0.0 };
/// c₀, c₁, order₁, order₂ of c₀/(s^order₂ + c₁ s^order₁ + c₀).
const DYNAMICS: [f64; 4] = [5.2589e6, 3081.0, 1.0523, 2.0384];

/// The device on the bench: continuous time, no code shared with the model.
fn bench(polynomial: &[f64]) -> Truth {
    let [c0, c1, order1, order2] = DYNAMICS;
    let term = |coefficient, order| PowerTerm { coefficient, order };
    let mut truth = Truth {
        plant: Plant::BoucWenFractional(BoucWenFractional {
            polynomial: polynomial.to_vec(),
            alpha: 1.1,
            beta: 0.35,
            gamma: 0.08,
            n: 1.0,
            numerator: vec![term(c0, 0.0)],
            denominator: vec![term(c0, 0.0), term(c1, order1), term(1.0, order2)],
            delay_s: 2e-4,
        }),
        ..Truth::default()
    };
    truth.sensor.adc = None;
    truth.sensor.noise_um = 0.0;
    truth
}

/// The model of the device as it was when it was identified.
fn model() -> Model {
    let [c0, c1, order1, order2] = DYNAMICS;
    let term = |coefficient, order| Power { coefficient, order };
    let numerator = vec![term(c0, 0.0)];
    let denominator = vec![term(c0, 0.0), term(c1, order1), term(1.0, order2)];
    Model {
        hysteresis: Hysteresis::from(BoucWen::new(vec![3.2, -0.02], 1.1, 0.35, 0.08, 1.0).unwrap()),
        dynamics: Dynamics::Fractional(TransferFunction::new(numerator, denominator).unwrap()),
        offset: 0.0,
        delay_s: 2e-4,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: Some(RATE_HZ),
    }
}

/// 0 … 10 V at 11 Hz, the amplitude going up and down.
fn drive(seconds: f64) -> Vec<f64> {
    let one = |k: usize| {
        let t = k as f64 / RATE_HZ;
        5.0 * (0.7 - 0.3 * (TAU * 0.9 * t).cos()) * (1.0 - (TAU * 11.0 * t).cos())
    };
    (0..(RATE_HZ * seconds) as usize).map(one).collect()
}

/// Standard normal numbers.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    move || {
        let (a, b): (f64, f64) = (rng.random(), rng.random());
        (-2.0 * (1.0 - a).ln()).sqrt() * (TAU * b).cos()
    }
}

fn record(u: &[f64], y: Vec<f64>) -> InputOutput {
    InputOutput::new("online", TimeBase::uniform(RATE_HZ), u.to_vec(), y).unwrap()
}

fn measured(u: &[f64], polynomial: &[f64]) -> Vec<f64> {
    let excitation = Excitation::of_samples("drive".into(), "drive".into(), u.to_vec(), RATE_HZ);
    measure(&bench(polynomial), &excitation, 1, 0).unwrap().y_true_um
}

fn correction() -> Correction<3> {
    Correction::new(model(), [Term::Offset, Term::Gain, Term::Power(2)]).unwrap()
}

fn least_squares(memory: f64) -> Rls<f64, 3> {
    Rls::new(RlsSettings {
        start: correction().nominal(),
        deviations: [0.5, 0.1, 0.05],
        noise: NOISE_UM,
        forgetting: 1.0 - 1.0 / memory,
        unexcited: Unexcited::Hold,
        bounds: None,
    })
    .unwrap()
}

fn monitor(run_length: f64) -> FitMonitor<f64> {
    let settings = MonitorSettings { shift: Some(0.5), spread: Some(1.5), run_length, fewest: 3 };
    FitMonitor::new(settings).unwrap()
}

fn rms(errors: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = errors.fold((0.0, 0.0), |(sum, count), e| (sum + e * e, count + 1.0));
    f64::sqrt(sum / count)
}

#[test]
fn a_device_whose_gain_drifts_and_whose_polynomial_bends_is_followed_near_the_noise() {
    let u = drive(60.0);
    let (before, after) = (measured(&u, &[3.2, -0.02]), measured(&u, &[3.2, -0.01]));
    let mut normal = noise(1);
    let last = u.len() as f64;
    let truth: Vec<f64> = (0..u.len())
        .map(|k| {
            let s = k as f64 / last;
            (1.0 + 0.1 * s) * ((1.0 - s) * before[k] + s * after[k])
        })
        .collect();
    let y: Vec<f64> = truth.iter().map(|y| y + NOISE_UM * normal()).collect();
    let regressors = correction().regressors(&u, Some(RATE_HZ), &REST).unwrap();

    let mut rls = Adapter::new(Estimator::LeastSquares(least_squares(250.0)), monitor(1e6), false);
    let followed = rls.run(&regressors, &record(&u, y.clone())).unwrap();
    let settings = NlmsSettings {
        start: correction().nominal(),
        deviations: [0.5, 0.1, 0.05],
        step: 0.05,
        regulariser: NOISE_UM * NOISE_UM,
        bounds: None,
    };
    let nlms = Nlms::new(settings).unwrap();
    let mut nlms =
        Adapter::new(Estimator::Gradient { nlms, deviation_um: 2.0 * NOISE_UM }, monitor(1e6), false);
    let gradient = nlms.run(&regressors, &record(&u, y.clone())).unwrap();

    let tail = u.len() - 5000;
    let error = |predicted: &[f64]| rms((tail..u.len()).map(|k| predicted[k] - y[k]));
    let fixed = model().simulate(&u, Some(RATE_HZ), &REST).unwrap();
    let corrected = correction().corrected(followed.parameters.last().unwrap()).unwrap();
    let corrected = corrected.simulate(&u, Some(RATE_HZ), &REST).unwrap();
    println!(
        "last 5 s, RMSE [µm]: noise {NOISE_UM}, model as it was {:.4}, least squares {:.4}, gradient {:.4}, \
         corrected model over the last 1 s {:.4}; parameters {:?}",
        error(&fixed),
        error(&followed.predicted),
        error(&gradient.predicted),
        rms((u.len() - 1000..u.len()).map(|k| corrected[k] - y[k])),
        rls.parameters(),
    );
    assert!(error(&fixed) > 50.0 * NOISE_UM);
    assert!(error(&followed.predicted) < 1.2 * NOISE_UM);
    assert!(error(&gradient.predicted) < 2.0 * NOISE_UM);
    // Simulated from rest, with the coefficients of the last sample.
    assert!(rms((u.len() - 1000..u.len()).map(|k| corrected[k] - y[k])) < 2.0 * NOISE_UM);
    // Gain 1.1, bend 1.1·0.01 at the end, less what forgetting lags: 250 samples of the drift.
    let [_, gain, bend] = *rls.parameters();
    assert!((gain - 1.1).abs() < 3e-3, "{gain}");
    assert!((bend - 0.011).abs() < 5e-4, "{bend}");
    // So fast a drift is seen: the gain rises, forgetting lags, the output lies above.
    assert!(!followed.alarms.is_empty() && followed.alarms.iter().all(|alarm| alarm.misfit == Misfit::Above));
}

#[test]
fn a_slow_drift_is_followed_without_an_alarm() {
    // A tenth of that: 1 % a minute.
    let u = drive(60.0);
    let mut normal = noise(5);
    let truth = measured(&u, &[3.2, -0.02]);
    let y: Vec<f64> = (0..u.len())
        .map(|k| (1.0 + 0.01 * k as f64 / u.len() as f64) * truth[k] + NOISE_UM * normal())
        .collect();
    let regressors = correction().regressors(&u, Some(RATE_HZ), &REST).unwrap();
    let mut adapter = Adapter::new(Estimator::LeastSquares(least_squares(250.0)), monitor(1e6), false);
    let trace = adapter.run(&regressors, &record(&u, y.clone())).unwrap();
    assert_eq!(trace.alarms, []);
    let error = rms((5000..u.len()).map(|k| trace.predicted[k] - y[k]));
    println!("1 % a minute: RMSE {error:.4} µm, noise {NOISE_UM}");
    assert!(error < 1.05 * NOISE_UM, "{error}");
}

#[test]
fn a_jump_of_the_gain_is_found_within_the_stated_delay_and_nothing_before() {
    let u = drive(40.0);
    let clean = measured(&u, &[3.2, -0.02]);
    let regressors = correction().regressors(&u, Some(RATE_HZ), &REST).unwrap();
    let delay = monitor(1e6).delay(Misfit::Spread).unwrap();
    let mut normal = noise(2);
    // Just before a crest, so that the jump is seen at once: 8 … 20 µm.
    for (jump, at) in [(1.05, 30_020), (0.997, 25_020), (1.003, 35_020)] {
        let after = |k: usize| if k < at { 1.0 } else { jump };
        let y: Vec<f64> = (0..u.len()).map(|k| after(k) * clean[k] + NOISE_UM * normal()).collect();
        let mut adapter = Adapter::new(Estimator::LeastSquares(least_squares(2000.0)), monitor(1e6), true);
        let trace = adapter.run(&regressors, &record(&u, y.clone())).unwrap();
        let found = trace.alarms.first().unwrap();
        println!(
            "jump to {jump} at {at}: found after {}, stated {delay:.0}, {} alarms",
            found.sample - at,
            trace.alarms.len()
        );
        assert!(found.sample >= at && ((found.sample - at) as f64) < delay, "{found:?}");
        // Reopened, it is near the noise again after a period (91 samples).
        let settled = found.sample + 91..found.sample + 2091;
        let error = rms(settled.clone().map(|k| trace.predicted[k] - y[k]));
        assert!(error < 1.2 * NOISE_UM, "{error}");
        assert!(trace.alarms.iter().all(|alarm| alarm.sample < settled.start));
        assert!((adapter.parameters()[1] - jump).abs() < 1e-3);
    }
}

#[test]
fn over_a_long_run_without_change_false_alarms_are_rarer_than_stated() {
    let u = drive(10.0);
    let regressors = correction().regressors(&u, Some(RATE_HZ), &REST).unwrap();
    let rows: Vec<Row<3>> = regressors.rows().collect();
    let (run_length, samples) = (1000.0, 1_000_000);
    let mut adapter = Adapter::new(Estimator::LeastSquares(least_squares(2000.0)), monitor(run_length), true);
    let mut normal = noise(3);
    let mut alarms = 0;
    for k in 0..samples {
        let row = &rows[k % rows.len()];
        let y = row.output(&[0.1, 1.02, 0.003]) + NOISE_UM * normal();
        alarms += usize::from(adapter.step(row, y).unwrap().misfit.is_some());
    }
    println!("{alarms} false alarms in {samples} samples, stated at most {}", samples as f64 / run_length);
    // Some, so that the test is one; fewer than stated.
    assert!(alarms > 0 && (alarms as f64) < samples as f64 / run_length);
}

#[test]
fn regressors_are_exact_changes_of_the_model() {
    let u = drive(1.0);
    let base = Model { offset: -3.0, ..model() };
    let terms = [Term::Offset, Term::Gain, Term::Power(1), Term::Power(3)];
    let correction = Correction::new(base.clone(), terms).unwrap();
    for start in [REST, Start::Rest { voltage_v: 4.0 }, Start::settled(91)] {
        let regressors = correction.regressors(&u, Some(RATE_HZ), &start).unwrap();
        for parameters in [correction.nominal(), [2.0, 1.3, 0.4, -0.002]] {
            let model = correction.corrected(&parameters).unwrap();
            let want = model.simulate(&u, Some(RATE_HZ), &start).unwrap();
            for (row, want) in regressors.rows().zip(want) {
                assert!((row.output(&parameters) - want).abs() < 1e-9);
            }
        }
    }
    assert_eq!(correction.corrected(&correction.nominal()).unwrap().offset, -3.0);
    // Terms left out stay as they are in the model.
    let none = Correction::new(base.clone(), []).unwrap().regressors(&u, Some(RATE_HZ), &REST).unwrap();
    let want = base.simulate(&u, Some(RATE_HZ), &REST).unwrap();
    assert!(none.rows().zip(want).all(|(row, want)| (row.output(&[]) - want).abs() < 1e-12));
}

#[test]
fn regressors_do_not_look_ahead() {
    let u = drive(2.0);
    let terms = [Term::Gain, Term::Power(2), Term::Creep { lag_s: 0.3 }];
    let correction = Correction::new(model(), terms).unwrap();
    let whole = correction.regressors(&u, Some(RATE_HZ), &REST).unwrap();
    let part = correction.regressors(&u[..700], Some(RATE_HZ), &REST).unwrap();
    for (a, b) in whole.rows().zip(part.rows()) {
        for (a, b) in a.regressors.iter().zip(b.regressors) {
            assert!((a - b).abs() < 1e-7, "{a} {b}");
        }
    }
}

#[test]
fn a_creep_column_is_the_first_order_lag_of_the_model() {
    // A static straight line: w = 3t, x = 3(t − τ(1 − e^(−t/τ))) from rest.
    let line = Model {
        hysteresis: Hysteresis::from(BoucWen::new(vec![1.0], 0.0, 1.0, 0.0, 1.0).unwrap()),
        dynamics: Dynamics::None,
        delay_s: 0.0,
        ..model()
    };
    let u: Vec<f64> = (0..5000).map(|k| 3.0 * k as f64 / RATE_HZ).collect();
    for lag_s in [0.02, 1.0, 500.0] {
        let correction = Correction::new(line.clone(), [Term::Creep { lag_s }]).unwrap();
        let regressors = correction.regressors(&u, Some(RATE_HZ), &REST).unwrap();
        for (k, row) in regressors.rows().enumerate() {
            let t = k as f64 / RATE_HZ;
            let want = 3.0 * (t + lag_s * (-t / lag_s).exp_m1());
            assert!((row.regressors[0] - want).abs() < 1e-9, "{} {want}", row.regressors[0]);
        }
        assert!(matches!(correction.regressors(&u, None, &REST), Err(IdentifyError::CorrectionNoRate)));
        assert!(matches!(correction.corrected(&[0.1]), Err(IdentifyError::CorrectionCreep { index: 0, .. })));
        assert_eq!(correction.corrected(&[0.0]).unwrap(), line);
    }
}

#[test]
fn creep_coefficients_are_found() {
    let terms = [Term::Gain, Term::Creep { lag_s: 0.1 }, Term::Creep { lag_s: 1.0 }];
    let correction = Correction::new(model(), terms).unwrap();
    // Steps of the mean, so that creep shows.
    let u: Vec<f64> =
        drive(20.0).iter().enumerate().map(|(k, u)| 0.5 * u + 4.0 * (k / 2500 % 2) as f64).collect();
    let regressors = correction.regressors(&u, Some(RATE_HZ), &REST).unwrap();
    let truth = [0.98, 0.03, 0.02];
    let mut normal = noise(4);
    let y = regressors.rows().map(|row| row.output(&truth) + NOISE_UM * normal()).collect();
    let rls = Rls::new(RlsSettings {
        start: correction.nominal(),
        deviations: [0.1, 0.1, 0.1],
        noise: NOISE_UM,
        forgetting: 1.0,
        unexcited: Unexcited::Hold,
        bounds: Some([(0.5, 1.5), (0.0, 1.0), (0.0, 1.0)]),
    })
    .unwrap();
    let mut adapter = Adapter::new(Estimator::LeastSquares(rls), monitor(1e6), false);
    let trace = adapter.run(&regressors, &record(&u, y)).unwrap();
    assert_eq!(trace.alarms, []);
    let Estimator::LeastSquares(rls) = adapter.estimator() else { unreachable!() };
    for (i, truth) in truth.iter().enumerate() {
        let std_error = rls.covariance(i).unwrap()[i].sqrt();
        assert!(std_error < 1e-3 && (rls.parameters()[i] - truth).abs() < 4.0 * std_error);
    }
}

#[test]
fn invalid_samples_are_predicted_and_not_learnt_from() {
    let u = drive(1.0);
    let regressors = correction().regressors(&u, Some(RATE_HZ), &REST).unwrap();
    let mut data = record(&u, regressors.rows().map(|row| row.output(&[0.0, 1.05, 0.0])).collect());
    let mut mask = vec![true; u.len()];
    data.y[500..600].fill(1e6);
    mask[500..600].fill(false);
    data.valid = Some(mask);
    let mut adapter = Adapter::new(Estimator::LeastSquares(least_squares(250.0)), monitor(1e6), false);
    let trace = adapter.run(&regressors, &data).unwrap();
    assert_eq!(trace.parameters[599], trace.parameters[499]);
    assert!((adapter.parameters()[1] - 1.05).abs() < 1e-3);
}

#[test]
fn what_cannot_be_is_refused() {
    let new = |term| Correction::new(model(), [Term::Gain, term]);
    for term in [Term::Power(0), Term::Power(21), Term::Creep { lag_s: 0.0 }, Term::Creep { lag_s: f64::NAN }]
    {
        assert!(matches!(new(term), Err(IdentifyError::CorrectionTerm { index: 1, .. })));
    }
    assert!(matches!(new(Term::Gain), Err(IdentifyError::CorrectionTwice { index: 1 })));
    let regressors: Regressors<3> = correction().regressors(&drive(0.1), Some(RATE_HZ), &REST).unwrap();
    let mut adapter = Adapter::new(Estimator::LeastSquares(least_squares(250.0)), monitor(1e6), false);
    let short = record(&drive(0.05), vec![0.0; 50]);
    let lengths = adapter.run(&regressors, &short);
    assert!(matches!(lengths, Err(IdentifyError::CorrectionLengths { expected: 100, found: 50 })));
    assert!(correction().regressors(&drive(0.1), None, &REST).is_err());
    assert!(correction().regressors(&[f64::NAN, 0.0], Some(RATE_HZ), &REST).is_err());
    assert!(correction().corrected(&[0.0, f64::NAN, 0.0]).is_err());
    let row = regressors.rows().last().unwrap();
    let before = adapter;
    assert_eq!(adapter.step(&row, f64::NAN), Err(SampleError::NotFinite));
    assert_eq!(adapter, before);
    let settings: IdentifyError = ParameterError::NoChange.into();
    assert!(settings.to_string().contains("looks for nothing"));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(50) })]

    #[test]
    fn a_model_that_is_right_but_for_its_terms_is_found_without_noise(
        offset in -1.0..1.0_f64, gain in 0.8..1.2_f64, bend in -0.05..0.05_f64,
    ) {
        let u = drive(0.5);
        let regressors = correction().regressors(&u, Some(RATE_HZ), &REST).unwrap();
        let truth = [offset, gain, bend];
        let mut adapter = Adapter::new(Estimator::LeastSquares(least_squares(250.0)), monitor(1e6), false);
        for row in regressors.rows() {
            adapter.step(&row, row.output(&truth)).unwrap();
        }
        // What is left of the prior: noise 0.02 µm over 500 samples of ten micrometres.
        for (found, truth) in adapter.parameters().iter().zip(truth) {
            prop_assert!((found - truth).abs() < 1e-3, "{found} {truth}");
        }
    }
}

/// White noise is independent sample by sample; eₖ = ρ eₖ₋₁ + white has 1 + 2 Σ ρᵏ = (1 + ρ)/(1 − ρ) samples
/// to an independent one; neither another gain nor a jump half-way makes that more.
#[test]
fn samples_that_carry_one_independent_one_are_counted() {
    let u = drive(40.0);
    let regressors = correction().regressors(&u, Some(RATE_HZ), &REST).unwrap();
    let nominal = correction().nominal();
    for rho in [0.0, 0.5, 0.9] {
        for jump in [0.0, 0.5] {
            let mut white = noise(5);
            let mut e = 0.0;
            let row_output = regressors.rows().enumerate().map(|(k, row)| {
                e = rho * e + NOISE_UM * white();
                let late = if k > u.len() / 2 { jump } else { 0.0 };
                1.1 * row.output(&nominal) + late + e
            });
            let y = row_output.collect();
            let found = regressors.samples_per_independent_one(&record(&u, y)).unwrap();
            let expected = (1.0 + rho) / (1.0 - rho);
            println!("rho {rho}, jump {jump}: {found:.2}, expected {expected:.2}");
            // A sum of some hundred estimated correlations over 5000 samples.
            assert!((found / expected - 1.0).abs() < 0.15, "rho {rho}, jump {jump}: {found} for {expected}");
        }
    }
}
