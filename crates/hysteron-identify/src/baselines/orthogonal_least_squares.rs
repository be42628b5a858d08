//! Forward regression by orthogonal least squares with the error reduction ratio.

use hysteron_numeric::dot;

/// Share of a column's square orthogonal to the selected ones below which it is dependent.
const DEPENDENT: f64 = 1e-14;

/// A term in the order of its selection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Selected {
    /// Index of the candidate column.
    pub column: usize,
    /// Share of Σ y² that it explains beyond those selected before it.
    pub error_reduction_ratio: f64,
}

/// Termination rule of the forward selection, by the residual after each term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoppingRule {
    /// Most terms.
    pub terms: usize,
    /// Number of terms without a decrease of the criterion N ln(Σ e²) + k ln N (Schwarz 1978,
    /// doi:10.1214/aos/1176344136) after which the search ends.
    pub patience: usize,
}

/// Selects columns one at a time: in each step the one with the largest error reduction ratio
///
/// ERR = (wᵀy)²/(wᵀw yᵀy),
///
/// w being the residual of the column after projection on those selected before (S. Chen, S. A. Billings, W.
/// Luo, Int. J. Control 50 (1989) 1873–1896, doi:10.1080/00207178908953472). Neither the selection nor the
/// ratios depend on the scales of the columns or of the target. Columns are overwritten by their residuals
/// (modified Gram–Schmidt). Ends with the best value of the criterion in [`StoppingRule`]; terms after it are
/// not returned.
pub fn select(columns: &mut [Vec<f64>], target: &[f64], stop: &StoppingRule) -> Vec<Selected> {
    let rows = target.len() as f64;
    let whole = dot(target, target);
    let squares: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
    let mut open: Vec<usize> = (0..columns.len()).filter(|&j| squares[j] > 0.0).collect();
    let mut rest = target.to_vec();
    let mut selected = Vec::new();
    let (mut least, mut best) = (f64::INFINITY, 0);
    while whole > 0.0 && selected.len() < stop.terms.min(target.len()) {
        open.retain(|&j| dot(&columns[j], &columns[j]) > DEPENDENT * squares[j]);
        let ratio = |j: usize| {
            let w = &columns[j];
            dot(w, &rest).powi(2) / (dot(w, w) * whole)
        };
        let Some((place, error_reduction_ratio)) = open
            .iter()
            .map(|&j| ratio(j))
            .enumerate()
            .reduce(|best, other| if other.1 > best.1 { other } else { best })
        else {
            break;
        };
        let column = open.swap_remove(place);
        open.sort_unstable();
        let w = std::mem::take(&mut columns[column]);
        let square = dot(&w, &w);
        let project = |other: &mut [f64]| {
            let share = dot(&w, other) / square;
            other.iter_mut().zip(&w).for_each(|(x, w)| *x -= share * w);
        };
        project(&mut rest);
        open.iter().for_each(|&j| project(&mut columns[j]));
        selected.push(Selected { column, error_reduction_ratio });
        let error = dot(&rest, &rest);
        // The rounding residual of an exact fit is not fitted.
        if error <= DEPENDENT * whole {
            return selected;
        }
        let criterion = rows * (error / whole).ln() + selected.len() as f64 * rows.ln();
        if criterion < least {
            (least, best) = (criterion, selected.len());
        } else if selected.len() >= best + stop.patience {
            break;
        }
    }
    selected.truncate(best);
    selected
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    const STOP: StoppingRule = StoppingRule { terms: 20, patience: 3 };

    fn wave(k: usize, j: usize) -> f64 {
        ((k * k + 3 * k * j) as f64 * 0.61 + j as f64).sin() + 0.2 * (k as f64 * 0.05 * j as f64).cos()
    }

    fn columns(rows: usize, count: usize) -> Vec<Vec<f64>> {
        (0..count).map(|j| (0..rows).map(|k| wave(k, j + 1)).collect()).collect()
    }

    /// Σ e² of the least-squares fit of these columns to the target.
    fn remaining(columns: &[Vec<f64>], of: &[usize], target: &[f64]) -> f64 {
        let y = DVector::from_column_slice(target);
        if of.is_empty() {
            return y.norm_squared();
        }
        let a = DMatrix::from_fn(target.len(), of.len(), |k, j| columns[of[j]][k]);
        let x = a.clone().svd(true, true).solve(&y, 1e-15).unwrap();
        (a * x - y).norm_squared()
    }

    #[test]
    fn ratios_are_those_of_brute_force_least_squares_and_each_is_the_largest() {
        let all = columns(120, 9);
        let target: Vec<f64> = (0..120)
            .map(|k| 2.0 * all[4][k] - 0.7 * all[1][k] + 0.3 * all[7][k] + 0.1 * wave(k, 30))
            .collect();
        let whole: f64 = target.iter().map(|y| y * y).sum();
        let selected = select(&mut all.clone(), &target, &StoppingRule { terms: 9, patience: 9 });
        assert!(selected.len() >= 3, "{selected:?}");
        let mut chosen = Vec::new();
        for step in &selected {
            let before = remaining(&all, &chosen, &target);
            let share = |j: usize| {
                let with: Vec<usize> = chosen.iter().copied().chain([j]).collect();
                (before - remaining(&all, &with, &target)) / whole
            };
            assert!((share(step.column) - step.error_reduction_ratio).abs() < 1e-12, "{selected:?}");
            for j in (0..9).filter(|j| !chosen.contains(j)) {
                assert!(share(j) <= step.error_reduction_ratio + 1e-12, "{j} {selected:?}");
            }
            chosen.push(step.column);
        }
    }

    #[test]
    fn terms_without_noise_are_found_exactly_and_no_others() {
        let all = columns(200, 12);
        let target: Vec<f64> = (0..200).map(|k| all[2][k] - 0.5 * all[9][k] + 1e-3 * all[5][k]).collect();
        let mut found: Vec<usize> =
            select(&mut all.clone(), &target, &STOP).iter().map(|s| s.column).collect();
        found.sort_unstable();
        assert_eq!(found, [2, 5, 9]);
    }

    #[test]
    fn a_repeated_column_is_taken_once_and_nothing_explains_nothing() {
        let one = columns(50, 1).remove(0);
        let target: Vec<f64> = one.iter().map(|x| 3.0 * x).collect();
        let selected = select(&mut [one.clone(), one.clone(), vec![0.0; 50]], &target, &STOP);
        assert_eq!(selected.len(), 1);
        assert!((selected[0].error_reduction_ratio - 1.0).abs() < 1e-14);
        assert_eq!(select(&mut [one], &[0.0; 50], &STOP), []);
        assert_eq!(select(&mut [], &target, &STOP), []);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        /// Powers of two scale without rounding: the same bits of every ratio.
        #[test]
        fn the_selection_does_not_depend_on_scales(
            exponents in prop::collection::vec(-20i32..20, 8), of_target in -20i32..20, seed in 0usize..1000,
        ) {
            let all = columns(60, 8);
            let target: Vec<f64> =
                (0..60).map(|k| all[3][k] + 0.4 * all[6][k] + 0.2 * wave(k + seed, 17)).collect();
            let scaled: Vec<Vec<f64>> = all
                .iter()
                .zip(&exponents)
                .map(|(c, e)| c.iter().map(|x| x * 2f64.powi(*e)).collect())
                .collect();
            let scaled_target: Vec<f64> = target.iter().map(|y| y * 2f64.powi(of_target)).collect();
            prop_assert_eq!(
                select(&mut all.clone(), &target, &STOP),
                select(&mut scaled.clone(), &scaled_target, &STOP)
            );
        }
    }
}
