//! What a drive is to make certain: some quantities (their generalised variance, D_s-optimality; for one
//! quantity c-optimality), or the output along given motions (its mean variance, I-optimality).
//!
//! Fedorov, Theory of Optimal Experiments (1972); Atkinson, Donev, Tobias, Optimum Experimental Designs, with
//! SAS (2007), ch. 10.

use nalgebra::DMatrix;

use super::information::Weighted;
use crate::IdentifyError;

/// Criterion over the covariance of the directions of the prior.
#[derive(Clone, Debug)]
pub(super) enum Objective {
    /// Gradients of quantities, one row each.
    Quantities(DMatrix<f64>),
    /// W = GᵀG/N over N samples of motions to predict, G the derivatives of the output.
    Output(DMatrix<f64>),
}

impl Objective {
    /// Geometric mean of the standard errors of the quantities, in the units of their gradients, or the rms
    /// standard deviation of the output, after a record; infinite where rounding leaves no covariance.
    pub(super) fn error(&self, record: &Weighted) -> f64 {
        record.covariance().map_or(f64::INFINITY, |c| self.error_of(&c))
    }

    /// [`Self::error`] of a record of this information and its due weight.
    fn error_after(&self, information: &DMatrix<f64>) -> f64 {
        self.error(&Weighted { matrix: information.clone(), weight: 1.0 })
    }

    /// [`Self::error`] of a covariance of the directions.
    pub(super) fn error_of(&self, covariance: &DMatrix<f64>) -> f64 {
        match self {
            Self::Quantities(gradients) => {
                let own = gradients * covariance * gradients.transpose();
                own.determinant().max(0.0).powf(0.5 / gradients.nrows().max(1) as f64)
            }
            Self::Output(weight) => {
                // No less than the sum is rounded by.
                let parts = weight.component_mul(covariance);
                parts.sum().max(f64::EPSILON * parts.abs().sum()).sqrt()
            }
        }
    }

    /// Repetitions of a record, a real number, that reach `error`; `None` where a million do not.
    pub(super) fn repetitions(&self, repeated: &Weighted, error: f64) -> Option<f64> {
        const MOST: f64 = 1e6;
        let reaches = |times: f64| self.error(&repeated.repeated(times)) <= error;
        if !reaches(MOST) {
            return None;
        }
        let (mut low, mut high) = (1e-6f64, MOST);
        for _ in 0..60 {
            let middle = (low * high).sqrt();
            if reaches(middle) { high = middle } else { low = middle }
        }
        Some(high)
    }
}

/// The segments by the error beside others of information `rest`, least first.
pub(super) fn ranked(
    objective: &Objective,
    information: &[DMatrix<f64>],
    rest: &DMatrix<f64>,
) -> Vec<(usize, f64)> {
    let errors = information.iter().map(|own| objective.error_after(&(rest + own)));
    let mut ranked: Vec<(usize, f64)> = errors.enumerate().collect();
    ranked.sort_by(|a, b| a.1.total_cmp(&b.1));
    ranked
}

/// Segments by their place among `information`, `slots` in number, that give the least error: from a greedy
/// choice, one segment is exchanged after the other as long as that helps (Fedorov's exchange algorithm).
///
/// # Errors
/// [`IdentifyError::Stopped`] where `go_on` says so.
pub(super) fn exchanged(
    objective: &Objective,
    information: &[DMatrix<f64>],
    slots: usize,
    go_on: impl Fn() -> Result<(), IdentifyError>,
) -> Result<Vec<usize>, IdentifyError> {
    let Some(first) = information.first() else { return Ok(Vec::new()) };
    let mut chosen = Vec::with_capacity(slots);
    let mut sum = DMatrix::zeros(first.nrows(), first.ncols());
    let best_beside = |rest: &DMatrix<f64>| {
        ranked(objective, information, rest).first().copied().unwrap_or((0, f64::INFINITY))
    };
    for _ in 0..slots {
        go_on()?;
        let (index, _) = best_beside(&sum);
        sum += &information[index];
        chosen.push(index);
    }
    let mut error = objective.error_after(&sum);
    // Each exchange lowers the error; a finite number of lists ends it.
    loop {
        let before = error;
        for slot in 0..slots {
            go_on()?;
            let rest = &sum - &information[chosen[slot]];
            let (index, less) = best_beside(&rest);
            if less < error * (1.0 - 1e-9) {
                (sum, error) = (rest + &information[index], less);
                chosen[slot] = index;
            }
        }
        if error >= before * (1.0 - 1e-6) {
            return Ok(chosen);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(diagonal: [f64; 2]) -> DMatrix<f64> {
        DMatrix::from_row_slice(2, 2, &[diagonal[0], 0.0, 0.0, diagonal[1]])
    }

    #[test]
    fn exchange_finds_the_best_of_all_lists() {
        let segments = [of([9.0, 0.0]), of([0.0, 5.0]), of([3.0, 2.5]), of([1.0, 1.0])];
        let both = Objective::Quantities(DMatrix::identity(2, 2));
        let first = Objective::Quantities(DMatrix::from_row_slice(1, 2, &[1.0, 0.0]));
        let output = Objective::Output(of([0.1, 2.0]));
        for objective in [both, first, output] {
            let chosen = exchanged(&objective, &segments, 3, || Ok(())).unwrap();
            let error = |list: &[usize]| {
                objective.error_after(&list.iter().fold(of([0.0, 0.0]), |sum, &i| sum + &segments[i]))
            };
            let mut least = f64::INFINITY;
            for list in 0..64usize {
                least = least.min(error(&[list % 4, list / 4 % 4, list / 16]));
            }
            assert!(error(&chosen) <= least * (1.0 + 1e-12), "{chosen:?}");
        }
    }

    #[test]
    fn an_error_halves_after_about_four_times_the_information() {
        let objective = Objective::Quantities(DMatrix::identity(2, 2));
        let record = |matrix| Weighted { matrix, weight: 1.0 };
        let one = record(of([100.0, 100.0]));
        let times = objective.repetitions(&one, 0.5 * objective.error(&one)).unwrap();
        // (1 + 100 n) = 4 · 101.
        assert!((times - 4.03).abs() < 1e-6, "{times}");
        assert_eq!(objective.repetitions(&record(of([1.0, 0.0])), 1e-3), None);
    }
}
