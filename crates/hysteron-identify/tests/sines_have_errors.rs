//! Gain and phase at the sines of a record in segments come with errors: the model's are the spread over
//! parameters drawn from their covariance, the measured ones the scatter of the output.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use hysteron_identify::{
    CampaignRecord, Choice, DynamicsChoice, FamilyChoice, Identification, Initial, Options, SineResponse,
    Watch, identify,
};
use hysteron_model::Start;
use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis, HysteresisForm};
use hysteron_model::model_file::number_mut;
use hysteron_model::record::{InputOutput, InterSample, TimeBase, Unit};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// White noise of variance 1, by a linear congruence.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

/// A stage of 90 Hz behind a loop.
fn truth() -> Model {
    let w = TAU * 90.0;
    let denominator = vec![Term::new(1.0, 0.0), Term::new(0.8 / w, 1.0), Term::new(1.0 / (w * w), 2.0)];
    Model {
        hysteresis: Hysteresis::from(BoucWen::new(vec![0.4], 0.08, 0.3, 0.1, 1.0).unwrap()),
        dynamics: Dynamics::Integer(TransferFunction::new(vec![Term::new(1.0, 0.0)], denominator).unwrap()),
        offset: 0.0,
        delay_s: 0.4e-3,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    }
}

/// A loop at 500 Hz, then sines of 5 and 40 Hz about 4 V at rates of their own; white noise of 1 nm.
fn record() -> InputOutput {
    let (mut times_s, mut u) = (Vec::new(), Vec::new());
    let mut from = 0.0;
    let mut stretch = |samples: u32, rate: f64, drive: &dyn Fn(f64) -> f64| {
        for k in 0..samples {
            let t = f64::from(k) / rate;
            times_s.push(from + t);
            u.push(drive(t));
        }
        from += f64::from(samples) / rate;
    };
    stretch(500, 500.0, &|t| 4.0 * t + 4.0 * (TAU * t).sin().powi(2));
    for (samples, rate, hz) in [(400, 200.0, 5.0), (600, 2000.0, 40.0)] {
        stretch(samples, rate, &|t| 4.0 + 0.8 * (TAU * hz * t).sin());
    }
    let mut noise = Noise(1);
    let time = TimeBase::NonUniform { times_s };
    let y = truth().simulate(&u, &time, &Start::Rest { voltage_v: 0.0 }).unwrap();
    let y = y.into_iter().map(|y| y + 1e-3 * noise.next()).collect();
    let mut data = InputOutput::new("segments", time, u, y).unwrap();
    (data.u_unit, data.y_unit) = (Unit::new("V"), Unit::new("um"));
    data
}

fn identified() -> Identification {
    let options = Options {
        hysteresis: FamilyChoice::Given(HysteresisForm::bouc_wen()),
        dynamics: DynamicsChoice::Integer,
        degree: Choice::Given(1),
        initial: Initial::Zero,
        ..Options::default()
    };
    identify(&[CampaignRecord { data: record(), role: None }], &options, &Watch::silent(), None).unwrap()
}

#[test]
fn the_models_errors_are_the_spread_over_drawn_parameters() {
    let found = identified();
    let fit = &found.records[0];
    assert_eq!(fit.sines.len(), 2, "{:?}", fit.data.segments());
    let known = found.of_numbers.as_ref().unwrap();
    // What is held has no error.
    let estimated: Vec<usize> = (0..known.names.len()).filter(|&i| known.matrix[(i, i)] > 0.0).collect();
    let matrix = known.matrix.select_rows(&estimated).select_columns(&estimated);
    let errors = matrix.diagonal().map(f64::sqrt);
    let eigen = matrix.map_with_location(|i, j, c| c / (errors[i] * errors[j])).symmetric_eigen();
    let root = eigen.eigenvectors * DMatrix::from_diagonal(&eigen.eigenvalues.map(|e| e.max(0.0).sqrt()));

    let mut noise = Noise(7);
    let draws: Vec<Vec<SineResponse>> = (0..1500)
        .map(|_| {
            let drawn = &root * DVector::from_fn(errors.len(), |_, _| noise.next());
            let mut model = found.model.clone();
            for (&index, step) in estimated.iter().zip(drawn.component_mul(&errors).iter()) {
                *number_mut(&mut model, &known.names[index]).unwrap() += step;
            }
            let y = model.simulate(&fit.data.u, &fit.data.time, &fit.start).unwrap();
            SineResponse::of_record(&fit.data, &y)
        })
        .collect();
    let spread = |of: &dyn Fn(&SineResponse) -> f64, sine: usize| {
        let values: Vec<f64> = draws.iter().map(|sines| of(&sines[sine])).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64).sqrt()
    };
    for (index, sine) in fit.sines.iter().enumerate() {
        let gain = sine.model.gain_std_error.unwrap() / spread(&|s| s.model.gain, index);
        let phase = sine.model.phase_std_error_deg.unwrap() / spread(&|s| s.model.phase_deg, index);
        assert!((gain - 1.0).abs() < 0.1 && (phase - 1.0).abs() < 0.1, "{gain} {phase}: {sine:?}");
    }
}

#[test]
fn measured_and_model_are_as_far_from_the_truth_as_their_errors_say() {
    let found = identified();
    let fit = &found.records[0];
    let y = truth().simulate(&fit.data.u, &fit.data.time, &fit.start).unwrap();
    for (sine, truth) in fit.sines.iter().zip(SineResponse::of_record(&fit.data, &y)) {
        for (what, own) in [("measured", sine.measured), ("model", sine.model)] {
            let gain = (own.gain - truth.model.gain) / own.gain_std_error.unwrap();
            let phase = (own.phase_deg - truth.model.phase_deg) / own.phase_std_error_deg.unwrap();
            assert!(gain.abs() < 3.5 && phase.abs() < 3.5, "{what}: {gain} {phase}, {sine:?}");
        }
        // 1 nm of noise on a sine of 0.8 V under a Hann window.
        let expected = 1e-3 / 0.8 * (3.0 / sine.samples.len() as f64).sqrt();
        let ratio = sine.measured.gain_std_error.unwrap() / expected;
        assert!((0.6..1.5).contains(&ratio), "{ratio}: {sine:?}");
    }
}
