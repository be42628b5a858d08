//! Linear least squares of a tall matrix.

use nalgebra::{ComplexField, DMatrix};

/// Solution of a linear least-squares problem.
#[derive(Clone, Debug)]
pub struct LeastSquares<T: ComplexField<RealField = f64>> {
    /// X that minimises ‖A X − B‖, one column per right-hand side.
    pub solution: DMatrix<T>,
    /// ‖A X − B‖² of each right-hand side.
    pub left: Vec<f64>,
    /// R of A with columns scaled to length 1, and their lengths.
    triangle: DMatrix<T>,
    lengths: Vec<f64>,
}

impl<T: ComplexField<RealField = f64>> LeastSquares<T> {
    /// Standard deviation of each unknown for uncorrelated errors of unit standard deviation; `None` where
    /// one is not determined.
    pub fn deviations(&self) -> Option<Vec<f64>> {
        let columns = self.lengths.len();
        let inverse = self.triangle.solve_upper_triangular(&DMatrix::identity(columns, columns))?;
        Some((0..columns).map(|j| inverse.row(j).norm() / self.lengths[j]).collect())
    }
}

/// Minimises ‖A X − B‖ by Householder reflections of A with its columns scaled to length 1.
///
/// # Errors
/// The first column that is zero, not finite, or of which no more than the share `dependent` lies outside the
/// span of those before it.
pub fn least_squares<T: ComplexField<RealField = f64>>(
    mut a: DMatrix<T>,
    mut b: DMatrix<T>,
    dependent: f64,
) -> Result<LeastSquares<T>, usize> {
    let columns = a.ncols();
    let lengths: Vec<f64> = a.column_iter().map(|column| column.norm()).collect();
    if let Some(column) = lengths.iter().position(|length| !(*length > 0.0 && length.is_finite())) {
        return Err(column);
    }
    if a.nrows() < columns {
        return Err(a.nrows());
    }
    a.column_iter_mut().zip(&lengths).for_each(|(mut column, length)| column.unscale_mut(*length));
    let qr = a.qr();
    qr.q_tr_mul(&mut b);
    let triangle = qr.unpack_r();
    let is_dependent = |j: &usize| {
        let apart = triangle[(*j, *j)].clone().modulus();
        apart.is_nan() || apart <= dependent
    };
    if let Some(column) = (0..columns).find(is_dependent) {
        return Err(column);
    }
    let left = b.rows(columns, b.nrows() - columns).column_iter().map(|rest| rest.norm_squared()).collect();
    let last = columns.saturating_sub(1);
    let mut solution = triangle.solve_upper_triangular(&b.rows(0, columns)).ok_or(last)?;
    solution.row_iter_mut().zip(&lengths).for_each(|(mut row, length)| row.unscale_mut(*length));
    if solution.iter().all(|x| x.is_finite()) {
        Ok(LeastSquares { solution, left, triangle, lengths })
    } else {
        Err(last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Complex;

    fn matrix() -> DMatrix<f64> {
        DMatrix::from_fn(9, 3, |i, j| ((i * i + 3 * i * j) % 7) as f64 + 0.1 * (i + j) as f64)
    }

    #[test]
    fn solution_residual_and_deviations_are_those_of_the_pseudo_inverse() {
        let a = matrix();
        let b = DMatrix::from_fn(9, 2, |i, j| (1.3 * i as f64 + j as f64).sin());
        let found = least_squares(a.clone(), b.clone(), 1e-12).unwrap();
        let pseudo = a.clone().pseudo_inverse(1e-12).unwrap();
        assert!((&found.solution - &pseudo * &b).norm() < 1e-13);
        let rest = &a * &found.solution - &b;
        for (j, left) in found.left.iter().enumerate() {
            assert!((left - rest.column(j).norm_squared()).abs() < 1e-13);
        }
        let covariance = (a.transpose() * &a).try_inverse().unwrap();
        for (j, deviation) in found.deviations().unwrap().iter().enumerate() {
            assert!((deviation - covariance[(j, j)].sqrt()).abs() < 1e-13);
        }
    }

    #[test]
    fn complex_right_sides_are_met() {
        let a = matrix().map(|x| Complex::new(x, 1.0 - 0.3 * x * x));
        let x = DMatrix::from_fn(3, 1, |i, _| Complex::new(i as f64, 2.0 - i as f64));
        let found = least_squares(a.clone(), &a * &x, 1e-12).unwrap();
        assert!((found.solution - x).norm() < 1e-12 && found.left[0] < 1e-22);
    }

    #[test]
    fn a_dependent_column_is_named() {
        let mut a = matrix();
        let sum = a.column(0) * 2.0 - a.column(1);
        a.set_column(2, &sum);
        let right = DMatrix::from_element(9, 1, 1.0);
        assert_eq!(least_squares(a.clone(), right.clone(), 1e-12).unwrap_err(), 2);
        a.column_mut(1).fill(0.0);
        assert_eq!(least_squares(a.clone(), right.clone(), 1e-12).unwrap_err(), 1);
        assert_eq!(
            least_squares(a.rows(0, 2).into_owned(), right.rows(0, 2).into_owned(), 1e-12).unwrap_err(),
            1
        );
    }
}
