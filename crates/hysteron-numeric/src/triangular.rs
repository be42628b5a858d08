//! The triangular factor of a tall matrix.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::InstructionSet;
use super::dispatch::reflect;
use super::inner_product::{inner_product_kernel, subtract_multiple_kernel};

/// Rows per reduction, small enough to stay in the cache.
const BLOCK: usize = 256;
/// Rows per task of a thread.
const SHARE: usize = 16 * BLOCK;

/// R of the QR factorisation of `columns`, all of one length.
///
/// Householder reflections over blocks of rows, the factor of the blocks before on top of each; then of the
/// factors of all shares (Demmel, Grigori, Hoemmen and Langou 2012, doi:10.1137/080731992). The grouping of
/// rows does not depend on the threads.
pub fn triangular(columns: &[&[f64]]) -> DMatrix<f64> {
    let width = columns.len();
    let rows = columns.first().map_or(0, |column| column.len());
    if width == 0 {
        return DMatrix::zeros(0, 0);
    }
    let set = InstructionSet::detected();
    let mut factors = vec![0.0; rows.div_ceil(SHARE) * width * width];
    factors.par_chunks_exact_mut(width * width).enumerate().for_each(|(share, factor)| {
        let mut work = vec![0.0; (width + BLOCK) * width];
        let end = rows.min((share + 1) * SHARE);
        for first in (share * SHARE..end).step_by(BLOCK) {
            let count = BLOCK.min(end - first);
            let height = width + count;
            let work = &mut work[..height * width];
            for (j, (own, column)) in work.chunks_exact_mut(height).zip(columns).enumerate() {
                own[..width].copy_from_slice(&factor[j * width..(j + 1) * width]);
                own[width..].copy_from_slice(&column[first..first + count]);
            }
            reflect(set, work, height, factor);
        }
    });
    let mut factor = vec![0.0; width * width];
    let height = factors.len() / width;
    let mut stacked = vec![0.0; height * width];
    for (share, part) in factors.chunks_exact(width * width).enumerate() {
        for (j, own) in stacked.chunks_exact_mut(height.max(1)).enumerate() {
            own[share * width..(share + 1) * width].copy_from_slice(&part[j * width..(j + 1) * width]);
        }
    }
    reflect(set, &mut stacked, height, &mut factor);
    DMatrix::from_vec(width, width, factor)
}

/// Columns of smaller norm count as zero: their squares underflow.
const NOTHING: f64 = 1e-140;

/// Reflects the columns of `work`, `height` rows each, to an upper triangle, and writes that to `factor`.
#[inline(always)]
pub(super) fn reflect_kernel(work: &mut [f64], height: usize, factor: &mut [f64]) {
    let width = work.len() / height.max(1);
    factor.fill(0.0);
    for k in 0..width.min(height) {
        let (head, tail) = work.split_at_mut((k + 1) * height);
        let v = &mut head[k * height + k..];
        let norm = inner_product_kernel(v, v).sqrt();
        if norm < NOTHING {
            v.fill(0.0);
        } else {
            let diagonal = -norm.copysign(v[0]);
            v[0] -= diagonal;
            let scale = 2.0 / inner_product_kernel(v, v);
            for other in tail.chunks_exact_mut(height) {
                let share = scale * inner_product_kernel(v, &other[k..]);
                subtract_multiple_kernel(&mut other[k..], share, v);
            }
            v[0] = diagonal;
        }
        let own = &work[k * height..k * height + k + 1];
        factor[k * width..k * width + k + 1].copy_from_slice(own);
    }
    for k in height..width {
        factor[k * width..k * width + height].copy_from_slice(&work[k * height..(k + 1) * height]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(k: usize, j: usize) -> f64 {
        ((k * (2 * j + 3)) as f64 * 0.37).sin() + 0.1 * j as f64
    }

    /// RᵀR = JᵀJ, which determines an upper triangular R.
    #[test]
    fn is_the_factor_of_matrices_of_any_height() {
        for rows in [0, 1, 3, 6, 255, 256, 257, 5000] {
            let n = 7;
            let values: Vec<f64> = (0..n).flat_map(|j| (0..rows).map(move |k| wave(k, j))).collect();
            let columns: Vec<&[f64]> = (0..n).map(|j| &values[j * rows..(j + 1) * rows]).collect();
            let r = triangular(&columns);
            let j = DMatrix::from_column_slice(rows, n, &values);
            let size = rows.max(1) as f64;
            assert!((r.transpose() * &r - j.transpose() * &j).amax() < 1e-13 * size, "{rows}");
            assert!((0..n).all(|i| (0..i).all(|j| r[(i, j)] == 0.0)));
        }
    }

    #[test]
    fn a_column_without_effect_stays_without() {
        let values: Vec<f64> = (0..900).map(|k| if k < 300 { 0.0 } else { wave(k, 1) }).collect();
        let columns: Vec<&[f64]> = values.chunks_exact(300).collect();
        let r = triangular(&columns);
        assert_eq!(r.column(0).amax(), 0.0);
        assert!(r[(1, 1)].abs() > 1.0);
        assert_eq!(triangular(&[]).len(), 0);
    }

    /// The squares of such a column are denormal, and their reciprocal is infinite.
    #[test]
    fn a_column_too_short_to_square_leaves_the_others_alone() {
        for tiny in [1e-120, 1e-150, 1e-158, 1e-170, 1e-300] {
            let values: Vec<f64> =
                (0..600).map(|k| if k < 300 { tiny * wave(k, 0) } else { wave(k, 1) }).collect();
            let r = triangular(&values.chunks_exact(300).collect::<Vec<_>>());
            assert!(r.iter().all(|x| x.is_finite()), "{tiny:e}: {r}");
            let square: f64 = values[300..].iter().map(|x| x * x).sum();
            assert!((r.column(1).norm_squared() - square).abs() < 1e-12 * square, "{tiny:e}");
        }
    }
}
