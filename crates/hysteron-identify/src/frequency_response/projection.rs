//! Linear least squares with a few columns, without allocation: modified Gram–Schmidt, orthogonalised twice.

/// A column whose part orthogonal to those before it is smaller than this share of it is left out.
const DEPENDENT: f64 = 1e-12;

/// Buffers for matrices of `rows` × `columns`, stored column by column.
pub(super) struct Projection {
    rows: usize,
    columns: usize,
    /// Orthonormal basis; zero columns where A's column depends on those before it.
    q: Vec<f64>,
    /// Upper triangle, `r[k · columns + l]` = ⟨q_k, a_l⟩; 0 on the diagonal where column k was left out.
    r: Vec<f64>,
}

impl Projection {
    pub fn new(rows: usize, columns: usize) -> Self {
        Self { rows, columns, q: vec![0.0; rows * columns], r: vec![0.0; columns * columns] }
    }

    /// Decomposes A = Q R.
    pub fn decompose(&mut self, a: &[f64]) {
        self.q.copy_from_slice(a);
        self.r.fill(0.0);
        for l in 0..self.columns {
            let (before, rest) = self.q.split_at_mut(l * self.rows);
            let column = &mut rest[..self.rows];
            let length = norm(column);
            // Once more removes what rounding left of the earlier directions.
            for _ in 0..2 {
                for (k, q) in before.chunks_exact(self.rows).enumerate() {
                    let share = dot(q, column);
                    column.iter_mut().zip(q).for_each(|(c, q)| *c -= share * q);
                    self.r[k * self.columns + l] += share;
                }
            }
            let left = norm(column);
            if left > DEPENDENT * length {
                column.iter_mut().for_each(|c| *c /= left);
                self.r[l * self.columns + l] = left;
            } else {
                column.fill(0.0);
            }
        }
    }

    /// Minimiser c of ‖A c − b‖; coefficients of columns left out are 0.
    pub fn solve(&self, b: &[f64], c: &mut [f64]) {
        for (c, q) in c.iter_mut().zip(self.q.chunks_exact(self.rows)) {
            *c = dot(q, b);
        }
        for k in (0..self.columns).rev() {
            let pivot = self.r[k * self.columns + k];
            let known: f64 = (k + 1..self.columns).map(|l| self.r[k * self.columns + l] * c[l]).sum();
            c[k] = if pivot > 0.0 { (c[k] - known) / pivot } else { 0.0 };
        }
    }

    /// v ← v − Q Qᵀ v.
    pub fn remove(&self, v: &mut [f64]) {
        for q in self.q.chunks_exact(self.rows) {
            let share = dot(q, v);
            v.iter_mut().zip(q).for_each(|(v, q)| *v -= share * q);
        }
    }

    /// v ← v − Q R⁻ᵀ u, that is v − (A⁺)ᵀ u. Overwrites `u`.
    pub fn subtract_pseudo_inverse_transposed(&self, u: &mut [f64], v: &mut [f64]) {
        for k in 0..self.columns {
            let pivot = self.r[k * self.columns + k];
            let known: f64 = (0..k).map(|l| self.r[l * self.columns + k] * u[l]).sum();
            u[k] = if pivot > 0.0 { (u[k] - known) / pivot } else { 0.0 };
        }
        for (u, q) in u.iter().zip(self.q.chunks_exact(self.rows)) {
            v.iter_mut().zip(q).for_each(|(v, q)| *v -= u * q);
        }
    }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

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
        projection.solve(&b, &mut c);
        let oracle = &pseudo * DVector::from_column_slice(&b);
        assert!((DVector::from_column_slice(&c) - oracle).norm() < 1e-12);
        let mut rest = b.clone();
        projection.remove(&mut rest);
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
        projection.solve(&b, &mut c);
        assert!((c[0] - 3.0).abs() < 1e-12 && (c[1] - 1.0).abs() < 1e-12 && c[2] == 0.0, "{c:?}");
    }
}
