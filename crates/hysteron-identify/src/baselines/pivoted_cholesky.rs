//! Low-rank factor of a kernel matrix.

use nalgebra::DMatrix;

/// Pivots below this end the factorisation.
const SMALLEST: f64 = 1e-12;

/// exp(−‖a − b‖²/(2ℓ²)).
pub(super) fn gaussian(a: &[f64], b: &[f64], width: f64) -> f64 {
    let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    (-0.5 * square / (width * width)).exp()
}

/// K ≈ L Lᵀ by Cholesky's method with the largest remaining diagonal as pivot (S. Fine, K. Scheinberg, J.
/// Mach. Learn. Res. 2 (2001) 243–264). The pivots are the centres: L Lᵀ is the Nyström approximation of K,
/// and each pivot is the row least explained by those before.
#[derive(Clone, Debug)]
pub(super) struct PivotedCholesky {
    /// Rows that are pivots, in their order.
    pub pivots: Vec<usize>,
    /// Columns of L.
    pub columns: Vec<Vec<f64>>,
    /// ℓ.
    pub width: f64,
}

impl PivotedCholesky {
    /// Factor of the Gaussian kernel over `rows` of `dimension` numbers each, up to `most` columns.
    pub fn new(rows: &[f64], dimension: usize, width: f64, most: usize) -> Self {
        let rows: Vec<&[f64]> = rows.chunks_exact(dimension).collect();
        let mut left = vec![1.0_f64; rows.len()];
        let mut factor = Self { pivots: Vec::new(), columns: Vec::new(), width };
        while factor.pivots.len() < most {
            let largest = left.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)));
            let Some((pivot, &diagonal)) = largest.filter(|(_, d)| **d > SMALLEST) else { break };
            let mut column: Vec<f64> = rows.iter().map(|x| gaussian(x, rows[pivot], width)).collect();
            for earlier in &factor.columns {
                let share = earlier[pivot];
                column.iter_mut().zip(earlier).for_each(|(c, e)| *c -= share * e);
            }
            let root = diagonal.sqrt();
            column.iter_mut().for_each(|c| *c /= root);
            left.iter_mut().zip(&column).for_each(|(d, c)| *d -= c * c);
            left[pivot] = 0.0;
            factor.pivots.push(pivot);
            factor.columns.push(column);
        }
        factor
    }

    /// Weights of the kernel functions at the centres equivalent to the combination `shares` of the columns.
    pub fn weights(&self, shares: &[f64]) -> Vec<f64> {
        let count = self.pivots.len();
        // Rows of the pivots: lower triangular.
        let lower =
            DMatrix::from_fn(count, count, |i, j| if j > i { 0.0 } else { self.columns[j][self.pivots[i]] });
        let right = DMatrix::from_column_slice(count, 1, shares);
        let solved = lower.transpose().solve_upper_triangular(&right);
        solved.map_or_else(|| vec![0.0; count], |w| w.iter().copied().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Vec<f64> {
        (0..40).flat_map(|k| [(k as f64 * 0.7).sin(), (k as f64 * 1.9).cos()]).collect()
    }

    #[test]
    fn a_full_factor_is_exact_and_a_short_one_is_nystroms_approximation() {
        let x = rows();
        let row = |i: usize| &x[2 * i..2 * i + 2];
        let kernel = DMatrix::from_fn(40, 40, |i, j| gaussian(row(i), row(j), 0.5));
        let product = |factor: &PivotedCholesky| {
            DMatrix::from_fn(40, 40, |i, j| factor.columns.iter().map(|c| c[i] * c[j]).sum::<f64>())
        };
        let full = PivotedCholesky::new(&x, 2, 0.5, 40);
        assert!((product(&full) - &kernel).amax() < 1e-11);

        // K_nm K_mm⁻¹ K_mn.
        let short = PivotedCholesky::new(&x, 2, 0.5, 8);
        let p = &short.pivots;
        let nm = DMatrix::from_fn(40, 8, |i, j| kernel[(i, p[j])]);
        let mm = DMatrix::from_fn(8, 8, |i, j| kernel[(p[i], p[j])]);
        let nystrom = &nm * mm.lu().solve(&nm.transpose()).unwrap();
        assert!((product(&short) - nystrom).amax() < 1e-11);
    }

    #[test]
    fn weights_give_the_combination_of_columns() {
        let x = rows();
        let factor = PivotedCholesky::new(&x, 2, 0.5, 6);
        let shares = [0.3, -1.0, 0.2, 0.9, -0.4, 0.1];
        let weights = factor.weights(&shares);
        for i in 0..40 {
            let expected: f64 = factor.columns.iter().zip(shares).map(|(c, s)| s * c[i]).sum();
            let at = |j: usize| gaussian(&x[2 * i..2 * i + 2], &x[2 * j..2 * j + 2], 0.5);
            let found: f64 = factor.pivots.iter().zip(&weights).map(|(&j, w)| w * at(j)).sum();
            assert!((found - expected).abs() < 1e-11);
        }
    }

    #[test]
    fn rows_that_repeat_are_one_centre() {
        let x = [0.5, 0.1, 0.5, 0.1, -0.3, 0.8];
        assert_eq!(PivotedCholesky::new(&x, 2, 1.0, 3).pivots.len(), 2);
    }
}
