//! Promise: every family that `hysteron-rt` runs is the library's own, sample by sample: forwards, in single
//! precision, and inverted.

// Helpers outside the test functions; a failure is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use hysteron_model::Start;
use hysteron_model::compensator::{Compensation, CompensatorOptions, CompensatorParts, Prediction};
use hysteron_model::dynamics::Dynamics;
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{FamilyStream, Hysteresis, HysteresisForm, examples};
use hysteron_model::invert::InversionError;
use hysteron_model::realise::{Realisation, RealiseOptions, RuntimeParts, realise};
use hysteron_model::record::InterSample;
use hysteron_rt::{Limited, ModelError, Real};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

const RATE_HZ: f64 = 1e3;
/// Voltages go from here to there.
const RANGE: [f64; 2] = [-2.0, 10.0];

/// A model of every family of columns; those that relax also with weights of a device that lags, and Dahl's
/// with a knee below 1.
fn models(inter_sample: InterSample) -> Vec<Model> {
    let all = examples(RANGE, 500.0, 1.0).unwrap().into_iter();
    let lagging: [(&str, &[f64], f64); 5] = [
        ("dahl", &[1.7, 1.4], -0.2),
        ("dahl", &[2.5, 0.4], -0.2),
        ("duhem", &[0.6], -4e-4),
        ("non-symmetric-bouc-wen", &[0.5, -0.2, 0.15], -0.1),
        ("song-der-kiureghian", &[0.5, 0.1, -0.08, 0.06, 0.05, -0.04], -0.2),
    ];
    let lagging = lagging.into_iter().map(|(name, shape, weight)| {
        let form: HysteresisForm = name.parse().unwrap();
        let form = if name == "duhem" { form.with_elements(3).unwrap() } else { form };
        let all = (0..form.columns()).map(|k| weight * (1.0 + 0.7 * (k as f64 * 1.7).sin()));
        form.operator(vec![1.0, 0.004], &all.collect::<Vec<f64>>(), shape).unwrap()
    });
    all.chain(lagging).map(|hysteresis| model(hysteresis, inter_sample)).collect()
}

fn model(hysteresis: Hysteresis, inter_sample: InterSample) -> Model {
    Model {
        hysteresis,
        dynamics: Dynamics::None,
        offset: 0.0,
        delay_s: 0.0,
        scheme: hysteron_model::dynamics::Scheme::Tustin,
        inter_sample,
        sample_rate_hz: Some(RATE_HZ),
    }
}

fn stream(model: &Model) -> FamilyStream {
    FamilyStream::new(&model.hysteresis, Some(1.0 / RATE_HZ)).unwrap()
}

fn realised(model: &Model) -> Realisation {
    realise(model, RATE_HZ, &RealiseOptions::default()).unwrap()
}

/// Holds, ramps slow and fast, jumps; `None` a rest.
fn drive(seed: u64, count: usize) -> Vec<(f64, bool)> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let [low, high] = RANGE;
    let mut u = 0.0_f64;
    let mut out = Vec::new();
    while out.len() < count {
        let length = random.random_range(1..40_usize);
        let slope: f64 = random.random_range(-0.6..0.6);
        match random.random_range(0..8) {
            0 => out.extend(std::iter::repeat_n((u, false), length)),
            1..4 => out.extend((0..length).map(|_| {
                u = (u + slope).clamp(low, high);
                (u, false)
            })),
            4 => out.extend((0..length).map(|_| {
                u = (u + 1e-5 * slope).clamp(low, high);
                (u, false)
            })),
            5 if random.random_bool(0.1) => {
                u = random.random_range(low..high);
                out.push((u, true));
            }
            _ => {
                u = random.random_range(low..high);
                out.push((u, false));
            }
        }
    }
    out
}

/// Largest difference to the library along a drive, and the range of its output.
fn difference<T: Real + Into<f64>>(model: &Model, seed: u64) -> (f64, f64) {
    let mut parts = RuntimeParts::<T>::new(&realised(model)).unwrap();
    let mut runtime = parts.model().unwrap();
    let mut library = stream(model);
    let (mut worst, mut low, mut high) = (0.0_f64, f64::MAX, f64::MIN);
    for (u, rests) in drive(seed, 30_000) {
        let rounded = T::of(u);
        let u: f64 = rounded.into();
        let (got, wanted) = if rests {
            (runtime.rest_at(rounded).unwrap(), library.rest_at(u))
        } else {
            (runtime.step(rounded).unwrap(), library.step(u).unwrap())
        };
        let got: f64 = got.into();
        worst = worst.max((got - wanted).abs());
        (low, high) = (low.min(wanted), high.max(wanted));
    }
    (worst, high - low)
}

