//! The straight line through a model's loop: the feedforward of a stage without compensation.

use crate::hammerstein::Model;
use crate::hysteresis::HysteresisError;
use crate::start::Start;

/// Samples of half a loop.
const HALF: usize = 500;
/// Sizes of the loops, as shares of the range.
const SIZES: [f64; 4] = [1.0, 0.75, 0.5, 0.25];
/// Samples over which a slope is taken.
const SLOPE_OVER: usize = 10;

/// displacement = offset + slope · voltage at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightLine {
    /// Displacement at 0 V.
    pub offset: f64,
    /// Displacement per volt.
    pub slope: f64,
    /// Ratio of the largest slope of the hysteresis to the line's: the factor by which the loop gain exceeds
    /// that of its linear part.
    pub steepest: f64,
}

impl StraightLine {
    /// Least squares through slow loops of four sizes over the range; `slow_gain` is the gain of the dynamics
    /// along them.
    ///
    /// # Errors
    /// [`HysteresisError`] of the simulated loops.
    pub fn of_model(model: &Model, slow_gain: f64, [low, high]: [f64; 2]) -> Result<Self, HysteresisError> {
        let mut u = Vec::with_capacity(SIZES.len() * 2 * HALF);
        for size in SIZES {
            for k in 0..2 * HALF {
                let share = if k < HALF { k } else { 2 * HALF - k } as f64 / HALF as f64;
                u.push(0.5 * (low + high) + size * (high - low) * (share - 0.5));
            }
        }
        let mut v = vec![0.0; u.len()];
        model.hysteresis.simulate(&u, Start::Rest { voltage_v: low }, &mut v)?;
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let (u_mean, v_mean) = (mean(&u), mean(&v));
        let products: f64 = u.iter().zip(&v).map(|(u, v)| (u - u_mean) * (v - v_mean)).sum();
        let squares: f64 = u.iter().map(|u| (u - u_mean) * (u - u_mean)).sum();
        let slope = products / squares;
        let slopes = (SLOPE_OVER..u.len()).filter_map(|k| {
            let (from, to) = (k - SLOPE_OVER, k);
            let moved = u[to] - u[from];
            // No turning point in between.
            let full = 0.99 * SLOPE_OVER as f64 * (u[to] - u[to - 1]).abs();
            (moved.abs() >= full && moved != 0.0).then(|| (v[to] - v[from]) / moved)
        });
        let steepest = slopes.fold(slope, f64::max) / slope;
        let slope_um = slope * slow_gain;
        Ok(Self { offset: model.offset + slow_gain * (v_mean - slope * u_mean), slope: slope_um, steepest })
    }
}
