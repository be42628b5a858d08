//! A controller: reference in, voltage out, sample by sample or over an array.

use hysteron::Limits;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::signals::samples;

/// The inverse of a model at its rate. It is not shared between threads.
#[pyclass(unsendable, module = "hysteron_models._native")]
pub struct Controller {
    inner: hysteron::Controller,
    limits: Limits,
}

impl Controller {
    pub fn new(inner: hysteron::Controller, limits: Limits) -> Self {
        Self { inner, limits }
    }
}

#[pymethods]
impl Controller {
    /// The voltage for the newest sample of the reference.
    fn step(&mut self, reference: f64) -> f64 {
        self.inner.step(reference).voltage
    }

    /// The voltages for samples of the reference, one after the other.
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        reference: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let reference = samples(&reference)?;
        Ok(PyArray1::from_iter(py, reference.into_iter().map(|r| self.inner.step(r).voltage)))
    }

    /// Displacement predicted for the last voltage.
    #[getter]
    fn displacement(&self) -> f64 {
        self.inner.displacement()
    }

    /// Resets to rest at a voltage; returns the displacement there.
    fn rest_at(&mut self, voltage: f64) -> f64 {
        self.inner.rest_at(voltage)
    }

    /// Preview of the reference [samples].
    #[getter]
    fn preview(&self) -> usize {
        self.inner.preview()
    }

    #[getter]
    fn sample_rate_hz(&self) -> f64 {
        self.inner.sample_rate_hz()
    }

    /// Least and largest voltage.
    #[getter]
    fn range(&self) -> (f64, f64) {
        (self.limits.low, self.limits.high)
    }
}
