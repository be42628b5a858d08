//! Coefficients by least squares of the simulated error, or of the one-step error, with exact derivatives.

use super::BaselineError;
use super::free_run::{Differentiable, free_run};
use super::regressors::{Regressors, Series};
use hysteron_optimize::{
    Algorithm, Bounds, Derivative, LeastSquaresOptions, LeastSquaresProblem, Problem, Range, Settings,
    Unobserved, minimize, root_mean_square,
};

/// Most errors minimised, evenly spaced: neighbours are redundant.
const ERRORS: usize = 8000;
/// Relative decrease of the cost below which a search ends.
const COST_TOLERANCE: f64 = 1e-5;

/// Past outputs fed to a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Feedback {
    /// The measured ones: one-step prediction, "series-parallel".
    Measured,
    /// Its own: simulation, "parallel" (K. S. Narendra, K. Parthasarathy, IEEE Trans. Neural Netw. 1 (1990)
    /// 4–27, doi:10.1109/72.80202).
    Simulated,
}

/// Minimises the error over the valid samples of `series` (about 8000 of them) by Levenberg–Marquardt, from
/// the coefficients of `model`, each within `reach`.
///
/// Sensitivities of the simulated output: dy_k/dθ = ∂f/∂θ + Σ_i ∂f/∂y_{k−i} dy_{k−i}/dθ.
///
/// # Errors
/// [`BaselineError::Search`], also where the initial simulation diverges.
pub(super) fn refine<M: Differentiable>(
    model: &M,
    regressors: &Regressors,
    series: &[Series],
    feedback: Feedback,
    reach: f64,
    iterations: usize,
) -> Result<M, BaselineError> {
    let ranges = model.coefficients().iter().enumerate();
    let ranges = ranges.map(|(i, c)| Range::linear(&format!("c{i}"), c - reach, c + reach)).collect();
    let usable: Vec<Vec<usize>> = series
        .iter()
        .map(|one| match feedback {
            Feedback::Simulated => (regressors.lags.past()..one.y.len()).filter(|&k| one.valid[k]).collect(),
            Feedback::Measured => one.rows(regressors.lags).collect(),
        })
        .collect();
    let every = usable.iter().map(Vec::len).sum::<usize>().div_ceil(ERRORS).max(1);
    let counted: Vec<Vec<usize>> =
        usable.into_iter().map(|one| one.into_iter().step_by(every).collect()).collect();
    let count = counted.iter().map(Vec::len).sum();
    let problem =
        Fit { model: model.clone(), regressors, series, feedback, bounds: Bounds { ranges }, counted, count };
    let algorithm = Algorithm::LeastSquares(LeastSquaresOptions {
        starts: 1,
        agreement: None,
        iterations,
        cost_tolerance: COST_TOLERANCE,
        ..LeastSquaresOptions::default()
    });
    let settings = Settings { starts: vec![model.coefficients().to_vec()], ..Settings::default() };
    let outcome = minimize(&problem, &algorithm, &settings, &mut Unobserved, None)
        .map_err(|e| BaselineError::Search { because: e.to_string() })?;
    let mut fitted = model.clone();
    fitted.set_coefficients(&outcome.best);
    Ok(fitted)
}

struct Fit<'a, M> {
    model: M,
    regressors: &'a Regressors,
    series: &'a [Series],
    feedback: Feedback,
    bounds: Bounds,
    /// Scored samples of each series, and their number.
    counted: Vec<Vec<usize>>,
    count: usize,
}

impl<M: Differentiable> Fit<'_, M> {
    fn at(&self, coefficients: &[f64]) -> M {
        let mut model = self.model.clone();
        model.set_coefficients(coefficients);
        model
    }

    /// Past outputs fed to the model; `None` where it diverges.
    fn fed(&self, model: &M, one: &Series) -> Option<Vec<f64>> {
        match self.feedback {
            Feedback::Measured => Some(one.y.clone()),
            Feedback::Simulated => free_run(model, self.regressors, one).ok(),
        }
    }
}

impl<M: Differentiable> Problem for Fit<'_, M> {
    type Workspace = Vec<f64>;

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) -> Vec<f64> {
        vec![0.0; self.count]
    }

    fn cost(&self, x: &[f64], residuals: &mut Vec<f64>) -> f64 {
        let mut out = std::mem::take(residuals);
        let cost =
            if self.residuals(x, residuals, &mut out) { root_mean_square(&out) } else { f64::INFINITY };
        *residuals = out;
        cost
    }
}

