//! Bayesian linear regression with the scale of the prior by evidence.
//!
//! e = Φ T z + noise: T the prior standard deviations in units of the scale s, z ~ N(0, s²), and every row
//! counts as w of an independent residual of variance r². With K = w T ΦᵀΦ T = V Λ Vᵀ, c = w Vᵀ T Φᵀ e and
//! λ_k = s² Λ_k/r², the posterior of the k-th coordinate is normal with mean (s² c_k/r²)/(1 + λ_k) and variance
//! s²/(1 + λ_k), and the logarithm of the evidence (C. E. Rasmussen, C. K. I. Williams, *Gaussian Processes for
//! Machine Learning*, MIT Press 2006, Eq. 2.30 and §5.4.1) is
//!
//! −½ \[n ln r² + Σ ln(1 + λ_k) + (w eᵀe − Σ (s² c_k²/r²)/(1 + λ_k))/r²\], n = w · rows.
//!
//! Some columns have a least scale: the posterior is then that of the larger of both, column by column.

use hysteron_numeric::gram;
use nalgebra::{DMatrix, DVector};

/// ln s of the grid: from and to, and its step.
const SCALES: (f64, f64, f64) = (-5.0, 1.5, 0.25);
/// Noise at first, in units of the rms of e, and repetitions of its estimate.
const FIRST_NOISE: f64 = 0.7;
const REPETITIONS: usize = 3;
/// Least noise in units of the rms of e: a residual that the columns explain exactly leaves rounding.
const LEAST_NOISE: f64 = 1e-6;
/// Eigenvalues below this share of the largest count as zero in the least squares.
const RANK: f64 = 1e-10;

/// Sums over the rows of all records.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    /// w ΦᵀΦ.
    pub gram: DMatrix<f64>,
    /// w Φᵀe.
    pub product: DVector<f64>,
    /// w eᵀe.
    pub power: f64,
    /// w · rows.
    pub count: f64,
}

/// Prior of the coefficients: independent normal numbers about 0.
#[derive(Clone, Debug)]
pub(super) struct Prior {
    /// Standard deviations in units of the scale.
    pub deviation: DVector<f64>,
    /// Least scale of each.
    pub least_scale: DVector<f64>,
}

/// Information in the coordinates in which it is diagonal.
struct Diagonal {
    /// Standard deviations T by which the columns are scaled.
    deviation: DVector<f64>,
    /// V, an eigenvector a column.
    vectors: DMatrix<f64>,
    /// Λ.
    values: Vec<f64>,
    /// c.
    product: DVector<f64>,
}

/// Posterior of the coefficients.
#[derive(Clone, Debug)]
pub(super) struct Posterior {
    /// Standard deviation r of the noise.
    pub noise: f64,
    /// Mean of the coefficients.
    pub mean: DVector<f64>,
    /// Their deviations, a column each, uncorrelated.
    pub directions: DMatrix<f64>,
    /// λ_k of each.
    pub information: Vec<f64>,
    /// Share of eᵀe that least squares on the columns explain.
    pub explained: f64,
}

impl Sums {
    pub(super) fn new(columns: usize) -> Self {
        Self {
            gram: DMatrix::zeros(columns, columns),
            product: DVector::zeros(columns),
            power: 0.0,
            count: 0.0,
        }
    }

    /// Adds rows, each of which counts as `weight` of an independent one.
    pub(super) fn add(&mut self, columns: &DMatrix<f64>, residual: &DVector<f64>, weight: f64) {
        let slices: Vec<&[f64]> = columns.as_slice().chunks_exact(columns.nrows().max(1)).collect();
        self.gram += weight * gram(&slices);
        self.product.gemv_tr(weight, columns, residual, 1.0);
        self.power += weight * residual.norm_squared();
        self.count += weight * residual.len() as f64;
    }

    /// These sums without those of some of their rows.
    pub(super) fn without(&self, part: &Self) -> Self {
        Self {
            gram: &self.gram - &part.gram,
            product: &self.product - &part.product,
            power: self.power - part.power,
            count: self.count - part.count,
        }
    }

    /// w |e − Φβ|².
    pub(super) fn power_left(&self, mean: &DVector<f64>) -> f64 {
        self.power - 2.0 * self.product.dot(mean) + (&self.gram * mean).dot(mean)
    }

