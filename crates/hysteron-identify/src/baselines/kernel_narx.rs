//! Kernel ridge regression NARX models, the least-squares support-vector machine with an offset.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::BaselineError;
use super::free_run::{OneStep, free_run, simulated_error};
use super::pivoted_cholesky::{PivotedCholesky, gaussian};
use super::regressors::{Lags, Regressors};
use super::training_set::{Rows, TrainingSet};
use hysteron_numeric::{dot, triangular};

/// Most training rows and kernel functions.
const ROWS: usize = 4000;
const CENTRES: usize = 100;
/// Widths ℓ of the kernel to try; every regressor lies in −1 … 1.
const WIDTHS: [f64; 4] = [1.0, 2.0, 4.0, 8.0];
/// Ridges λ to try: 10^low … 10^high.
const RIDGES: std::ops::RangeInclusive<i32> = -12..=0;
/// Share of a column orthogonal to the others below which it is dependent.
const DEPENDENT: f64 = 1e-10;

/// y_k = b + wᵀx + Σ αⱼ exp(−‖x − cⱼ‖²/(2ℓ²)).
#[derive(Clone, Debug, PartialEq)]
pub struct KernelNarx {
    /// b, then w.
    pub linear: Vec<f64>,
    /// Centres cⱼ, one after the other.
    pub centres: Vec<f64>,
    /// Weights αⱼ.
    pub weights: Vec<f64>,
    /// ℓ.
    pub width: f64,
    /// λ, by leave-one-out.
    pub ridge: f64,
}

impl OneStep for KernelNarx {
    fn next(&self, x: &[f64]) -> f64 {
        let linear = self.linear[0] + x.iter().zip(&self.linear[1..]).map(|(x, w)| x * w).sum::<f64>();
        let centres = self.centres.chunks_exact(x.len()).zip(&self.weights);
        centres.fold(linear, |sum, (c, weight)| sum + weight * gaussian(x, c, self.width))
    }

    fn parameters(&self) -> usize {
        self.linear.len() + self.weights.len()
    }
}

/// Trains on sets of the same records with different lag intervals; returns the index of the best set first.
///
/// λ is chosen by the one-step leave-one-out error, a poor guide to simulation for the other choices; lag
/// interval, lags and ℓ by the held-out simulation error.
pub(super) fn train(
    sets: &[TrainingSet],
    lags: &[Lags],
) -> Result<(usize, Regressors, KernelNarx), BaselineError> {
    let mut tried = Vec::new();
    let mut refused = BaselineError::NoStableModel;
    for (number, set) in sets.iter().enumerate() {
        for &lags in lags {
            let regressors = Regressors::scaled(lags, &set.fitted);
            let rows = match Rows::new(&regressors, &set.fitted, ROWS) {
                Ok(rows) => rows,
                Err(error) => {
                    refused = error;
                    continue;
                }
            };
            for width in WIDTHS {
                let model = Ridge::new(&rows, width, CENTRES).best();
                let error = simulated_error(&model, &regressors, &set.series, &set.held_back);
                tried.extend(error.map(|error| (error, number, lags, width)));
            }
        }
    }
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, number, lags, width) in tried {
        let set = &sets[number];
        let regressors = Regressors::scaled(lags, &set.series);
        let model = Ridge::new(&Rows::new(&regressors, &set.series, ROWS)?, width, CENTRES).best();
        if set.series.iter().all(|one| free_run(&model, &regressors, one).is_ok()) {
            return Ok((number, regressors, model));
        }
    }
    Err(refused)
}

/// Kernel ridge regression with an unpenalised linear part, prepared for any λ:
///
/// minimise Σ (t − b − wᵀx − f(x))² + λ ‖f‖², f in the span of the kernel functions at the centres (Nyström's
/// approximation, C. K. I. Williams, M. Seeger, Advances in Neural Information Processing Systems 13 (2001)
/// 682–688).
///
/// With K ≈ L Lᵀ it is ridge regression on the columns of L; the linear part is projected out first.
pub(super) struct Ridge<'a> {
    rows: &'a Rows,
    kernel: PivotedCholesky,
    /// 1 and the regressors.
    linear: Vec<Vec<f64>>,
    /// Diagonal of the projection on the linear part.
    leverage: Vec<f64>,
    /// Target less its linear part.
    target: Vec<f64>,
    /// Columns of L less their linear parts, in the coordinates of the eigenvectors of their Gram matrix.
    z: Vec<Vec<f64>>,
    vectors: DMatrix<f64>,
    values: Vec<f64>,
}

