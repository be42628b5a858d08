//! Standard errors of the parameters of one step.
//!
//! Covariance of a least-squares fit, σ² (JᵀJ)⁻¹, times the factor by which correlated residuals carry less
//! information than white ones (the integrated autocorrelation time of the residual): a two-step fit leaves
//! structured residuals, and the white-noise formula would be far too optimistic.

use super::result::Correlation;
use hysteron_numeric::fft::{RealFft, fast_length};
use hysteron_optimize::LeastSquaresProblem;
use nalgebra::{DMatrix, DVector};

/// Central difference step, as a share of the parameter's search range.
const STEP: f64 = 1e-6;

/// Covariance of the search vector at `x`; `None` where the data do not determine every parameter.
/// `left_out`: derivatives of the residuals with respect to a parameter that the model omits; the bias from
/// omitting it and the variance of its estimate are added.
pub(super) fn covariance<P: LeastSquaresProblem>(
    problem: &P,
    x: &[f64],
    left_out: Option<&[f64]>,
) -> Option<DMatrix<f64>> {
    let (rows, parameters) = (problem.residual_count(), x.len());
    if parameters == 0 || rows <= parameters {
        return None;
    }
    let mut ws = problem.workspace();
    let mut at = x.to_vec();
    let mut residual = vec![0.0; rows];
    if !problem.residuals(x, &mut ws, &mut residual) {
        return None;
    }
    let mut jacobian = DMatrix::zeros(rows, parameters);
    let (mut up, mut down) = (vec![0.0; rows], vec![0.0; rows]);
    for (j, range) in problem.bounds().ranges.iter().enumerate() {
        let step =
            STEP * (range.high - range.low).min(10.0 * x[j].abs().max(1e-3 * (range.high - range.low)));
        at[j] = x[j] + step;
        let above = problem.residuals(&at, &mut ws, &mut up);
        at[j] = x[j] - step;
        let below = problem.residuals(&at, &mut ws, &mut down);
        at[j] = x[j];
        if !(above && below) {
            return None;
        }
        for (i, (u, d)) in up.iter().zip(&down).enumerate() {
            jacobian[(i, j)] = (u - d) / (2.0 * step);
        }
    }
    let within = covariance_of(jacobian.clone(), &residual)?;
    let Some(left_out) = left_out else { return Some(within) };
    let along = DVector::from_column_slice(left_out);
    // Columns scaled to unit length: their units differ by many decades.
    let norms = DVector::from_iterator(parameters, jacobian.column_iter().map(|c| c.norm()));
    for (mut column, norm) in jacobian.column_iter_mut().zip(&norms) {
        column /= *norm;
    }
    let moved_by_one = jacobian.clone().svd(true, true).solve(&along, 0.0).ok()?;
    let own = &along - &jacobian * &moved_by_one;
    let information = own.norm_squared();
    let variance = residual.iter().map(|e| e * e).sum::<f64>() / (rows - parameters) as f64;
    let best = own.dot(&DVector::from_column_slice(&residual)) / information;
    let square = best * best + variance * correlation_time(&residual) / information;
    if !square.is_finite() {
        return Some(within);
    }
    let moved = moved_by_one.component_div(&norms);
    Some(within + &moved * moved.transpose() * square)
}

/// Covariance of parameters with the Jacobian and the residual given; `None` where the data do not determine
/// every one.
pub(super) fn covariance_of(mut jacobian: DMatrix<f64>, residual: &[f64]) -> Option<DMatrix<f64>> {
    let (rows, parameters) = jacobian.shape();
    if parameters == 0 || rows <= parameters {
        return None;
    }
    // Columns scaled to unit length: their units differ by many decades.
    let norms: Vec<f64> = jacobian.column_iter().map(|c| c.norm()).collect();
    if norms.iter().any(|&n| !(n > 0.0 && n.is_finite())) {
        return None;
    }
    for (mut column, norm) in jacobian.column_iter_mut().zip(&norms) {
        column /= *norm;
    }
    let r = jacobian.qr().r();
    let inverse = r.try_inverse()?;
    let variance = residual.iter().map(|e| e * e).sum::<f64>() / (rows - parameters) as f64;
    let factor = variance * correlation_time(residual);
    let mut covariance = &inverse * inverse.transpose() * factor;
    for i in 0..parameters {
        for j in 0..parameters {
            covariance[(i, j)] /= norms[i] * norms[j];
        }
    }
    covariance.iter().all(|c| c.is_finite()).then_some(covariance)
}

/// The correlation matrix of a covariance, and its condition number.
pub(super) fn correlation(step: &str, names: Vec<String>, covariance: &DMatrix<f64>) -> Correlation {
    let deviation: Vec<f64> = covariance.diagonal().iter().map(|v| v.sqrt()).collect();
    let matrix = covariance.map_with_location(|i, j, c| c / (deviation[i] * deviation[j]));
    let eigenvalues = matrix.symmetric_eigenvalues();
    Correlation {
        step: step.to_owned(),
        names,
        matrix: matrix.row_iter().map(|row| row.iter().copied().collect()).collect(),
        condition_number: eigenvalues.max() / eigenvalues.min().max(0.0),
    }
}

