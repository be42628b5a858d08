//! Start of a fit to the training data of a fold.

use nalgebra::{DMatrix, DVector};

use super::super::joint::{JointProblem, information};
use hysteron_numeric::dot;
use hysteron_optimize::{Derivative, LeastSquaresProblem, Problem, Range};

/// Directions with a larger standard error, in shares of the ranges, are not determined.
const LOOSE: f64 = 0.05;
/// Share of the way to the middle of the box.
const AWAY: f64 = 0.25;
/// Step of the differences, in shares of a range.
const STEP: f64 = 1e-6;

/// The point `x`, optimum of a fit to more data, with everything that the data of `problem` do not determine
/// moved part of the way to the middle of the box: it must not keep values from the other data. What they do
/// determine, a fit finds again from wherever it starts.
///
/// The directions are the eigenvectors of s⁻² Jᵀ J/ρ in shares of the ranges, with s² the mean square of the
/// residuals and ρ the samples to an independent one.
pub(super) fn without_what_is_loose(problem: &JointProblem, x: &[f64]) -> Vec<f64> {
    if x.is_empty() {
        return Vec::new();
    }
    let ranges = &problem.bounds().ranges;
    let at: Vec<f64> = ranges.iter().zip(x).map(|(range, &x)| range.to_unit(x)).collect();
    let moved = |apart: &DVector<f64>| -> Vec<f64> {
        let of = |((range, at), apart): ((&Range, &f64), &f64)| {
            range.from_unit((at + AWAY * apart).clamp(0.0, 1.0))
        };
        ranges.iter().zip(&at).zip(apart.iter()).map(of).collect()
    };
    let to_middle = DVector::from_iterator(at.len(), at.iter().map(|at| 0.5 - at));
    let Some(information) = information_matrix(problem, x, &at) else { return moved(&to_middle) };
    let eigen = information.symmetric_eigen();
    let mut apart = DVector::zeros(at.len());
    for (value, direction) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value < LOOSE.powi(-2) {
            apart += direction * direction.dot(&to_middle);
        }
    }
    moved(&apart)
}

/// Inverse covariance of the searched numbers in shares of their ranges; `None` where the problem has no
/// derivatives.
fn information_matrix(problem: &JointProblem, x: &[f64], at: &[f64]) -> Option<DMatrix<f64>> {
    let (rows, count) = (problem.residual_count(), x.len());
    let (mut residuals, mut jacobian) = (vec![0.0; rows], vec![0.0; rows * count]);
    let mut ws = problem.workspace();
    if !problem.residuals(x, &mut ws, &mut residuals)
        || problem.jacobian(x, &mut ws, &mut jacobian) != Derivative::Written
    {
        return None;
    }
    for ((column, range), &at) in jacobian.chunks_exact_mut(rows).zip(&problem.bounds().ranges).zip(at) {
        let [low, high] = [at - STEP, at + STEP].map(|at| range.from_unit(at.clamp(0.0, 1.0)));
        let [from, to] = [low, high].map(|x| range.to_unit(x));
        let slope = (high - low) / (to - from);
        column.iter_mut().for_each(|d| *d *= slope);
    }
    let square = dot(&residuals, &residuals);
    let columns: Vec<&[f64]> = jacobian.chunks_exact(rows).collect();
    let scale = information(problem, x) / square;
    let matrix = DMatrix::from_fn(count, count, |i, j| scale * dot(columns[i], columns[j]));
    matrix.iter().all(|value| value.is_finite()).then_some(matrix)
}
