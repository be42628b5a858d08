//! One sample after another through every family, in both precisions, forward and back.

use std::sync::{LazyLock, Mutex, PoisonError};

use hysteron_model::compensator::{Compensation, CompensatorOptions, CompensatorParts};
use hysteron_model::realise::{Realisation, RealiseOptions, RuntimeParts, realise};
use hysteron_rt::Real;

use crate::exported::models;
use crate::numbers::Bytes;

/// Voltages of the compensators \[V\].
const RANGE: [f64; 2] = [0.0, 100.0];
/// Their largest rates \[V/s\].
const SLEWS: [f64; 2] = [f64::INFINITY, 2e5];

/// A model and its compensators, made once: every input begins with their memory cleared.
struct Subject {
    double: Parts<f64>,
    single: Parts<f32>,
}

struct Parts<T> {
    forward: RuntimeParts<T>,
    /// One of each of the slews, where there is one.
    back: [Option<CompensatorParts<T>>; 2],
}

static SUBJECTS: LazyLock<Vec<Mutex<Subject>>> = LazyLock::new(|| {
    let subject = |(_, model)| {
        let realisation =
            realise(&model, models::RATE_HZ, &RealiseOptions::default()).expect("a model of the tests");
        let compensation = Compensation::new(&model, models::RATE_HZ, &CompensatorOptions::default()).ok();
        let (double, single) = (
            Parts::new(&realisation, compensation.as_ref()),
            Parts::new(&realisation, compensation.as_ref()),
        );
        Mutex::new(Subject { double, single })
    };
    models::all().into_iter().map(subject).collect()
});

impl<T: Real> Parts<T> {
    fn new(realisation: &Realisation, compensation: Option<&Compensation>) -> Self {
        let back = |slew| CompensatorParts::new(compensation?, RANGE, slew).ok();
        Self { forward: RuntimeParts::new(realisation).expect("a model of the tests"), back: SLEWS.map(back) }
    }
}

/// Which model, which precision, then calls.
pub fn steps(data: &[u8]) {
    let mut bytes = Bytes(data);
    let subject = &SUBJECTS[usize::from(bytes.byte()) % SUBJECTS.len()];
    let mut subject = subject.lock().unwrap_or_else(PoisonError::into_inner);
    let options = bytes.byte();
    let slew = usize::from(options & 2 != 0);
    if options & 1 == 0 {
        both(&mut subject.double, slew, bytes);
    } else {
        both(&mut subject.single, slew, bytes);
    }
}

fn both<T: Real + Into<f64>>(parts: &mut Parts<T>, slew: usize, bytes: Bytes<'_>) {
    forward(&mut parts.forward, Bytes(bytes.0));
    if let Some(parts) = &mut parts.back[slew] {
        back(parts, SLEWS[slew], bytes);
    }
}

fn forward<T: Real + Into<f64>>(parts: &mut RuntimeParts<T>, mut bytes: Bytes<'_>) {
    let Ok(mut model) = parts.model() else { return };
    while !bytes.is_empty() {
        let found = match bytes.byte() % 16 {
            0 => model.rest_at(T::of(bytes.number(100.0))),
            1 => {
                let (u, y) = (bytes.number(100.0), bytes.number(50.0));
                model.start_at(T::of(u), T::of(y)).map(|()| T::of(0.0))
            }
            _ => model.step(T::of(bytes.number(100.0))),
        };
        if let Ok(y) = found {
            assert!(y.is_finite(), "an output that is not finite");
        }
    }
}

/// The voltage is within its range and slew, whatever is asked for.
fn back<T: Real + Into<f64>>(parts: &mut CompensatorParts<T>, slew: f64, mut bytes: Bytes<'_>) {
    let Ok(mut compensator) = parts.compensator() else { return };
    let most = slew / models::RATE_HZ;
    let mut last: Option<f64> = None;
    while !bytes.is_empty() {
        match bytes.byte() % 16 {
            0 => {
                let (virgin, voltage) = (bytes.number(100.0), bytes.number(100.0));
                if compensator.rest_after(T::of(virgin), T::of(voltage)).is_ok() {
                    last = None;
                }
            }
            1 => drop(compensator.measured_at_rest(T::of(bytes.number(50.0)))),
            _ => {
                let voltage: f64 = compensator.step(T::of(bytes.number(50.0))).voltage.into();
                assert!((RANGE[0]..=RANGE[1]).contains(&voltage), "{voltage} V");
                if let Some(last) = last {
                    // One rounding of the subtraction here.
                    assert!((voltage - last).abs() <= most * (1.0 + 1e-6), "from {last} to {voltage} V");
                }
                last = Some(voltage);
            }
        }
    }
}