/// 1 + 2 Σ ρ_k of a series, summed up to the first ρ_k ≤ 0 or a tenth of the series (Geyer's initial positive
/// sequence, doi:10.1214/ss/1177011137, in its simplest form): the number of samples that carry the
/// information of one independent sample. At least 1.
pub(crate) fn correlation_time(e: &[f64]) -> f64 {
    initial_positive_sum(&autocorrelation(e)[..e.len()])
}

/// [`correlation_time`] of a series with the inner products `products` at lags 0 … N − 1.
pub(super) fn initial_positive_sum(products: &[f64]) -> f64 {
    positive_sum(&products[..products.len() / 10])
}

/// 1 + 2 Σ ρ_k from inner products or autocorrelations at lags 0, 1, …, up to the first that is not positive.
pub(super) fn positive_sum(products: &[f64]) -> f64 {
    let power = products.first().copied().unwrap_or(0.0);
    if power <= 0.0 {
        return 1.0;
    }
    let lags = products.iter().skip(1);
    1.0 + lags.map(|product| 2.0 * product / power).take_while(|&share| share > 0.0).sum::<f64>()
}

/// Σ_i e_i e_{i+k} for k = 0 … N − 1 (and more values after these), by the power spectrum of the zero-padded
/// series.
pub(super) fn autocorrelation(e: &[f64]) -> Vec<f64> {
    let fft = RealFft::new(fast_length(2 * e.len()));
    let mut time = fft.forward.make_input_vec();
    let mut spectrum = fft.forward.make_output_vec();
    time[..e.len()].copy_from_slice(e);
    // All lengths come from the plan, so the transforms cannot fail.
    fft.transform(&mut time, &mut spectrum);
    let scale = 1.0 / fft.len() as f64;
    spectrum.iter_mut().for_each(|bin| *bin = (bin.norm_sqr() * scale).into());
    fft.invert(&mut spectrum, &mut time);
    time
}