#[test]
fn the_runtime_steps_as_the_library_does() {
    for model in models(InterSample::Hold) {
        let name = model.hysteresis.form().name();
        let (double, range) = difference::<f64>(&model, 1);
        let (single, _) = difference::<f32>(&model, 2);
        println!("{}: {:.1e} of the range in f64, {:.1e} in f32", name, double / range, single / range);
        assert!(double <= 1e-12 * range, "{}: {double:e} of {range}", name);
        assert!(single <= 32.0 * f64::from(f32::EPSILON) * range, "{}: {single:e} of {range}", name);
    }
}

#[test]
fn a_rest_in_mid_stroke_and_the_batch_simulation_agree() {
    for model in models(InterSample::Hold) {
        let name = model.hysteresis.form().name();
        let mut parts = RuntimeParts::<f64>::new(&realised(&model)).unwrap();
        let mut runtime = parts.model().unwrap();
        let u: Vec<f64> = drive(3, 2000).into_iter().map(|(u, _)| u).collect();
        for (voltage_v, virgin_v) in [(3.0, 3.0), (4.0, 1.0), (0.0, 8.0)] {
            let start = if voltage_v == virgin_v {
                Start::Rest { voltage_v }
            } else {
                let memory = model.hysteresis.memory_of_move(virgin_v, voltage_v).unwrap();
                Start::Remembering { voltage_v, memory: model.hysteresis.memory(memory) }
            };
            let batch = model.simulate(&u, Some(RATE_HZ), &start).unwrap();
            runtime.rest_after(virgin_v, voltage_v).unwrap();
            for (u, wanted) in u.iter().zip(&batch) {
                let got = runtime.step(*u).unwrap();
                assert!((got - wanted).abs() < 1e-11, "{}: {got} {wanted}", name);
            }
        }
    }
}

#[test]
fn bad_numbers_leave_no_trace() {
    for model in models(InterSample::Hold) {
        let name = model.hysteresis.form().name();
        let realised = realised(&model);
        let (mut parts, mut twin) =
            (RuntimeParts::<f64>::new(&realised).unwrap(), RuntimeParts::<f64>::new(&realised).unwrap());
        let (mut tried, mut twin) = (parts.model().unwrap(), twin.model().unwrap());
        for (u, _) in drive(4, 300) {
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert_eq!(tried.step(bad), Err(ModelError::NotFinite), "{}", name);
            }
            for bad in [1e308, -1e308] {
                assert_eq!(tried.step(bad), Err(ModelError::Overflow), "{}", name);
            }
            assert_eq!(tried.step(u), twin.step(u), "{}", name);
        }
    }
}

/// Without dynamics: the voltage that the compensator finds makes the library put out the reference.
#[test]
fn the_inverse_makes_the_library_follow() {
    for model in models(InterSample::Hold) {
        let name = model.hysteresis.form().name();
        let options = CompensatorOptions {
            preview: Some(0),
            prediction: Prediction::Stays,
            ..CompensatorOptions::default()
        };
        let compensation = Compensation::new(&model, RATE_HZ, &options).unwrap();
        let mut parts = CompensatorParts::<f64>::new(&compensation, RANGE, f64::INFINITY).unwrap();
        let mut compensator = parts.compensator().unwrap();
        let mut library = stream(&model);
        let rest = compensator.rest_at(4.0).unwrap();
        library.rest_at(4.0);
        let mut worst = 0.0_f64;
        for k in 0..4000 {
            let t = f64::from(k) * 0.01;
            let wanted = rest + 1.6 * (0.9 * t).sin() + 1.1 * (2.3 * t).sin() - 1.1 * (5.1 * t).sin();
            let drive = compensator.step(wanted);
            assert_eq!(drive.limited, Limited::No, "{} {k}", name);
            worst = worst.max((library.step(drive.voltage).unwrap() - wanted).abs());
        }
        println!("{}: {worst:.1e} µm", name);
        assert!(worst < 1e-12 * 20.0, "{}: {worst:e}", name);
    }
}

/// Relays alone are flat in places: a reference there has no voltage, and the reason is said.
#[test]
fn what_does_not_rise_is_refused() {
    let form = "preisach".parse::<HysteresisForm>().unwrap().with_elements(4).unwrap();
    let mut weights = vec![0.0; form.columns()];
    weights[5] = 1.0;
    let model = model(form.operator(vec![0.0], &weights, &RANGE).unwrap(), InterSample::Hold);
    let compensation = Compensation::new(&model, RATE_HZ, &CompensatorOptions::default()).unwrap();
    let refused = CompensatorParts::<f64>::new(&compensation, RANGE, f64::INFINITY).map(drop);
    assert!(matches!(refused, Err(InversionError::NotInvertible(_))), "{refused:?}");
    assert!(refused.unwrap_err().to_string().contains("does not raise the output"));
}
