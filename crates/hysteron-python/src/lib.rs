//! Native part of the Python package `hysteron_models`: records, fits, models and controllers as Python
//! objects.
//!
//! Arrays cross as NumPy arrays, options and results as the JSON of the library's own types. Computations
//! release the interpreter; wording, defaults and plots for the user are in Python
//! (`python/hysteron_models`).

mod compare;
mod controller;
mod decoupling;
mod deploy;
mod design;
mod errors;
mod excite;
mod fit;
mod fleet;
mod inverse;
mod model;
mod record;
mod respond;
mod signals;
mod task;
mod work;

use pyo3::prelude::*;

/// Reuses freed memory for the next search; the system's allocator would return it and have it zeroed again.
#[global_allocator]
static GLOBAL: mimalloc::MiMalloc = mimalloc::MiMalloc;

#[pymodule]
mod _native {
    #[pymodule_export]
    use super::compare::{compare, compare_axes};
    #[pymodule_export]
    use super::controller::Controller;
    #[pymodule_export]
    use super::design::design;
    #[pymodule_export]
    use super::excite::{excite, play};
    #[pymodule_export]
    use super::fit::{Fit, choices, identify};
    #[pymodule_export]
    use super::fleet::{chi_square_quantile, chi_square_tail, difference_of, fleet_page, student_tail};
    #[pymodule_export]
    use super::model::{Model, residual_correlation};
    #[pymodule_export]
    use super::record::{Record, contents, inspect, prepare, read, split_header, write};
    #[pymodule_export]
    use super::respond::explain_response;

    use super::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
