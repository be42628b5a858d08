//! Normalised least mean squares: it converges for every step that is allowed.

use super::noise::Noise;
use hysteron_rt::{Nlms, NlmsSettings, ParameterError, SampleError};
use proptest::prelude::*;

const DEVIATIONS: [f64; 3] = [0.1, 2.0, 0.5];

fn settings(step: f64, regulariser: f64) -> NlmsSettings<f64, 3> {
    NlmsSettings { start: [1.0, 0.0, -0.5], deviations: DEVIATIONS, step, regulariser, bounds: None }
}

/// Σ (θᵢ − θᵢ*)²/σᵢ².
fn distance(parameters: &[f64; 3], truth: &[f64; 3]) -> f64 {
    (0..3).map(|i| ((parameters[i] - truth[i]) / DEVIATIONS[i]).powi(2)).sum()
}

fn output(truth: &[f64; 3], phi: &[f64; 3]) -> f64 {
    (0..3).map(|i| truth[i] * phi[i]).sum()
}

#[test]
fn a_step_by_hand() {
    let settings = NlmsSettings {
        start: [0.0, 1.0],
        deviations: [1.0, 2.0],
        step: 0.5,
        regulariser: 1.0,
        bounds: Some([(0.0, 0.4), (0.0, 9.0)]),
    };
    let mut nlms = Nlms::new(settings).unwrap();
    // e = 11 − 1 = 10, q + ε = 2² + 2²·1² + 1 = 9: θ moves by 5/9 of (2, 4).
    assert_eq!(nlms.step(&[2.0, 1.0], 11.0), Ok(10.0));
    assert_eq!(nlms.parameters()[0], 0.4);
    let moved: f64 = nlms.parameters()[1];
    assert!((moved - 29.0 / 9.0).abs() < 1e-15);
    nlms.reset();
    assert_eq!(nlms.parameters(), &[0.0, 1.0]);
    // Nothing drives, nothing is learnt, also without regulariser.
    let mut bare = Nlms::new(NlmsSettings { regulariser: 0.0, ..settings }).unwrap();
    assert_eq!(bare.step(&[0.0, 0.0], 3.0), Ok(3.0));
    assert_eq!(bare.parameters(), &[0.0, 1.0]);
}

#[test]
fn it_converges_for_every_step_between_0_and_2_and_no_other_is_taken() {
    let truth = [1.1, -0.7, 0.25];
    for step in [0.02, 0.2, 1.0, 1.8, 1.98] {
        let settings = NlmsSettings { deviations: [1.0; 3], ..settings(step, 0.0) };
        let (mut nlms, mut noise) = (Nlms::new(settings).unwrap(), Noise(1));
        for _ in 0..20_000 {
            let phi = [noise.normal(), noise.normal(), noise.normal()];
            nlms.step(&phi, output(&truth, &phi)).unwrap();
        }
        assert!(distance(nlms.parameters(), &truth) < 1e-24, "step {step}: {:?}", nlms.parameters());
    }
    for step in [0.0, -0.1, 2.0, 2.5, f64::NAN] {
        assert!(matches!(
            Nlms::new(settings(step, 0.0)),
            Err(ParameterError::Number { name: "the step", .. })
        ));
    }
}

#[test]
fn in_white_noise_it_settles_where_the_theory_says() {
    // ±1 regressors have a constant power, so that the distance obeys E d⁺ = (1 − μ(2 − μ)/N) E d + μ² s²/N:
    // the parameters add μ/(2 − μ) of the noise variance to that of the prediction.
    let (truth, step, deviation) = ([0.3, -0.2, 0.1, 0.5], 0.5, 0.1);
    let settings =
        NlmsSettings { start: [0.0; 4], deviations: [1.0; 4], step, regulariser: 0.0, bounds: None };
    let (mut nlms, mut noise) = (Nlms::new(settings).unwrap(), Noise(2));
    let (mut sum, settled, all) = (0.0, 1000, 400_000);
    for k in 0..all {
        let phi: [f64; 4] = [0; 4].map(|_| if noise.uniform() < 0.5 { -1.0 } else { 1.0 });
        let clean: f64 = (0..4).map(|i| truth[i] * phi[i]).sum();
        if k >= settled {
            sum += (clean - nlms.predict(&phi)).powi(2);
        }
        nlms.step(&phi, clean + deviation * noise.normal()).unwrap();
    }
    let found = sum / f64::from(all - settled);
    let want = step / (2.0 - step) * deviation * deviation;
    // About 4e5·0.1 independent squares: four standard errors are 3 %.
    assert!((found / want - 1.0).abs() < 0.03, "{found} for {want}");
}

#[test]
fn what_cannot_be_is_refused_and_a_bad_sample_changes_nothing() {
    for regulariser in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Nlms::new(settings(1.0, regulariser)), Err(ParameterError::Number { .. })));
    }
    let zero = NlmsSettings { deviations: [1.0, 0.0, 1.0], ..settings(1.0, 0.0) };
    assert!(matches!(Nlms::new(zero), Err(ParameterError::Parameter { index: 1, .. })));
    let mut nlms = Nlms::new(settings(1.0, 0.0)).unwrap();
    let before = nlms;
    assert_eq!(nlms.step(&[f64::NAN, 0.0, 0.0], 0.0), Err(SampleError::NotFinite));
    assert_eq!(nlms.step(&[1e200, 0.0, 0.0], 0.0), Err(SampleError::Overflow));
    assert_eq!(nlms, before);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    #[test]
    fn without_noise_no_sample_raises_the_distance_and_it_falls_as_stated(
        step in 0.01..1.99_f64, regulariser in 0.0..3.0_f64, bounded in any::<bool>(),
        truth in prop::array::uniform3(-1.0..1.0_f64),
        samples in prop::collection::vec(prop::array::uniform3(-3.0..3.0_f64), 1..40),
    ) {
        let bounds = bounded.then_some([(-1.0, 1.0); 3]);
        let mut nlms = Nlms::new(NlmsSettings { bounds, ..settings(step, regulariser) }).unwrap();
        for phi in &samples {
            let before = distance(nlms.parameters(), &truth);
            let e = nlms.step(phi, output(&truth, phi)).unwrap();
            let fall = before - distance(nlms.parameters(), &truth);
            let q: f64 = (0..3).map(|i| (DEVIATIONS[i] * phi[i]).powi(2)).sum();
            let power = regulariser + q;
            let want =
                e * e * (2.0 * step * power - step * step * q) / (power * power).max(f64::MIN_POSITIVE);
            prop_assert!(fall >= want - 1e-9 * (1.0 + before), "{fall} {want}");
            prop_assert!(bounded || (fall - want).abs() <= 1e-9 * (1.0 + before), "{fall} {want}");
        }
    }
}
