//! Drive waveforms.

use hysteron_rig::excitation::{AmplifierLimits, ExcitationSpec};
use pyo3::prelude::*;
use serde::Deserialize;

use crate::errors::{from_json, option, to_json};
use crate::record::Record;
use crate::work;

/// A waveform and what plays it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    spec: ExcitationSpec,
    limits: Option<AmplifierLimits>,
}

/// The drive as a record, and its figures as JSON.
#[pyfunction]
pub fn excite(py: Python<'_>, options: &str) -> PyResult<(Record, String)> {
    let Asked { spec, limits } = from_json(options)?;
    let found = work::run(py, || {
        let excitation = spec.generate()?;
        limits.unwrap_or_default().check(&excitation)?;
        Ok::<_, hysteron_rig::RigError>((excitation.to_record(), excitation.summary()))
    })?;
    let (record, summary) = found.map_err(option)?;
    Ok((record.into(), to_json(&summary)?))
}
