//! The least-squares problem of a structure on a response, linear coefficients projected out.
//!
//! Residuals w_i (Σ_k c_k φ_k(s_i; x) − G_i), real parts then imaginary parts, c the minimiser for x. With A
//! the weighted functions, P⊥ = I − A A⁺ and r the residual, the Jacobian is exact (Golub and Pereyra 1973,
//! doi:10.1137/0710036): ∂r/∂x_j = P⊥ (∂A/∂x_j) c − (A⁺)ᵀ (∂A/∂x_j)ᵀ r.

use std::f64::consts::{SQRT_2, TAU};

use super::super::projection::Projection;
use super::{FrequencyResponse, Structure, Weighting};
use crate::IdentifyError;
use hysteron_model::record::NOISY;
use hysteron_numeric::Complex64;
use hysteron_numeric::dot;
use hysteron_optimize::{Bounds, Derivative, LeastSquaresProblem, Problem, root_mean_square};

/// Least-squares problem of a structure and a response.
pub(super) struct ResponseProblem {
    pub structure: Structure,
    bounds: Bounds,
    omega: Vec<f64>,
    weights: Vec<Complex64>,
    /// w G, real parts then imaginary parts.
    target: Vec<f64>,
}

/// Buffers of one evaluation.
pub(super) struct Buffers {
    values: Vec<Complex64>,
    slopes: Vec<Complex64>,
    /// A.
    functions: Vec<f64>,
    /// ∂A/∂x_j, one after the other.
    derivatives: Vec<f64>,
    projection: Projection,
    /// c.
    pub coefficients: Vec<f64>,
    residuals: Vec<f64>,
    products: Vec<f64>,
}

impl ResponseProblem {
    pub fn new(
        response: &FrequencyResponse,
        structure: Structure,
        weighting: Weighting,
    ) -> Result<Self, IdentifyError> {
        let (low, high) = response.range_hz();
        let omega: Vec<f64> = response.frequency_hz.iter().map(|f| TAU * f).collect();
        let weights = weights(response, weighting)?;
        let weighted = || weights.iter().zip(&response.values).map(|(w, g)| w * g);
        let target = weighted().map(|z| z.re).chain(weighted().map(|z| z.im)).collect();
        let bounds = Bounds { ranges: structure.ranges(low, high) };
        Ok(Self { structure, bounds, omega, weights, target })
    }

    fn rows(&self) -> usize {
        self.target.len()
    }

    /// Fills A, its derivatives, c and the residuals.
    fn evaluate(&self, x: &[f64], ws: &mut Buffers) {
        let (points, rows) = (self.omega.len(), self.rows());
        for (i, (&omega, weight)) in self.omega.iter().zip(&self.weights).enumerate() {
            self.structure.evaluate(omega, x, &mut ws.values, &mut ws.slopes);
            for (k, value) in ws.values.iter().enumerate() {
                let z = weight * value;
                ws.functions[k * rows + i] = z.re;
                ws.functions[k * rows + points + i] = z.im;
            }
            for (m, slope) in ws.slopes.iter().enumerate() {
                let z = weight * slope;
                ws.derivatives[m * rows + i] = z.re;
                ws.derivatives[m * rows + points + i] = z.im;
            }
        }
        ws.projection.decompose(&ws.functions);
        ws.projection.coefficients_into(&self.target, &mut ws.coefficients);
        ws.residuals.iter_mut().zip(&self.target).for_each(|(r, t)| *r = -t);
        for (c, column) in ws.coefficients.iter().zip(ws.functions.chunks_exact(rows)) {
            ws.residuals.iter_mut().zip(column).for_each(|(r, a)| *r += c * a);
        }
    }

    /// Linear coefficients at `x`.
    pub fn coefficients(&self, x: &[f64]) -> Vec<f64> {
        let mut ws = self.workspace();
        self.evaluate(x, &mut ws);
        ws.coefficients
    }

    /// Residuals at `x` and the Jacobian, column by column: nonlinear parameters, then coefficients.
    pub fn full_jacobian(&self, x: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut ws = self.workspace();
        self.evaluate(x, &mut ws);
        let rows = self.rows();
        let mut jacobian = vec![0.0; rows * self.structure.parameter_count()];
        let width = self.structure.linear_count();
        for (j, column) in jacobian.chunks_exact_mut(rows).enumerate() {
            if j < x.len() {
                add_products(&ws.derivatives[j * width * rows..], rows, &ws.coefficients, column);
            } else {
                let k = j - x.len();
                column.copy_from_slice(&ws.functions[k * rows..(k + 1) * rows]);
            }
        }
        (ws.residuals, jacobian)
    }
}

/// `out` += Σ_k c_k · column k.
fn add_products(columns: &[f64], rows: usize, coefficients: &[f64], out: &mut [f64]) {
    for (c, column) in coefficients.iter().zip(columns.chunks_exact(rows)) {
        out.iter_mut().zip(column).for_each(|(o, d)| *o += c * d);
    }
}

