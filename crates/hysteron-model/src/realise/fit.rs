//! Weights of given poles by linear least squares, and how many poles of the branch cut it takes.

use nalgebra::{DMatrix, DVector};

use super::target::{Pole, Target};
use hysteron_numeric::Complex64;

/// Singular values below this share of the largest are left out: they gain accuracy by weights that cancel.
const SMALLEST: f64 = 1e-11;

/// A point of the fit: angle θ = ωh, and the weight of an error there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub theta: f64,
    pub weight: f64,
}

/// taps + sections on the plane of the target.
#[derive(Clone, Debug)]
pub(super) struct FittedSections {
    pub taps: Vec<f64>,
    /// Poles with their weights, whose imaginary part is 0 for a real pole.
    pub poles: Vec<(Pole, Complex64)>,
}

impl FittedSections {
    pub fn at(&self, target: Target<'_>, theta: f64) -> Complex64 {
        let q = Complex64::from_polar(1.0, -theta);
        let taps = self.taps.iter().rev().fold(Complex64::ZERO, |sum, &tap| sum * q + tap);
        self.poles.iter().fold(taps, |sum, &(pole, weight)| {
            let [re, im] = target.basis(pole, self.taps.len(), theta);
            sum + re * weight.re + im * weight.im
        })
    }
}

/// Least squares over `points` for the weights of `poles` and of `taps` taps. A prescribed static gain is met
/// exactly, by the first tap. `None` where the equations cannot be solved.
pub(super) fn weights(
    target: Target<'_>,
    at_rest: Option<f64>,
    points: &[Point],
    poles: &[Pole],
    taps: usize,
) -> Option<FittedSections> {
    let tied = at_rest.is_some();
    let at_rest = at_rest.unwrap_or(0.0);
    let columns: usize = poles.iter().map(|p| if p.is_pair() { 2 } else { 1 }).sum();
    let free_taps = taps - usize::from(tied);
    let (rows, columns) = (2 * points.len(), columns + free_taps);
    let mut matrix = DMatrix::zeros(rows, columns);
    let mut right = DVector::zeros(rows);
    for (i, point) in points.iter().enumerate() {
        let mut put = |column: usize, z: Complex64| {
            matrix[(2 * i, column)] = z.re * point.weight;
            matrix[(2 * i + 1, column)] = z.im * point.weight;
        };
        // Every function minus its value at rest, which the first tap compensates.
        let less = |z: Complex64, at_rest: f64| if tied { z - at_rest } else { z };
        let mut column = 0;
        for tap in usize::from(tied)..taps {
            put(column, less(Complex64::from_polar(1.0, -point.theta * tap as f64), 1.0));
            column += 1;
        }
        for &pole in poles {
            let [re, im] = target.basis(pole, taps, point.theta);
            put(column, less(re, 1.0));
            column += 1;
            if pole.is_pair() {
                put(column, im);
                column += 1;
            }
        }
        let value = less(target.at(point.theta), at_rest) * point.weight;
        (right[2 * i], right[2 * i + 1]) = (value.re, value.im);
    }
    let solution = solve(matrix, &right)?;
    let mut solution = solution.iter().copied();
    let mut next = || solution.next().unwrap_or(0.0);
    let mut all_taps = vec![0.0; taps];
    all_taps.iter_mut().skip(usize::from(tied)).for_each(|tap| *tap = next());
    let poles: Vec<(Pole, Complex64)> = poles
        .iter()
        .map(|&pole| (pole, Complex64::new(next(), if pole.is_pair() { next() } else { 0.0 })))
        .collect();
    if tied && let Some((first, others)) = all_taps.split_first_mut() {
        *first = at_rest - others.iter().sum::<f64>() - poles.iter().map(|(_, c)| c.re).sum::<f64>();
    }
    Some(FittedSections { taps: all_taps, poles })
}

/// Least squares with columns of unit length, small singular values left out; `None` where a response is beyond
/// all numbers.
fn solve(mut matrix: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    if matrix.ncols() == 0 {
        return Some(DVector::zeros(0));
    }
    let mut lengths: Vec<f64> = matrix.column_iter().map(|c| c.norm()).collect();
    if !lengths.iter().all(|length| length.is_finite()) {
        return None;
    }
    for (mut column, length) in matrix.column_iter_mut().zip(&mut lengths) {
        *length = length.max(f64::MIN_POSITIVE);
        column /= *length;
    }
    // The triangle is small, the matrix is tall.
    let qr = matrix.qr();
    let mut rotated = right.clone();
    qr.q_tr_mul(&mut rotated);
    let svd = qr.r().try_svd(true, true, f64::EPSILON, 2000)?;
    let head = rotated.rows(0, svd.singular_values.len()).into_owned();
    let largest = svd.singular_values.iter().copied().fold(0.0, f64::max);
    let mut solution = svd.solve(&head, SMALLEST * largest).ok()?;
    for (x, length) in solution.iter_mut().zip(&lengths) {
        *x /= length;
    }
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}
