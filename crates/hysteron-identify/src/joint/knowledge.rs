//! Uncertainty of a joint fit: covariance of all parameters in the article's symbols, robust to coloured
//! residuals.
//!
//! With J the Jacobian in every parameter (the eliminated ones too) and Ω the covariance of the residuals,
//! the covariance of the estimate is (JᵀJ)⁻¹ JᵀΩJ (JᵀJ)⁻¹. JᵀΩJ = Σ_k w_k ρ_k Σ_t J_t J_{t+k}ᵀ record by
//! record, ρ the autocovariance of the record's residual and w the Parzen window (Newey, West 1987,
//! doi:10.2307/1913610, for errors that are stationary and do not depend on the regressors; Parzen's window
//! keeps the estimate positive). The residual is prewhitened by a first-order autoregression and recoloured
//! afterwards, which reduces the bias of the window (Andrews, Monahan 1992, doi:10.2307/2951574). The fit
//! removes power from the residual in the span of its derivatives: h of the n/τ independent samples of a
//! record, h the record's leverage and τ its correlation time, hence the factor 1/(1 − hτ/n).

use super::super::result::Correlation;
use super::super::uncertainty::{autocorrelation, correlation, correlation_time, initial_positive_sum};
use super::problem::{JointProblem, Linearisation};
use super::record::JointRecord;
use hysteron_numeric::fft::{RealFft, fast_length};
use hysteron_numeric::{Complex64, dot, triangular};
use hysteron_optimize::{LeastSquaresProblem, Problem};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Largest coefficient of the prewhitening autoregression.
const STRONGEST: f64 = 0.97;
/// Largest share of a record's independent samples in the leverage correction.
const MOST_USED: f64 = 0.75;
/// Lags of the window as a multiple of the whitened residual's correlation time, and fewest.
const WINDOW: f64 = 6.0;
const FEWEST_LAGS: usize = 12;
/// Combinations of parameters (of columns of unit length) with a singular value below this share of the
/// largest are not determined: the inverse information there is rounding error.
const NOT_DETERMINED: f64 = 1e-7;
/// Share of a parameter in such combinations up to which it is rounding error.
const ROUNDING: f64 = 1e-12;
/// Share of a standard deviation due to an undetermined parameter above which the function is undetermined.
const NOTICED: f64 = 1e-3;
/// Rows processed at a time: all columns of a block fit the processor's cache.
const ROWS: usize = 1024;

/// Covariance of all estimates.
#[derive(Clone, Debug, PartialEq)]
pub struct Covariance {
    /// Names: coefficients and weights in the order of the model, then the searched numbers.
    pub names: Vec<String>,
    /// Estimates.
    pub values: Vec<f64>,
    /// Covariance matrix, zero rows and columns where a parameter is held, over the combinations that the
    /// records determine. A bound of the search box is no information: parameters at a bound count as free
    /// here, and the shift of all estimates without the bound counts as an error.
    pub matrix: DMatrix<f64>,
    /// Parameters with most of their variance in undetermined combinations, so that `matrix` holds only part
    /// of it, and those at a bound.
    pub undetermined: Vec<bool>,
    /// Ratio of the largest to the smallest singular value of the Jacobian with columns of unit length.
    pub condition_number: f64,
}

impl Covariance {
    /// Standard error of parameter `index`; `None` where it is held or not determined.
    pub fn std_error(&self, index: usize) -> Option<f64> {
        self.deviation(index).filter(|_| !self.undetermined[index])
    }

    /// The matrix with zero rows and columns for undetermined parameters.
    pub fn of_determined(&self) -> DMatrix<f64> {
        let lost = |i: usize| self.undetermined[i];
        self.matrix.map_with_location(|i, j, c| if lost(i) || lost(j) { 0.0 } else { c })
    }

    /// Standard deviation from the matrix, if any.
    fn deviation(&self, index: usize) -> Option<f64> {
        let variance = self.matrix[(index, index)];
        (variance.is_finite() && variance > 0.0).then(|| variance.sqrt())
    }

