//! Linear least squares by orthonormal columns: the elimination step of variable projection.
//!
//! Golub, Pereyra, "The differentiation of pseudo-inverses and nonlinear least squares problems whose
//! variables separate", SIAM J. Numer. Anal. 10 (1973), doi:10.1137/0710036.

use hysteron_numeric::{dot, project_out, subtract};

/// Orthonormal basis Q (and R) of a growing set of columns, by Gram–Schmidt with reorthogonalisation,
/// orthogonal to working accuracy (Giraud et al. 2005, doi:10.1007/s00211-005-0615-4). Memory for all columns is
/// reserved at once, but not touched before it holds one.
#[derive(Clone, Debug, Default)]
pub(super) struct Projection {
    rows: usize,
    columns: usize,
    q: Vec<f64>,
    /// Upper triangle, column by column, `capacity` rows each.
    r: Vec<f64>,
    capacity: usize,
}

/// A column whose component orthogonal to the earlier ones is below this share of its norm is dependent.
const DEPENDENT: f64 = 1e-11;

impl Projection {
    pub(super) fn new(rows: usize, capacity: usize) -> Self {
        let mut new = Self::default();
        new.empty(rows, capacity);
        new
    }

    /// No columns, with room for `capacity` of `rows` rows; storage that suffices is kept.
    pub(super) fn empty(&mut self, rows: usize, capacity: usize) {
        self.q.reserve((rows * capacity).saturating_sub(self.q.len()));
        self.r.resize(self.r.len().max(capacity * capacity), 0.0);
        (self.rows, self.columns, self.capacity) = (rows, 0, capacity);
    }

    pub(super) fn clear(&mut self) {
        self.columns = 0;
    }

    /// Keeps the first `columns` columns only.
    pub(super) fn truncate(&mut self, columns: usize) {
        self.columns = self.columns.min(columns);
    }

    /// Number of columns.
    pub(super) fn len(&self) -> usize {
        self.columns
    }

    /// Maximum number of columns.
    pub(super) fn capacity(&self) -> usize {
        self.capacity
    }

    /// These columns with room for more.
    pub(super) fn with_capacity(&self, capacity: usize) -> Self {
        let mut wider = Self::new(self.rows, capacity);
        wider.columns = self.columns.min(capacity);
        wider.q.extend_from_slice(&self.q[..wider.columns * self.rows]);
        for c in 0..wider.columns {
            wider.r[c * capacity..c * capacity + wider.columns]
                .copy_from_slice(&self.r[c * self.capacity..c * self.capacity + wider.columns]);
        }
        wider
    }

    /// Adds the column that `fill` writes. A column that depends on the earlier ones gets a zero basis
    /// vector, hence coefficient zero.
    pub(super) fn push(&mut self, fill: impl FnOnce(&mut [f64])) {
        let c = self.columns;
        self.q.resize(self.q.len().max((c + 1) * self.rows), 0.0);
        let (done, rest) = self.q.split_at_mut(c * self.rows);
        let new = &mut rest[..self.rows];
        fill(new);
        let r = &mut self.r[c * self.capacity..(c + 1) * self.capacity];
        r.fill(0.0);
        let norm_before = dot(new, new).sqrt();
        for _ in 0..2 {
            for (q, r) in done.chunks_exact(self.rows.max(1)).zip(r.iter_mut()) {
                let share = dot(q, new);
                *r += share;
                subtract(new, share, q);
            }
        }
        let norm = dot(new, new).sqrt();
        if norm > DEPENDENT * norm_before {
            new.iter_mut().for_each(|x| *x /= norm);
            r[c] = norm;
        } else {
            new.fill(0.0);
        }
        self.columns += 1;
    }

    /// Projects `x` onto the orthogonal complement of the columns.
    pub(super) fn project(&self, x: &mut [f64]) {
        project_out(&self.q[..self.columns * self.rows], x);
    }

    /// Replaces all columns by those of `matrix`.
    pub(super) fn decompose(&mut self, matrix: &[f64]) {
        self.clear();
        for column in matrix.chunks_exact(self.rows.max(1)) {
            self.push(|q| q.copy_from_slice(column));
        }
    }

    /// Coefficients c of the columns A that minimise ‖x − A c‖; 0 for a dependent column.
    pub(super) fn coefficients(&self, x: &[f64]) -> Vec<f64> {
        let mut c = vec![0.0; self.columns];
        self.coefficients_into(x, &mut c);
        c
    }

    /// [`Self::coefficients`] into `c`.
    pub(super) fn coefficients_into(&self, x: &[f64], c: &mut [f64]) {
        c.iter_mut().zip(self.basis()).for_each(|(c, q)| *c = dot(q, x));
        for i in (0..self.columns).rev() {
            let pivot = self.r[i * self.capacity + i];
            c[i] = if pivot > 0.0 { c[i] / pivot } else { 0.0 };
            for j in 0..i {
                c[j] -= self.r[i * self.capacity + j] * c[i];
            }
        }
    }

    /// v ← v − Q R⁻ᵀ u, that is v − (A⁺)ᵀ u. Overwrites `u`.
    pub(super) fn subtract_pseudo_inverse_transposed(&self, u: &mut [f64], v: &mut [f64]) {
        for k in 0..self.columns {
            let r = &self.r[k * self.capacity..=k * self.capacity + k];
            let known = dot(&r[..k], &u[..k]);
            u[k] = if r[k] > 0.0 { (u[k] - known) / r[k] } else { 0.0 };
        }
        for (u, q) in u.iter().zip(self.basis()) {
            subtract(v, *u, q);
        }
    }

    fn basis(&self) -> impl Iterator<Item = &[f64]> {
        self.q.chunks_exact(self.rows.max(1)).take(self.columns)
    }
}

