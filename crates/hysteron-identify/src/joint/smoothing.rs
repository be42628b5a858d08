//! Hysteresis weights smoothed by a roughness penalty chosen by cross-validation.
//!
//! Records with few reversal voltages determine few of the many weights of a plane, and non-negative least
//! squares then concentrates the weight of a neighbourhood in one cell. So, with the nonlinear parameters
//! held at the optimum, the weights are refitted: c ≥ 0 that minimises ‖y − A c‖² + κ Σ (c_i − c_j)² over
//! neighbours i, j of the plane, coefficients of l\[u\] free. κ is chosen by cross-validation: the records
//! are divided into folds, and each is predicted by the weights fitted to the others (Stone 1974,
//! doi:10.1111/j.2517-6161.1974.tb00994.x). Validation records are not used.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::super::layout::Role;
use super::problem::JointProblem;
use super::record::JointRecord;
use hysteron_numeric::{non_negative_least_squares, triangular};

/// Least number of folds over all records, equally many from each record without cycles.
const PARTS: usize = 8;
/// Penalties tried, as shares of the one that balances the records.
const SHARES: [f64; 10] = [0.0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1];

/// Roughness penalty chosen for the differences of neighbouring weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothing {
    /// κ, as a share of the penalty that balances the records; 0 where smoothing does not reduce the held-out
    /// error.
    pub share: f64,
    /// Weighted held-out error at this κ.
    pub left_out: f64,
    /// Weighted held-out error with κ = 0.
    pub left_out_without: f64,
}

/// Coefficients of u, u², … and smoothed weights at the nonlinear parameters `x`, with the choice of κ.
/// `None` where the family's weights have no neighbours, or a linear parameter is held or searched.
pub(super) fn smoothed(problem: &JointProblem, x: &[f64]) -> Option<(Vec<f64>, Smoothing)> {
    let form = problem.hysteresis();
    let on_plane = form.neighbours().into_iter().map(|(a, b)| (a, Some(b)));
    let chained =
        if problem.records().iter().any(JointRecord::is_on_stamps) { form.chain() } else { Vec::new() };
    let neighbours: Vec<(usize, Option<usize>)> = on_plane.chain(chained).collect();
    let layout = problem.layout();
    let free = layout.polynomial.iter().all(|role| *role == Role::Projected);
    let sign = match layout.weights.first() {
        Some(&Role::OneSided(sign)) if layout.weights.iter().all(|role| *role == Role::OneSided(sign)) => {
            sign
        }
        _ => return None,
    };
    if neighbours.is_empty() || !free {
        return None;
    }
    let (columns, target) = problem.linear_columns(x)?;
    let rows = target.len().max(1);
    let all: Vec<&[f64]> = columns.chunks_exact(rows).chain([target.as_slice()]).collect();
    let per_record = PARTS.div_ceil(problem.records().len());
    let parts: Vec<DMatrix<f64>> = (0..problem.records().len())
        .flat_map(|record| {
            let rows = problem.rows(record);
            // Each cycle of a record in cycles is a fold, so that the level after a cycle is predicted from
            // the others.
            let cycles = problem.records()[record].cycles;
            let per_record = if cycles > 1 { cycles } else { per_record };
            let end = move |k: usize| rows.start + (rows.end - rows.start) * k / per_record;
            (0..per_record).map(move |k| end(k)..end(k + 1))
        })
        .map(|rows| triangular(&all.iter().map(|column| &column[rows.clone()]).collect::<Vec<_>>()))
        .collect();
    let fit = Fit { degree: problem.degree(), sign, neighbours };
    let whole = stacked(parts.iter());
    let unit = fit.unit(&whole);
    // Held-out error of every fold at each penalty, fitted to the other folds.
    let errors: Vec<Vec<f64>> = (0..parts.len())
        .into_par_iter()
        .map(|out| {
            let others = stacked(parts.iter().enumerate().filter(|(k, _)| *k != out).map(|(_, part)| part));
            let error = |share: f64| match fit.solve(&others, share * unit) {
                Some(c) => square_left(&parts[out], &c),
                None => f64::INFINITY,
            };
            SHARES.iter().map(|share| error(*share)).collect()
        })
        .collect();
    let total = |index: usize| errors.iter().map(|part| part[index]).sum::<f64>();
    let best = (0..SHARES.len()).min_by(|&a, &b| total(a).total_cmp(&total(b)))?;
    let valid = problem.valid() as f64;
    let [left_out, left_out_without] = [best, 0].map(|index| (total(index) / valid).sqrt());
    let smoothing = Smoothing { share: SHARES[best], left_out, left_out_without };
    left_out.is_finite().then_some((fit.solve(&whole, SHARES[best] * unit)?, smoothing))
}

/// The triangular factor of all rows behind these factors.
fn stacked<'a>(factors: impl Iterator<Item = &'a DMatrix<f64>>) -> DMatrix<f64> {
    let factors: Vec<&DMatrix<f64>> = factors.collect();
    let width = factors.first().map_or(0, |factor| factor.ncols());
    let columns: Vec<Vec<f64>> = (0..width)
        .map(|j| {
            factors.iter().flat_map(|factor| factor.column(j).iter().copied().collect::<Vec<_>>()).collect()
        })
        .collect();
    triangular(&columns.iter().map(Vec::as_slice).collect::<Vec<_>>())
}

/// ‖y − A c‖² from the triangular factor of \[A y\].
fn square_left(factor: &DMatrix<f64>, coefficients: &[f64]) -> f64 {
    let last = factor.ncols() - 1;
    (0..factor.nrows())
        .map(|row| {
            let fitted: f64 = coefficients.iter().enumerate().map(|(j, c)| factor[(row, j)] * c).sum();
            (factor[(row, last)] - fitted).powi(2)
        })
        .sum()
}

