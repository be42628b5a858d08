//! Tracking of a device with known gain and offset.

use super::*;
use crate::IdentifyError;
use hysteron_model::dynamics::{Dynamics, Scheme};
use hysteron_model::hysteresis::{ArticleOperator, Hysteresis};
use hysteron_model::model_file::{Maker, SignalUnits};
use hysteron_model::record::{InterSample, Source, TimeBase};

const START: Start = Start::Rest { voltage_v: 0.0 };

fn model() -> Model {
    let hysteresis =
        ArticleOperator { polynomial: vec![3.2, -0.02], alpha: 1.1, beta: 0.35, gamma: 0.08, n: 1.0 };
    Model {
        hysteresis: Hysteresis::from(hysteresis),
        dynamics: Dynamics::None,
        offset: 0.0,
        delay_s: 0.0,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    }
}

/// The model's output times 1.07, less 0.2.
fn today(time: TimeBase) -> InputOutput {
    let u: Vec<f64> = (0..4000).map(|k| 5.0 - 5.0 * (k as f64 * 0.02).cos()).collect();
    let y = model().simulate(&u, None, &START).unwrap().iter().map(|y| 1.07 * y - 0.2).collect();
    InputOutput::new("today", time, u, y).unwrap()
}

fn options(method: FollowMethod) -> FollowOptions {
    FollowOptions {
        method,
        terms: vec![Term::Offset, Term::Gain],
        noise: 0.01,
        every: None,
        run_length: 1e6,
        reopen: false,
    }
}

fn uniform() -> TimeBase {
    TimeBase::uniform(1000.0)
}

#[test]
fn least_squares_find_gain_and_offset_and_the_file_says_so() {
    let data = today(uniform());
    let options = options(FollowMethod::LeastSquares { memory_s: None });
    let followed = Followed::over(&data, &model(), &START, &options).unwrap();
    assert!((followed.paths[0].end + 0.2).abs() < 1e-3, "{:?}", followed.paths);
    assert!((followed.paths[1].end - 1.07).abs() < 1e-4, "{:?}", followed.paths);
    assert_eq!(followed.memory_s, Some(0.8));
    assert!(followed.last.rmse < 1e-2 * followed.before.rmse);
    let old = ModelFile::from_model(&model(), SignalUnits::default());
    let source = Source { path: "old.json".to_owned(), sha256: "ab".repeat(32) };
    let file = followed.model_file(&data, &options, (&old, &source), &Maker::default()).unwrap();
    let named = &file.provenance.as_ref().unwrap().options;
    assert_eq!(named["estimator"], "rls");
    assert_eq!(named["adapted model"], "old.json");
    assert_eq!(named["gain"], followed.paths[1].end.to_string());
    assert!((file.offset.value + 0.2).abs() < 1e-3);
    assert_eq!(known_noise(&file, &data), Some(followed.last.rmse));
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let method = FollowMethod::Gradient { step: 0.05 };
    let none = FollowOptions { terms: Vec::new(), ..options(method) };
    let followed = Followed::over(&today(uniform()), &model(), &START, &none);
    assert!(matches!(followed, Err(IdentifyError::FollowTerms(0))));
    let followed = Followed::over(&today(TimeBase::Unknown), &model(), &START, &options(method));
    assert!(matches!(followed, Err(IdentifyError::FollowNotUniform)));
}
