//! Factorised covariance P = U diag(d) Uᵀ with U unit upper triangular, and its update by one scalar
//! measurement.
//!
//! The factors are updated, never P: P stays symmetric and positive definite whatever the rounding, to the
//! accuracy of a computation with twice the digits on P itself, without square roots (G. J. Bierman,
//! *Factorization Methods for Discrete Sequential Estimation*, Academic Press 1977, ch. V).

use super::dot;
use crate::real::Real;

/// P = U diag(d) Uᵀ. Of U what is above the diagonal is used; `upper[j][i]` is its row i of column j.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Covariance<T, const N: usize> {
    upper: [[T; N]; N],
    diagonal: [T; N],
}

/// Result of a measurement update.
#[derive(Clone, Copy)]
pub(super) struct Update<T, const N: usize> {
    pub(super) covariance: Covariance<T, N>,
    /// P φ / (r + φᵀPφ).
    pub(super) gain: [T; N],
    /// r + φᵀPφ.
    pub(super) variance: T,
}

impl<T: Real, const N: usize> Covariance<T, N> {
    /// diag(σ²).
    pub(super) fn independent(deviations: &[T; N]) -> Self {
        let mut upper = [[T::of(0.0); N]; N];
        for (j, column) in upper.iter_mut().enumerate() {
            for (i, entry) in column.iter_mut().enumerate() {
                if i == j {
                    *entry = T::of(1.0);
                }
            }
        }
        Self { upper, diagonal: deviations.map(|deviation| deviation * deviation) }
    }

    /// P⁺ = (P − P φ φᵀ P / (r + φᵀPφ)) / λ for a measurement of φᵀθ with the variance r > 0.
    #[inline]
    pub(super) fn update(&self, regressors: &[T; N], r: T, forgetting: T) -> Update<T, N> {
        let zero = T::of(0.0);
        let (mut covariance, mut gain, mut variance) = (*self, [zero; N], r);
        for (j, (column, d)) in covariance.upper.iter_mut().zip(&mut covariance.diagonal).enumerate() {
            let mut f = zero;
            for (&u, &regressor) in column.iter().zip(regressors).take(j + 1) {
                f = f + u * regressor;
            }
            let v = *d * f;
            let next = variance + f * v;
            let p = -(f / variance);
            *d = *d * (variance / next) / forgetting;
            for (u, b) in column.iter_mut().zip(&mut gain).take(j) {
                let old = *u;
                *u = old + *b * p;
                *b = *b + old * v;
            }
            if let Some(b) = gain.get_mut(j) {
                *b = v;
            }
            variance = next;
        }
        Update { covariance, gain: gain.map(|b| b / variance), variance }
    }

    /// Column `at` of P.
    #[inline]
    pub(super) fn column(&self, at: usize) -> [T; N] {
        let mut out = [T::of(0.0); N];
        for (j, (column, &d)) in self.upper.iter().zip(&self.diagonal).enumerate() {
            let Some(&own) = column.get(at).filter(|_| j >= at) else { continue };
            for (out, &u) in out.iter_mut().zip(column).take(j + 1) {
                *out = *out + u * d * own;
            }
        }
        out
    }

    /// φᵀ P φ.
    pub(super) fn variance_of(&self, regressors: &[T; N]) -> T {
        let mut sum = T::of(0.0);
        for (column, &d) in self.upper.iter().zip(&self.diagonal) {
            // Below the diagonal the stored entries are 0.
            let f = dot(column, regressors);
            sum = sum + d * f * f;
        }
        sum
    }

    pub(super) fn is_finite(&self) -> bool {
        super::all_finite(&self.diagonal) && self.upper.iter().all(|column| super::all_finite(column))
    }
}
