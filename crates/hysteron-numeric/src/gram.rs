//! Inner products of all pairs of columns.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::InstructionSet;
use super::dispatch::inner_product;

/// Rows of all columns that fit the cache together.
const BLOCK: usize = 512;
/// Rows per task of a thread.
const SHARE: usize = 8 * BLOCK;

/// ΦᵀΦ of the columns of Φ, all of one length. The grouping of the sums does not depend on the threads.
pub fn gram(columns: &[&[f64]]) -> DMatrix<f64> {
    let width = columns.len();
    let rows = columns.first().map_or(0, |column| column.len());
    let set = InstructionSet::detected();
    let mut parts = vec![0.0; rows.div_ceil(SHARE) * width * width];
    parts.par_chunks_exact_mut((width * width).max(1)).enumerate().for_each(|(share, part)| {
        let end = rows.min((share + 1) * SHARE);
        for first in (share * SHARE..end).step_by(BLOCK) {
            let rows = first..end.min(first + BLOCK);
            for (j, (sums, column)) in part.chunks_exact_mut(width).zip(columns).enumerate() {
                for (sum, other) in sums.iter_mut().zip(&columns[..=j]) {
                    *sum += inner_product(set, &column[rows.clone()], &other[rows.clone()]);
                }
            }
        }
    });
    let mut whole = DMatrix::zeros(width, width);
    for part in parts.chunks_exact((width * width).max(1)) {
        whole.as_mut_slice().iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
    }
    whole.fill_lower_triangle_with_upper_triangle();
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_the_product_of_the_matrix() {
        for rows in [0, 1, 511, 513, 9000] {
            let phi = DMatrix::from_fn(rows, 6, |i, j| ((i * (2 * j + 3)) as f64 * 0.37).sin());
            let columns: Vec<&[f64]> = phi.as_slice().chunks_exact(rows.max(1)).collect();
            let columns = if rows == 0 { vec![&[][..]; 6] } else { columns };
            let apart = (gram(&columns) - phi.tr_mul(&phi)).amax();
            assert!(apart < 1e-13 * rows.max(1) as f64, "{rows}: {apart}");
        }
        assert_eq!(gram(&[]).len(), 0);
    }
}
