//! The law against the least-squares problem that it solves.

#![allow(clippy::unwrap_used)]

use super::*;
use crate::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use crate::hysteresis::{ArticleOperator, Hysteresis};
use crate::record::InterSample;

const RATE_HZ: f64 = 1e4;
const SAMPLES: usize = 240;

fn term(coefficient: f64, order: f64) -> Term {
    Term { coefficient, order }
}

fn model(g: Dynamics, delay_s: f64) -> Model {
    Model {
        hysteresis: Hysteresis::from(ArticleOperator::new(vec![1.0], 0.0, 1.0, 0.0, 1.0).unwrap()),
        dynamics: g,
        offset: 0.0,
        delay_s,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: Some(RATE_HZ),
    }
}

fn models() -> Vec<Model> {
    let natural = TAU * 280.0;
    let square = natural * natural;
    let mode = TransferFunction::new(
        vec![term(square, 0.0)],
        vec![term(square, 0.0), term(0.4 * natural, 1.0), term(1.0, 2.0)],
    );
    // Slow and fast at once: poles from a cut.
    let fractional = TransferFunction::new(
        vec![term(1.0, 0.0), term(0.02, 0.4)],
        vec![term(1.0, 0.0), term(0.03, 0.5), term(1e-3, 1.0)],
    );
    vec![
        model(Dynamics::Integer(mode.unwrap()), 2.3e-4),
        model(Dynamics::Fractional(fractional.unwrap()), 0.0),
        model(Dynamics::None, 3e-4),
        model(Dynamics::None, 2.5e-4),
    ]
}

/// The cut of a fractional model is realised down to 1 Hz.
fn options(preview: usize, prediction: Prediction) -> CompensatorOptions {
    let realise = RealiseOptions { lowest_frequency_hz: Some(1.0), ..RealiseOptions::default() };
    CompensatorOptions { preview: Some(preview), prediction, realise, ..CompensatorOptions::default() }
}

/// A bump between rests.
fn reference() -> Vec<f64> {
    let bump = |x: f64| if (0.0..1.0).contains(&x) { (PI * x).sin().powi(4) } else { 0.0 };
    (0..SAMPLES).map(|k| bump((k as f64 - 50.0) / 70.0) - 0.4 * bump((k as f64 - 80.0) / 30.0)).collect()
}

/// Answer of the realised dynamics to one sample, from the formula of each section.
fn impulse_response(dynamics: &LinearRealisation) -> Vec<f64> {
    let taps = dynamics.taps.len();
    let at = |k: usize| {
        let Some(k) = k.checked_sub(dynamics.delay_samples) else { return 0.0 };
        if k < taps {
            return dynamics.taps[k];
        }
        let own =
            |s: &crate::realise::Section| (s.weight * s.gain * (1.0 - s.gain).powu((k - taps) as u32)).re;
        dynamics.sections.iter().map(own).sum()
    };
    (0..SAMPLES).map(at).collect()
}

/// v that makes Σ (r − y)² + λ Σ (Δ²v)² smallest over the record, by least squares on all of its samples at
/// once.
fn all_at_once(law: &Compensation, weight: f64, r: &[f64]) -> DVector<f64> {
    let h = impulse_response(&law.dynamics);
    let mut system = DMatrix::zeros(2 * SAMPLES, SAMPLES);
    let mut right = DVector::zeros(2 * SAMPLES);
    for row in 0..SAMPLES {
        right[row] = r[row];
        for column in 0..=row {
            system[(row, column)] = h[row - column];
        }
        for (back, factor) in [1.0, -2.0, 1.0].into_iter().enumerate() {
            if let Some(column) = row.checked_sub(back) {
                system[(SAMPLES + row, column)] = factor * weight.sqrt();
            }
        }
    }
    system.svd(true, true).solve(&right, 1e-14).unwrap()
}

/// The law, sample by sample, as written in its definition; `r` beyond its end is 0.
fn sample_by_sample(law: &Compensation, r: &[f64]) -> Vec<f64> {
    let taps = law.dynamics.taps.len();
    let mut v = Vec::new();
    let mut states = vec![Complex64::ZERO; law.states.len()];
    let at = |v: &Vec<f64>, back: usize| v.len().checked_sub(back).map_or(0.0, |k| v[k]);
    for k in 0..r.len() {
        let last = at(&v, 1);
        let mut next = last;
        next += law.recent.iter().enumerate().map(|(l, g)| g * (at(&v, l + 2) - last)).sum::<f64>();
        for ([re, im], state) in law.states.iter().zip(&states) {
            next += re * (state.re - last) + im * state.im;
        }
        for (j, gain) in law.reference.iter().enumerate() {
            let r = (k + law.preview).checked_sub(j).and_then(|k| r.get(k)).copied().unwrap_or(0.0);
            next += gain * (r - law.dynamics.held_gain() * last);
        }
        v.push(next);
        let drive = at(&v, taps + 1);
        for (section, state) in law.dynamics.sections.iter().zip(&mut states) {
            *state += section.gain * (drive - *state);
        }
    }
    v
}

