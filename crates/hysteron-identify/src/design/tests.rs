//! Designs on a model of the class, whose answers are known.

use super::*;
use hysteron_model::Start;
use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::model_file::{Interval, ScoreEntry, ScoreRole, SignalUnits, ValidRange};
use hysteron_model::record::{InputOutput, InterSample, TimeBase};
use hysteron_model::validate::Scoring;
use nalgebra::DMatrix;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Bouc–Wen hysteresis, a resonance at 120 Hz and a delay of 0.4 ms, known to a few percent.
fn file() -> ModelFile {
    let term = |coefficient, order| Term { coefficient, order };
    let (omega, damping) = (TAU * 120.0, 0.05);
    let g = TransferFunction {
        numerator: vec![term(1.0, 0.0)],
        denominator: vec![term(1.0, 0.0), term(2.0 * damping / omega, 1.0), term(omega.powi(-2), 2.0)],
    };
    let model = Model {
        hysteresis: Hysteresis::from(BoucWen::new(vec![2.0, 0.02], -0.6, 0.3, 0.1, 1.0).unwrap()),
        dynamics: Dynamics::Integer(g),
        offset: 0.0,
        delay_s: 4e-4,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Linear,
        sample_rate_hz: Some(2000.0),
    };
    let mut file = ModelFile::from_model(&model, SignalUnits::default());
    let names = ["linear", "quadratic", "alpha", "beta", "gamma"].map(str::to_owned).into_iter();
    let dynamics = ["denominator[1].coefficient", "denominator[2].coefficient", "delay"].map(str::to_owned);
    let names: Vec<String> = names.chain(dynamics).collect();
    let errors = names.iter().map(|name| (0.05 * file.number(name).unwrap().value).powi(2));
    let covariance = DMatrix::from_diagonal(&nalgebra::DVector::from_iterator(names.len(), errors));
    file.set_covariance(&names, &covariance);
    let mut range = ValidRange::of_inputs(&[0.0, 10.0], "V", Some((1.0, 100.0))).with_rate(3000.0);
    range.input = Interval { low: 0.0, high: 10.0, unit: "V".to_owned() };
    file.valid_range = Some(range);
    file
}

fn options(purpose: Purpose) -> DesignOptions {
    DesignOptions { noise: Some(0.01), ..DesignOptions::new(purpose, 0.6) }
}

fn made(purpose: Purpose) -> Design {
    design(&DesignBasis::from(&file()), &options(purpose), Listener::silent()).unwrap()
}

#[test]
fn every_purpose_is_served_better_than_by_loop_and_sweep_within_range_and_slew() {
    for purpose in Purpose::ALL {
        let found = made(purpose);
        assert_eq!(found.drive.len(), 1200);
        assert!(found.drive.iter().all(|u| (0.0..=10.0).contains(u)), "{purpose:?}");
        assert!(found.drive.windows(2).all(|w| (w[1] - w[0]).abs() * 2000.0 <= 3000.0), "{purpose:?}");
        assert!(found.usual.windows(2).all(|w| (w[1] - w[0]).abs() * 2000.0 <= 3000.0), "{purpose:?}");
        let aims: Vec<&Expected> = found.expected.iter().filter(|e| e.aim).collect();
        assert!(!aims.is_empty(), "{purpose:?}");
        let product = |of: &dyn Fn(&Expected) -> f64| aims.iter().map(|e| of(e)).product::<f64>();
        assert!(product(&|e| e.designed) <= product(&|e| e.usual) * (1.0 + 1e-9), "{purpose:?}");
        assert!(found.expected.iter().all(|e| e.designed <= e.now * (1.0 + 1e-9)), "{purpose:?}");
        assert!(found.usual_repetitions.is_none_or(|times| times >= 1.0 - 1e-6), "{purpose:?}");
        let record = found.record();
        assert_eq!((record.channels[0].samples.len(), found.summary().samples), (1200, 1200));
    }
}