    /// Correlation of the parameters that the records determine, if there are any.
    pub(in super::super) fn correlation(&self, step: &str) -> Option<Correlation> {
        let known: Vec<usize> = (0..self.names.len()).filter(|&i| self.std_error(i).is_some()).collect();
        let names = known.iter().map(|&i| self.names[i].clone()).collect();
        let of_known = || self.matrix.select_rows(&known).select_columns(&known);
        (!known.is_empty()).then(|| correlation(step, names, &of_known()))
    }

    /// Covariance of functions f of the parameters, J C Jᵀ with J by central differences of f, whose steps
    /// are a small part of each standard error.
    pub fn transformed(&self, names: Vec<String>, f: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        let values = f(&self.values);
        let mut jacobian = DMatrix::zeros(values.len(), self.values.len());
        let mut at = self.values.clone();
        for j in 0..self.values.len() {
            // Parameters that are held do not vary.
            let Some(std_error) = self.deviation(j) else { continue };
            let size = self.values[j].abs();
            // A standard error above the value does not set the step: f may be undefined at that distance.
            let within = if size > 0.0 { std_error.min(size) } else { std_error };
            let step = 1e-3 * within.max(1e-9 * size);
            at[j] = self.values[j] + step;
            let taken_up = at[j] - self.values[j];
            let up = f(&at);
            at[j] = self.values[j] - step;
            let taken = taken_up - (at[j] - self.values[j]);
            let down = f(&at);
            at[j] = self.values[j];
            for (i, (u, d)) in up.iter().zip(&down).enumerate() {
                jacobian[(i, j)] = (u - d) / taken;
            }
        }
        let matrix = &jacobian * &self.matrix * jacobian.transpose();
        let hangs_on = |i: usize, j: usize| {
            let part = jacobian[(i, j)] * self.deviation(j).unwrap_or(0.0);
            self.undetermined[j] && part.abs() > NOTICED * matrix[(i, i)].max(0.0).sqrt()
        };
        let undetermined =
            (0..values.len()).map(|i| (0..self.values.len()).any(|j| hangs_on(i, j))).collect();
        Self { names, values, matrix, undetermined, condition_number: self.condition_number }
    }
}

/// Estimates and their covariance at an optimum, in the fit's own (unit-α) symbols: first the eliminated
/// coefficients, then the searched numbers.
#[derive(Debug)]
pub(in super::super) struct Knowledge {
    /// Covariance robust to coloured residuals.
    pub(in super::super) covariance: Covariance,
    /// s² (JᵀJ)⁻¹, the covariance for white residuals.
    pub(in super::super) white: DMatrix<f64>,
    /// s² = Σ r² / (N − p) of the weighted residuals, p including the offsets.
    pub(in super::super) variance: f64,
    pub(in super::super) linearisation: Linearisation,
}

/// Estimates and covariance at the optimum `x`. `None` where no covariance can be estimated.
pub(in super::super) fn knowledge(problem: &JointProblem, x: &[f64]) -> Option<Knowledge> {
    knowledge_of(problem, x, problem.linearise(x)?)
}

