//! Arrays of Python as samples, and back.

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

/// An array of Python.
pub type Samples<'py> = Bound<'py, PyArray1<f64>>;

/// The samples of a contiguous array.
pub fn samples(array: &PyReadonlyArray1<'_, f64>) -> PyResult<Vec<f64>> {
    Ok(array.as_slice()?.to_vec())
}
