//! A model at a controller's rate: its response, its realisation, its source.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hysteron_export::{
    AxesExportRequest, ExportError, ExportRequest, Means, NamedFile, export, export_axes, write_folder,
};
use hysteron_identify::Listener;
use hysteron_model::model::{Capability, CheckedRealisation};
use hysteron_model::realise::{RealiseOptions, realise};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::errors::{from_json, raised, to_json};
use crate::model::Model;
use crate::signals::{Samples, samples};
use crate::work;

/// A result as JSON, and matrices.
type Matrices<'py> = (String, Vec<Bound<'py, PyArray2<f64>>>);

#[pymethods]
impl Model {
    /// Response of the dynamic block with its delay at frequencies [Hz]: real and imaginary part.
    fn frequency_response<'py>(
        &self,
        py: Python<'py>,
        frequency_hz: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<(Samples<'py>, Samples<'py>)> {
        let body = self.core().hammerstein(Capability::Simulation).map_err(raised)?;
        let values = body.law().frequency_response(&samples(&frequency_hz)?).map_err(raised)?;
        Ok((
            PyArray1::from_iter(py, values.iter().map(|value| value.re)),
            PyArray1::from_iter(py, values.iter().map(|value| value.im)),
        ))
    }

    /// The dynamic block at a sample rate [Hz] as sections, and as the matrices A, B, C, D of a state space
    /// of one input and output.
    #[pyo3(signature = (sample_rate_hz, accuracy=1e-5, lowest_frequency_hz=None))]
    fn realise<'py>(
        &self,
        py: Python<'py>,
        sample_rate_hz: f64,
        accuracy: f64,
        lowest_frequency_hz: Option<f64>,
    ) -> PyResult<Matrices<'py>> {
        let body = self.core().hammerstein(Capability::Realisation).map_err(raised)?;
        let options = RealiseOptions { accuracy, lowest_frequency_hz };
        let options = body.realise_options(sample_rate_hz, options);
        let begun = Instant::now();
        let found = work::run(py, || {
            let realisation = realise(body.law(), sample_rate_hz, &options)?;
            CheckedRealisation::new(realisation, body.data(), accuracy, &move || begun.elapsed())
        })?;
        let found = found.map_err(raised)?;
        let space = found.realisation.dynamics.state_space();
        let n = space.b.len();
        let rows = |flat: &[f64], columns: usize| -> Vec<Vec<f64>> {
            flat.chunks(columns.max(1)).map(<[f64]>::to_vec).collect()
        };
        let matrices = [rows(&space.a, n), rows(&space.b, 1), rows(&space.c, n), vec![vec![space.d]]];
        let matrices = matrices.iter().map(|matrix| PyArray2::from_vec2(py, matrix));
        Ok((to_json(&found)?, matrices.collect::<Result<_, _>>()?))
    }

    /// Source for a controller, written into a folder: names of the files. The options are those of the kind
    /// of model.
    fn export(&self, py: Python<'_>, folder: PathBuf, options: &str) -> PyResult<Vec<String>> {
        let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
        let means = Means { compiler: &compiler, listener: Listener::silent() };
        let files = if self.core().channels().is_some() {
            let asked: AxesExportRequest = from_json(options)?;
            let model = self.core();
            work::run(py, || written(&folder, export_axes(model, &asked, means)?.files))?
        } else {
            let asked: ExportRequest = from_json(options)?;
            let body = self.core().hammerstein(Capability::Export).map_err(raised)?;
            work::run(py, || written(&folder, export(body, &asked, means)?.files))?
        };
        files.map_err(raised)
    }
}

/// Writes the files of an export; their names.
fn written(folder: &Path, files: Vec<NamedFile>) -> Result<Vec<String>, ExportError> {
    write_folder(folder, &files)?;
    Ok(files.into_iter().map(|file| file.name).collect())
}
