//! Levenberg–Marquardt for a few unbounded unknowns with exact derivatives.

use nalgebra::{DMatrix, DVector};

/// Residuals with their derivatives.
pub(super) struct Linearisation {
    pub(super) residual: DVector<f64>,
    pub(super) jacobian: DMatrix<f64>,
}

/// Result of a search.
pub(super) struct Optimum {
    pub(super) x: Vec<f64>,
    pub(super) at: Linearisation,
    pub(super) iterations: usize,
    /// No step reduced the cost by more than rounding, or the steps became negligible.
    pub(super) converged: bool,
}

const ITERATIONS: usize = 100;
/// Step relative to the unknowns below which it is negligible.
const STEP: f64 = 1e-12;
/// Relative reduction of the sum of squares below which it is negligible.
const GAIN: f64 = 1e-13;

/// Least squares from `start`; `at` gives residuals and derivatives, or `None` where the model is not
/// admissible.
pub(super) fn minimise(start: Vec<f64>, at: impl Fn(&[f64]) -> Option<Linearisation>) -> Option<Optimum> {
    let mut best = at(&start)?;
    let mut x = DVector::from_vec(start);
    let mut cost = best.residual.norm_squared();
    let (mut damping, mut iterations, mut converged) = (1e-4, 0, false);
    while iterations < ITERATIONS && !converged {
        iterations += 1;
        let scale: Vec<f64> = best.jacobian.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
        let scaled = |j: usize, x: f64| x / scale[j];
        let normal = best.jacobian.tr_mul(&best.jacobian);
        let normal = normal.map_with_location(|i, j, x| x / (scale[i] * scale[j]));
        let gradient = best.jacobian.tr_mul(&best.residual).map_with_location(|j, _, g| -scaled(j, g));
        let mut moved = false;
        while damping < 1e12 {
            let mut damped = normal.clone();
            for j in 0..scale.len() {
                damped[(j, j)] += damping;
            }
            let Some(step) = damped.cholesky().map(|c| c.solve(&gradient)) else {
                damping *= 10.0;
                continue;
            };
            let step = step.map_with_location(|j, _, d| scaled(j, d));
            let next = &x + &step;
            let small = step.iter().zip(&next).all(|(d, x)| d.abs() <= STEP * x.abs());
            let found = at(next.as_slice()).filter(|f| f.residual.norm_squared() < cost);
            if let Some(found) = found {
                let before = std::mem::replace(&mut cost, found.residual.norm_squared());
                (x, best, moved) = (next, found, true);
                damping = (0.1 * damping).max(1e-15);
                converged = small || before - cost <= GAIN * before;
                break;
            }
            if small {
                break;
            }
            damping = (10.0 * damping).max(1e-8);
        }
        converged |= !moved;
    }
    Some(Optimum { x: x.as_slice().to_vec(), at: best, iterations, converged })
}
