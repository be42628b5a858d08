//! Convolution quadrature weights of any operator.

use super::Scheme;
use crate::dynamics_error::{DynamicsError, check_result, check_sample_rate};
use hysteron_numeric::Complex64;
use hysteron_numeric::fft::{RealFft, fast_length};

/// r^L: the geometric mean of the aliasing error r^L and the rounding error ε·r^−N at L = 2N.
const ALIASING: f64 = 1e-10;

/// First `count` weights ω_j of Σ ω_j z^j = K(δ(z)/h), so that (K u)_k ≈ Σ_j ω_j u_{k−j}.
///
/// `operator` is K(s), real on the positive real axis and analytic in the right half-plane; it is evaluated
/// at s = δ(z)/h on |z| = r < 1 (Lubich 1988, doi:10.1007/BF01398686). ω_j carries an error of about 1e-10 of
/// the largest |K| on the circle times the sample's own r^−j ≤ 1e5 in rounding.
///
/// # Errors
/// [`DynamicsError::SampleRate`], [`DynamicsError::ResultNotFinite`] where K is not finite on the circle.
pub fn convolution_weights(
    operator: impl Fn(Complex64) -> Complex64,
    count: usize,
    sample_rate_hz: f64,
    scheme: Scheme,
) -> Result<Vec<f64>, DynamicsError> {
    check_sample_rate(sample_rate_hz)?;
    let length = fast_length(2 * count);
    let damping = -ALIASING.ln() / length as f64;
    let fft = RealFft::new(length);
    let mut spectrum: Vec<Complex64> = (0..=length / 2)
        .map(|bin| {
            let angle = if 2 * bin == length {
                std::f64::consts::PI
            } else {
                std::f64::consts::TAU * bin as f64 / length as f64
            };
            let (log_abs, arg) = scheme.log_delta(damping, angle);
            operator(Complex64::from_polar(log_abs.exp() * sample_rate_hz, arg))
        })
        .collect();
    // The first and last bins of a real sequence are real.
    spectrum[0].im = 0.0;
    spectrum[length / 2].im = 0.0;
    let mut series = vec![0.0; length];
    // This cannot fail: lengths are right by construction, and the two bins above are real.
    fft.invert(&mut spectrum, &mut series);
    series.truncate(count);
    for (j, w) in series.iter_mut().enumerate() {
        *w *= (damping * j as f64).exp() / length as f64;
    }
    check_result(series)
}
