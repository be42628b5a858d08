//! Fractional derivatives and integrals of sampled data.

use super::{Scheme, weights};
use crate::dynamics_error::{DynamicsError, check_result, check_sample_rate};
use hysteron_numeric::convolution::causal_convolution;

/// Dᵅ of samples taken at `sample_rate_hz`, any real α (negative: integral of order −α), in O(N log N).
///
/// (Dᵅ f)_k = h^−α Σ_{j≤k} w_j f_{k−j} with the [`weights`] of the scheme: the Riemann–Liouville operator
/// with its lower end at the first sample (f = 0 before). Unit: that of the samples times s^−α. First order
/// in h for `GrunwaldLetnikov`; second for `Bdf2` where f and f′ start at zero. Agrees with
/// [`differintegral_direct`] within 1e-12 of the largest value.
///
/// # Errors
/// [`DynamicsError::OperatorOrder`], [`DynamicsError::SampleRate`]; [`DynamicsError::ImproperOperator`] for
/// `Tustin` with α > 0, which diverges; [`DynamicsError::NoWeights`] for `BandLimited`;
/// [`DynamicsError::ResultNotFinite`].
///
/// ```
/// # use hysteron_model::fractional::{differintegral, Scheme};
/// // D^½ √x = Γ(3/2), whatever x is.
/// let root: Vec<f64> = (0..=1000).map(|k| (k as f64 / 1000.0).sqrt()).collect();
/// let d = differintegral(0.5, &root, 1000.0, Scheme::GrunwaldLetnikov)?;
/// assert!((d[1000] - 0.886226925).abs() < 1e-5);
/// # Ok::<(), hysteron_model::dynamics::DynamicsError>(())
/// ```
pub fn differintegral(
    alpha: f64,
    samples: &[f64],
    sample_rate_hz: f64,
    scheme: Scheme,
) -> Result<Vec<f64>, DynamicsError> {
    let kernel = kernel(alpha, samples.len(), sample_rate_hz, scheme)?;
    check_result(causal_convolution(&kernel, samples))
}

/// [`differintegral`] by the direct sum, O(N²): the oracle.
///
/// # Errors
/// Those of [`differintegral`].
pub fn differintegral_direct(
    alpha: f64,
    samples: &[f64],
    sample_rate_hz: f64,
    scheme: Scheme,
) -> Result<Vec<f64>, DynamicsError> {
    let kernel = kernel(alpha, samples.len(), sample_rate_hz, scheme)?;
    let sum = |k: usize| kernel.iter().zip(samples[..=k].iter().rev()).map(|(w, f)| w * f).sum();
    check_result((0..samples.len()).map(sum).collect())
}

fn kernel(alpha: f64, count: usize, sample_rate_hz: f64, scheme: Scheme) -> Result<Vec<f64>, DynamicsError> {
    check_sample_rate(sample_rate_hz)?;
    let mut kernel = weights(scheme, alpha, count)?;
    if scheme == Scheme::Tustin && alpha > 0.0 {
        return Err(DynamicsError::ImproperOperator { numerator: alpha, denominator: 0.0 });
    }
    let scale = sample_rate_hz.powf(alpha);
    kernel.iter_mut().for_each(|w| *w *= scale);
    Ok(kernel)
}