impl<'a> Ridge<'a> {
    pub fn new(rows: &'a Rows, width: f64, centres: usize) -> Self {
        let kernel = PivotedCholesky::new(&rows.x, rows.width, width, centres);
        let ones = std::iter::once(vec![1.0; rows.len()]);
        let linear: Vec<Vec<f64>> =
            ones.chain((0..rows.width).map(|j| rows.iter().map(|x| x[j]).collect())).collect();
        let basis = orthonormal(&linear);
        let without = |column: &[f64]| {
            let mut rest = column.to_vec();
            // Twice, against rounding of the first projection.
            for _ in 0..2 {
                for q in &basis {
                    let share = dot(q, &rest);
                    rest.iter_mut().zip(q).for_each(|(x, q)| *x -= share * q);
                }
            }
            rest
        };
        let target = without(&rows.target);
        let projected: Vec<Vec<f64>> = kernel.columns.iter().map(|c| without(c)).collect();
        let count = projected.len();
        let gram = DMatrix::from_fn(count, count, |i, j| dot(&projected[i], &projected[j]));
        let SymmetricEigen { eigenvectors: vectors, eigenvalues } = gram.symmetric_eigen();
        let z = vectors.column_iter().map(|v| combined(&projected, v.iter().copied())).collect();
        let leverage = (0..rows.len()).map(|i| basis.iter().map(|q| q[i] * q[i]).sum()).collect();
        let values = eigenvalues.iter().map(|d| d.max(0.0)).collect();
        Self { rows, kernel, linear, leverage, target, z, vectors, values }
    }

    /// Root mean square of the leave-one-out residuals e_i/(1 − h_ii), h the hat matrix (D. M. Allen,
    /// Technometrics 16 (1974) 125–127, doi:10.1080/00401706.1974.10489157); the centres stay.
    pub fn leave_one_out(&self, ridge: f64) -> f64 {
        let mut leverage = self.leverage.clone();
        let mut rest = self.target.clone();
        for (z, d) in self.z.iter().zip(&self.values) {
            let share = dot(z, &self.target) / (d + ridge);
            for ((e, h), z) in rest.iter_mut().zip(&mut leverage).zip(z) {
                *e -= share * z;
                *h += z * z / (d + ridge);
            }
        }
        let square: f64 = rest.iter().zip(&leverage).map(|(e, h)| (e / (1.0 - h)).powi(2)).sum();
        (square / rest.len() as f64).sqrt()
    }

    /// The model of the λ with the smallest leave-one-out error.
    pub fn best(&self) -> KernelNarx {
        let ridges = RIDGES.map(|exponent| 10f64.powi(exponent));
        let errors = ridges.map(|ridge| (self.leave_one_out(ridge), ridge));
        let (_, ridge) = errors.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 1.0));
        self.model(ridge)
    }

    /// The model of one λ.
    pub fn model(&self, ridge: f64) -> KernelNarx {
        let shares = self.z.iter().zip(&self.values).map(|(z, d)| dot(z, &self.target) / (d + ridge));
        let in_columns = &self.vectors * DVector::from_iterator(self.z.len(), shares);
        let curved = combined(&self.kernel.columns, in_columns.iter().copied());
        let straight: Vec<f64> = self.rows.target.iter().zip(&curved).map(|(t, f)| t - f).collect();
        KernelNarx {
            linear: least_squares(&self.linear, &straight),
            centres: self.kernel.pivots.iter().flat_map(|&i| self.row(i)).copied().collect(),
            weights: self.kernel.weights(in_columns.as_slice()),
            width: self.kernel.width,
            ridge,
        }
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.rows.x[i * self.rows.width..(i + 1) * self.rows.width]
    }
}

/// Σ cⱼ columnⱼ.
fn combined(columns: &[Vec<f64>], shares: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sum = vec![0.0; columns.first().map_or(0, Vec::len)];
    for (column, share) in columns.iter().zip(shares) {
        sum.iter_mut().zip(column).for_each(|(s, c)| *s += share * c);
    }
    sum
}

/// An orthonormal basis of the span of the columns.
fn orthonormal(columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for column in columns {
        let mut rest = column.clone();
        for _ in 0..2 {
            for q in &basis {
                let share = dot(q, &rest);
                rest.iter_mut().zip(q).for_each(|(x, q)| *x -= share * q);
            }
        }
        let norm = dot(&rest, &rest).sqrt();
        if norm > DEPENDENT * dot(column, column).sqrt() {
            rest.iter_mut().for_each(|x| *x /= norm);
            basis.push(rest);
        }
    }
    basis
}