    /// The posterior; `None` without a residual.
    pub(super) fn posterior(&self, prior: &Prior) -> Option<Posterior> {
        if !(self.power > 0.0 && self.count > 0.0 && self.power.is_finite()) {
            return None;
        }
        let unit = self.diagonal(prior.deviation.clone());
        let largest = unit.values.iter().copied().fold(0.0, f64::max);
        let explained: f64 = unit
            .values
            .iter()
            .zip(&unit.product)
            .filter(|(value, _)| **value > RANK * largest)
            .map(|(value, c)| c * c / value)
            .sum();
        let mean_square = self.power / self.count;
        let least = LEAST_NOISE * LEAST_NOISE * mean_square;
        let mut square = FIRST_NOISE * FIRST_NOISE * mean_square;
        let mut scale_square = 1.0;
        for _ in 0..REPETITIONS {
            scale_square = best_scale(&unit, square);
            square = self.remainder(&unit, scale_square, square).max(least);
        }
        let scale = scale_square.sqrt();
        let own = self.diagonal(prior.deviation.zip_map(&prior.least_scale, |t, least| t * scale.max(least)));
        for _ in 0..REPETITIONS - 1 {
            square = self.remainder(&own, 1.0, square).max(least);
        }
        let information: Vec<f64> = own.values.iter().map(|value| value / square).collect();
        let shrunk = |(c, information): (&f64, &f64)| c / square / (1.0 + information);
        let coordinates =
            DVector::from_iterator(information.len(), own.product.iter().zip(&information).map(shrunk));
        let directions = DMatrix::from_fn(information.len(), information.len(), |i, k| {
            own.deviation[i] * own.vectors[(i, k)] / (1.0 + information[k]).sqrt()
        });
        Some(Posterior {
            noise: square.sqrt(),
            mean: (&own.vectors * coordinates).component_mul(&own.deviation),
            directions,
            information,
            explained: explained / self.power,
        })
    }

    fn diagonal(&self, deviation: DVector<f64>) -> Diagonal {
        let scaled = self.gram.map_with_location(|i, j, g| deviation[i] * g * deviation[j]);
        let eigen = scaled.symmetric_eigen();
        Diagonal {
            values: eigen.eigenvalues.iter().map(|v| v.max(0.0)).collect(),
            product: eigen.eigenvectors.tr_mul(&self.product.component_mul(&deviation)),
            vectors: eigen.eigenvectors,
            deviation,
        }
    }

    /// Mean square of the residual from the posterior mean at the scale s and the noise variance `square`.
    fn remainder(&self, of: &Diagonal, scale_square: f64, square: f64) -> f64 {
        let gained = of.values.iter().zip(&of.product).map(|(value, c)| {
            let z = scale_square * c / square / (1.0 + scale_square * value / square);
            2.0 * z * c - z * z * value
        });
        (self.power - gained.sum::<f64>()).max(0.0) / self.count
    }
}

