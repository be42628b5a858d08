//! Inner product, projections and root mean square of long columns.
//!
//! Sums are interleaved in a fixed order, so that every instruction set gives the same bits.

use super::InstructionSet;
use super::dispatch::{inner_product, project_out_four, subtract_multiple};

/// Σ aᵢ bᵢ in eight interleaved sums.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    inner_product(InstructionSet::detected(), a, b)
}

/// x ← x − `factor` · `column`.
pub fn subtract(x: &mut [f64], factor: f64, column: &[f64]) {
    subtract_multiple(InstructionSet::detected(), x, factor, column);
}

/// Projects the span of `orthonormal` columns, stored one after the other, out of `x`.
pub fn project_out(orthonormal: &[f64], x: &mut [f64]) {
    // Four at a time, which takes less than half of the memory traffic; among them the order does not
    // matter.
    let rows = x.len().max(1);
    let set = InstructionSet::detected();
    let fours = orthonormal.chunks_exact(4 * rows);
    let rest = fours.remainder();
    for four in fours {
        project_out_four(set, four, x);
    }
    for column in rest.chunks_exact(rows) {
        let share = inner_product(set, column, x);
        subtract_multiple(set, x, share, column);
    }
}

#[inline(always)]
pub(super) fn inner_product_kernel(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a8.remainder().iter().zip(b8.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a8.zip(b8) {
        for i in 0..8 {
            sums[i] += x[i] * y[i];
        }
    }
    sums.iter().sum::<f64>() + rest
}

#[inline(always)]
pub(super) fn subtract_multiple_kernel(x: &mut [f64], factor: f64, column: &[f64]) {
    for (x, column) in x.iter_mut().zip(column) {
        *x -= factor * column;
    }
}

/// Projects four orthonormal columns, stored one after the other in `q`, out of `x`.
#[inline(always)]
pub(super) fn project_out_four_kernel(q: &[f64], x: &mut [f64]) {
    let rows = x.len();
    let (ab, cd) = q.split_at(2 * rows);
    let ((a, b), (c, d)) = (ab.split_at(rows), cd.split_at(rows));
    let mut sums = [[0.0; 4]; 4];
    let whole = rows / 4 * 4;
    for k in (0..whole).step_by(4) {
        let x = &x[k..k + 4];
        for (sums, q) in sums.iter_mut().zip([&a[k..k + 4], &b[k..k + 4], &c[k..k + 4], &d[k..k + 4]]) {
            for i in 0..4 {
                sums[i] += q[i] * x[i];
            }
        }
    }
    let mut shares = sums.map(|sums| sums.iter().sum::<f64>());
    for (share, q) in shares.iter_mut().zip([a, b, c, d]) {
        *share += inner_product_kernel(&q[whole..], &x[whole..]);
    }
    for ((((x, a), b), c), d) in x.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        *x -= (shares[0] * a + shares[1] * b) + (shares[2] * c + shares[3] * d);
    }
}

/// √(Σ rᵢ² / N), the cost of a residual vector (article Eq. 7); +∞ if any residual is not finite or there is
/// none.
pub fn root_mean_square(residuals: &[f64]) -> f64 {
    // Eight interleaved sums are independent; the order of summation is fixed.
    let mut sums = [0.0; 8];
    let eights = residuals.chunks_exact(8);
    let rest: f64 = eights.remainder().iter().map(|r| r * r).sum();
    for eight in eights {
        for (sum, r) in sums.iter_mut().zip(eight) {
            *sum += r * r;
        }
    }
    let cost = ((sums.iter().sum::<f64>() + rest) / residuals.len() as f64).sqrt();
    if cost.is_finite() { cost } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dispatch::reflect;

    fn wave(rows: usize, columns: usize) -> Vec<f64> {
        (0..rows * columns).map(|k| (k as f64 * 0.37).sin() + 0.1 * (k % 7) as f64).collect()
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        // The second length leaves a remainder after the widest vectors.
        for rows in [3, 1013] {
            let columns = wave(rows, 5);
            let run = |set| {
                let (mut q, mut x) = (columns[..4 * rows].to_vec(), columns[4 * rows..].to_vec());
                let mut factor = [0.0; 16];
                let product = inner_product(set, &q, &columns);
                project_out_four(set, &q, &mut x);
                subtract_multiple(set, &mut x, 0.3, &q);
                reflect(set, &mut q, rows, &mut factor);
                let all = x.iter().chain(&q).chain(&factor).chain([&product]);
                all.map(|x| x.to_bits()).collect::<Vec<_>>()
            };
            for set in InstructionSet::available() {
                assert_eq!(run(set), run(InstructionSet::baseline()), "{set:?}");
            }
        }
    }

    #[test]
    fn sums_are_those_of_one_term_after_the_other() {
        for rows in [0, 1, 7, 8, 100] {
            let (a, b) = (wave(rows, 1), wave(rows + 3, 1));
            let slow: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
            assert!((dot(&a, &b[..rows]) - slow).abs() < 1e-13 * rows.max(1) as f64);
        }
    }
}
