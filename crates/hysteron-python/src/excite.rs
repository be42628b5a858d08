//! Drive waveforms, and their response on the simulated bench.

use hysteron_model::record::TimeBase;
use hysteron_rig::excitation::{AmplifierLimits, Excitation, ExcitationSpec};
use hysteron_rig::{Truth, measure};
use pyo3::prelude::*;
use serde::Deserialize;

use crate::errors::{from_json, option, raised, to_json};
use crate::record::Record;
use crate::work;

/// A waveform and the limits of its amplifier.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WaveformRequest {
    spec: ExcitationSpec,
    limits: Option<AmplifierLimits>,
}

/// The drive as a record, and its figures as JSON.
#[pyfunction]
pub fn excite(py: Python<'_>, options: &str) -> PyResult<(Record, String)> {
    let WaveformRequest { spec, limits } = from_json(options)?;
    let found = work::run(py, || {
        let excitation = spec.generate()?;
        limits.unwrap_or_default().check(&excitation)?;
        Ok::<_, hysteron_rig::RigError>((excitation.to_record(), excitation.summary()))
    })?;
    let (record, summary) = found.map_err(option)?;
    Ok((record.into(), to_json(&summary)?))
}

/// A drive played on the simulated bench: the record, simulated, and the true parameters as JSON.
#[pyfunction]
#[pyo3(signature = (drive, truth=None, seed=0, stream=0, with_truth=false))]
pub fn play(
    py: Python<'_>,
    drive: &Record,
    truth: Option<&str>,
    seed: u64,
    stream: usize,
    with_truth: bool,
) -> PyResult<(Record, String)> {
    let truth: Truth = truth.map_or(Ok(Truth::default()), from_json)?;
    let signal = drive.inner.drive(None).map_err(raised)?;
    let TimeBase::Uniform { sample_rate_hz, .. } = signal.time else {
        return Err(option("the drive has no uniform sample rate: the bench's converter runs at one"));
    };
    let words = format!("drive of {}", drive.inner.name);
    let drive = Excitation::of_samples(drive.inner.name.clone(), words, signal.samples, sample_rate_hz);
    let run = work::run(py, || measure(&truth, &drive, seed, stream))?.map_err(option)?;
    let record = if with_truth { run.record_with_truth() } else { run.record };
    Ok((record.into(), to_json(&truth)?))
}
