//! Cholesky factor of a large matrix.

use nalgebra::{Cholesky, DMatrix, Dyn};

/// Columns factored at once: small enough for the cache, wide enough for the products.
const BLOCK: usize = 64;

/// The factor L of a symmetric positive definite A = L Lᵀ, of which the lower triangle is read: as
/// [`DMatrix::cholesky`], block by block, so that nearly all of it is matrix products (G. H. Golub, C. F. Van Loan,
/// *Matrix Computations*, 4th ed., § 4.2.6). `None` where A is not positive definite.
pub fn cholesky(mut a: DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    let order = a.nrows();
    for first in (0..order).step_by(BLOCK) {
        let width = BLOCK.min(order - first);
        let diagonal = a.view((first, first), (width, width)).into_owned().cholesky()?.unpack();
        a.view_mut((first, first), (width, width)).copy_from(&diagonal);
        let below = first + width;
        let height = order - below;
        // L₂₁ = A₂₁ L₁₁⁻ᵀ, then A₂₂ − L₂₁ L₂₁ᵀ on and below the diagonal.
        let mut right = a.view((below, first), (height, width)).transpose();
        diagonal.solve_lower_triangular_mut(&mut right);
        let left = right.transpose();
        a.view_mut((below, first), (height, width)).copy_from(&left);
        for column in (0..height).step_by(BLOCK) {
            let (rows, columns) = (height - column, BLOCK.min(height - column));
            let mut rest = a.view_mut((below + column, below + column), (rows, columns));
            rest.gemm(-1.0, &left.rows(column, rows), &right.columns(column, columns), 1.0);
        }
    }
    Some(Cholesky::pack_dirty(a))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positive definite, with scales of its own in every row.
    fn definite(order: usize) -> DMatrix<f64> {
        let entry = |i: usize, j: usize| {
            ((i * i * 7 + j * j * 13 + i * j * 31) as f64).sin() * 2.0_f64.powi(i as i32 % 9 - 4)
        };
        let root = DMatrix::from_fn(order, order + 3, entry);
        &root * root.transpose() + DMatrix::identity(order, order) * 1e-3
    }

    #[test]
    fn the_solution_is_that_of_the_factor_column_by_column() {
        for order in [1, 5, 63, 64, 65, 66, 131, 200] {
            let a = definite(order);
            let b = DMatrix::from_fn(order, 2, |i, j| (i as f64 - 3.0 * j as f64).cos());
            let (blocks, columns) = (cholesky(a.clone()).unwrap(), a.clone().cholesky().unwrap());
            let size = a.diagonal().max().sqrt();
            assert!((blocks.l() - columns.l()).amax() < 1e-9 * size, "{order}");
            assert!((&a * blocks.solve(&b) - &b).amax() < 1e-9, "{order}");
            let product = blocks.l() * blocks.l().transpose();
            assert!((product - &a).amax() < 1e-13 * size * size, "{order}");
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_has_none() {
        for order in [1, 64, 100] {
            let mut a = definite(order);
            a[(order - 1, order - 1)] = -1.0;
            assert!(cholesky(a.clone()).is_none() && a.cholesky().is_none());
            let mut a = definite(order);
            a[(order - 1, 0)] = f64::NAN;
            assert!(cholesky(a).is_none());
        }
    }
}