#[test]
fn a_drive_that_moves_the_output_farther_than_the_records_did_says_so() {
    let mut file = file();
    let warns = |file: &ModelFile| {
        let found =
            design(&DesignBasis::from(file), &options(Purpose::Resonance), Listener::silent()).unwrap();
        (found.stroke, found.findings.iter().any(|f| f.topic == "stroke"))
    };
    let (stroke, warned) = warns(&file);
    // Resonant: more than the static stroke of some 20 µm.
    assert!(stroke > 25.0 && !warned, "{stroke}");
    let scores = |measured: f64| hysteron_model::validate::Scores {
        rmse: 0.01 * measured,
        rmse_percent_of_stroke: Some(1.0),
        ..flat_scores()
    };
    for (measured, expected) in [(1.1 * stroke, false), (0.5 * stroke, true)] {
        file.scores = vec![ScoreEntry::new("r", ScoreRole::Training, "um", &scores(measured))];
        assert_eq!(warns(&file).1, expected, "{measured}");
    }
}

/// Scores of no record in particular.
fn flat_scores() -> hysteron_model::validate::Scores {
    let u: Vec<f64> = (0..100).map(f64::from).collect();
    let record = InputOutput::new("r", TimeBase::uniform(1.0), u.clone(), u.clone()).unwrap();
    hysteron_model::validate::score(&record, &u, &Scoring::default()).unwrap()
}

#[test]
fn the_same_options_give_the_same_drive() {
    let [a, b] = [(); 2].map(|()| made(Purpose::Delay).drive);
    assert_eq!(a, b);
}

#[test]
fn creep_and_resonance_are_assumed_where_the_model_has_none() {
    let mut file = file();
    let still = Model { dynamics: Dynamics::None, ..file.to_model().unwrap() };
    let covariance = DMatrix::from_element(1, 1, 1e-4);
    let valid = file.valid_range.clone();
    file = ModelFile::from_model(&still, SignalUnits::default());
    file.set_covariance(&["linear".to_owned()], &covariance);
    file.valid_range = valid;
    for purpose in [Purpose::Creep, Purpose::Resonance] {
        let found = design(&DesignBasis::from(&file), &options(purpose), Listener::silent()).unwrap();
        assert!(found.findings.iter().any(|f| f.text.contains("assumed")), "{purpose:?}");
        let aim = found.expected.iter().find(|e| e.aim).unwrap();
        assert!(aim.designed < 0.5 * aim.now, "{purpose:?} {aim:?}");
    }
}

#[test]
fn a_resonance_that_is_assumed_has_the_frequency_asked_for() {
    // A lag of 5 ms turns the phase by 57° at 50 Hz already: with it G lags by 90° well below 90 Hz.
    let mut file = file();
    let lag =
        TransferFunction::new(vec![Term::new(1.0, 0.0)], vec![Term::new(1.0, 0.0), Term::new(5e-3, 1.0)]);
    let slow = Model { dynamics: Dynamics::Integer(lag.unwrap()), ..file.to_model().unwrap() };
    let valid = file.valid_range.clone();
    file = ModelFile::from_model(&slow, SignalUnits::default());
    file.set_covariance(&["linear".to_owned()], &DMatrix::from_element(1, 1, 1e-4));
    file.valid_range = valid;
    for (resonance_hz, above) in [(90.0, false), (200.0, true)] {
        let options = DesignOptions {
            resonance_hz: Some(resonance_hz),
            highest_hz: above.then_some(150.0),
            ..options(Purpose::Resonance)
        };
        let found = design(&DesignBasis::from(&file), &options, Listener::silent()).unwrap();
        let values: Vec<f64> = found.expected.iter().filter(|e| e.aim).filter_map(|e| e.value).collect();
        // 1/(2ζ) over the gain at a tenth, ζ = 0.05.
        let gain = (0.99_f64.powi(2) + 0.01_f64.powi(2)).sqrt() / 0.1;
        assert!((values[0] - resonance_hz).abs() < 1e-9 && (values[1] - gain).abs() < 1e-9, "{values:?}");
        let told = found.findings.iter().any(|f| f.text.contains("above the highest frequency"));
        assert_eq!(told, above, "{:?}", found.findings);
    }
}

