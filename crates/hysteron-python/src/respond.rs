//! Measured frequency responses, and the structures fitted to them.

use std::path::PathBuf;

use hysteron_identify::frequency_response::empirical::{EmpiricalOptions, empirical_response};
use hysteron_identify::frequency_response::{Explained, Family, Weighting, compare};
use hysteron_io::{ResponseOptions, read_frequency_response};
use hysteron_model::UnknownName;
use hysteron_model::record::{ChannelChoice, FrequencyResponse};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::errors::{from_json, option, raised, to_json};
use crate::model::{Model, maker};
use crate::record::{Record, single};
use crate::signals::Samples;
use crate::work;

/// Frequencies, real and imaginary parts, standard deviations where they are known, and the unit.
type Points<'py> = (Samples<'py>, Samples<'py>, Samples<'py>, Option<Samples<'py>>, String);

/// A response, the structures as JSON, the page, and the model of the best one that a model file can hold.
type Found<'py> = (Points<'py>, String, String, Option<Model>);

/// The response of periodic records, or of a file of responses, and the structures fitted to it.
#[pyfunction]
#[pyo3(signature = (
    records, path=None, options="{}", structures=Vec::new(), modes=None, band=None, input=None, output=None,
    response=None, over=None
))]
#[allow(clippy::too_many_arguments, reason = "keywords of a call from Python")]
pub fn explain_response<'py>(
    py: Python<'py>,
    records: Vec<PyRef<'_, Record>>,
    path: Option<PathBuf>,
    options: &str,
    structures: Vec<String>,
    modes: Option<usize>,
    band: Option<(f64, f64)>,
    input: Option<String>,
    output: Option<String>,
    response: Option<String>,
    over: Option<String>,
) -> PyResult<Found<'py>> {
    let options: EmpiricalOptions = from_json(options)?;
    let (measured, empirical) = match path {
        Some(path) => {
            let named = ResponseOptions { response, over, max_bytes: None };
            (work::run(py, || read_frequency_response(&path, &named))?.map_err(raised)?, None)
        }
        None => {
            let data = single(&records, &ChannelChoice { input, output })?;
            let found = work::run(py, || empirical_response(&data, &options))?.map_err(raised)?;
            (found.response.clone(), Some(found))
        }
    };
    let measured = match band.or(measured.band_above_noise()) {
        Some((low, high)) => measured.band(low, high),
        None => measured,
    };
    if measured.is_empty() {
        return Err(option("no point of the response lies in the band"));
    }
    let named = |name: &String| UnknownName::find("structure", name, Family::ALL, Family::name);
    let families = structures.iter().map(named).collect::<Result<Vec<_>, _>>();
    let families = families.map_err(raised)?;
    let families = if families.is_empty() { Family::for_response(&measured) } else { families };
    let found = work::run(py, || {
        let candidates = compare(&measured, Weighting::of(&measured), &families, modes)?;
        Ok::<_, hysteron_identify::IdentifyError>(Explained { response: measured, empirical, candidates })
    })?;
    let found = found.map_err(raised)?;
    let page = hysteron_report::frequency_response::page(&found, &maker()).to_html();
    let model = found.model_file(&maker()).ok();
    let model = model.map(|written| hysteron_model::Model::try_from(written.file).map_err(raised));
    let model = model.transpose()?.map(Model::from);
    let FrequencyResponse { frequency_hz, values, std_dev, unit, .. } = &found.response;
    let points = (
        PyArray1::from_slice(py, frequency_hz),
        PyArray1::from_iter(py, values.iter().map(|value| value.re)),
        PyArray1::from_iter(py, values.iter().map(|value| value.im)),
        std_dev.as_ref().map(|std_dev| PyArray1::from_slice(py, std_dev)),
        unit.clone(),
    );
    Ok((points, to_json(&found)?, page, model))
}
