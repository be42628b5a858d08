//! The inverse of a model: drives, controllers, closed loops.

use hysteron_identify::{ForecastDrive, Listener, drive_for};
use hysteron_model::control::Plant;
use hysteron_model::invert::LastRun;
use hysteron_model::model::{Capability, InverseRequest};
use hysteron_model::realise::RealiseOptions;
use hysteron_model::record::Signal;
use hysteron_model::tracking::{PlantDescription, TrackOptions, track};
use hysteron_rig::{Dac, RigStage, Truth};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::controller::Controller;
use crate::errors::{Class, failed, from_json, option, raised, to_json};
use crate::model::{Model, maker};
use crate::signals::{Samples, samples};
use crate::work;

/// Summary, page, and name, drive and displacement of every controller.
type Tracked<'py> = (String, String, Vec<(&'static str, Samples<'py>, Samples<'py>)>);

#[pymethods]
impl Model {
    /// The drive (zero-order hold) with which the output follows a reference: drive, predicted output,
    /// summary.
    #[pyo3(signature = (reference, sample_rate_hz, options, last=None))]
    fn invert<'py>(
        &self,
        py: Python<'py>,
        reference: PyReadonlyArray1<'py, f64>,
        sample_rate_hz: f64,
        options: &str,
        last: Option<(PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>)>,
    ) -> PyResult<(Samples<'py>, Samples<'py>, String)> {
        let asked: InverseRequest = from_json(options)?;
        let body = self.core().hammerstein(Capability::Inversion).map_err(raised)?;
        let reference = samples(&reference)?;
        let last = last.map(|(drive, measured)| PyResult::Ok((samples(&drive)?, samples(&measured)?)));
        let last = last.transpose()?;
        let last = last.as_ref().map(|(drive, measured)| LastRun { drive, measured });
        let found =
            work::run(py, || drive_for(body, &reference, sample_rate_hz, &asked, last, Listener::silent()))?;
        let ForecastDrive { drive, summary } = found.map_err(raised)?;
        let json = to_json(&summary)?;
        Ok((PyArray1::from_vec(py, drive.drive), PyArray1::from_vec(py, drive.predicted), json))
    }

    /// A controller at its rate [Hz].
    fn controller(&self, sample_rate_hz: f64, options: &str) -> PyResult<Controller> {
        let asked: InverseRequest = from_json(options)?;
        let body = self.core().hammerstein(Capability::Inversion).map_err(raised)?;
        let limits = asked.limits(body).map_err(raised)?;
        let law = asked.law(body, sample_rate_hz, RealiseOptions::default(), Some(0));
        let made = hysteron::Controller::of_law(law.map_err(raised)?, limits);
        Ok(Controller::new(made.map_err(raised)?, limits))
    }

    /// Tracking of a reference by several controllers, on the simulated bench or on the model itself:
    /// summary, and the name, drive and displacement of each.
    #[pyo3(signature = (reference, sample_rate_hz, options, plant="rig", truth=None, seed=0))]
    #[allow(clippy::too_many_arguments, reason = "keywords of a call from Python")]
    fn track<'py>(
        &self,
        py: Python<'py>,
        reference: PyReadonlyArray1<'py, f64>,
        sample_rate_hz: f64,
        options: &str,
        plant: &str,
        truth: Option<&str>,
        seed: u64,
    ) -> PyResult<Tracked<'py>> {
        let body = self.core().hammerstein(Capability::Tracking).map_err(raised)?;
        let options: TrackOptions = from_json(options)?;
        let truth: Truth = truth.map_or(Ok(Truth::default()), from_json)?;
        let truth = Truth { dac: Dac::Hold, ..truth };
        let bench = RigStage { truth: &truth, seed, stream: 0 };
        let plant = match plant {
            "rig" => {
                let words = format!("the simulated bench ({})", truth.describe());
                (Plant::Stage(&bench), PlantDescription { name: "rig", words })
            }
            "model" => {
                let words = "the model itself, simulated without noise".to_owned();
                (Plant::Model, PlantDescription { name: "model", words })
            }
            other => return Err(option(format!("plant: expected \"rig\" or \"model\", found \"{other}\""))),
        };
        let unit = body.data().units.output.clone();
        let reference = Signal::uniform(samples(&reference)?, sample_rate_hz, &unit);
        let reference = Signal { name: "reference".to_owned(), ..reference };
        let found = work::run(py, || track(body, &reference, &options, plant))?;
        let found = found.map_err(|e| failed(Class::Model, e))?;
        let page = hysteron_report::tracking::page(&found, &maker()).to_html();
        let runs = found.runs.iter().map(|run| {
            let drive = PyArray1::from_slice(py, &run.played.drive);
            (run.controller.name(), drive, PyArray1::from_slice(py, &run.played.displacement))
        });
        Ok((to_json(&found)?, page, runs.collect()))
    }
}
