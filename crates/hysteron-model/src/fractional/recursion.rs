//! The article's simulator, Eq. 4: an implicit recursion over the whole past.

use super::weights::cleared_weights;
use super::{Scheme, Term};
use crate::dynamics_error::{DynamicsError, check_result, check_sample_rate};

/// Response of Σ numerator / Σ denominator to `input`, zero before the first sample, by the O(N²) recursion
/// (article Eq. 4):
///
/// x_k = (Σ_j n_j u_{k−j} − Σ_{j≥1} d_j x_{k−j}) / d₀, d_j = Σ_i a_i h^−α_i w_j^(α_i), n_j likewise from b,
/// β.
///
/// Any number of terms, any scheme that has weights, stable or not. The oracle of the fast simulators. Under
/// `Tustin` both series are first multiplied by (1 + z)^α_n: with whole orders this is the usual difference
/// equation, and without it rounding at z = −1 grows as k^α_n.
///
/// # Errors
/// See [`DynamicsError`]: terms, orders, sample rate, scheme, an improper operator under `Tustin`, a result
/// that is not finite.
pub fn simulate_recursion(
    numerator: &[Term],
    denominator: &[Term],
    input: &[f64],
    sample_rate_hz: f64,
    scheme: Scheme,
) -> Result<Vec<f64>, DynamicsError> {
    let (n, d) = kernels(numerator, denominator, input.len(), sample_rate_hz, scheme)?;
    let past = |kernel: &[f64], signal: &[f64]| -> f64 {
        kernel.iter().zip(signal.iter().rev()).map(|(w, x)| w * x).sum()
    };
    let mut output = Vec::with_capacity(input.len());
    for k in 0..input.len() {
        let forcing = past(&n, &input[..=k]);
        output.push((forcing - past(&d[1..], &output)) / d[0]);
    }
    check_result(output)
}

/// The merged series (n, d) of numerator and denominator; n is cut after its last non-zero weight, d has at
/// least one.
pub(super) fn kernels(
    numerator: &[Term],
    denominator: &[Term],
    count: usize,
    sample_rate_hz: f64,
    scheme: Scheme,
) -> Result<(Vec<f64>, Vec<f64>), DynamicsError> {
    check_sample_rate(sample_rate_hz)?;
    let highest = |part: &'static str, terms: &[Term]| {
        let orders = terms.iter().filter(|term| term.coefficient != 0.0).map(|term| term.order);
        orders.reduce(f64::max).ok_or(DynamicsError::NoOperatorTerms { part })
    };
    let orders = (highest("numerator", numerator)?, highest("denominator", denominator)?);
    if scheme == Scheme::Tustin && orders.0 > orders.1 {
        return Err(DynamicsError::ImproperOperator { numerator: orders.0, denominator: orders.1 });
    }
    let merged = |terms: &[Term]| -> Result<Vec<f64>, DynamicsError> {
        let mut sum = vec![0.0; count.max(1)];
        for term in terms {
            let scale = term.coefficient * sample_rate_hz.powf(term.order);
            for (sum, w) in sum.iter_mut().zip(cleared_weights(scheme, term.order, orders.1, count.max(1))?) {
                *sum += scale * w;
            }
        }
        Ok(sum)
    };
    let mut n = merged(numerator)?;
    n.truncate(n.iter().rposition(|w| *w != 0.0).map_or(1, |last| last + 1));
    Ok((n, merged(denominator)?))
}
