//! Models of every kind that can be exported.

use hysteron_export::{ExportError, Inverse, Precision, Subject};
use hysteron_model::compensator::{Compensation, CompensatorOptions, Prediction};
use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis, HysteresisForm, PrandtlIshlinskii, examples};
use hysteron_model::model_file::{Interval, ModelFile, SignalUnits, ValidRange};
use hysteron_model::realise::{RealiseOptions, realise};
use hysteron_model::record::{Dependence, InterSample};

/// Rate that all are realised at \[Hz\].
pub const RATE_HZ: f64 = 1e4;

fn bouc_wen(n: f64) -> Hysteresis {
    Hysteresis::from(BoucWen { polynomial: vec![0.3, 1e-4], alpha: 0.08, beta: 0.05, gamma: 0.01, n })
}

/// The stage of article Eq. 13 behind n = 1.
pub fn stage() -> Model {
    Model {
        hysteresis: bouc_wen(1.0),
        dynamics: Dynamics::Fractional(TransferFunction::article_eq13()),
        offset: 1.25,
        delay_s: 2.3e-4,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: Some(RATE_HZ),
    }
}

fn plays() -> Hysteresis {
    let thresholds: Vec<f64> = (1..=12).map(|k| 4.0 * f64::from(k)).collect();
    let weights = thresholds.iter().map(|r| 0.02 / (1.0 + 0.05 * r)).collect();
    Hysteresis::from(PrandtlIshlinskii { polynomial: vec![0.3, -2e-4], thresholds, weights })
}

fn parallel() -> Hysteresis {
    let form = "parallel-bouc-wen".parse::<HysteresisForm>().unwrap().with_elements(3).unwrap();
    let shape = [0.05, 0.02, 0.2, -0.05, 0.01, 0.003];
    form.operator(vec![0.3], &[-0.05, -0.02, 0.01], &shape).unwrap()
}

/// Families of the library, by name.
fn families() -> Vec<(&'static str, Hysteresis)> {
    let all = examples([0.0, 100.0], 2e3, 0.3).unwrap().into_iter();
    let families = all.filter(|hysteresis| hysteresis.form() != HysteresisForm::default());
    // Names of files and of functions.
    let name = |hysteresis: &Hysteresis| &*hysteresis.form().name().replace('-', "_").leak();
    families.map(|hysteresis| (name(&hysteresis), hysteresis)).collect()
}

fn resonance() -> Dynamics {
    // 300 Hz, lightly damped.
    let omega = std::f64::consts::TAU * 300.0;
    let terms = vec![Term::new(omega * omega, 0.0), Term::new(0.04 * omega, 1.0), Term::new(1.0, 2.0)];
    Dynamics::Integer(TransferFunction::new(vec![Term::new(omega * omega, 0.0)], terms).unwrap())
}

/// Every kind of hysteresis, dynamics and delay, by name.
pub fn all() -> Vec<(&'static str, Model)> {
    let stage = stage();
    let with = |hysteresis| Model { hysteresis, ..stage.clone() };
    let bare = Model { dynamics: Dynamics::None, delay_s: 0.0, ..stage.clone() };
    let rate =
        families().into_iter().find(|(_, family)| family.form().depends_on() == Dependence::Rate).unwrap().1;
    let others = families().into_iter().map(|(name, hysteresis)| (name, with(hysteresis)));
    let means = ("means_rate", Model { scheme: Scheme::BandLimited, ..with(rate) });
    let mut all = vec![
        ("stage", stage.clone()),
        ("quadratic", Model { dynamics: resonance(), delay_s: 0.0, ..with(bouc_wen(2.0)) }),
        ("power", with(bouc_wen(1.5))),
        ("parallel", with(parallel())),
        ("plays", with(plays())),
        ("means", Model { scheme: Scheme::BandLimited, ..stage.clone() }),
        ("means_quadratic", Model { scheme: Scheme::BandLimited, ..with(bouc_wen(2.0)) }),
        ("means_plays", Model { scheme: Scheme::BandLimited, ..with(plays()) }),
        ("bare", bare.clone()),
        (
            // Nothing but a Bouc–Wen operator, of the other sense of rotation.
            "memory",
            Model {
                hysteresis: Hysteresis::from(BoucWen {
                    polynomial: vec![0.0],
                    alpha: -0.08,
                    beta: 0.05,
                    gamma: -0.03,
                    n: 1.0,
                }),
                ..bare.clone()
            },
        ),
        (
            // Without a bound: z escapes in a move of some hundred thousand volts.
            "unbounded",
            Model {
                hysteresis: Hysteresis::from(BoucWen {
                    polynomial: vec![0.1],
                    alpha: 0.08,
                    beta: -1e-9,
                    gamma: 0.0,
                    n: 2.0,
                }),
                ..bare
            },
        ),
    ];
    all.extend(others);
    all.push(means);
    all
}

/// Number types.
pub const PRECISIONS: [Precision; 2] = [Precision::F32, Precision::F64];

/// A model realised at its rate, meant for 0 to 100 V.
pub fn subject(name: &str, model: &Model, precision: Precision) -> Subject {
    subject_at(name, model, precision, RATE_HZ).unwrap()
}

/// The same at another rate.
pub fn subject_at(
    name: &str,
    model: &Model,
    precision: Precision,
    rate_hz: f64,
) -> Result<Subject, ExportError> {
    let realisation = realise(model, rate_hz, &RealiseOptions::default()).unwrap();
    let mut file = ModelFile::from_model(model, SignalUnits::default());
    let interval = |low, high, unit: &str| Interval { low, high, unit: unit.into() };
    file.valid_range = Some(ValidRange { input: interval(0.0, 100.0, "V"), frequency: None, rate: None });
    Subject::new(name, precision, &file, realisation, 1e-5)
}

/// Models with an inverse: one of each law, with and without dynamics.
pub fn invertible() -> Vec<(&'static str, Model)> {
    let mut kinds = vec!["stage", "quadratic", "power", "plays", "bare"];
    kinds.extend(families().into_iter().map(|(name, _)| name));
    all().into_iter().filter(|(name, _)| kinds.contains(name)).collect()
}

/// The inverse of a model for 0 to 100 V and 200 kV/s, 20 V a sample.
pub fn inverse(name: &str, model: &Model, precision: Precision, prediction: Prediction) -> Inverse {
    let options = CompensatorOptions { prediction, ..CompensatorOptions::default() };
    let compensation = Compensation::new(model, RATE_HZ, &options).unwrap();
    Inverse::new(&subject(name, model, precision), compensation, [0.0, 100.0], 2e5).unwrap()
}