struct Fit {
    degree: usize,
    /// Sign of all weights.
    sign: f64,
    neighbours: Vec<(usize, Option<usize>)>,
}

impl Fit {
    /// κ that balances the penalty and the weights' columns, orthogonal to those of u, u², ….
    fn unit(&self, factor: &DMatrix<f64>) -> f64 {
        let weights = factor.ncols() - 1;
        let squares: f64 = (self.degree..weights)
            .map(|j| (self.degree..factor.nrows()).map(|i| factor[(i, j)].powi(2)).sum::<f64>())
            .sum();
        squares / (2 * self.neighbours.len()) as f64
    }

    /// Coefficients of u, u², …, then the weights. `None` where powers of u are linearly dependent.
    fn solve(&self, factor: &DMatrix<f64>, kappa: f64) -> Option<Vec<f64>> {
        let (degree, last) = (self.degree, factor.ncols() - 1);
        let root = kappa.sqrt();
        // Rows below those of u, u², … hold the other columns with these projected out.
        let column = |j: usize, scale: f64| (degree..factor.nrows()).map(move |i| scale * factor[(i, j)]);
        let differences = |weight: Option<usize>| {
            self.neighbours.iter().map(move |&(a, b)| match weight {
                Some(weight) if weight == a => root,
                Some(weight) if Some(weight) == b => -root,
                _ => 0.0,
            })
        };
        let columns: Vec<Vec<f64>> = (degree..last)
            .map(|j| column(j, self.sign).chain(differences(Some(j - degree))).collect())
            .collect();
        let target: Vec<f64> = column(last, 1.0).chain(differences(None)).collect();
        let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let weights = non_negative_least_squares(&slices, &target);
        let mut coefficients = vec![0.0; last];
        coefficients[degree..].iter_mut().zip(weights).for_each(|(c, w)| *c = self.sign * w);
        for i in (0..degree).rev() {
            let others: f64 = (i + 1..last).map(|j| factor[(i, j)] * coefficients[j]).sum();
            coefficients[i] = (factor[(i, last)] - others) / factor[(i, i)];
            if !coefficients[i].is_finite() {
                return None;
            }
        }
        Some(coefficients)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factor(columns: &[Vec<f64>]) -> DMatrix<f64> {
        triangular(&columns.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }

    /// Three weights after one power; no rows distinguish the second and the third.
    fn columns() -> [Vec<f64>; 5] {
        let power: Vec<f64> = (0..12).map(|k| f64::from(k) * 0.1).collect();
        let first: Vec<f64> = (0..12).map(|k| f64::from(k % 3)).collect();
        let second: Vec<f64> = (0..12).map(|k| f64::from(k % 5) - 1.0).collect();
        let target = (0..12).map(|k| 2.0 * power[k] + 0.5 * first[k] + 1.2 * second[k]).collect();
        [power, first, second.clone(), second, target]
    }

    #[test]
    fn what_the_rows_do_not_tell_apart_is_shared_by_neighbours() {
        let fit = Fit { degree: 1, sign: 1.0, neighbours: vec![(1, Some(2))] };
        let factor = factor(&columns());
        let plain = fit.solve(&factor, 0.0).unwrap();
        assert!(plain[2] == 0.0 || plain[3] == 0.0, "{plain:?}");
        let found = fit.solve(&factor, 1e-6).unwrap();
        for (found, expected) in found.iter().zip([2.0, 0.5, 0.6, 0.6]) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }

    #[test]
    fn the_minimum_obeys_its_conditions() {
        // All weights neighbours, of negative sign, and a target that one of them cannot fit.
        let mut all = columns();
        all[3].iter_mut().enumerate().for_each(|(k, x)| *x += (k as f64).sin());
        all[4].iter_mut().enumerate().for_each(|(k, y)| *y = -*y + 0.3 * (k as f64 * 1.7).cos());
        let fit = Fit { degree: 1, sign: -1.0, neighbours: vec![(0, Some(1)), (1, Some(2))] };
        let kappa = 0.7;
        let c = fit.solve(&factor(&all), kappa).unwrap();
        let left: Vec<f64> =
            (0..12).map(|k| all[4][k] - (0..4).map(|j| c[j] * all[j][k]).sum::<f64>()).collect();
        let along = |j: usize| all[j].iter().zip(&left).map(|(a, r)| a * r).sum::<f64>();
        let drawn = [c[1] - c[2], (c[2] - c[1]) + (c[2] - c[3]), c[3] - c[2]];
        assert!(along(0).abs() < 1e-10);
        for j in 0..3 {
            let gradient = along(j + 1) - kappa * drawn[j];
            assert!(
                c[j + 1] <= 0.0 && gradient > -1e-10 && (c[j + 1] == 0.0 || gradient.abs() < 1e-10),
                "{c:?}"
            );
        }
        assert!((square_left(&factor(&all), &c) - left.iter().map(|r| r * r).sum::<f64>()).abs() < 1e-10);
    }

    #[test]
    fn factors_of_parts_make_that_of_the_whole() {
        let all = columns();
        let part = |rows: std::ops::Range<usize>| {
            factor(&all.each_ref().map(|column| column[rows.clone()].to_vec()))
        };
        let (whole, parts) = (factor(&all), stacked([part(0..5), part(5..12)].iter()));
        assert!((whole.tr_mul(&whole) - parts.tr_mul(&parts)).norm() < 1e-12);
    }
}
