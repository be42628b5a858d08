//! Linear dynamics after the hysteresis block by polynomial models: output error, Box–Jenkins, refined
//! instrumental variables.
//!
//! All use the output v of an identified hysteresis block and the measured displacement y, one offset per
//! record:
//!
//! - ARX, the equation error by linear least squares, is [`hysteron_model::dynamics::arx`]: fast, biased by
//!   noise on y;
//! - [`fit_polynomial`]: *output error* y = B/F v + e minimises the simulation error, *Box–Jenkins* y = B/F
//!   v + C/D e adds a noise model and minimises the prediction error (Ljung 1999, §4.2, ch. 7), in z
//!   at the sample rate;
//! - [`fit_srivc`]: B(s)/A(s) in continuous time by simplified refined instrumental variables (Young,
//!   Garnier).
//!
//! Orders are selected by [`select_polynomial`] and [`select_srivc`].
//!
//! Source: L. Ljung, *System Identification: Theory for the User*, 2nd ed., Prentice Hall 1999.

mod covariance;
mod filter;
mod gauss_newton;
mod polynomial;
mod prediction_error;
mod roots;
mod select;
mod srivc;
mod steiglitz_mcbride;
mod variable_filter;

pub use polynomial::{PolynomialFit, PolynomialModel, PolynomialOrders, fit_polynomial};
pub use select::{Selected, select_polynomial, select_srivc};
pub use srivc::{SrivcFit, SrivcOrders, fit_srivc};

use hysteron_model::dynamics::DynamicsError;
use hysteron_model::dynamics::arx::ArxRecord;

/// Checks records of one fit, and that there are more samples than unknowns.
fn check(records: &[ArxRecord<'_>], unknowns: usize) -> Result<(), DynamicsError> {
    let mut rows = 0;
    for record in records {
        let samples = record.input.len();
        for (what, length) in
            [("output", record.output.len()), ("valid mask", record.valid.map_or(samples, <[bool]>::len))]
        {
            if length != samples {
                return Err(DynamicsError::Length { what, expected: samples, found: length });
            }
        }
        for (what, signal) in [("input", record.input), ("output", record.output)] {
            if let Some(index) = signal.iter().position(|x| !x.is_finite()) {
                return Err(DynamicsError::InputNotFinite { what, index, value: signal[index] });
            }
        }
        rows += (0..samples).filter(|&k| is_valid(record, k)).count();
    }
    let need = unknowns + records.len() + 1;
    if rows < need { Err(DynamicsError::TooFewSamples { need, found: rows }) } else { Ok(()) }
}

fn is_valid(record: &ArxRecord<'_>, k: usize) -> bool {
    record.valid.is_none_or(|valid| valid[k])
}

/// The output with masked samples interpolated linearly.
fn bridged(record: &ArxRecord<'_>) -> Vec<f64> {
    let mut y = record.output.to_vec();
    let valid: Vec<usize> = (0..y.len()).filter(|&k| is_valid(record, k)).collect();
    let (Some(&first), Some(&last)) = (valid.first(), valid.last()) else { return vec![0.0; y.len()] };
    let (start, end) = (y[first], y[last]);
    y[..first].fill(start);
    y[last..].fill(end);
    for pair in valid.windows(2) {
        let (from, to) = (y[pair[0]], y[pair[1]]);
        let steps = (pair[1] - pair[0]) as f64;
        for (k, y) in y[pair[0]..pair[1]].iter_mut().enumerate() {
            *y = from + (to - from) * k as f64 / steps;
        }
    }
    y
}