#[test]
fn with_all_of_the_reference_known_it_is_the_least_squares_solution() {
    let r = reference();
    for model in models() {
        let law = Compensation::new(&model, RATE_HZ, &options(SAMPLES, Prediction::Stays)).unwrap();
        let passed = law.dynamics.response(law.bandwidth_hz, RATE_HZ).norm_sqr();
        let roughness = (2.0 * (PI * law.bandwidth_hz / RATE_HZ).sin()).powi(4);
        let weight =
            if law.bandwidth_hz.is_finite() { 1e-3 / (1.0 - 1e-3) * passed / roughness } else { 0.0 };
        let (whole, own) = (all_at_once(&law, weight, &r), sample_by_sample(&law, &r));
        // The last samples of a record have no more to come.
        let apart = (0..SAMPLES - 60).map(|k| (whole[k] - own[k]).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-7, "{:?}: {apart:e}", model.dynamics);
    }
}

#[test]
fn its_response_is_what_it_does() {
    let frequency_hz = 150.0;
    let phase = |k: usize| TAU * frequency_hz * k as f64 / RATE_HZ;
    let r: Vec<f64> = (0..6000).map(|k| phase(k).sin()).collect();
    for model in models() {
        for (preview, prediction) in
            [(5, Prediction::Stays), (0, Prediction::Band { highest_hz: 200.0, noise: 1e-3 })]
        {
            let law = Compensation::new(&model, RATE_HZ, &options(preview, prediction)).unwrap();
            let (v, w) = (sample_by_sample(&law, &r), law.response(frequency_hz));
            for (k, v) in v.iter().enumerate().take(5900).skip(5000) {
                let expected = (w * Complex64::from_polar(1.0, phase(k))).im;
                assert!((v - expected).abs() < 2e-4 * w.norm(), "{k}: {v} {expected}");
            }
        }
    }
}

#[test]
fn a_level_is_predicted_exactly_and_a_sine_of_the_band_well() {
    let band = Prediction::Band { highest_hz: 100.0, noise: 1e-3 };
    let weights = band.weights(10, RATE_HZ).unwrap();
    for ahead in 0..10 {
        assert!((weights.row(ahead).sum() - 1.0).abs() < 1e-9);
        for frequency_hz in [3.0, 40.0, 95.0] {
            let angle = |k: f64| TAU * frequency_hz * k / RATE_HZ + 0.3;
            let predicted: f64 =
                (0..weights.ncols()).map(|l| weights[(ahead, l)] * angle(-(l as f64)).sin()).sum();
            assert!((predicted - angle(ahead as f64 + 1.0).sin()).abs() < 5e-3);
        }
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let model = &models()[0];
    let law = |options: &CompensatorOptions| Compensation::new(model, RATE_HZ, options);
    let usual = CompensatorOptions::default();
    for bandwidth_hz in [0.0, -1.0, 5000.0, f64::NAN] {
        let refused = law(&CompensatorOptions { bandwidth_hz: Some(bandwidth_hz), ..usual });
        assert!(matches!(refused, Err(InversionError::Option { .. })), "{bandwidth_hz}");
    }
    for (highest_hz, noise) in [(0.0, 0.1), (6000.0, 0.1), (10.0, 0.0), (10.0, f64::NAN)] {
        let prediction = Prediction::Band { highest_hz, noise };
        let refused = law(&CompensatorOptions { prediction, ..usual });
        assert!(matches!(refused, Err(InversionError::Option { .. })), "{highest_hz} {noise}");
    }
    let steep = Model {
        hysteresis: Hysteresis::from(ArticleOperator::new(vec![1.0, -0.1], 0.0, 1.0, 0.0, 1.0).unwrap()),
        ..model.clone()
    };
    let law = Compensation::new(&steep, RATE_HZ, &usual).unwrap();
    assert!(CompensatorParts::<f64>::new(&law, [0.0, 4.0], f64::INFINITY).is_ok());
    let refused = CompensatorParts::<f64>::new(&law, [0.0, 6.0], f64::INFINITY);
    assert!(matches!(refused, Err(InversionError::NotInvertible(_))), "{refused:?}");
    for (range, slew) in
        [([1.0, 1.0], 1.0), ([0.0, f64::NAN], 1.0), ([0.0, 1.0], 0.0), ([0.0, 1.0], f64::NAN)]
    {
        assert!(CompensatorParts::<f64>::new(&law, range, slew).is_err(), "{range:?} {slew}");
    }
}
