//! Non-negative least squares.

use nalgebra::{DMatrix, DVector};

use super::triangular;

/// Rounding error of a gradient, relative to the norm of the target.
const ROUNDING: f64 = 1e-13;

/// c ≥ 0 that minimises ‖`target` − Σ c_j `columns`_j‖: the active-set method of C. L. Lawson and R. J.
/// Hanson, *Solving Least Squares Problems* (1974), ch. 23, doi:10.1137/1.9781611971217, on the triangular
/// factor of columns and target. Columns that depend on others, or are zero, get 0; all get NaN where that
/// factor is not finite.
pub fn non_negative_least_squares(columns: &[&[f64]], target: &[f64]) -> Vec<f64> {
    let count = columns.len();
    let mut all = columns.to_vec();
    all.push(target);
    let factor = triangular(&all);
    if !factor.iter().all(|x| x.is_finite()) {
        return vec![f64::NAN; count];
    }
    let norms: Vec<f64> = (0..count).map(|j| factor.column(j).norm()).collect();
    let unit =
        DMatrix::from_fn(
            count + 1,
            count,
            |i, j| if norms[j] > 0.0 { factor[(i, j)] / norms[j] } else { 0.0 },
        );
    let target = factor.column(count).into_owned();
    let size = target.norm();
    let mut c = DVector::zeros(count);
    let mut free = Free::new(&unit, &target);
    let mut barred = vec![false; count];
    // Each round frees one column; apart from rounding, the method ends long before this.
    for _ in 0..10 * count.max(1) {
        let gradient = unit.tr_mul(&(&target - &unit * &c));
        let next = (0..count)
            .filter(|j| !free.columns.contains(j) && !barred[*j] && gradient[*j] > ROUNDING * size)
            .max_by(|&i, &j| gradient[i].total_cmp(&gradient[j]));
        let Some(next) = next else { break };
        if !free.push(next) {
            barred[next] = true;
            continue;
        }
        loop {
            let solution = free.coefficients();
            if solution.iter().all(|x| *x > 0.0) {
                free.columns.iter().zip(&solution).for_each(|(&j, x)| c[j] = *x);
                barred.fill(false);
                break;
            }
            if solution.last().is_some_and(|x| *x <= 0.0)
                && free.columns.last() == Some(&next)
                && c[next] == 0.0
            {
                // Its gradient was rounding.
                barred[next] = true;
            }
            let step = free
                .columns
                .iter()
                .zip(&solution)
                .filter(|(_, x)| **x <= 0.0)
                .map(|(&j, x)| c[j] / (c[j] - x))
                .fold(1.0, f64::min);
            free.columns.iter().zip(&solution).for_each(|(&j, x)| c[j] += step * (x - c[j]));
            for &j in &free.columns {
                if c[j] <= ROUNDING * size {
                    c[j] = 0.0;
                }
            }
            free.retain(|j| c[j] > 0.0);
        }
    }
    (0..count).map(|j| if norms[j] > 0.0 { c[j] / norms[j] } else { 0.0 }).collect()
}

/// Columns of unit length below which the part beside the others is rounding.
const DEPENDENT: f64 = 1e-11;

/// QR factorisation of the free columns, to which columns are added one by one (Gram–Schmidt, repeated).
struct Free<'u> {
    unit: &'u DMatrix<f64>,
    target: &'u DVector<f64>,
    columns: Vec<usize>,
    q: Vec<DVector<f64>>,
    /// Column j of R down to its diagonal.
    r: Vec<Vec<f64>>,
    /// Qᵀ target.
    shares: Vec<f64>,
}

impl<'u> Free<'u> {
    fn new(unit: &'u DMatrix<f64>, target: &'u DVector<f64>) -> Self {
        Self { unit, target, columns: Vec::new(), q: Vec::new(), r: Vec::new(), shares: Vec::new() }
    }

    /// Adds a column; `false` where it depends on the others.
    fn push(&mut self, column: usize) -> bool {
        let mut beside: DVector<f64> = self.unit.column(column).into_owned();
        let mut r = vec![0.0; self.q.len()];
        for _ in 0..2 {
            for (q, r) in self.q.iter().zip(&mut r) {
                let share = q.dot(&beside);
                *r += share;
                beside.axpy(-share, q, 1.0);
            }
        }
        let norm = beside.norm();
        if norm < DEPENDENT {
            return false;
        }
        beside /= norm;
        r.push(norm);
        self.shares.push(beside.dot(self.target));
        self.q.push(beside);
        self.r.push(r);
        self.columns.push(column);
        true
    }

    /// Leaves the columns that are not to be kept.
    fn retain(&mut self, kept: impl Fn(usize) -> bool) {
        let columns = std::mem::take(&mut self.columns);
        *self = Self::new(self.unit, self.target);
        for column in columns.into_iter().filter(|column| kept(*column)) {
            self.push(column);
        }
    }

    /// Coefficients of the columns by least squares.
    fn coefficients(&self) -> Vec<f64> {
        let mut c = self.shares.clone();
        for j in (0..c.len()).rev() {
            c[j] /= self.r[j][j];
            for i in 0..j {
                c[i] -= self.r[j][i] * c[j];
            }
        }
        c
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn residual(columns: &[Vec<f64>], c: &[f64], target: &[f64]) -> Vec<f64> {
        (0..target.len())
            .map(|k| target[k] - c.iter().zip(columns).map(|(c, a)| c * a[k]).sum::<f64>())
            .collect()
    }

    proptest! {
        /// Karush–Kuhn–Tucker: c ≥ 0; no column along the residual; none that is used across it.
        #[test]
        fn the_minimum_obeys_its_conditions(
            rows in proptest::collection::vec(proptest::collection::vec(-1.0..1.0f64, 6), 8..40),
            target in proptest::collection::vec(-1.0..1.0f64, 40),
        ) {
            let columns: Vec<Vec<f64>> = (0..6).map(|j| rows.iter().map(|row| row[j]).collect()).collect();
            let target = &target[..rows.len()];
            let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            let c = non_negative_least_squares(&slices, target);
            let r = residual(&columns, &c, target);
            for (c, a) in c.iter().zip(&columns) {
                let along: f64 = a.iter().zip(&r).map(|(a, r)| a * r).sum();
                prop_assert!(*c >= 0.0 && along < 1e-10, "{c} {along}");
                prop_assert!(*c == 0.0 || along.abs() < 1e-10, "{c} {along}");
            }
        }
    }

    #[test]
    fn by_hand() {
        // Along the first axis only: the second coefficient would be −1.
        assert_eq!(non_negative_least_squares(&[&[1.0, 0.0], &[0.0, 1.0]], &[2.0, -1.0]), [2.0, 0.0]);
        // Twice the same column, and one of zeros.
        let c = non_negative_least_squares(&[&[1.0, 1.0], &[1.0, 1.0], &[0.0, 0.0]], &[3.0, 3.0]);
        assert!((c[0] + c[1] - 3.0).abs() < 1e-12 && c[2] == 0.0, "{c:?}");
        assert_eq!(non_negative_least_squares(&[], &[1.0]), [0.0; 0]);
        // No solution is not the solution 0.
        assert!(non_negative_least_squares(&[&[f64::NAN, 1.0]], &[1.0, 1.0])[0].is_nan());
    }
}