/// s² of the grid with the largest evidence at the noise variance `square`.
fn best_scale(of: &Diagonal, square: f64) -> f64 {
    let (from, to, step) = SCALES;
    let steps = ((to - from) / step).round() as usize;
    let scales = (0..=steps).map(|k| (2.0 * (from + step * k as f64)).exp());
    let evidence = |scale_square: f64| {
        let each = of.values.iter().zip(&of.product).map(|(value, c)| {
            let information = scale_square * value / square;
            information.ln_1p() - scale_square * c * c / (square * square) / (1.0 + information)
        });
        -0.5 * each.sum::<f64>()
    };
    scales.max_by(|a, b| evidence(*a).total_cmp(&evidence(*b))).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(k: usize) -> f64 {
        (12.989_8 * k as f64 + 0.3).sin()
    }

    fn problem(rows: usize, noise: f64) -> (DMatrix<f64>, DVector<f64>, Prior) {
        let columns = DMatrix::from_fn(rows, 5, |i, j| number(7 * i + 1001 * j));
        let truth = DVector::from_vec(vec![0.8, -0.5, 0.0, 0.3, -1.2]);
        let residual = &columns * &truth + DVector::from_fn(rows, |i, _| noise * number(5 * i + 77_777));
        (columns, residual, prior(1.0, 0.0))
    }

    fn prior(unit: f64, least: f64) -> Prior {
        let deviation = DVector::from_vec(vec![1.0, 1.0, 0.5, 2.0, 1.0]) * unit;
        Prior { deviation, least_scale: DVector::from_element(5, least) }
    }

    fn sums(columns: &DMatrix<f64>, residual: &DVector<f64>, weight: f64) -> Sums {
        let mut sums = Sums::new(columns.ncols());
        sums.add(columns, residual, weight);
        sums
    }

    #[test]
    fn agrees_with_the_dense_posterior_and_the_dense_evidence() {
        let (columns, residual, prior) = problem(60, 0.4);
        let weight = 0.3;
        let sums = sums(&columns, &residual, weight);
        let found = sums.posterior(&prior).unwrap();
        let prior = prior.deviation;
        // The scale is not part of the result: it is in the deviations of a direction without information.
        let square = found.noise * found.noise;
        let covariance = &found.directions * found.directions.transpose();
        let precision = covariance.clone().try_inverse().unwrap();
        let data = columns.tr_mul(&columns) * (weight / square);
        let of_prior = precision - &data;
        let scale_square = 1.0 / (of_prior[(0, 0)] * prior[0] * prior[0]);
        for i in 0..5 {
            for j in 0..5 {
                let expected = if i == j { 1.0 / (scale_square * prior[i] * prior[i]) } else { 0.0 };
                assert!((of_prior[(i, j)] - expected).abs() < 1e-6 * (1.0 + data[(i, i)]), "{i} {j}");
            }
        }
        let mean = covariance * columns.tr_mul(&residual) * (weight / square);
        assert!((mean - &found.mean).norm() < 1e-9 * found.mean.norm());
        // Evidence: the density of the residual under N(0, s² Φ T² Φᵀ + r²/w I), up to a constant.
        let dense = |scale_square: f64| {
            let scaled = DMatrix::from_fn(60, 5, |i, j| columns[(i, j)] * prior[j] * scale_square.sqrt());
            let of = &scaled * scaled.transpose() + DMatrix::identity(60, 60) * (square / weight);
            let root = of.cholesky().unwrap();
            let log_determinant: f64 = 2.0 * root.l().diagonal().iter().map(|x| x.ln()).sum::<f64>();
            -0.5 * (log_determinant + residual.dot(&root.solve(&residual)))
        };
        let grid: Vec<f64> = (0..=26).map(|k| (2.0 * (-5.0 + 0.25 * f64::from(k))).exp()).collect();
        let best = grid.iter().copied().max_by(|a, b| dense(*a).total_cmp(&dense(*b))).unwrap();
        assert_eq!(best_scale(&sums.diagonal(prior), square), best);
    }

    #[test]
    fn a_least_scale_is_that_of_the_prior_where_the_records_say_nothing() {
        let (columns, residual, _) = problem(60, 0.4);
        let mut silent = columns;
        silent.column_mut(1).fill(0.0);
        let found = sums(&silent, &residual, 0.3).posterior(&prior(1.0, 7.0)).unwrap();
        let variance: f64 = found.directions.row(1).iter().map(|x| x * x).sum();
        assert!((variance - 49.0).abs() < 1e-9 && found.mean[1].abs() < 1e-12, "{variance}");
    }

    #[test]
    fn units_scale_with_the_residual() {
        let (columns, residual, unit) = problem(60, 0.4);
        let one = sums(&columns, &residual, 0.3).posterior(&unit).unwrap();
        let thousand = sums(&columns, &(&residual * 1e3), 0.3).posterior(&prior(1e3, 0.0)).unwrap();
        assert!((thousand.noise / one.noise / 1e3 - 1.0).abs() < 1e-9);
        assert!((&thousand.mean / 1e3 - &one.mean).norm() < 1e-9 * one.mean.norm());
        assert!((thousand.explained - one.explained).abs() < 1e-9);
    }

    #[test]
    fn noise_is_not_explained_and_the_truth_is() {
        let (columns, residual, prior) = problem(4000, 0.05);
        let found = sums(&columns, &residual, 1.0).posterior(&prior).unwrap();
        assert!(found.explained > 0.99 && (found.noise / (0.05 / 2f64.sqrt()) - 1.0).abs() < 0.05);
        let noise = DVector::from_fn(4000, |i, _| 0.1 * number(i + 31));
        let found = sums(&columns, &noise, 1.0).posterior(&prior).unwrap();
        assert!(found.explained < 0.01, "{}", found.explained);
        assert!(sums(&columns, &DVector::zeros(4000), 1.0).posterior(&prior).is_none());
    }
}
