//! One sample after another through every family, in both precisions, forward and back.

use std::sync::LazyLock;

use hysteron_model::compensator::{Compensation, CompensatorOptions, CompensatorParts};
use hysteron_model::realise::{Realisation, RealiseOptions, RuntimeParts, realise};
use hysteron_rt::Real;

use crate::exported::models;
use crate::numbers::Bytes;

struct Subject {
    realisation: Realisation,
    compensation: Option<Compensation>,
}

static SUBJECTS: LazyLock<Vec<Subject>> = LazyLock::new(|| {
    let subject = |(_, model)| {
        let realisation =
            realise(&model, models::RATE_HZ, &RealiseOptions::default()).expect("a model of the tests");
        let compensation = Compensation::new(&model, models::RATE_HZ, &CompensatorOptions::default()).ok();
        Subject { realisation, compensation }
    };
    models::all().into_iter().map(subject).collect()
});

/// Which model, which precision, then calls.
pub fn steps(data: &[u8]) {
    let mut bytes = Bytes(data);
    let subject = &SUBJECTS[usize::from(bytes.byte()) % SUBJECTS.len()];
    let options = bytes.byte();
    if options & 1 == 0 {
        forward::<f64>(subject, Bytes(bytes.0));
        back::<f64>(subject, options, bytes);
    } else {
        forward::<f32>(subject, Bytes(bytes.0));
        back::<f32>(subject, options, bytes);
    }
}

fn forward<T: Real + Into<f64>>(subject: &Subject, mut bytes: Bytes<'_>) {
    let Ok(mut parts) = RuntimeParts::<T>::new(&subject.realisation) else { return };
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
fn back<T: Real + Into<f64>>(subject: &Subject, options: u8, mut bytes: Bytes<'_>) {
    let Some(compensation) = &subject.compensation else { return };
    let (range, slew) = ([0.0, 100.0], if options & 2 == 0 { f64::INFINITY } else { 2e5 });
    let Ok(mut parts) = CompensatorParts::<T>::new(compensation, range, slew) else { return };
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
                assert!((range[0]..=range[1]).contains(&voltage), "{voltage} V");
                if let Some(last) = last {
                    // One rounding of the subtraction here.
                    assert!((voltage - last).abs() <= most * (1.0 + 1e-6), "from {last} to {voltage} V");
                }
                last = Some(voltage);
            }
        }
    }
}
