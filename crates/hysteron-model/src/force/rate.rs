//! Rate of a sampled displacement.

use super::ForceModelError;
use crate::record::{InputOutput, Quantity, Record, TimeBase, Unit};

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

/// `data` with the rate of its input from the channel of this name or header of `record`, which it was
/// selected from, in the unit of the input per second.
///
/// # Errors
/// [`ForceModelError`]: no such channel, another unit, another number of samples.
pub fn with_rate(data: InputOutput, record: &Record, name: &str) -> Result<InputOutput, ForceModelError> {
    let channel = record.channel(name).ok_or_else(|| ForceModelError::NoRateChannel {
        name: name.to_owned(),
        available: record.channels.iter().map(|channel| channel.header()).collect::<Vec<_>>().join(", "),
    })?;
    let factor = channel.unit.symbol().split_once("_per_").and_then(|(length, time)| {
        let (length, time) = (Unit::new(length), Unit::new(time));
        let is_rate = length.base_unit() == data.u_unit && time.base().0 == Quantity::Time;
        is_rate.then(|| length.base().1 / time.base().1)
    });
    let factor = factor.ok_or_else(|| ForceModelError::RateUnit {
        channel: channel.name.clone(),
        found: if channel.unit.symbol().is_empty() { "no unit".to_owned() } else { channel.unit.to_string() },
        displacement: data.u_unit.symbol().to_owned(),
    })?;
    if channel.samples.len() != data.len() {
        return Err(ForceModelError::RateLength { expected: data.len(), found: channel.samples.len() });
    }
    let rate = channel.samples.iter().map(|v| v * factor).collect();
    Ok(InputOutput { rate: Some(rate), ..data })
}
