//! Bounded linear least squares: the subproblem of one Levenberg–Marquardt step.

use nalgebra::{DMatrix, DVector};

/// Multipliers within this fraction of ‖aⱼ‖ ‖b − A p‖ count as zero.
const MULTIPLIER_TOLERANCE: f64 = 1e-13;

/// Minimiser of ‖A p − b‖ over low ≤ p ≤ high, for A of full column rank and a box that contains 0.
///
/// Primal active set from p = 0, with bounds at 0 fixed that the descent there points beyond (Stark and
/// Parker 1995, "Bounded-variable least-squares", Computational Statistics 10, 129–141): solve for the free
/// variables, move towards that solution until a bound blocks, fix the blocking variable; where none blocks,
/// release the bound with the largest multiplier of wrong sign. Every pass reduces ‖A p − b‖ or fixes a
/// variable, so the result is no worse than p = 0 and inside the box.
pub(super) fn solve(a: &DMatrix<f64>, b: &DVector<f64>, low: &[f64], high: &[f64]) -> DVector<f64> {
    let n = a.ncols();
    let norms: Vec<f64> = a.column_iter().map(|column| column.norm()).collect();
    let mut p = DVector::zeros(n);
    let descent = a.tr_mul(b);
    let blocked = |j: usize| match descent[j] {
        descent if low[j] == 0.0 && descent <= 0.0 => Some(Bound::Low),
        descent if high[j] == 0.0 && descent >= 0.0 => Some(Bound::High),
        _ => None,
    };
    let mut fixed: Vec<Option<Bound>> = (0..n).map(blocked).collect();
    for _ in 0..10 * n + 20 {
        let free: Vec<usize> = (0..n).filter(|&j| fixed[j].is_none()).collect();
        if let Some(wanted) = solve_free(a, b, &p, &free) {
            let mut share = 1.0;
            let mut blocking = None;
            for (&j, &z) in free.iter().zip(wanted.iter()) {
                let (limit, bound) = if z < low[j] { (low[j], Bound::Low) } else { (high[j], Bound::High) };
                if (z < low[j] || z > high[j]) && (limit - p[j]) / (z - p[j]) < share {
                    share = (limit - p[j]) / (z - p[j]);
                    blocking = Some((j, bound, limit));
                }
            }
            for (&j, &z) in free.iter().zip(wanted.iter()) {
                p[j] = (p[j] + share * (z - p[j])).clamp(low[j], high[j]);
            }
            if let Some((j, bound, limit)) = blocking {
                p[j] = limit;
                fixed[j] = Some(bound);
                continue;
            }
        }
        let rest = b - a * &p;
        let descent = a.tr_mul(&rest);
        let tolerance = MULTIPLIER_TOLERANCE * rest.norm();
        let wrong = |j: usize| match fixed[j] {
            Some(Bound::Low) => descent[j] / norms[j],
            Some(Bound::High) => -descent[j] / norms[j],
            None => 0.0,
        };
        match (0..n).filter(|&j| wrong(j) > tolerance).max_by(|&i, &j| wrong(i).total_cmp(&wrong(j))) {
            Some(j) => fixed[j] = None,
            None => break,
        }
    }
    p
}

#[derive(Clone, Copy)]
enum Bound {
    Low,
    High,
}

/// Solution for the free variables with the others held, by QR; `None` where none is free or A lacks rank.
fn solve_free(a: &DMatrix<f64>, b: &DVector<f64>, p: &DVector<f64>, free: &[usize]) -> Option<DVector<f64>> {
    if free.is_empty() {
        return None;
    }
    let mut held = p.clone();
    free.iter().for_each(|&j| held[j] = 0.0);
    let mut right = b - a * held;
    let qr = a.select_columns(free).qr();
    qr.q_tr_mul(&mut right);
    let solution = qr.r().solve_upper_triangular(&right.rows(0, free.len()).into_owned())?;
    solution.iter().all(|z| z.is_finite()).then_some(solution)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn minimum_with_one_active_bound_is_the_one_computed_by_hand() {
        // ‖A p − b‖² = (p₁ − 1)² + (p₁ + p₂ − 3)², p₂ ≤ 1: free minimum (1, 2); on p₂ = 1, p₁ = 3/2.
        let a = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 1.0, 1.0]);
        let b = DVector::from_column_slice(&[1.0, 3.0]);
        let p = solve(&a, &b, &[-9.0, -9.0], &[9.0, 9.0]);
        assert!((p[0] - 1.0).abs() < 1e-14 && (p[1] - 2.0).abs() < 1e-14);
        let p = solve(&a, &b, &[-9.0, -9.0], &[9.0, 1.0]);
        assert!((p[0] - 1.5).abs() < 1e-14 && p[1] == 1.0);
    }

    /// Oracle: the best of the minima over all 3ⁿ choices of free, lower and upper that lie in the box.
    fn by_enumeration(a: &DMatrix<f64>, b: &DVector<f64>, low: &[f64], high: &[f64]) -> f64 {
        let n = a.ncols();
        let mut best = f64::INFINITY;
        for code in 0..3_usize.pow(n as u32) {
            let sides: Vec<usize> = (0..n).map(|j| code / 3_usize.pow(j as u32) % 3).collect();
            let mut p = DVector::from_fn(n, |j, _| [0.0, low[j], high[j]][sides[j]]);
            let free: Vec<usize> = (0..n).filter(|&j| sides[j] == 0).collect();
            if let Some(z) = solve_free(a, b, &p, &free) {
                free.iter().zip(z.iter()).for_each(|(&j, &z)| p[j] = z);
            }
            if (0..n).all(|j| low[j] - 1e-12 <= p[j] && p[j] <= high[j] + 1e-12) {
                best = best.min((b - a * p).norm());
            }
        }
        best
    }

    proptest! {
        #[test]
        fn minimum_is_the_best_of_all_active_sets(
            entries in prop::collection::vec(-1.0..1.0_f64, 12),
            right in prop::collection::vec(-2.0..2.0_f64, 4),
            low in prop::collection::vec(prop_oneof![-1.0..=0.0_f64, Just(0.0)], 3),
            high in prop::collection::vec(prop_oneof![0.0..=1.0_f64, Just(0.0), Just(1e9)], 3),
        ) {
            let a = DMatrix::from_column_slice(4, 3, &entries);
            prop_assume!(a.clone().svd(false, false).singular_values.min() > 1e-3);
            let b = DVector::from_column_slice(&right);
            let p = solve(&a, &b, &low, &high);
            prop_assert!((0..3).all(|j| low[j] <= p[j] && p[j] <= high[j]));
            let norm = (&b - &a * p).norm();
            let oracle = by_enumeration(&a, &b, &low, &high);
            prop_assert!(norm <= oracle + 1e-11, "{norm} {oracle}");
        }
    }
}
