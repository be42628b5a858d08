//! Covariance of an estimate under coloured residuals.

use nalgebra::DMatrix;

use super::gauss_newton::Linearisation;
use crate::joint::coloured_square;
use crate::uncertainty::correlation_time;

/// Covariance of the first `count` unknowns of a least-squares estimate, and the effective number of
/// independent samples of its residual. `segments`: samples of each record, one after the other; `white`: the
/// residual is white by a noise model.
pub(super) fn covariance(
    segments: &[usize],
    at: &Linearisation,
    count: usize,
    white: bool,
) -> (Option<DMatrix<f64>>, f64) {
    let normal = at.jacobian.tr_mul(&at.jacobian);
    let residual = at.residual.as_slice();
    let valid = residual.iter().filter(|e| **e != 0.0).count();
    let variance = at.residual.norm_squared() / valid.saturating_sub(normal.ncols()).max(1) as f64;
    let covariance = if white {
        inverse(&normal).map(|inverse| inverse * variance)
    } else {
        sandwich(segments, &at.jacobian, normal, residual)
    };
    let covariance = covariance.map(|c| c.view((0, 0), (count, count)).into_owned());
    (covariance, independent_samples(segments, residual))
}

/// M⁻¹ of a Gram matrix, its columns scaled to unit length.
fn inverse(m: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale: Vec<f64> = m.diagonal().iter().map(|d| d.sqrt()).collect();
    let scaled = m.map_with_location(|i, j, x| x / (scale[i] * scale[j]));
    let inverse = scaled.try_inverse()?.map_with_location(|i, j, x| x / (scale[i] * scale[j]));
    inverse.iter().all(|x| x.is_finite()).then_some(inverse)
}

pub(super) fn independent_samples(segments: &[usize], residual: &[f64]) -> f64 {
    let mut first = 0;
    let mut independent = 0.0;
    for &samples in segments {
        let own = &residual[first..first + samples];
        let valid = own.iter().filter(|e| **e != 0.0).count();
        independent += valid as f64 / correlation_time(own);
        first += samples;
    }
    independent.max(2.0)
}

/// M⁻¹ (Σ_records Σ_k ρ_k Σ_t z_t z_{t+k}ᵀ) M⁻ᵀ for an estimate with M δ = Σ z e, ρ the autocovariance of the
/// residual; `None` where M is singular. Rows of excluded samples are 0.
pub(super) fn sandwich(
    segments: &[usize],
    instruments: &DMatrix<f64>,
    m: DMatrix<f64>,
    residual: &[f64],
) -> Option<DMatrix<f64>> {
    let count = m.ncols();
    let scale: Vec<f64> = instruments.column_iter().map(|c| c.norm()).collect();
    if scale.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
        return None;
    }
    let scaled = |m: &DMatrix<f64>| m.map_with_location(|i, j, x| x / (scale[i] * scale[j]));
    let inverse = scaled(&m).try_inverse()?;
    let mut middle = DMatrix::zeros(count, count);
    let mut first = 0;
    for &samples in segments {
        let columns: Vec<&[f64]> = (0..count)
            .map(|j| &instruments.as_slice()[j * instruments.nrows() + first..][..samples])
            .collect();
        middle += coloured_square(&columns, &residual[first..first + samples]);
        first += samples;
    }
    let covariance = &inverse * scaled(&middle) * inverse.transpose();
    let covariance = covariance.map_with_location(|i, j, x| x / (scale[i] * scale[j]));
    covariance.iter().all(|c| c.is_finite()).then_some(covariance)
}