#[test]
fn a_design_needs_a_covariance_limits_and_can_be_stopped() {
    let mut bare = file();
    bare.correlation = None;
    let fails = |file: &ModelFile, options: &DesignOptions| {
        design(&DesignBasis::from(file), options, Listener::silent()).unwrap_err()
    };
    let delay = options(Purpose::Delay);
    assert!(matches!(fails(&bare, &delay), IdentifyError::NoCorrelation));
    for wrong in [
        DesignOptions { range: Some([5.0, 5.0]), ..delay.clone() },
        DesignOptions { slew_per_s: Some(0.1), ..delay.clone() },
        DesignOptions { highest_hz: Some(900.0), ..delay.clone() },
        DesignOptions { noise: Some(0.0), ..delay.clone() },
        DesignOptions { resonance_hz: Some(f64::NAN), ..delay.clone() },
    ] {
        assert!(matches!(fails(&file(), &wrong), IdentifyError::Option { .. }), "{wrong:?}");
    }
    for time_s in [-1.0, f64::NAN, 0.1, 1e9] {
        let wrong = DesignOptions { time_s, ..delay.clone() };
        assert!(matches!(fails(&file(), &wrong), IdentifyError::DesignTime { .. }), "{time_s}");
    }
    let stop = |_: &str, _: f64| ControlFlow::Break(());
    let stopped = design(&DesignBasis::from(&file()), &delay, Listener::new(&stop));
    assert!(matches!(stopped, Err(IdentifyError::Stopped)));
}

/// The information of a record against finite differences of the output with respect to the numbers
/// themselves, one by one.
#[test]
fn the_information_is_that_of_the_derivatives_of_the_predicted_output() {
    let file = file();
    let drive: Vec<f64> = (0..600).map(|k| 5.0 - 5.0 * (f64::from(k) * 0.05).cos()).collect();
    let prior = prior::Prior::new(&file, &[]).unwrap();
    let start = Start::Rest { voltage_v: 0.0 };
    let columns = crate::sensitivity::sensitivities(
        prior.count(),
        |k, step| prior.at(k, step),
        (&drive, hysteron_model::record::Timing::Rate(2000.0), &start),
        &hysteron_numeric::Meter::silent(),
    )
    .unwrap();
    let found = information::information(&columns, &information::Noise::White(0.01));
    let (names, covariance) = file.covariance().unwrap();
    let simulated = |name: &str, by: f64| {
        let mut model = file.to_model().unwrap();
        *hysteron_model::model_file::number_mut(&mut model, name).unwrap() += by;
        model.simulate(&drive, Some(2000.0), &start).unwrap()
    };
    let derivatives: Vec<Vec<f64>> = names
        .iter()
        .enumerate()
        .map(|(i, name)| {
            let step = 1e-3 * covariance[(i, i)].sqrt();
            let (up, down) = (simulated(name, step), simulated(name, -step));
            let d: Vec<f64> = up.iter().zip(&down).map(|(u, d)| (u - d) / (2.0 * step)).collect();
            let mean = d.iter().sum::<f64>() / d.len() as f64;
            d.iter().map(|x| x - mean).collect()
        })
        .collect();
    // log det(I + F) does not depend on the choice of directions; with a diagonal covariance these are the
    // numbers, in units of their standard errors.
    let count = names.len();
    let own = DMatrix::from_fn(count, count, |i, j| {
        let product: f64 = derivatives[i].iter().zip(&derivatives[j]).map(|(a, b)| a * b).sum();
        product * (covariance[(i, i)] * covariance[(j, j)]).sqrt() / 1e-4
    });
    let log_det = |m: &DMatrix<f64>| (DMatrix::identity(count, count) + m).determinant().ln();
    assert!((log_det(&found) - log_det(&own)).abs() < 1e-4, "{} {}", log_det(&found), log_det(&own));
    assert!((found.trace() / own.trace() - 1.0).abs() < 1e-5);
}
