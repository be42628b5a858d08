//! Power series of δ(z)ᵅ.

use super::Scheme;
use crate::dynamics_error::DynamicsError;

/// Grünwald–Letnikov weights: w₀ = 1, w_j = w_{j−1}(1 − (α+1)/j), the series of (1 − z)ᵅ (article Eq. 3).
///
/// Real α of either sign; without the factor h^−α. Source: Podlubny, Fractional Differential Equations
/// (1999), §7.4.
pub fn grunwald_letnikov_weights(alpha: f64, count: usize) -> Vec<f64> {
    let mut weights = Vec::with_capacity(count);
    let mut w = 1.0;
    for j in 0..count {
        if j > 0 {
            w *= 1.0 - (alpha + 1.0) / j as f64;
        }
        weights.push(w);
    }
    weights
}

/// First `count` coefficients of the power series of δ(z)ᵅ, without the factor h^−α.
///
/// # Errors
/// [`DynamicsError::OperatorOrder`] for an order that is not finite, [`DynamicsError::NoWeights`] for
/// `BandLimited`.
pub fn weights(scheme: Scheme, alpha: f64, count: usize) -> Result<Vec<f64>, DynamicsError> {
    cleared_weights(scheme, alpha, 0.0, count)
}

/// [`weights`], for `Tustin` multiplied by (1 + z)^`cleared`: a quotient of two polynomials in δ cleared of
/// the singularity at z = −1 has kernels that decay, and its recursion does not amplify rounding there.
///
/// Three-term recurrences from the differential equation of the generating function:
/// (3 − 4z + z²) f′ = −α(4 − 2z) f for BDF2, and for Tustin, f = 2ᵅ (1 − z)^p (1 + z)^q with p = α and
/// q = cleared − α, (1 − z²) f′ = ((q − p) − (q + p) z) f.
pub(super) fn cleared_weights(
    scheme: Scheme,
    alpha: f64,
    cleared: f64,
    count: usize,
) -> Result<Vec<f64>, DynamicsError> {
    if !alpha.is_finite() {
        return Err(DynamicsError::OperatorOrder { order: alpha });
    }
    let recurrence = |first: f64, step: &dyn Fn(f64, f64, f64) -> f64| {
        let mut series = Vec::with_capacity(count);
        let (mut f, mut before) = (first, 0.0);
        for k in 0..count {
            series.push(f);
            (f, before) = (step(k as f64, f, before), f);
        }
        series
    };
    match scheme {
        Scheme::BandLimited => Err(DynamicsError::NoWeights { scheme }),
        Scheme::GrunwaldLetnikov => Ok(grunwald_letnikov_weights(alpha, count)),
        Scheme::Bdf2 => Ok(recurrence(1.5f64.powf(alpha), &|k, f, before| {
            (4.0 * (k - alpha) * f - (k - 1.0 - 2.0 * alpha) * before) / (3.0 * (k + 1.0))
        })),
        Scheme::Tustin => Ok(recurrence(2f64.powf(alpha), &|k, f, before| {
            ((cleared - 2.0 * alpha) * f + (k - 1.0 - cleared) * before) / (k + 1.0)
        })),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_small_orders_are_the_known_ones() {
        assert_eq!(grunwald_letnikov_weights(1.0, 4), [1.0, -1.0, 0.0, 0.0]);
        assert_eq!(grunwald_letnikov_weights(-1.0, 4), [1.0; 4]);
        assert_eq!(grunwald_letnikov_weights(0.5, 4), [1.0, -0.5, -0.125, -0.0625]);
        assert_eq!(weights(Scheme::Bdf2, 1.0, 4), Ok(vec![1.5, -2.0, 0.5, 0.0]));
        assert_eq!(weights(Scheme::Tustin, 1.0, 5), Ok(vec![2.0, -4.0, 4.0, -4.0, 4.0]));
        for scheme in [Scheme::Bdf2, Scheme::Tustin, Scheme::GrunwaldLetnikov] {
            assert_eq!(weights(scheme, 0.0, 3), Ok(vec![1.0, 0.0, 0.0]));
        }
    }

    #[test]
    fn squaring_the_series_of_a_half_gives_the_series_of_one() {
        for scheme in [Scheme::Bdf2, Scheme::Tustin, Scheme::GrunwaldLetnikov] {
            let half = weights(scheme, 0.5, 50).unwrap();
            let one = weights(scheme, 1.0, 50).unwrap();
            for k in 0..50 {
                let square: f64 = (0..=k).map(|j| half[j] * half[k - j]).sum();
                assert!((square - one[k]).abs() < 1e-13, "{scheme} {k}");
            }
        }
    }
}
