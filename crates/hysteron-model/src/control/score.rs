//! Tracking score of a displacement against its reference.

/// The error of a displacement against its reference, its mean removed: a sensor's zero is arbitrary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackingScore {
    /// Root mean square \[µm\].
    pub rms: f64,
    /// Largest magnitude \[µm\].
    pub max: f64,
    /// The mean removed \[µm\].
    pub mean: f64,
    /// Rms in per cent of the reference's stroke.
    pub rms_percent: f64,
    /// The largest magnitude in per cent of the stroke.
    pub max_percent: f64,
}

impl TrackingScore {
    /// Score from sample `from` on; NaN where no samples remain, the percentages infinite or NaN for a
    /// constant reference.
    pub fn of(displacement: &[f64], reference: &[f64], from: usize) -> Self {
        let errors = || reference.iter().zip(displacement).skip(from).map(|(r, y)| r - y);
        let count = errors().count() as f64;
        let mean = errors().sum::<f64>() / count;
        let rms = (errors().map(|e| (e - mean).powi(2)).sum::<f64>() / count).sqrt();
        let max = errors().map(|e| (e - mean).abs()).fold(if count > 0.0 { 0.0 } else { f64::NAN }, f64::max);
        let ends = reference.iter().skip(from);
        let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| (l.min(*r), h.max(*r)));
        let percent = 100.0 / (high - low);
        Self { rms, max, mean, rms_percent: percent * rms, max_percent: percent * max }
    }
}