/// Subtracts the mean from `x`.
pub(super) fn centre(x: &mut [f64]) {
    let mut sums = [0.0; 8];
    let eights = x.chunks_exact(8);
    let rest: f64 = eights.remainder().iter().sum();
    for eight in eights {
        for (sum, x) in sums.iter_mut().zip(eight) {
            *sum += x;
        }
    }
    let mean = (sums.iter().sum::<f64>() + rest) / x.len() as f64;
    x.iter_mut().for_each(|x| *x -= mean);
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn finds_the_coefficients_of_an_exact_combination() {
        let t: Vec<f64> = (0..50).map(|k| k as f64 / 50.0).collect();
        let mut projection = Projection::new(50, 3);
        for power in 0..3 {
            projection.push(|c| c.iter_mut().zip(&t).for_each(|(c, t)| *c = t.powi(power)));
        }
        let mut y: Vec<f64> = t.iter().map(|t| 2.0 - 3.0 * t + 0.5 * t * t).collect();
        let c = projection.coefficients(&y);
        for (found, truth) in c.iter().zip([2.0, -3.0, 0.5]) {
            assert!((found - truth).abs() < 1e-12, "{c:?}");
        }
        projection.project(&mut y);
        assert!(y.iter().all(|r| r.abs() < 1e-13));
    }

    #[test]
    fn what_is_left_is_orthogonal_to_any_number_of_columns() {
        let rows = 1003;
        let wave = |k: usize, j: usize| ((k * (j + 1)) as f64 * 0.013).sin() + 0.2 * j as f64;
        for columns in 0..10 {
            let mut projection = Projection::new(rows, columns);
            for j in 0..columns {
                projection.push(|c| c.iter_mut().enumerate().for_each(|(k, c)| *c = wave(k, j)));
            }
            let mut x: Vec<f64> = (0..rows).map(|k| (k as f64 * 0.37).cos() + wave(k, 2)).collect();
            let mut one_by_one = x.clone();
            for q in projection.basis() {
                let share: f64 = q.iter().zip(&one_by_one).map(|(q, x)| q * x).sum();
                subtract(&mut one_by_one, share, q);
            }
            projection.project(&mut x);
            for (x, slow) in x.iter().zip(&one_by_one) {
                assert!((x - slow).abs() < 1e-13, "{columns}: {x} {slow}");
            }
        }
    }

    #[test]
    fn a_dependent_column_gets_no_share() {
        let mut projection = Projection::new(4, 2);
        projection.push(|c| c.copy_from_slice(&[1.0, 2.0, 3.0, 4.0]));
        projection.push(|c| c.copy_from_slice(&[2.0, 4.0, 6.0, 8.0]));
        assert_eq!(projection.coefficients(&[1.0, 2.0, 3.0, 4.0])[1], 0.0);
    }

    #[test]
    fn residual_is_orthogonal_to_the_columns() {
        let a = [1.0, -0.5, 2.0, 0.25, 3.0];
        let b = [0.1, 1.0, 0.3, -1.0, 0.2];
        let mut projection = Projection::new(5, 2);
        projection.push(|c| c.copy_from_slice(&a));
        projection.push(|c| c.copy_from_slice(&b));
        let mut y = [1.0, 2.0, -1.0, 0.5, 0.7];
        projection.project(&mut y);
        assert!(dot(&y, &a).abs() < 1e-14 && dot(&y, &b).abs() < 1e-14);
    }

    fn matrix(rows: usize, columns: usize) -> Vec<f64> {
        (0..rows * columns).map(|k| ((k * k + 3 * k) % 17) as f64 - 7.5 + 0.01 * k as f64).collect()
    }

    #[test]
    fn solution_and_transposed_pseudo_inverse_are_those_of_the_singular_value_decomposition() {
        let (rows, columns) = (9, 4);
        let a = matrix(rows, columns);
        let mut projection = Projection::new(rows, columns);
        projection.decompose(&a);
        let dense = DMatrix::from_column_slice(rows, columns, &a);
        let pseudo = dense.clone().pseudo_inverse(1e-12).unwrap();
        let b: Vec<f64> = (0..rows).map(|i| (i as f64 * 1.3).sin()).collect();
        let mut c = vec![0.0; columns];
        projection.coefficients_into(&b, &mut c);
        let oracle = &pseudo * DVector::from_column_slice(&b);
        assert!((DVector::from_column_slice(&c) - oracle).norm() < 1e-12);
        let mut rest = b.clone();
        projection.project(&mut rest);
        assert!((dense.tr_mul(&DVector::from_column_slice(&rest))).norm() < 1e-12);
        let mut u = vec![1.0, -2.0, 0.5, 3.0];
        let expected = -pseudo.transpose() * DVector::from_column_slice(&u);
        let mut v = vec![0.0; rows];
        projection.subtract_pseudo_inverse_transposed(&mut u, &mut v);
        assert!((DVector::from_column_slice(&v) - expected).norm() < 1e-12);
    }

    #[test]
    fn a_dependent_column_gets_the_coefficient_zero() {
        let mut a = matrix(6, 3);
        for i in 0..6 {
            a[12 + i] = 2.0 * a[i] - a[6 + i];
        }
        let mut projection = Projection::new(6, 3);
        projection.decompose(&a);
        let b: Vec<f64> = (0..6).map(|i| 3.0 * a[i] + a[6 + i]).collect();
        let mut c = vec![0.0; 3];
        projection.coefficients_into(&b, &mut c);
        assert!((c[0] - 3.0).abs() < 1e-12 && (c[1] - 1.0).abs() < 1e-12 && c[2] == 0.0, "{c:?}");
    }
}
