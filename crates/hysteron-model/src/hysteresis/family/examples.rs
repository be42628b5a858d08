//! An operator of every family, for tests of code that takes any family.

use super::DriveSpan;
use crate::hysteresis::{Hysteresis, HysteresisError, HysteresisForm};

/// Operators of every family over the voltages `ends`, each of a few elements; their output rises with the
/// voltage, by `slope` per volt or somewhat more. The drive is at most as fast as `fastest_rate` \[1/s\], for
/// half the range to either side.
///
/// # Errors
/// None where the ends are in order.
pub fn examples(ends: [f64; 2], fastest_rate: f64, slope: f64) -> Result<Vec<Hysteresis>, HysteresisError> {
    let stroke = ends[1] - ends[0];
    let span = DriveSpan { stroke, ends, grid: ends, fastest_rate, ..DriveSpan::UNIT };
    let of = |usual: HysteresisForm| {
        let form = (1..=4).rev().find_map(|count| usual.with_elements(count).ok()).unwrap_or(usual);
        let columns = form.columns();
        let weight = |index: usize| {
            let unit = form.description().weight_unit(index).input;
            // A column without the unit of the drive runs from -1 to 1.
            let size = stroke.powi(1 + unit) * if unit == 0 { 0.5 } else { 1.0 };
            // All different.
            0.3 * slope * size / columns as f64 * (1.0 + 0.7 * (1.7 * index as f64).sin())
        };
        let weights: Vec<f64> = (0..columns).map(|index| form.sign() * weight(index)).collect();
        form.operator(vec![slope, 0.02 * slope / stroke], &weights, &form.example(&span))
    };
    HysteresisForm::usual().into_iter().map(of).collect()
}
