//! Polynomial NARX models, their terms selected by orthogonal least squares.

use super::BaselineError;
use super::free_run::{Differentiable, OneStep, simulated_error};
use super::monomial::Monomial;
use super::orthogonal_least_squares::{StoppingRule, select};
use super::regressors::{Lags, Regressors, Series};
use super::simulation_error::{Feedback, refine};
use super::training_set::{Rows, TrainingSet};
use hysteron_numeric::triangular;

/// Highest degree of a term: the least that includes rate-independent hysteresis (see [`Lags`]).
const DEGREE: usize = 3;
/// Most terms, and terms without gain after which the selection ends.
const STOP: StoppingRule = StoppingRule { terms: 30, patience: 4 };
/// Rows for the selection of terms, and for the fit of coefficients.
const ROWS_SELECTED_ON: usize = 6000;
const ROWS_FITTED: usize = 60_000;
/// Structures whose coefficients are refined before the final choice.
const FINALISTS: usize = 3;
/// Iterations of a refinement, and largest change of a coefficient.
const ITERATIONS: usize = 30;
const REACH: f64 = 10.0;

/// y_k = Σ cᵢ mᵢ(x), monomials mᵢ of the regressors.
#[derive(Clone, Debug, PartialEq)]
pub struct PolynomialNarx {
    /// Terms in the order of their selection.
    pub terms: Vec<Monomial>,
    /// Their coefficients, for regressors and output in units of the training ranges.
    pub coefficients: Vec<f64>,
}

impl OneStep for PolynomialNarx {
    fn next(&self, x: &[f64]) -> f64 {
        self.terms.iter().zip(&self.coefficients).map(|(m, c)| c * m.value(x)).sum()
    }

    fn parameters(&self) -> usize {
        self.coefficients.len()
    }
}

impl Differentiable for PolynomialNarx {
    fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    fn set_coefficients(&mut self, coefficients: &[f64]) {
        self.coefficients = coefficients.to_vec();
    }

    fn derivatives(&self, x: &[f64], by_x: &mut [f64], by_parameter: &mut [f64]) -> f64 {
        by_x.fill(0.0);
        let mut output = 0.0;
        for ((term, c), slot) in self.terms.iter().zip(&self.coefficients).zip(by_parameter) {
            *slot = term.value(x);
            output += c * *slot;
            term.add_derivatives(x, *c, by_x);
        }
        output
    }
}

/// A structure, its regressors and its held-out simulation error.
struct Candidate<'a> {
    set: &'a TrainingSet,
    regressors: Regressors,
    model: PolynomialNarx,
    error: f64,
}

/// Trains on sets of the same records with different lag intervals; returns the index of the best set first.
///
/// For every interval and number of lags, terms are selected on three quarters of the records by the one-step
/// error. Of the nested models (the first term, the first two, …) those that simulate the held-out quarter
/// best are refined on the simulated error of the three quarters, and the best of these on the quarter is
/// refined on all.
pub(super) fn train(
    sets: &[TrainingSet],
    lags: &[Lags],
) -> Result<(usize, Regressors, PolynomialNarx), BaselineError> {
    let mut candidates = Vec::new();
    let mut refused = BaselineError::NoStableModel;
    for set in sets {
        for &lags in lags {
            match along_the_way(set, lags) {
                Ok(found) => candidates.extend(best_of(found)),
                Err(error) => refused = error,
            }
        }
    }
    candidates.sort_by(|a, b| a.error.total_cmp(&b.error));
    candidates.truncate(FINALISTS);
    for candidate in &mut candidates {
        let Candidate { set, regressors, model, error } = candidate;
        if let Ok(refined) = refine(model, regressors, &set.fitted, Feedback::Simulated, REACH, ITERATIONS)
            && let Some(new) = simulated_error(&refined, regressors, &set.series, &set.held_back)
            && new < *error
        {
            (*model, *error) = (refined, new);
        }
    }
    candidates.sort_by(|a, b| a.error.total_cmp(&b.error));
    let Candidate { set, regressors, model, .. } = candidates.into_iter().next().ok_or(refused)?;
    // A model that is stable on the held-out quarter is stable on the whole: a refinement only lowers the
    // error.
    let model = refine(&model, &regressors, &set.series, Feedback::Simulated, REACH, ITERATIONS)?;
    let number = sets.iter().position(|s| std::ptr::eq(s, set)).unwrap_or(0);
    Ok((number, regressors, model))
}

