//! One experiment on the simulated bench.

use super::period::Periods;
use super::sensor::SensorState;
use super::truth::{Dac, Truth};
use super::{RigError, RigRun};
use crate::excitation::Excitation;
use hysteron_model::record::{Channel, Record, TimeBase, Unit};

/// Simulates one experiment: a waveform on the bench, initially at rest at its first voltage.
///
/// `stream` numbers the record within a campaign: with the same seed, different streams have independent
/// noise.
///
/// # Errors
/// Any [`RigError`]: an invalid truth or drive, unstable dynamics, a diverging hysteresis.
///
/// ```
/// use hysteron_rig::{Truth, measure};
/// use hysteron_rig::excitation::{ExcitationSpec, Waveform};
///
/// let sine = Waveform::Sine { frequency_hz: 5.0, periods: 2.0 };
/// let drive = ExcitationSpec::new(1_000.0, 0.0, 10.0, sine).generate()?;
/// let run = measure(&Truth::default(), &drive, 1, 0)?;
/// assert_eq!(run.record.channels[1].samples.len(), 400);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn measure(truth: &Truth, drive: &Excitation, seed: u64, stream: usize) -> Result<RigRun, RigError> {
    truth.validate()?;
    let (y_true_um, hysteresis_um) = respond(truth, drive)?;
    if let Some(k) = y_true_um.iter().position(|y| !y.is_finite()) {
        return Err(RigError::NotFinite { time_s: k as f64 / drive.sample_rate_hz, value: y_true_um[k] });
    }
    let mut sensor = SensorState::new(&truth.sensor, drive.sample_rate_hz, seed, stream);
    let y_um = y_true_um.iter().map(|y| sensor.read(*y)).collect();
    let clipped_samples = sensor.clipped();
    let channel =
        |name: &str, unit: &str, samples| Channel { name: name.into(), unit: Unit::new(unit), samples };
    let mut comments = vec![
        "simulated: this record was computed by the hysteron bench rig, not measured".to_owned(),
        format!("drive: {}", drive.description),
        format!("plant: {}", truth.describe()),
        format!("seed {seed}, stream {stream}"),
    ];
    if clipped_samples > 0 {
        comments.push(format!("the converter clipped {clipped_samples} samples"));
    }
    Ok(RigRun {
        record: Record {
            name: format!("simulated_{}", drive.name),
            time: TimeBase::Uniform {
                start_s: 0.0,
                sample_rate_hz: drive.sample_rate_hz,
                jitter_samples: 0.0,
            },
            channels: vec![channel("u", "V", drive.samples_v.clone()), channel("y", "um", y_um)],
            valid: None,
            source: None,
        },
        y_true_um,
        hysteresis_um,
        clipped_samples,
        comments,
    })
}

/// True displacement and output of the hysteresis for a drive.
fn respond(truth: &Truth, drive: &Excitation) -> Result<(Vec<f64>, Vec<f64>), RigError> {
    let u = &drive.samples_v;
    if let Some(&bad) = u.iter().find(|x| !x.is_finite()) {
        return Err(RigError::Drive { what: "a sample", value: bad, expected: "finite voltages" });
    }
    let Some(&first_v) = u.first() else {
        return Err(RigError::Drive { what: "number of samples", value: 0.0, expected: "at least 1" });
    };
    let mut periods = Periods::at_rest(truth, drive.sample_rate_hz, first_v)?;
    let period = |(k, &u_k): (usize, &f64)| {
        let end_v = match truth.dac {
            Dac::Linear => u.get(k + 1).copied().unwrap_or(u_k),
            Dac::Hold => u_k,
        };
        periods.next(u_k, end_v)
    };
    u.iter().enumerate().map(period).collect()
}