/// [`knowledge`] from the linearisation at `x`.
pub(in super::super) fn knowledge_of(
    problem: &JointProblem,
    x: &[f64],
    linearisation: Linearisation,
) -> Option<Knowledge> {
    let Linearisation { linear, eliminated, searched, residuals, coefficients } = &linearisation;
    let rows = problem.residual_count();
    let names: Vec<String> = eliminated
        .iter()
        .map(|&index| problem.layout().linear_name(index, problem.hysteresis()))
        .chain(problem.bounds().ranges.iter().map(|r| r.name.clone()))
        .collect();
    let values: Vec<f64> =
        eliminated.iter().map(|&index| coefficients[index]).chain(x.iter().copied()).collect();
    let on_bound: Vec<bool> = eliminated
        .iter()
        .map(|_| false)
        .chain(problem.bounds().ranges.iter().zip(x).map(|(range, &x)| range.is_end(x)))
        .collect();
    let columns: Vec<&[f64]> = linear.chunks_exact(rows).chain(searched.chunks_exact(rows)).collect();
    let norms: Vec<f64> = columns.par_iter().map(|c| dot(c, c).sqrt()).collect();
    let free: Vec<usize> = (0..columns.len()).filter(|&j| norms[j] > 0.0 && norms[j].is_finite()).collect();
    let local: usize = problem.records().iter().map(JointRecord::local_columns).sum();
    if free.is_empty() || problem.valid() <= free.len() + local {
        return None;
    }
    let p = free.len();
    let free_columns: Vec<&[f64]> = free.iter().map(|&j| columns[j]).collect();
    let free_norms: Vec<f64> = free.iter().map(|&j| norms[j]).collect();
    let of_unit_columns =
        |matrix: DMatrix<f64>| matrix.map_with_location(|i, j, x| x / (free_norms[i] * free_norms[j]));
    // Triangular factor of columns of unit length.
    let r = triangular(&free_columns).map_with_location(|_, j, x| x / free_norms[j]);
    let svd = r.svd(false, true);
    let (singular, directions) = (svd.singular_values, svd.v_t?);
    let condition_number = singular.max() / singular.min();
    if condition_number.is_nan() {
        return None;
    }
    let (kept, lost): (Vec<usize>, Vec<usize>) =
        (0..p).partition(|&k| singular[k] > NOT_DETERMINED * singular.max());
    let scaled = DMatrix::from_fn(kept.len(), p, |k, j| directions[(kept[k], j)] / singular[kept[k]]);
    let bread = scaled.transpose() * &scaled;
    // Variance of a parameter in the truncated singular directions, with singular values floored at rounding.
    let undetermined_free: Vec<bool> = (0..p)
        .map(|j| {
            let share: f64 = lost.iter().map(|&k| directions[(k, j)].powi(2)).sum();
            let floor = f64::EPSILON * singular.max();
            let adds: f64 = lost.iter().map(|&k| (directions[(k, j)] / singular[k].max(floor)).powi(2)).sum();
            share > ROUNDING && adds > bread[(j, j)]
        })
        .collect();
    let mut undetermined = on_bound.clone();
    free.iter().zip(&undetermined_free).for_each(|(&j, &lost)| undetermined[j] |= lost);
    let meat = (0..problem.records().len())
        .into_par_iter()
        .map(|record| {
            let rows = problem.rows(record);
            let own: Vec<&[f64]> = free_columns.iter().map(|column| &column[rows.clone()]).collect();
            let residual = &residuals[rows];
            let leverage = (&bread * of_unit_columns(gram(&own))).trace()
                + problem.records()[record].local_columns() as f64;
            let independent = problem.records()[record].valid as f64 / correlation_time(residual);
            let used = (leverage / independent).min(MOST_USED);
            of_unit_columns(coloured_square(&own, residual)) / (1.0 - used)
        })
        // Summed in the order of the records, independently of the threads.
        .collect::<Vec<_>>()
        .into_iter()
        .fold(DMatrix::zeros(p, p), |sum, part| sum + part);
    let variance = residuals.iter().map(|r| r * r).sum::<f64>() / (problem.valid() - p - local) as f64;
    let in_own_units = |small: DMatrix<f64>| {
        let mut matrix = DMatrix::zeros(columns.len(), columns.len());
        for (i, &fi) in free.iter().enumerate() {
            for (j, &fj) in free.iter().enumerate() {
                matrix[(fi, fj)] = small[(i, j)] / (norms[fi] * norms[fj]);
            }
        }
        matrix
    };
    // Shift of the estimates if those at a bound were free: a bias in addition to the noise error.
    let held_back = free.iter().zip(&free_columns).zip(&free_norms);
    let pull = held_back.map(|((&j, c), norm)| if on_bound[j] { dot(c, residuals) / norm } else { 0.0 });
    let moved = &bread * DVector::from_iterator(p, pull);
    let matrix = in_own_units(&bread * meat * &bread + &moved * moved.transpose());
    let white = in_own_units(bread * variance);
    Some(Knowledge {
        covariance: Covariance { names, values, matrix, undetermined, condition_number },
        white,
        variance,
        linearisation,
    })
}

