//! Kinds of the drive of a record.

use realfft::RealFftPlanner;

use super::periods::active_range;
use super::turning_points::{range_of, turning_points};

/// Kind of drive. Frequencies in cycles per sample: times the sample rate they are Hz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExcitationKind {
    /// The drive never changes.
    Constant,
    /// Held values with jumps between them.
    Steps {
        /// Different values held.
        levels: usize,
    },
    /// A few slow strokes that do not repeat: ramps, one loop, reversal curves.
    Ramps {
        /// Reversals of more than 2 % of the range.
        reversals: usize,
    },
    /// One frequency, of constant or changing amplitude.
    Wave {
        /// Frequency, per sample.
        frequency: f64,
        /// Its shape.
        shape: WaveShape,
        /// Distinct heights of turning points: 2 for a constant amplitude, more for nested loops.
        turning_levels: usize,
    },
    /// One frequency at a time, running from one to another.
    Sweep {
        /// First frequency, per sample.
        from: f64,
        /// Last frequency, per sample.
        to: f64,
    },
    /// Many frequencies at once: multisine, band-limited random, or a signal to be tracked.
    Broadband {
        /// Frequency below which 1 % of the power lies, per sample.
        from: f64,
        /// Frequency below which 99 % of the power lies, per sample.
        to: f64,
    },
}

/// Shape of a [`ExcitationKind::Wave`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WaveShape {
    /// Rms over amplitude near 1/√2.
    Sine,
    /// Rms over amplitude near 1/√3.
    Triangle,
    /// Neither.
    Other,
}

impl ExcitationKind {
    /// `constant`, `steps`, `ramps`, `sine`, `triangle`, `wave`, `sweep` or `broadband`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Steps { .. } => "steps",
            Self::Ramps { .. } => "ramps",
            Self::Wave { shape: WaveShape::Sine, .. } => "sine",
            Self::Wave { shape: WaveShape::Triangle, .. } => "triangle",
            Self::Wave { shape: WaveShape::Other, .. } => "wave",
            Self::Sweep { .. } => "sweep",
            Self::Broadband { .. } => "broadband",
        }
    }

    /// Lowest and highest frequency \[per sample\], the same for one frequency; `None` where it has none
    /// (ramps, steps).
    pub fn span(&self) -> Option<(f64, f64)> {
        match *self {
            Self::Wave { frequency, .. } => Some((frequency, frequency)),
            Self::Sweep { from, to } => Some((from.min(to), from.max(to))),
            Self::Broadband { from, to } => Some((from, to)),
            Self::Constant | Self::Steps { .. } | Self::Ramps { .. } => None,
        }
    }
}

/// Classifies a drive by its holds, the distances between its turning points (of more than 2 % of its range),
/// and its spectrum.
pub fn excitation_kind(u: &[f64]) -> ExcitationKind {
    let Some((start, end)) = active_range(u) else {
        let (low, high) = range_of(u);
        return if high > low { ExcitationKind::Steps { levels: 2 } } else { ExcitationKind::Constant };
    };
    let moving = &u[start..end];
    let (low, high) = range_of(moving);
    let span = high - low;
    if is_held(moving, span) {
        let values = u.windows(2).filter(|w| (w[1] - w[0]).abs() <= 1e-9 * span).map(|w| w[1]).collect();
        return ExcitationKind::Steps { levels: distinct(values, 0.005 * span) };
    }
    let points = turning_points(moving, 0.02 * span);
    // Turning points are known to a fraction of a sample only where the drive is smooth there.
    let places: Vec<f64> = points.iter().map(|p| p.index as f64 + vertex(moving, p.index)).collect();
    let halves: Vec<f64> = places.windows(2).map(|w| w[1] - w[0]).collect();
    if halves.len() < 3 {
        return ExcitationKind::Ramps { reversals: points.len() };
    }
    let mut sorted = halves.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |fraction: f64| sorted[((sorted.len() - 1) as f64 * fraction).round() as usize];
    if at(0.9) <= 1.25 * at(0.1) {
        let middle = at(0.5);
        let regular: Vec<f64> = halves.iter().copied().filter(|h| (h / middle - 1.0).abs() < 0.3).collect();
        let mean = regular.iter().sum::<f64>() / regular.len() as f64;
        return ExcitationKind::Wave {
            frequency: 0.5 / mean,
            shape: wave_shape(moving, &points),
            turning_levels: distinct(points.iter().map(|p| p.value).collect(), 0.03 * span),
        };
    }
    if halves.len() >= 8 && rank_correlation(&halves).abs() > 0.9 {
        let last = halves.len() - 1;
        return ExcitationKind::Sweep {
            from: extrapolated(&places, &halves, 0, 1, 0.0),
            to: extrapolated(&places, &halves, last, last - 1, moving.len() as f64),
        };
    }
    if halves.len() < 12 {
        return ExcitationKind::Ramps { reversals: points.len() };
    }
    let (from, to) = power_band(moving);
    ExcitationKind::Broadband { from, to }
}

