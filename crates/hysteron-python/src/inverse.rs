//! The inverse of a model: drives, controllers, closed loops.

use hysteron_identify::{Listener, PredictionBand};
use hysteron_model::Start;
use hysteron_model::compensator::{Compensation, CompensatorOptions, Limits, Prediction};
use hysteron_model::control::Plant;
use hysteron_model::invert::{InverseOptions, LastRun};
use hysteron_model::model::{Capability, InverseSummary};
use hysteron_model::realise::RealiseOptions;
use hysteron_model::record::Signal;
use hysteron_model::tracking::{PlantDescription, TrackOptions, track};
use hysteron_rig::{Dac, RigStage, Truth};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use serde::Deserialize;

use crate::controller::Controller;
use crate::errors::{Class, failed, from_json, option, raised, to_json};
use crate::model::{Model, maker};
use crate::signals::{Samples, samples};
use crate::work;

/// Options of an inverse beside the model; missing ones take the library's defaults.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Inverting {
    pub range: Option<[f64; 2]>,
    pub slew_per_s: Option<f64>,
    bandwidth_hz: Option<f64>,
    preview: Option<usize>,
    pub predict_to_hz: Option<f64>,
    periodic: bool,
    rest_voltage: Option<f64>,
    virgin_voltage: Option<f64>,
}

impl Inverting {
    fn options(&self, range_v: [f64; 2]) -> InverseOptions {
        InverseOptions {
            bandwidth_hz: self.bandwidth_hz,
            slew_v_per_s: self.slew_per_s.unwrap_or(f64::INFINITY),
            start: match self.rest_voltage {
                _ if self.periodic => Start::PERIODIC,
                Some(voltage_v) => Start::Rest { voltage_v },
                None => Start::AsIdentified,
            },
            virgin_v: self.virgin_voltage.or(InverseOptions::switched_on(range_v)),
            ..InverseOptions::within(range_v)
        }
    }

    /// Options of a controller, with the default `preview`.
    pub fn compensator(
        &self,
        model: &Model,
        rate: f64,
        preview: Option<usize>,
    ) -> PyResult<CompensatorOptions> {
        let body = model.core().hammerstein(Capability::Inversion).map_err(raised)?;
        Ok(CompensatorOptions {
            bandwidth_hz: self.bandwidth_hz,
            preview: self.preview.or(preview),
            prediction: Prediction::up_to(self.predict_to_hz),
            realise: body.realise_options(rate, RealiseOptions::default()),
            ..CompensatorOptions::default()
        })
    }
}

/// Summary, page, and name, drive and displacement of every controller.
type Tracked<'py> = (String, String, Vec<(&'static str, Samples<'py>, Samples<'py>)>);

impl Model {
    /// The given range of the drive, else the one of the identification.
    pub fn range(&self, given: Option<[f64; 2]>) -> PyResult<[f64; 2]> {
        let body = self.core().hammerstein(Capability::Inversion).map_err(raised)?;
        let unknown =
            "the model does not say which drive it was identified with: give the range of the drive";
        given.or(body.drive_range()).ok_or_else(|| option(unknown))
    }
}

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
        let asked: Inverting = from_json(options)?;
        let range = self.range(asked.range)?;
        let body = self.core().hammerstein(Capability::Inversion).map_err(raised)?;
        let options = asked.options(range);
        let reference = samples(&reference)?;
        let last = last.map(|(drive, measured)| PyResult::Ok((samples(&drive)?, samples(&measured)?)));
        let last = last.transpose()?;
        let law = body.law();
        let found = match last {
            Some((drive, measured)) => work::run(py, || {
                law.learn(
                    &reference,
                    LastRun { drive: &drive, measured: &measured },
                    sample_rate_hz,
                    &options,
                )
            })?,
            None if asked.preview.is_some() || asked.predict_to_hz.is_some() => {
                let wanted = asked.compensator(self, sample_rate_hz, Some(0))?;
                work::run(py, || {
                    Compensation::new(law, sample_rate_hz, &wanted)?.follow(&reference, &options)
                })?
            }
            None => work::run(py, || law.invert(&reference, sample_rate_hz, &options))?,
        };
        let found = found.map_err(raised)?;
        let forecast = work::run(py, || {
            PredictionBand::forecast(body.data(), &reference, &found, sample_rate_hz, Listener::silent())
        })?;
        let forecast = forecast.map_err(raised)?;
        let findings = body.findings_on_drive(&found, range);
        let units = &body.data().units;
        let summary = InverseSummary::new(&reference, &found, sample_rate_hz, forecast, findings, units);
        let json = to_json(&summary)?;
        Ok((PyArray1::from_vec(py, found.drive), PyArray1::from_vec(py, found.predicted), json))
    }

    /// A controller at its rate [Hz].
    fn controller(&self, sample_rate_hz: f64, options: &str) -> PyResult<Controller> {
        let asked: Inverting = from_json(options)?;
        let [low, high] = self.range(asked.range)?;
        let limits = Limits { low, high, slew_v_per_s: asked.slew_per_s.unwrap_or(f64::INFINITY) };
        let options = asked.compensator(self, sample_rate_hz, Some(0))?;
        let body = self.core().hammerstein(Capability::Inversion).map_err(raised)?;
        let made = hysteron::Controller::new(body.law(), sample_rate_hz, limits, &options);
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
