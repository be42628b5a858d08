//! The inverse of models of several axes.

use hysteron_model::axes::AxesRecord;
use hysteron_model::model::DecouplingRequest;
use hysteron_model::record::{TimeBase, Unit};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::errors::{from_json, raised, to_json};
use crate::model::Model;
use crate::signals::{Samples, samples};
use crate::work;

/// Drives, predicted outputs, summary.
type Decoupled<'py> = (Vec<Samples<'py>>, Vec<Samples<'py>>, String);

#[pymethods]
impl Model {
    /// The drives (zero-order hold) of all actuators with which the outputs follow references, one array per
    /// output: drives, predicted outputs, summary.
    fn decouple<'py>(
        &self,
        py: Python<'py>,
        references: Vec<PyReadonlyArray1<'py, f64>>,
        sample_rate_hz: f64,
        options: &str,
    ) -> PyResult<Decoupled<'py>> {
        let asked: DecouplingRequest = from_json(options)?;
        let model = self.core();
        let references = AxesRecord {
            name: "references".to_owned(),
            time: TimeBase::uniform(sample_rate_hz),
            sample_rate_hz,
            u: references.iter().map(samples).collect::<PyResult<_>>()?,
            y: Vec::new(),
            valid: None,
            inputs: Vec::new(),
            outputs: Vec::new(),
            u_unit: Unit::new(&model.units().output),
            y_unit: Unit::new(""),
            source: None,
        };
        let found = work::run(py, || model.decouple_for(&references, &asked))?;
        let (found, summary) = found.map_err(raised)?;
        let summary = to_json(&summary)?;
        let arrays =
            |lists: Vec<Vec<f64>>| lists.into_iter().map(|list| PyArray1::from_vec(py, list)).collect();
        Ok((arrays(found.drive), arrays(found.predicted), summary))
    }
}