impl<M: Differentiable> LeastSquaresProblem for Fit<'_, M> {
    fn residual_count(&self) -> usize {
        self.count
    }

    fn residuals(&self, coefficients: &[f64], _: &mut Vec<f64>, out: &mut [f64]) -> bool {
        let model = self.at(coefficients);
        let mut x = vec![0.0; self.regressors.lags.count()];
        let mut place = 0;
        for (one, counted) in self.series.iter().zip(&self.counted) {
            let Some(y) = self.fed(&model, one) else { return false };
            for &k in counted {
                let predicted = match self.feedback {
                    Feedback::Simulated => y[k],
                    Feedback::Measured => {
                        self.regressors.fill(one, &y, k, &mut x);
                        model.next(&x)
                    }
                };
                out[place] = predicted - one.y[k];
                place += 1;
            }
        }
        true
    }

    fn jacobian(&self, coefficients: &[f64], _: &mut Vec<f64>, out: &mut [f64]) -> Derivative {
        let model = self.at(coefficients);
        let (lags, parameters) = (self.regressors.lags, coefficients.len());
        let (mut x, mut by_x) = (vec![0.0; lags.count()], vec![0.0; lags.count()]);
        let mut own = vec![0.0; parameters];
        let mut place = 0;
        for (one, counted) in self.series.iter().zip(&self.counted) {
            let Some(y) = self.fed(&model, one) else { return Derivative::Infeasible };
            let mut counted = counted.iter().peekable();
            // Sensitivities of the outputs before, sample k in slot k mod ny.
            let mut before = vec![vec![0.0; parameters]; lags.output];
            for k in lags.past()..y.len() {
                let counts = counted.next_if_eq(&&k).is_some();
                if self.feedback == Feedback::Measured && !counts {
                    continue;
                }
                self.regressors.fill(one, &y, k, &mut x);
                model.derivatives(&x, &mut by_x, &mut own);
                if self.feedback == Feedback::Simulated {
                    self.regressors.to_lagged_outputs(&mut by_x);
                    for (i, share) in by_x.iter().take(lags.output).enumerate() {
                        let earlier = &before[(k - 1 - i) % lags.output];
                        own.iter_mut().zip(earlier).for_each(|(s, e)| *s += share * e);
                    }
                    before[k % lags.output].copy_from_slice(&own);
                }
                if counts {
                    own.iter().enumerate().for_each(|(j, s)| out[j * self.count + place] = *s);
                    place += 1;
                }
            }
        }
        Derivative::Written
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baselines::monomial::Monomial;
    use crate::baselines::neural_narx::NeuralNarx;
    use crate::baselines::polynomial_narx::PolynomialNarx;
    use crate::baselines::regressors::{Lags, directions};

    const LAGS: Lags = Lags { output: 3, input: 2 };

    fn series() -> Vec<Series> {
        let one = |n: usize, f: f64| {
            let u: Vec<f64> = (0..n).map(|k| (k as f64 * f).sin()).collect();
            let y = u.iter().enumerate().map(|(k, u)| 0.5 * u + 0.5 * ((k * k) as f64 * 0.7).sin()).collect();
            let valid = (0..n).map(|k| k % 17 != 5).collect();
            Series { direction: directions(&u, 0.01), u, y, valid }
        };
        vec![one(60, 0.11), one(45, 0.29)]
    }

    /// A stable nonlinear recursion.
    fn polynomial() -> PolynomialNarx {
        let terms = [vec![], vec![0], vec![1], vec![3], vec![0, 0, 5], vec![2, 5, 6], vec![4, 4]];
        let coefficients = vec![0.05, 0.6, 0.1, 0.3, -0.2, 0.15, 0.4];
        PolynomialNarx { terms: terms.into_iter().map(Monomial).collect(), coefficients }
    }

    fn neural() -> NeuralNarx {
        let inputs = LAGS.count();
        let parameters = (0..1 + inputs + 3 * (2 + inputs)).map(|i| 0.15 * ((i * i) as f64 * 0.7).sin());
        NeuralNarx::new(inputs, parameters.collect())
    }

    /// Central differences of the residuals, error 1e-10 for step 1e-5 and third derivatives of the order of
    /// 1.
    fn check<M: Differentiable>(model: &M, feedback: Feedback) {
        let series = series();
        let regressors = Regressors::scaled(LAGS, &series);
        let c = model.coefficients().to_vec();
        let ranges = c.iter().map(|c| Range::linear("c", c - 1.0, c + 1.0)).collect();
        let counted: Vec<Vec<usize>> = series.iter().map(|one| one.rows(LAGS).step_by(2).collect()).collect();
        let count = counted.iter().map(Vec::len).sum();
        let problem = Fit {
            model: model.clone(),
            regressors: &regressors,
            series: &series,
            feedback,
            bounds: Bounds { ranges },
            counted,
            count,
        };
        let mut ws = problem.workspace();
        let mut jacobian = vec![f64::NAN; count * c.len()];
        assert_eq!(problem.jacobian(&c, &mut ws, &mut jacobian), Derivative::Written);
        for j in 0..c.len() {
            let mut at = |h: f64| {
                let mut moved = c.clone();
                moved[j] += h;
                let mut out = vec![f64::NAN; count];
                assert!(problem.residuals(&moved, &mut ws, &mut out));
                out
            };
            let (up, down) = (at(1e-5), at(-1e-5));
            for i in 0..count {
                let (difference, exact) = ((up[i] - down[i]) / 2e-5, jacobian[j * count + i]);
                assert!(
                    (difference - exact).abs() < 1e-7 * (1.0 + exact.abs()),
                    "{j} {i}: {difference} {exact}"
                );
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        for feedback in [Feedback::Measured, Feedback::Simulated] {
            check(&polynomial(), feedback);
            check(&neural(), feedback);
        }
    }

    #[test]
    fn coefficients_that_made_the_output_are_found_again_from_near_them() {
        let truth = polynomial();
        let regressors = Regressors::unscaled(LAGS);
        let mut series = series();
        for one in &mut series {
            one.y = free_run(&truth, &regressors, one).unwrap();
        }
        let mut start = truth.clone();
        start.coefficients.iter_mut().for_each(|c| *c *= 0.9);
        let found = refine(&start, &regressors, &series, Feedback::Simulated, 1.0, 50).unwrap();
        for (c, t) in found.coefficients.iter().zip(&truth.coefficients) {
            assert!((c - t).abs() < 1e-6, "{c} {t}");
        }
    }

    #[test]
    fn a_start_that_diverges_is_refused() {
        let mut model = polynomial();
        model.coefficients[1] = 3.0;
        let series = series();
        let refused =
            refine(&model, &Regressors::unscaled(LAGS), &series, Feedback::Simulated, 0.1, 5).unwrap_err();
        assert!(matches!(refused, BaselineError::Search { .. }), "{refused}");
    }
}
