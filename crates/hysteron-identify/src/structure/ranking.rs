//! Ranking of candidates by held-out error, with the one-standard-error rule.

use serde::{Deserialize, Serialize};

/// Rank statistics of one candidate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Standing {
    /// Mean held-out error over the folds.
    pub mean: f64,
    /// Standard error of that mean over the folds.
    pub std_error: f64,
    /// Mean over the folds of this candidate's error less the best one's.
    pub difference: f64,
    /// Standard error of that mean of paired differences.
    pub difference_std_error: f64,
    /// Not worse than the best by more than one standard error of the difference.
    pub as_good_as_best: bool,
}

/// The order of the candidates.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranking {
    /// Candidate with the smallest mean error.
    pub best: usize,
    /// Among those as good as the best the one with the fewest parameters: the "one standard error" rule
    /// (Hastie, Tibshirani, Friedman, The Elements of Statistical Learning, 2009, §7.10), with the standard
    /// error of paired differences, in which the difficulty of a fold common to all candidates cancels.
    pub preferred: usize,
    /// Candidates by mean error, smallest first; those without an error on every fold are left out.
    pub order: Vec<usize>,
    /// Standing of each candidate; `None` for one left out.
    pub standings: Vec<Option<Standing>>,
}

/// Ranks candidates by their errors on the folds, `None` for one that failed on a fold; `parameters` of each.
/// `None` where no candidate is complete.
pub fn rank(errors: &[Option<Vec<f64>>], parameters: &[usize]) -> Option<Ranking> {
    let mut order: Vec<usize> = (0..errors.len()).filter(|&i| errors[i].is_some()).collect();
    let mean_of = |i: usize| errors[i].as_deref().map_or(f64::INFINITY, |e| moments(e).0);
    order.sort_by(|&a, &b| mean_of(a).total_cmp(&mean_of(b)).then(parameters[a].cmp(&parameters[b])));
    let best = *order.first()?;
    let of_best = errors[best].as_deref()?;
    let standings: Vec<Option<Standing>> = errors
        .iter()
        .map(|of_this| {
            let of_this = of_this.as_deref()?;
            let paired: Vec<f64> = of_this.iter().zip(of_best).map(|(a, b)| a - b).collect();
            let (mean, std_error) = moments(of_this);
            let (difference, difference_std_error) = moments(&paired);
            let as_good_as_best = difference <= difference_std_error;
            Some(Standing { mean, std_error, difference, difference_std_error, as_good_as_best })
        })
        .collect();
    let good = |i: &usize| standings[*i].is_some_and(|s| s.as_good_as_best);
    // Ties go to the smaller error.
    let preferred = order.iter().copied().filter(good).min_by_key(|&i| parameters[i]).unwrap_or(best);
    Some(Ranking { best, preferred, order, standings })
}

/// Mean and its standard error, s/√F.
fn moments(x: &[f64]) -> (f64, f64) {
    let count = x.len() as f64;
    let mean = x.iter().sum::<f64>() / count;
    let square = x.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    (mean, if x.len() > 1 { (square / (count - 1.0) / count).sqrt() } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hand_computed_differences() {
        let errors = [Some(vec![1.0, 2.0, 3.0]), Some(vec![1.5, 2.0, 4.0])];
        let ranking = rank(&errors, &[5, 4]).unwrap();
        let other = ranking.standings[1].unwrap();
        // Differences 0.5, 0, 1: mean 0.5, s = 0.5, standard error 0.5/√3.
        assert_eq!((ranking.best, other.mean, other.difference), (0, 2.5, 0.5));
        assert!((other.difference_std_error - 0.5 / 3f64.sqrt()).abs() < 1e-15);
        assert!((ranking.standings[0].unwrap().std_error - 1.0 / 3f64.sqrt()).abs() < 1e-15);
        assert!(!other.as_good_as_best);
        assert_eq!(ranking.preferred, 0);
    }

    #[test]
    fn the_simplest_of_those_as_good_is_preferred() {
        // The second is better on one fold and worse on another; the third simpler still, but worse on every
        // fold.
        let errors = [Some(vec![1.0, 1.0, 1.0]), Some(vec![0.9, 1.2, 1.0]), Some(vec![1.5, 1.5, 1.6]), None];
        let ranking = rank(&errors, &[9, 6, 3, 1]).unwrap();
        assert_eq!((ranking.best, ranking.preferred), (0, 1));
        assert_eq!(ranking.order, [0, 1, 2]);
        assert_eq!(ranking.standings[3], None);
    }

    #[test]
    fn equals_are_settled_by_their_parameters_and_nothing_is_no_ranking() {
        let errors = [Some(vec![1.0, 2.0]), Some(vec![1.0, 2.0])];
        let ranking = rank(&errors, &[7, 6]).unwrap();
        assert_eq!((ranking.best, ranking.preferred), (1, 1));
        assert_eq!(rank(&[None, None], &[1, 2]), None);
    }
}