fn best_of(candidates: Vec<Candidate<'_>>) -> Option<Candidate<'_>> {
    candidates.into_iter().min_by(|a, b| a.error.total_cmp(&b.error))
}

/// The nested models of one to all selected terms that can be simulated, with their errors.
fn along_the_way(set: &TrainingSet, lags: Lags) -> Result<Vec<Candidate<'_>>, BaselineError> {
    let regressors = Regressors::scaled(lags, &set.fitted);
    let terms = selected_terms(&regressors, &set.fitted)?;
    let models = nested(&regressors, &set.fitted, &terms)?;
    let candidate = |model| {
        let error = simulated_error(&model, &regressors, &set.series, &set.held_back)?;
        Some(Candidate { set, regressors: regressors.clone(), model, error })
    };
    Ok(models.into_iter().filter_map(candidate).collect())
}

/// Terms by orthogonal least squares of the one-step error, in their order.
fn selected_terms(regressors: &Regressors, series: &[Series]) -> Result<Vec<Monomial>, BaselineError> {
    let rows = Rows::new(regressors, series, ROWS_SELECTED_ON)?;
    let all = Monomial::all(rows.width, DEGREE, regressors.direction());
    let mut columns: Vec<Vec<f64>> = all.iter().map(|m| rows.iter().map(|x| m.value(x)).collect()).collect();
    let selected = select(&mut columns, &rows.target, &STOP);
    Ok(selected.into_iter().map(|s| all[s.column].clone()).collect())
}