/// Standard error of f(x) by the delta method, with central differences of `f`.
pub(super) fn standard_error(covariance: &DMatrix<f64>, x: &[f64], f: impl Fn(&[f64]) -> f64) -> Option<f64> {
    let mut at = x.to_vec();
    let gradient = DVector::from_iterator(
        x.len(),
        (0..x.len()).map(|j| {
            let step = 1e-6 * x[j].abs().max(1e-9);
            at[j] = x[j] + step;
            let up = f(&at);
            at[j] = x[j] - step;
            let down = f(&at);
            at[j] = x[j];
            (up - down) / (2.0 * step)
        }),
    );
    let variance = (covariance * &gradient).dot(&gradient);
    (variance.is_finite() && variance >= 0.0).then(|| variance.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_optimize::{Bounds, Problem, Range};

    #[test]
    fn autocorrelation_is_the_sum_of_products() {
        let e: Vec<f64> = (0..77).map(|k| f64::from(k * k % 23) - 11.0).collect();
        let products = autocorrelation(&e);
        for lag in 0..e.len() {
            let direct: f64 = e.iter().zip(&e[lag..]).map(|(a, b)| a * b).sum();
            assert!((products[lag] - direct).abs() < 1e-10, "{lag}: {} {direct}", products[lag]);
        }
    }

    /// r = a + b t − y.
    struct Line {
        t: Vec<f64>,
        y: Vec<f64>,
        bounds: Bounds,
    }

    impl Problem for Line {
        type Workspace = Vec<f64>;
        fn bounds(&self) -> &Bounds {
            &self.bounds
        }
        fn workspace(&self) -> Vec<f64> {
            vec![0.0; self.t.len()]
        }
        fn cost(&self, x: &[f64], ws: &mut Vec<f64>) -> f64 {
            let mut out = std::mem::take(ws);
            self.residuals(x, ws, &mut out);
            *ws = out;
            hysteron_optimize::root_mean_square(ws)
        }
    }

    impl LeastSquaresProblem for Line {
        fn residual_count(&self) -> usize {
            self.t.len()
        }
        fn residuals(&self, x: &[f64], _: &mut Vec<f64>, out: &mut [f64]) -> bool {
            for ((r, t), y) in out.iter_mut().zip(&self.t).zip(&self.y) {
                *r = x[0] + x[1] * t - y;
            }
            true
        }
    }

    #[test]
    fn agrees_with_the_textbook_errors_of_a_straight_line() {
        // Alternating residuals ±1 around y = 2 + 3 t: white by this measure, variance N/(N−2).
        let t: Vec<f64> = (0..100).map(|k| k as f64).collect();
        let e: Vec<f64> = (0..100).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let y = t.iter().zip(&e).map(|(t, e)| 2.0 + 3.0 * t + e).collect();
        let bounds =
            Bounds { ranges: vec![Range::linear("a", -10.0, 10.0), Range::linear("b", -10.0, 10.0)] };
        let line = Line { t: t.clone(), y, bounds };
        let c = covariance(&line, &[2.0, 3.0], None).unwrap();
        let s2 = 100.0 / 98.0;
        let mean = 49.5;
        let sxx: f64 = t.iter().map(|t| (t - mean) * (t - mean)).sum();
        assert!((c[(1, 1)] / (s2 / sxx) - 1.0).abs() < 1e-6, "{}", c[(1, 1)]);
        assert!((c[(0, 0)] / (s2 * (0.01 + mean * mean / sxx)) - 1.0).abs() < 1e-6);
        // Textbook: corr(a, b) = −mean / √(mean² + Sxx/N), and the eigenvalues of a 2 × 2 correlation are 1 ±
        // ρ.
        let rho = -mean / (mean * mean + sxx / 100.0).sqrt();
        let found = correlation("line", vec!["a".into(), "b".into()], &c);
        assert!((found.matrix[0][1] - rho).abs() < 1e-6 && found.matrix[0][0] == 1.0, "{found:?}");
        assert!((found.condition_number / ((1.0 - rho) / (1.0 + rho)) - 1.0).abs() < 1e-4, "{found:?}");
        let doubled = standard_error(&c, &[2.0, 3.0], |x| 2.0 * x[1]).unwrap();
        assert!((doubled - 2.0 * c[(1, 1)].sqrt()).abs() < 1e-9);
    }

    #[test]
    fn a_slow_residual_counts_for_fewer_samples() {
        let slow: Vec<f64> = (0..1000).map(|k| (k as f64 / 50.0).sin()).collect();
        assert!(correlation_time(&slow) > 50.0);
        let white: Vec<f64> = (0..1000).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        assert_eq!(correlation_time(&white), 1.0);
    }

    #[test]
    fn says_so_when_a_parameter_is_not_determined() {
        let bounds =
            Bounds { ranges: vec![Range::linear("a", -10.0, 10.0), Range::linear("b", -10.0, 10.0)] };
        let line = Line { t: vec![0.0; 10], y: vec![1.0; 10], bounds };
        assert!(covariance(&line, &[1.0, 0.0], None).is_none());
    }

    /// y = 2 + 3 t + ½ t² fitted by a line: the variance of its slope grows by the squared bias from the
    /// omitted t² and the variance of that coefficient, both by textbook formulas for t = −5 … 5, where t² is
    /// orthogonal to t.
    #[test]
    fn what_is_left_out_counts_as_far_as_it_moves_the_parameters() {
        let t: Vec<f64> = (-5..=5).map(f64::from).collect();
        let noise = |k: usize| if k.is_multiple_of(2) { 0.1 } else { -0.1 };
        let y = t.iter().enumerate().map(|(k, t)| 2.0 + 3.0 * t + 0.5 * t * t + noise(k)).collect();
        let bounds =
            Bounds { ranges: vec![Range::linear("a", -10.0, 20.0), Range::linear("b", -10.0, 10.0)] };
        let line = Line { t: t.clone(), y, bounds };
        let mean = line.y.iter().sum::<f64>() / 11.0;
        let slope = t.iter().zip(&line.y).map(|(t, y)| t * y).sum::<f64>() / 110.0;
        let within = covariance(&line, &[mean, slope], None).unwrap();
        // Along −½ t² of the residual a + b t − y.
        let along: Vec<f64> = t.iter().map(|t| -t * t).collect();
        let beside = covariance(&line, &[mean, slope], Some(&along)).unwrap();
        let (s1, s2) = (t.iter().map(|t| t * t).sum::<f64>(), t.iter().map(|t| t.powi(4)).sum::<f64>());
        let own = s2 - s1 * s1 / 11.0;
        let residual: Vec<f64> = t.iter().zip(&line.y).map(|(t, y)| mean + slope * t - y).collect();
        let coefficient = t.iter().zip(&residual).map(|(t, e)| -(t * t - s1 / 11.0) * e).sum::<f64>() / own;
        let noise = residual.iter().map(|e| e * e).sum::<f64>() / 9.0 * correlation_time(&residual) / own;
        let expected = within[(0, 0)] + (s1 / 11.0).powi(2) * (coefficient.powi(2) + noise);
        assert!((coefficient - 0.5).abs() < 0.01, "{coefficient}");
        assert!((beside[(0, 0)] / expected - 1.0).abs() < 1e-6, "{} {expected}", beside[(0, 0)]);
        assert!((beside[(1, 1)] / within[(1, 1)] - 1.0).abs() < 1e-9);
    }
}