/// Minimum-norm least-squares solution.
pub(super) fn least_squares(columns: &[Vec<f64>], target: &[f64]) -> Vec<f64> {
    let count = columns.len();
    let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).chain([target]).collect();
    let r = triangular(&slices);
    let square = r.view((0, 0), (count, count)).into_owned();
    let scale = square.amax();
    let right = r.view((0, count), (count, 1)).into_owned();
    let solved = square.svd(true, true).solve(&right, DEPENDENT * scale);
    solved.map_or_else(|_| vec![0.0; count], |x| x.iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(count: usize) -> Rows {
        let wave = |k: usize, a: f64| ((k * k) as f64 * a).sin();
        let x: Vec<f64> = (0..count).flat_map(|k| [wave(k, 0.37), wave(k, 0.911)]).collect();
        let target = x.chunks_exact(2).enumerate();
        let target =
            target.map(|(k, x)| 0.3 + x[0] - 0.5 * x[1] + (2.0 * x[0]).sin() * x[1] + 0.05 * wave(k, 1.7));
        Rows { target: target.collect(), width: 2, x }
    }

    /// α and (b, w) of [K + λ, A; Aᵀ, 0] (α; β) = (t; 0).
    #[test]
    fn with_a_centre_for_every_row_it_is_the_direct_solution() {
        let rows = rows(25);
        let (width, ridge, n) = (0.8, 1e-3, rows.len());
        let row = |i: usize| &rows.x[2 * i..2 * i + 2];
        let system = DMatrix::from_fn(n + 3, n + 3, |i, j| {
            let linear = |k: usize, c: usize| if c == 0 { 1.0 } else { row(k)[c - 1] };
            match (i < n, j < n) {
                (true, true) => gaussian(row(i), row(j), width) + if i == j { ridge } else { 0.0 },
                (true, false) => linear(i, j - n),
                (false, true) => linear(j, i - n),
                (false, false) => 0.0,
            }
        });
        let right = DVector::from_fn(n + 3, |i, _| rows.target.get(i).copied().unwrap_or(0.0));
        let direct = system.lu().solve(&right).unwrap();
        let model = Ridge::new(&rows, width, n).model(ridge);
        assert_eq!(model.weights.len(), n);
        for x in [[0.1, -0.4], [0.9, 0.9], [-2.0, 3.0]] {
            let kernel: f64 = (0..n).map(|i| direct[i] * gaussian(&x, row(i), width)).sum();
            let expected = direct[n] + direct[n + 1] * x[0] + direct[n + 2] * x[1] + kernel;
            let found = model.next(&x);
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }

    #[test]
    fn leave_one_out_is_what_leaving_one_out_gives() {
        let rows = rows(40);
        let (ridge, centres) = (0.02, 10);
        let prepared = Ridge::new(&rows, 0.7, centres);
        let columns: Vec<&[f64]> =
            prepared.linear.iter().chain(&prepared.kernel.columns).map(Vec::as_slice).collect();
        let penalty = |j: usize| if j < 3 { 0.0 } else { ridge };
        let mut square = 0.0;
        for out in 0..rows.len() {
            let kept: Vec<usize> = (0..rows.len()).filter(|i| *i != out).collect();
            let normal = DMatrix::from_fn(columns.len(), columns.len(), |i, j| {
                let sum: f64 = kept.iter().map(|&k| columns[i][k] * columns[j][k]).sum();
                sum + if i == j { penalty(i) } else { 0.0 }
            });
            let right = DVector::from_fn(columns.len(), |i, _| {
                kept.iter().map(|&k| columns[i][k] * rows.target[k]).sum::<f64>()
            });
            let c = normal.lu().solve(&right).unwrap();
            let predicted: f64 = columns.iter().zip(c.iter()).map(|(column, c)| column[out] * c).sum();
            square += (rows.target[out] - predicted).powi(2);
        }
        let expected = (square / rows.len() as f64).sqrt();
        let found = prepared.leave_one_out(ridge);
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }

    #[test]
    fn the_ridge_with_the_smallest_error_is_taken() {
        let rows = rows(60);
        let prepared = Ridge::new(&rows, 0.7, 30);
        let best = prepared.best();
        for exponent in RIDGES {
            let ridge = 10f64.powi(exponent);
            assert!(prepared.leave_one_out(best.ridge) <= prepared.leave_one_out(ridge));
        }
        // Noise of amplitude 0.05 excludes the smallest one.
        assert!(best.ridge > 1e-12);
    }

    #[test]
    fn columns_that_depend_on_one_another_do_no_harm() {
        let x: Vec<f64> = (0..30).flat_map(|k| [(k as f64).sin(), 2.0 * (k as f64).sin()]).collect();
        let target: Vec<f64> = (0..30).map(|k| 1.0 + 5.0 * (k as f64).sin()).collect();
        let rows = Rows { x, width: 2, target };
        let model = Ridge::new(&rows, 1.0, 10).model(1e-3);
        assert!((model.next(&[0.5, 1.0]) - 3.5).abs() < 1e-9);
    }
}