/// 1/G_i, smaller where neighbours scatter, or √2/σ_i so that real and imaginary part of a residual have
/// variance 1.
fn weights(response: &FrequencyResponse, weighting: Weighting) -> Result<Vec<Complex64>, IdentifyError> {
    match (weighting, &response.std_dev) {
        (Weighting::Uncertainty, Some(std_dev)) => {
            Ok(std_dev.iter().map(|s| Complex64::new(SQRT_2 / s, 0.0)).collect())
        }
        _ => match response.values.iter().position(|g| *g == Complex64::ZERO) {
            Some(index) => Err(response.bad_value(index, "usable for relative errors").into()),
            None if weighting == Weighting::Scatter => {
                let points = response.values.iter().zip(response.scatter());
                Ok(points.map(|(g, s)| g.inv() / (s / (NOISY * g.norm())).hypot(1.0)).collect())
            }
            None => Ok(response.values.iter().map(|g| g.inv()).collect()),
        },
    }
}

impl Problem for ResponseProblem {
    type Workspace = Buffers;

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) -> Buffers {
        let (rows, width) = (self.rows(), self.structure.linear_count());
        let parameters = self.structure.nonlinear_count();
        Buffers {
            values: vec![Complex64::ZERO; width],
            slopes: vec![Complex64::ZERO; width * parameters],
            functions: vec![0.0; width * rows],
            derivatives: vec![0.0; width * parameters * rows],
            projection: Projection::new(rows, width),
            coefficients: vec![0.0; width],
            residuals: vec![0.0; rows],
            products: vec![0.0; width],
        }
    }

    fn cost(&self, x: &[f64], ws: &mut Buffers) -> f64 {
        self.evaluate(x, ws);
        root_mean_square(&ws.residuals)
    }
}

impl LeastSquaresProblem for ResponseProblem {
    fn residual_count(&self) -> usize {
        self.rows()
    }

    fn residuals(&self, x: &[f64], ws: &mut Buffers, out: &mut [f64]) -> bool {
        self.evaluate(x, ws);
        out.copy_from_slice(&ws.residuals);
        out.iter().all(|r| r.is_finite())
    }

    fn jacobian(&self, x: &[f64], ws: &mut Buffers, out: &mut [f64]) -> Derivative {
        self.evaluate(x, ws);
        let (rows, width) = (self.rows(), self.structure.linear_count());
        for (j, column) in out.chunks_exact_mut(rows).enumerate() {
            let derivative = &ws.derivatives[j * width * rows..(j + 1) * width * rows];
            column.fill(0.0);
            add_products(derivative, rows, &ws.coefficients, column);
            ws.projection.project(column);
            for (product, d) in ws.products.iter_mut().zip(derivative.chunks_exact(rows)) {
                *product = dot(d, &ws.residuals);
            }
            ws.projection.subtract_pseudo_inverse_transposed(&mut ws.products, column);
        }
        if out.iter().all(|d| d.is_finite()) { Derivative::Written } else { Derivative::Infeasible }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Core;
    use super::*;

    #[test]
    fn jacobian_of_the_projected_residuals_agrees_with_differences_of_sixth_order() {
        let f: Vec<f64> = (0..12).map(|k| 1.5f64.powi(k)).collect();
        let g = f.iter().map(|f| Complex64::new(1.0 / (1.0 + 0.01 * f), -0.3 + 0.002 * f)).collect();
        let response = FrequencyResponse::new("g", f, g).unwrap();
        let rational = Structure::of(Core::Rational { poles: 3, direct: true });
        for structure in [
            Structure::LOSS_ANGLE.with_delay(),
            Structure::of(Core::FractionalOscillator).with_power_law(),
            rational.with_power_law().with_delay(),
        ] {
            let problem = ResponseProblem::new(&response, structure, Weighting::Relative).unwrap();
            let mut ws = problem.workspace();
            let x: Vec<f64> = problem.bounds().ranges.iter().map(|r| r.from_unit(0.47)).collect();
            let rows = problem.residual_count();
            let mut exact = vec![0.0; rows * x.len()];
            assert_eq!(problem.jacobian(&x, &mut ws, &mut exact), Derivative::Written);
            let mut at = |j: usize, h: f64| {
                let mut moved = x.clone();
                moved[j] += h;
                let mut out = vec![0.0; rows];
                assert!(problem.residuals(&moved, &mut ws, &mut out));
                out
            };
            for j in 0..x.len() {
                let h = 1e-3 * x[j].abs().max(1e-4);
                let sides: Vec<_> = [1.0, 2.0, 3.0].map(|k| (at(j, k * h), at(j, -k * h))).into();
                let column = &exact[j * rows..(j + 1) * rows];
                let scale = column.iter().fold(0.0f64, |m, d| m.max(d.abs()));
                for (i, exact) in column.iter().enumerate() {
                    let d = |m: usize| sides[m].0[i] - sides[m].1[i];
                    let difference = (45.0 * d(0) - 9.0 * d(1) + d(2)) / (60.0 * h);
                    assert!((difference - exact).abs() <= 1e-7 * scale, "{structure}: {difference} {exact}");
                }
            }
        }
    }
}
