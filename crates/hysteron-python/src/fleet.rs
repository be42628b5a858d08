//! Fleets of devices: difference of two models, tails of distributions, the page of a fleet.

use hysteron_identify::difference;
use hysteron_numeric::distribution;
use pyo3::prelude::*;

use crate::errors::{Class, failed, from_json, to_json};
use crate::model::{Model, maker};

/// Difference of two models of one structure, as JSON, and whether it is significant.
#[pyfunction]
pub fn difference_of(first: &Model, second: &Model) -> PyResult<(String, bool)> {
    let found = difference::difference(first.core(), second.core()).map_err(|e| failed(Class::Model, e))?;
    Ok((to_json(&found)?, found.is_significant()))
}

/// P(χ² > x).
#[pyfunction]
pub fn chi_square_tail(x: f64, degrees: f64) -> f64 {
    distribution::chi_square_tail(x, degrees)
}

/// The x that χ² exceeds with probability 1 − p.
#[pyfunction]
pub fn chi_square_quantile(p: f64, degrees: f64) -> f64 {
    distribution::chi_square_quantile(p, degrees)
}

/// P(|T| > |t|) of Student's T.
#[pyfunction]
pub fn student_tail(t: f64, degrees: f64) -> f64 {
    distribution::student_tail(t, degrees)
}

/// Page of a fleet, from the JSON of `hysteron_report::fleet::Fleet`.
#[pyfunction]
pub fn fleet_page(fleet: &str) -> PyResult<String> {
    Ok(hysteron_report::fleet::page(&from_json(fleet)?, &maker().program).to_html())
}