/// Inner products of all pairs of columns, block of rows by block; the order of summation is fixed.
fn gram<C: AsRef<[f64]> + Sync>(columns: &[C]) -> DMatrix<f64> {
    let p = columns.len();
    let rows = columns.first().map_or(0, |column| column.as_ref().len());
    let blocks: Vec<DMatrix<f64>> = (0..rows.div_ceil(ROWS))
        .into_par_iter()
        .map(|block| {
            let part = |j: usize| &columns[j].as_ref()[block * ROWS..rows.min((block + 1) * ROWS)];
            let mut products = DMatrix::zeros(p, p);
            for i in 0..p {
                for j in 0..=i {
                    products[(i, j)] = dot(part(i), part(j));
                    products[(j, i)] = products[(i, j)];
                }
            }
            products
        })
        .collect();
    blocks.into_iter().fold(DMatrix::zeros(p, p), |sum, block| sum + block)
}

/// Σ_k w_k ρ_k Σ_t J_t J_{t+k}ᵀ over one record, in the frequency domain. The residual may be that of another
/// record.
pub(in super::super) fn coloured_square(columns: &[&[f64]], residual: &[f64]) -> DMatrix<f64> {
    let longest = columns.iter().map(|column| column.len()).fold(residual.len(), usize::max);
    // Zero-padded to twice the length against circular wrap-around.
    let fft = RealFft::new(fast_length(2 * longest));
    let root = root_power(residual, &fft);
    let buffers = || {
        let forward = &fft.forward;
        (forward.make_input_vec(), forward.make_output_vec(), forward.make_scratch_vec())
    };
    let coloured: Vec<Vec<f64>> = columns
        .par_iter()
        .map_init(buffers, |(time, spectrum, scratch), column| {
            let (own, padding) = time.split_at_mut(column.len());
            own.copy_from_slice(column);
            padding.fill(0.0);
            // All lengths come from the plan, so the transform cannot fail.
            fft.transform_with(scratch, time, spectrum);
            let mut coloured = vec![0.0; 2 * spectrum.len()];
            for ((pair, x), root) in coloured.chunks_exact_mut(2).zip(&*spectrum).zip(&root) {
                (pair[0], pair[1]) = (root * x.re, root * x.im);
            }
            coloured
        })
        .collect();
    gram(&coloured)
}

/// Root of the residual's smoothed power spectrum at each frequency of `fft`, scaled so that sums of squares
/// over frequency equal those over time.
fn root_power(residual: &[f64], fft: &RealFft) -> Vec<f64> {
    let n = residual.len();
    let (memory, white) = whitened(residual);
    let products = autocorrelation(&white);
    let time = initial_positive_sum(&products[..n]);
    let lags = ((WINDOW * time).ceil() as usize).max(FEWEST_LAGS).min(n.saturating_sub(1));
    let length = fft.len();
    let valid = residual.iter().filter(|r| **r != 0.0).count().max(1) as f64;
    let mut windowed = fft.forward.make_input_vec();
    for k in 0..=lags {
        let value = products[k] / valid * parzen(k as f64 / (lags + 1) as f64);
        windowed[k] = value;
        if k > 0 {
            windowed[length - k] = value;
        }
    }
    let mut spectrum = fft.forward.make_output_vec();
    fft.transform(&mut windowed, &mut spectrum);
    let root = |(bin, power): (usize, &Complex64)| {
        let angle = TAU * bin as f64 / length as f64;
        let coloured = power.re / (1.0 - 2.0 * memory * angle.cos() + memory * memory);
        // Every frequency but the first and the last also represents its negative.
        let twice = if bin == 0 || 2 * bin == length { 1.0 } else { 2.0 };
        (twice * coloured.max(0.0) / length as f64).sqrt()
    };
    spectrum.iter().enumerate().map(root).collect()
}

/// First-order autoregression a of a series, and e_k − a e_{k−1}.
fn whitened(e: &[f64]) -> (f64, Vec<f64>) {
    let square: f64 = e.iter().map(|x| x * x).sum();
    let product: f64 = e.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let memory = if square > 0.0 { (product / square).clamp(-STRONGEST, STRONGEST) } else { 0.0 };
    let mut before = 0.0;
    let white = e.iter().map(|&x| x - memory * std::mem::replace(&mut before, x)).collect();
    (memory, white)
}

