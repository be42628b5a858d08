//! The inverse of models of several axes.

use hysteron_model::axes::AxesRecord;
use hysteron_model::compensator::Limits;
use hysteron_model::decoupling::{DecouplingOptions, LawOptions};
use hysteron_model::model::DecoupledSummary;
use hysteron_model::record::{TimeBase, Unit};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use serde::Deserialize;

use crate::errors::{from_json, option, raised, to_json};
use crate::model::Model;
use crate::signals::{Samples, samples};
use crate::work;

/// Options of a call.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Decoupling {
    limits: Option<Vec<[f64; 2]>>,
    slew_per_s: Option<f64>,
    bandwidth_hz: Option<f64>,
    preview: Option<usize>,
    level: Option<f64>,
    #[serde(default)]
    periodic: bool,
}

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
        let asked: Decoupling = from_json(options)?;
        let model = self.core();
        let unknown = "the model does not say which drives it was identified with: give their limits";
        let mut limits = match &asked.limits {
            Some(given) => given.iter().map(|[low, high]| Limits::range(*low, *high)).collect(),
            None => model.limits_of_records().ok_or_else(|| option(unknown))?,
        };
        if let Some(slew) = asked.slew_per_s {
            limits.iter_mut().for_each(|limit| *limit = limit.slew(slew));
        }
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
        let (found, preview) = work::run(py, || match asked.preview {
            Some(_) => {
                let options = LawOptions {
                    bandwidth_hz: asked.bandwidth_hz,
                    preview: asked.preview,
                    level: asked.level,
                };
                let found = model.decouple_by_sample(&references, &options, &limits);
                found.map(|(found, law)| (found, Some(law.preview)))
            }
            None => {
                let options = DecouplingOptions {
                    bandwidth_hz: asked.bandwidth_hz,
                    periodic: asked.periodic,
                    level: asked.level,
                    ..DecouplingOptions::within(limits.clone())
                };
                model.decouple(&references, &options).map(|found| (found, None))
            }
        })?
        .map_err(raised)?;
        let summary = to_json(&DecoupledSummary::new(model, &references, &found, preview))?;
        let arrays =
            |lists: Vec<Vec<f64>>| lists.into_iter().map(|list| PyArray1::from_vec(py, list)).collect();
        Ok((arrays(found.drive), arrays(found.predicted), summary))
    }
}