/// The least-squares fits of the first term, of the first two, and so on.
fn nested(
    regressors: &Regressors,
    series: &[Series],
    terms: &[Monomial],
) -> Result<Vec<PolynomialNarx>, BaselineError> {
    let rows = Rows::new(regressors, series, ROWS_FITTED)?;
    let mut columns: Vec<Vec<f64>> =
        terms.iter().map(|m| rows.iter().map(|x| m.value(x)).collect()).collect();
    columns.push(rows.target);
    let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let r = triangular(&slices);
    let fit = |count: usize| {
        let upper = r.view((0, 0), (count, count)).into_owned();
        let solved = upper.solve_upper_triangular(&r.view((0, terms.len()), (count, 1)).into_owned())?;
        let coefficients: Vec<f64> = solved.iter().copied().collect();
        let finite = coefficients.iter().all(|c| c.is_finite());
        finite.then(|| PolynomialNarx { terms: terms[..count].to_vec(), coefficients })
    };
    Ok((1..=terms.len()).filter_map(fit).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baselines::free_run::free_run;
    use crate::baselines::regressors::directions;

    const LAGS: Lags = Lags { output: 2, input: 2 };

    /// Outputs of `model` to steps of any height, each held for three samples, in two records.
    fn series(model: &PolynomialNarx) -> Vec<Series> {
        let one = |n: usize| {
            let mut state = 7919 + n as u64;
            let mut level = 0.0;
            // A linear congruential generator (Knuth's MMIX constants).
            let drive = |k: usize| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                if k.is_multiple_of(3) {
                    level = (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0;
                }
                level
            };
            let u: Vec<f64> = (0..n).map(drive).collect();
            let mut series =
                Series { direction: directions(&u, 0.01), y: vec![0.1; n], valid: vec![true; n], u };
            series.y = free_run(model, &Regressors::unscaled(LAGS), &series).unwrap();
            series
        };
        vec![one(700), one(500)]
    }

    const Y: usize = 0;
    const DY: usize = 1;
    const U: usize = 2;
    const STEP: usize = 4;
    const S: usize = 5;

    fn model(terms: &[(&[usize], f64)]) -> PolynomialNarx {
        PolynomialNarx {
            terms: terms.iter().map(|(t, _)| Monomial(t.to_vec())).collect(),
            coefficients: terms.iter().map(|(_, c)| *c).collect(),
        }
    }

    /// Hysteresis followed by a lag.
    fn truth() -> PolynomialNarx {
        model(&[
            (&[Y], 0.9),
            (&[DY], 0.25),
            (&[U], 0.08),
            (&[STEP], 0.35),
            (&[Y, STEP, S], -0.4),
            (&[U, U, STEP], -0.2),
        ])
    }

    /// The model of all terms selected from its own simulation.
    fn found_again(truth: &PolynomialNarx) -> PolynomialNarx {
        let series = series(truth);
        let regressors = Regressors::unscaled(LAGS);
        let terms = selected_terms(&regressors, &series).unwrap();
        nested(&regressors, &series, &terms).unwrap().pop().unwrap()
    }

    #[test]
    fn the_terms_and_coefficients_of_a_sparse_model_are_found_exactly() {
        let (truth, found) = (truth(), found_again(&truth()));
        assert_eq!(found.terms.len(), truth.terms.len(), "{:?}", found.terms);
        for (term, c) in truth.terms.iter().zip(&truth.coefficients) {
            let place = found.terms.iter().position(|t| t == term).unwrap_or_else(|| panic!("{term:?}"));
            assert!((found.coefficients[place] - c).abs() < 1e-9, "{term:?}: {}", found.coefficients[place]);
        }
    }

    #[test]
    fn a_term_that_later_ones_make_needless_has_no_coefficient() {
        // The two terms of the hysteresis equation resemble one of ∇y before either is selected: forward
        // selection cannot remove it.
        let truth = model(&[
            (&[Y], 0.9),
            (&[DY], 0.25),
            (&[U], 0.08),
            (&[STEP], 0.35),
            (&[U, STEP, S], 0.3),
            (&[Y, STEP, S], -0.5),
        ]);
        let found = found_again(&truth);
        assert!(found.terms.len() <= 7, "{:?}", found.terms);
        for (term, c) in found.terms.iter().zip(&found.coefficients) {
            let place = truth.terms.iter().position(|t| t == term);
            let expected = place.map_or(0.0, |p| truth.coefficients[p]);
            assert!((c - expected).abs() < 1e-9, "{term:?}: {c}");
        }
        assert!(truth.terms.iter().all(|t| found.terms.contains(t)));
    }

    #[test]
    fn every_size_along_the_way_is_the_least_squares_fit_of_its_terms() {
        let regressors = Regressors::unscaled(LAGS);
        let mut series = series(&truth());
        for one in &mut series {
            one.y.iter_mut().enumerate().for_each(|(k, y)| *y += 0.01 * ((k * k) as f64 * 0.7).sin());
        }
        let terms = selected_terms(&regressors, &series).unwrap();
        let rows = Rows::new(&regressors, &series, usize::MAX).unwrap();
        for model in nested(&regressors, &series, &terms).unwrap() {
            let count = model.terms.len();
            let a = nalgebra::DMatrix::from_fn(rows.len(), count, |i, j| {
                model.terms[j].value(&rows.x[i * rows.width..(i + 1) * rows.width])
            });
            let y = nalgebra::DVector::from_column_slice(&rows.target);
            let brute = a.svd(true, true).solve(&y, 1e-14).unwrap();
            for (c, b) in model.coefficients.iter().zip(brute.iter()) {
                assert!((c - b).abs() < 1e-8 * (1.0 + b.abs()), "{count}: {c} {b}");
            }
        }
    }
}
