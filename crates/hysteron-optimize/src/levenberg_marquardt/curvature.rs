//! The part of the Hessian that Gauss–Newton leaves out, S ≈ Σ rᵢ ∇²rᵢ, by secants.
//!
//! Where residuals stay large at the optimum, as of a model that lacks something of the device, Gauss–Newton
//! steps are too long in directions of large S, and the fit goes to and fro. S follows from the gradients
//! before and after each step (Dennis, Gay and Welsch 1981, "An adaptive nonlinear least-squares algorithm",
//! doi:10.1145/355958.355965): with s the step, y = J₊ᵀr₊ − Jᵀr and y♯ = J₊ᵀr₊ − Jᵀr₊, S₊ s = y♯, by the
//! symmetric update nearest to the sized S. It takes part in the step as long as it predicts the fall of the
//! last one better.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Smallest cosine between s and y for an update.
const LEAST_COSINE: f64 = 1e-8;

/// S, and whether it is used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Curvature {
    /// Column by column.
    matrix: Vec<f64>,
    last: Option<Secant>,
    is_used: bool,
}

/// The last accepted step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Secant {
    pub(super) step: Vec<f64>,
    /// Jᵀr before it.
    pub(super) gradient: Vec<f64>,
    /// Jᵀr₊: the Jacobian before it, the residuals after it.
    pub(super) crossed: Vec<f64>,
}

impl Curvature {
    pub(super) fn none(dimension: usize) -> Self {
        Self { matrix: vec![0.0; dimension * dimension], last: None, is_used: false }
    }

    pub(super) fn is_consistent(&self, dimension: usize) -> bool {
        let is_vector = |x: &Vec<f64>| x.len() == dimension && x.iter().all(|x| x.is_finite());
        self.matrix.len() == dimension * dimension
            && self.matrix.iter().all(|x| x.is_finite())
            && self
                .last
                .as_ref()
                .is_none_or(|last| [&last.step, &last.gradient, &last.crossed].into_iter().all(is_vector))
    }

    /// S where it is used.
    pub(super) fn used(&self) -> Option<DMatrix<f64>> {
        self.is_used.then(|| self.matrix())
    }

    fn matrix(&self) -> DMatrix<f64> {
        let dimension = self.matrix.len().isqrt();
        DMatrix::from_column_slice(dimension, dimension, &self.matrix)
    }

    /// Learns from the gradient at the point of the last accepted step.
    pub(super) fn update(&mut self, gradient: &DVector<f64>) {
        let Some(Secant { step, gradient: before, crossed }) = self.last.take() else { return };
        let s = DVector::from_vec(step);
        let y = gradient - DVector::from_vec(before);
        let wanted = gradient - DVector::from_vec(crossed);
        let along = y.dot(&s);
        if along.is_nan() || along <= LEAST_COSINE * y.norm() * s.norm() {
            return;
        }
        let mut matrix = self.matrix();
        let known = s.dot(&(&matrix * &s)).abs();
        // S changes with the residuals: it is sized down where they have fallen.
        if known > 0.0 {
            matrix *= (s.dot(&wanted).abs() / known).min(1.0);
        }
        let off = wanted - &matrix * &s;
        let scaled = &y / along;
        matrix += &off * scaled.transpose() + &scaled * off.transpose()
            - &scaled * scaled.transpose() * s.dot(&off);
        if matrix.iter().all(|x| x.is_finite()) {
            self.matrix = matrix.as_slice().to_vec();
        }
    }

    /// Notes an accepted step with its `fall` of ½‖r‖² and that predicted by Gauss–Newton.
    pub(super) fn note(&mut self, secant: Secant, fall: f64, predicted: f64) {
        let s = DVector::from_column_slice(&secant.step);
        let with = predicted - 0.5 * s.dot(&(self.matrix() * &s));
        self.is_used = (with - fall).abs() < (predicted - fall).abs();
        self.last = Some(secant);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gradients of a quadratic whose Gauss–Newton part is 1: S is what is left of its Hessian along every
    /// step so far.
    #[test]
    fn secants_are_met() {
        let hessian = DMatrix::from_row_slice(3, 3, &[3.0, 0.4, -0.2, 0.4, 2.0, 0.5, -0.2, 0.5, 1.5]);
        let mut curvature = Curvature::none(3);
        let mut at = DVector::from_vec(vec![1.0, -2.0, 0.5]);
        for step in [[0.3, 0.1, -0.2], [-0.1, 0.4, 0.2], [0.2, -0.1, 0.3]] {
            let step = DVector::from_column_slice(&step);
            let gradient = &hessian * &at;
            at += &step;
            let after = &hessian * &at;
            // J₊ᵀr₊ − Jᵀr₊ = (H − 1) s.
            let crossed = &after - (&hessian * &step - &step);
            let vectors = [&step, &gradient, &crossed].map(|x| x.as_slice().to_vec());
            let [step_taken, gradient, crossed] = vectors;
            curvature.note(Secant { step: step_taken, gradient, crossed }, 1.0, 1.0);
            curvature.update(&after);
            let found = curvature.matrix();
            assert!((&found - found.transpose()).norm() < 1e-12);
            assert!((&found * &step - (&hessian * &step - &step)).norm() < 1e-12);
        }
        // It predicts the fall better where that is less than by Gauss–Newton.
        let secant = Secant { step: vec![0.3, 0.1, -0.2], gradient: vec![0.0; 3], crossed: vec![0.0; 3] };
        curvature.note(secant.clone(), 0.9, 1.0);
        assert!(curvature.used().is_some());
        curvature.note(secant, 1.0, 1.0);
        assert!(curvature.used().is_none());
    }
}