/// True if more than half of the samples repeat their predecessor, and at least half of the other moves
/// exceed 2 % of the range.
fn is_held(u: &[f64], span: f64) -> bool {
    let held = u.windows(2).filter(|w| (w[1] - w[0]).abs() <= 1e-9 * span).count();
    let jumps = u.windows(2).filter(|w| (w[1] - w[0]).abs() > 0.02 * span).count();
    let moves = u.len() - 1 - held;
    2 * held >= u.len() && jumps >= 1 && 2 * jumps >= moves
}

/// Frequency at the place `at`, on the line through the half periods `near` and `next`; within a factor of 4
/// of that of `near`.
fn extrapolated(places: &[f64], halves: &[f64], near: usize, next: usize, at: f64) -> f64 {
    let frequency = |i: usize| 0.5 / halves[i];
    let centre = |i: usize| places[i] + 0.5 * halves[i];
    let slope = (frequency(next) - frequency(near)) / (centre(next) - centre(near));
    let here = frequency(near);
    (here + slope * (at - centre(near))).clamp(0.25 * here, 4.0 * here)
}

/// Values further apart than `gap` from their neighbour below.
fn distinct(mut values: Vec<f64>, gap: f64) -> usize {
    values.sort_unstable_by(f64::total_cmp);
    let mut count = usize::from(!values.is_empty());
    count += values.windows(2).filter(|w| w[1] - w[0] > gap).count();
    count
}

/// Vertex of the parabola through three samples, from the middle one, within half a sample.
fn vertex(x: &[f64], k: usize) -> f64 {
    match (k.checked_sub(1).and_then(|i| x.get(i)), x.get(k), x.get(k + 1)) {
        (Some(a), Some(b), Some(c)) if a - 2.0 * b + c != 0.0 => {
            (0.5 * (a - c) / (a - 2.0 * b + c)).clamp(-0.5, 0.5)
        }
        _ => 0.0,
    }
}

fn wave_shape(u: &[f64], points: &[super::TurningPoint]) -> WaveShape {
    // Rms about the middle over half the stroke, in the stroke of the median one.
    let mut ratios: Vec<f64> = points
        .windows(2)
        .filter_map(|w| {
            let part = u.get(w[0].index..w[1].index)?;
            let middle = 0.5 * (w[0].value + w[1].value);
            let half = 0.5 * (w[0].value - w[1].value).abs();
            let square = part.iter().map(|x| (x - middle).powi(2)).sum::<f64>() / part.len() as f64;
            Some(square.sqrt() / half)
        })
        .collect();
    ratios.sort_unstable_by(f64::total_cmp);
    match ratios.get(ratios.len() / 2) {
        Some(r) if (r - 0.5f64.sqrt()).abs() < 0.04 => WaveShape::Sine,
        Some(r) if (r - (1.0f64 / 3.0).sqrt()).abs() < 0.04 => WaveShape::Triangle,
        _ => WaveShape::Other,
    }
}

