//! Rate of a sampled displacement.

use super::ForceModelError;
use crate::record::TimeBase;

/// Rate of the displacement `x` at every sample: the slope of the straight line through the samples within
/// half of `window_s` to either side, at least one to each side, by least squares. On a uniform grid this is
/// the derivative of the filter of Savitzky and Golay of second degree (doi:10.1021/ac60214a047); of three
/// samples the central difference. At the ends of the record one side is shorter.
///
/// # Errors
/// [`ForceModelError::NoTimes`].
pub fn rate_of(x: &[f64], time: &TimeBase, window_s: f64) -> Result<Vec<f64>, ForceModelError> {
    let times: Vec<f64> =
        (0..x.len()).map(|k| time.time_s(k)).collect::<Option<_>>().ok_or(ForceModelError::NoTimes)?;
    // Rounding of the time stamps must not change the number of samples.
    let half_s = 0.5 * window_s * (1.0 + 1e-6);
    let last = x.len().saturating_sub(1);
    let slope = |k: usize| {
        let mut first = k.saturating_sub(1);
        while first > 0 && times[k] - times[first - 1] <= half_s {
            first -= 1;
        }
        let mut end = (k + 1).min(last);
        while end < last && times[end + 1] - times[k] <= half_s {
            end += 1;
        }
        let count = (end - first + 1) as f64;
        let mean_t = times[first..=end].iter().sum::<f64>() / count;
        let mean_x = x[first..=end].iter().sum::<f64>() / count;
        let (mut product, mut square) = (0.0, 0.0);
        for (t, x) in times[first..=end].iter().zip(&x[first..=end]) {
            product += (t - mean_t) * (x - mean_x);
            square += (t - mean_t).powi(2);
        }
        // Loggers with a coarse clock write equal stamps.
        if square > 0.0 { product / square } else { 0.0 }
    };
    Ok((0..x.len()).map(slope).collect())
}
