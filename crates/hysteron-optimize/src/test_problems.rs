//! Classical problems with known minima, for the tests of this crate.

use super::{Bounds, LeastSquaresProblem, Problem, Range, root_mean_square};

/// A cost given by a function.
pub(super) struct Cost<F> {
    pub(super) bounds: Bounds,
    pub(super) cost: F,
}

impl<F: Fn(&[f64]) -> f64 + Sync> Problem for Cost<F> {
    type Workspace = ();

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) {}

    fn cost(&self, x: &[f64], _: &mut ()) -> f64 {
        (self.cost)(x)
    }
}

/// Residuals given by a function, which answers whether the point is feasible.
pub(super) struct Residuals<F> {
    pub(super) bounds: Bounds,
    pub(super) count: usize,
    pub(super) residuals: F,
}

impl<F: Fn(&[f64], &mut [f64]) -> bool + Sync> Problem for Residuals<F> {
    type Workspace = Vec<f64>;

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) -> Vec<f64> {
        vec![0.0; self.count]
    }

    fn cost(&self, x: &[f64], workspace: &mut Vec<f64>) -> f64 {
        if (self.residuals)(x, workspace) { root_mean_square(workspace) } else { f64::INFINITY }
    }

    fn identity(&self) -> String {
        "test residuals".to_owned()
    }
}

impl<F: Fn(&[f64], &mut [f64]) -> bool + Sync> LeastSquaresProblem for Residuals<F> {
    fn residual_count(&self) -> usize {
        self.count
    }

    fn residuals(&self, x: &[f64], _: &mut Vec<f64>, out: &mut [f64]) -> bool {
        (self.residuals)(x, out)
    }
}

pub(super) fn cube(dimension: usize, low: f64, high: f64) -> Bounds {
    Bounds { ranges: (0..dimension).map(|j| Range::linear(&format!("x{j}"), low, high)).collect() }
}

pub(super) fn sphere(dimension: usize) -> Cost<impl Fn(&[f64]) -> f64 + Sync> {
    Cost { bounds: cube(dimension, -5.12, 7.0), cost: |x: &[f64]| x.iter().map(|x| x * x).sum() }
}

pub(super) fn rastrigin(dimension: usize) -> Cost<impl Fn(&[f64]) -> f64 + Sync> {
    let cost = |x: &[f64]| x.iter().map(|x| x * x - 10.0 * (std::f64::consts::TAU * x).cos() + 10.0).sum();
    Cost { bounds: cube(dimension, -5.12, 4.0), cost }
}

pub(super) type ResidualFunction = fn(&[f64], &mut [f64]) -> bool;

/// (10 (x₂ − x₁²), 1 − x₁); minimum 0 at (1, 1).
pub(super) fn rosenbrock(bounds: Bounds) -> Residuals<ResidualFunction> {
    let residuals: ResidualFunction = |x, out| {
        out.copy_from_slice(&[10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]);
        true
    };
    Residuals { bounds, count: 2, residuals }
}

/// Powell's singular function, Moré, Garbow and Hillstrom 1981 (doi:10.1145/355934.355936) no. 13; minimum 0
/// at 0, where the Jacobian has rank 2.
pub(super) fn powell_singular() -> Residuals<ResidualFunction> {
    let residuals: ResidualFunction = |x, out| {
        out[0] = x[0] + 10.0 * x[1];
        out[1] = 5.0_f64.sqrt() * (x[2] - x[3]);
        out[2] = (x[1] - 2.0 * x[2]).powi(2);
        out[3] = 10.0_f64.sqrt() * (x[0] - x[3]).powi(2);
        true
    };
    Residuals { bounds: cube(4, -4.0, 5.0), count: 4, residuals }
}

/// Bard's function, no. 8 there; minimum of the sum of squares 8.21487e−3.
pub(super) fn bard() -> Residuals<ResidualFunction> {
    let residuals: ResidualFunction = |x, out| {
        let y = [0.14, 0.18, 0.22, 0.25, 0.29, 0.32, 0.35, 0.39, 0.37, 0.58, 0.73, 0.96, 1.34, 2.10, 4.39];
        for (i, (y, r)) in y.iter().zip(out).enumerate() {
            let (u, v) = ((i + 1) as f64, (15 - i) as f64);
            *r = y - (x[0] + u / (v * x[1] + u.min(v) * x[2]));
        }
        true
    };
    Residuals { bounds: cube(3, 0.01, 10.0), count: 15, residuals }
}

/// Kowalik and Osborne's function, no. 15 there; minimum of the sum of squares 3.07505e−4.
pub(super) fn kowalik_osborne() -> Residuals<ResidualFunction> {
    let residuals: ResidualFunction = |x, out| {
        let y = [0.1957, 0.1947, 0.1735, 0.1600, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246];
        let u = [4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625_f64];
        for ((y, u), r) in y.iter().zip(u).zip(out) {
            *r = y - x[0] * (u * u + u * x[1]) / (u * u + u * x[2] + x[3]);
        }
        true
    };
    Residuals { bounds: cube(4, 0.0, 1.0), count: 11, residuals }
}

/// Brown and Dennis's function, no. 16 there, whose residuals stay large; minimum of the sum of squares
/// 85822.2.
pub(super) fn brown_dennis() -> Residuals<ResidualFunction> {
    let residuals: ResidualFunction = |x, out| {
        for (i, r) in (1..).zip(out) {
            let t = 0.2 * f64::from(i);
            *r = (x[0] + t * x[1] - t.exp()).powi(2) + (x[2] + x[3] * t.sin() - t.cos()).powi(2);
        }
        true
    };
    Residuals { bounds: cube(4, -50.0, 50.0), count: 20, residuals }
}