/// Parzen's window, 1 at 0 and 0 at 1.
fn parzen(x: f64) -> f64 {
    if x < 0.5 { 1.0 - 6.0 * x * x * (1.0 - x) } else { 2.0 * (1.0 - x).max(0.0).powi(3) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coloured_square_is_the_double_sum() {
        let n = 60;
        let e: Vec<f64> =
            (0..n).map(|k| ((k * k) as f64 * 0.7).sin() + 0.5 * (k as f64 * 0.2).cos()).collect();
        let j = DMatrix::from_fn(n, 2, |k, c| ((k + 1) as f64 * (0.05 + 0.11 * c as f64)).cos());
        let found = coloured_square(&[j.column(0).as_slice(), j.column(1).as_slice()], &e);
        let (memory, white) = whitened(&e);
        assert!(memory > 0.1, "{memory}");
        let lags = ((WINDOW * correlation_time(&white)).ceil() as usize).max(FEWEST_LAGS).min(n - 1);
        let of_white = |k: usize| -> f64 {
            let rho = white.iter().zip(&white[k..]).map(|(x, y)| x * y).sum::<f64>() / n as f64;
            parzen(k as f64 / (lags + 1) as f64) * rho
        };
        // Recoloured: the autocovariance of a first-order autoregression a falls as a^|k|/(1 − a²).
        let coloured = |k: i32| -> f64 {
            (-(lags as i32)..=lags as i32)
                .map(|m| of_white(m.unsigned_abs() as usize) * memory.powi((k - m).abs()))
                .sum::<f64>()
                / (1.0 - memory * memory)
        };
        for a in 0..2 {
            for b in 0..2 {
                let mut sum = 0.0;
                for s in 0..n {
                    for t in 0..n {
                        sum += coloured(s as i32 - t as i32) * j[(s, a)] * j[(t, b)];
                    }
                }
                assert!((found[(a, b)] - sum).abs() < 1e-10 * sum.abs().max(1.0), "{} {sum}", found[(a, b)]);
            }
        }
    }

    #[test]
    fn blocks_of_rows_add_up_to_the_whole_matrix() {
        let rows = 2 * ROWS + 37;
        let j = DMatrix::from_fn(rows, 3, |k, c| ((k + 1) as f64 * (0.05 + 0.11 * c as f64)).cos() + 0.1);
        let columns: Vec<&[f64]> = j.as_slice().chunks_exact(rows).collect();
        let norms: Vec<f64> = j.column_iter().map(|c| c.norm()).collect();
        let gram = gram(&columns);
        let whole = j.tr_mul(&j);
        for a in 0..3 {
            for b in 0..3 {
                let size = norms[a] * norms[b];
                assert!((gram[(a, b)] - whole[(a, b)]).abs() < 1e-13 * size);
            }
        }
    }

    #[test]
    fn whitening_takes_an_autoregression_out() {
        // The impulse response of the autoregression itself.
        let e: Vec<f64> = (0..400).map(|k| 0.8f64.powi(k)).collect();
        let (memory, white) = whitened(&e);
        assert!((memory - 0.8).abs() < 1e-12, "{memory}");
        assert!(white[0] == 1.0 && white[1..].iter().all(|x| x.abs() < 1e-12));
    }

    /// Of a, b and c, b is not determined: functions of b are not either, and the others keep their errors.
    #[test]
    fn a_function_of_what_is_not_determined_is_not_determined() {
        let known = Covariance {
            names: ["a", "b", "c"].map(str::to_owned).to_vec(),
            values: vec![1.0, 2.0, 3.0],
            matrix: DMatrix::from_diagonal(&DVector::from_vec(vec![0.01, 0.04, 0.09])),
            undetermined: vec![false, true, false],
            condition_number: 1e9,
        };
        assert_eq!((known.std_error(0), known.std_error(1)), (Some(0.1), None));
        let names = ["a b", "2 c", "a"].map(str::to_owned).to_vec();
        let found = known.transformed(names, |x| vec![x[0] * x[1], 2.0 * x[2], x[0]]);
        assert_eq!(found.undetermined, [true, false, false]);
        assert!((found.std_error(1).unwrap() - 0.6).abs() < 1e-6);
        assert_eq!(found.of_determined()[(0, 0)], 0.0);
        assert_eq!(found.correlation("s").unwrap().names, ["2 c", "a"]);
    }
}