/// Spearman's rank correlation of the values with their order.
fn rank_correlation(values: &[f64]) -> f64 {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let n = values.len() as f64;
    let squares: f64 = order.iter().enumerate().map(|(rank, &k)| (rank as f64 - k as f64).powi(2)).sum();
    1.0 - 6.0 * squares / (n * (n * n - 1.0))
}

/// Frequencies (per sample) between which 98 % of the power lies.
fn power_band(u: &[f64]) -> (f64, f64) {
    let n = u.len();
    let mean = u.iter().sum::<f64>() / n as f64;
    let mut centred: Vec<f64> = u.iter().map(|x| x - mean).collect();
    let plan = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut spectrum = plan.make_output_vec();
    if plan.process(&mut centred, &mut spectrum).is_err() {
        return (0.0, 0.5);
    }
    let total: f64 = spectrum.iter().map(|c| c.norm_sqr()).sum();
    let reaches = |fraction: f64| {
        let mut sum = 0.0;
        let bin = spectrum.iter().position(|c| {
            sum += c.norm_sqr();
            sum >= fraction * total
        });
        bin.unwrap_or(0) as f64 / n as f64
    };
    (reaches(0.01), reaches(0.99))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn made(n: usize, f: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..n).map(|k| f(k as f64)).collect()
    }

    #[test]
    fn each_kind_is_recognised() {
        assert_eq!(excitation_kind(&[1.0; 100]), ExcitationKind::Constant);
        let steps = made(1000, |k| (k / 100.0).floor() * 0.5);
        assert_eq!(excitation_kind(&steps), ExcitationKind::Steps { levels: 10 });
        let loop_once = made(1000, |k| 500.0 - (k - 500.0).abs());
        assert_eq!(excitation_kind(&loop_once), ExcitationKind::Ramps { reversals: 1 });
        let sine = made(2000, |k| 3.0 + (TAU * k / 200.0).sin());
        let ExcitationKind::Wave { frequency, shape, turning_levels } = excitation_kind(&sine) else {
            panic!("{:?}", excitation_kind(&sine))
        };
        assert!((frequency * 200.0 - 1.0).abs() < 1e-3);
        assert_eq!((shape, turning_levels), (WaveShape::Sine, 2));
        let triangle = made(2000, |k| (k % 100.0 - 50.0).abs());
        assert!(matches!(
            excitation_kind(&triangle),
            ExcitationKind::Wave { shape: WaveShape::Triangle, .. }
        ));
        let shrinking = made(2000, |k| (TAU * k / 200.0).sin() * (1.0 - (k / 400.0).floor() / 5.0));
        assert!(matches!(excitation_kind(&shrinking), ExcitationKind::Wave { turning_levels: 8..=12, .. }));
    }

    #[test]
    fn a_sweep_is_told_from_noise_and_its_ends_are_found() {
        // Linear from 0.002 to 0.05 per sample in 5000 samples.
        let sweep = made(5000, |k| (TAU * (0.002 * k + 0.5 * 0.048 / 5000.0 * k * k)).sin());
        let ExcitationKind::Sweep { from, to } = excitation_kind(&sweep) else {
            panic!("{:?}", excitation_kind(&sweep))
        };
        assert!((from / 0.002 - 1.0).abs() < 0.5, "{from}");
        assert!((to / 0.05 - 1.0).abs() < 0.05, "{to}");
        let multisine = made(2000, |k| {
            (5..=80).map(|h| (TAU * f64::from(h) * k / 2000.0 + f64::from(h * h)).cos()).sum()
        });
        let ExcitationKind::Broadband { from, to } = excitation_kind(&multisine) else {
            panic!("{:?}", excitation_kind(&multisine))
        };
        assert!((from - 5.0 / 2000.0).abs() < 1e-3 && (to - 80.0 / 2000.0).abs() < 1e-3, "{from} {to}");
    }
}
