//! Waveforms made of ramps and holds.

use super::{Shape, whole_samples};

/// Up to 1, then down to 1 − i/curves and back up for i = 1 … curves, then down to 0, all at one speed. Every
/// turning point falls on a sample.
pub(super) fn reversal_curves(curves: u32, ramp_s: f64, fs: f64) -> Shape {
    let mut turning = vec![0.0, 1.0];
    for i in 1..=curves {
        turning.extend([1.0 - f64::from(i) / f64::from(curves), 1.0]);
    }
    turning.push(0.0);
    let mut values = vec![0.0];
    for leg in turning.windows(2) {
        let samples = ((leg[1] - leg[0]).abs() * ramp_s * fs).round().max(1.0) as usize;
        values.extend((1..=samples).map(|k| {
            if k == samples { leg[1] } else { leg[0] + (leg[1] - leg[0]) * k as f64 / samples as f64 }
        }));
    }
    Shape::plain(values)
}

/// Levels 0, 1/steps … 1 … 0, each held, with raised-cosine transitions.
pub(super) fn staircase(steps: u32, hold_s: f64, transition_s: f64, fs: f64) -> Shape {
    let hold = (hold_s * fs).round().max(1.0) as usize;
    let transition = (transition_s * fs).round() as usize;
    let levels: Vec<f64> =
        (0..=steps).chain((0..steps).rev()).map(|i| f64::from(i) / f64::from(steps)).collect();
    let mut values = Vec::with_capacity(levels.len() * (hold + transition));
    for (i, &level) in levels.iter().enumerate() {
        values.extend(std::iter::repeat_n(level, hold));
        if let Some(&next) = levels.get(i + 1) {
            values.extend((1..=transition).map(|k| {
                let part = k as f64 / (transition + 1) as f64;
                level + (next - level) * 0.5 * (1.0 - (std::f64::consts::PI * part).cos())
            }));
        }
    }
    Shape::plain(values)
}

/// Forward ramp, return ramp, corners rounded by a moving average over `turnaround` of a line (so:
/// parabolas), scaled back to 0 … 1 and started at the minimum.
pub(super) fn raster(line_hz: f64, lines: f64, return_fraction: f64, turnaround: f64, fs: f64) -> Shape {
    let samples = (lines / line_hz * fs).round() as usize;
    let (forward, back) = (1.0 - return_fraction, return_fraction);
    // Integral from 0 of the sharp wave that rises from 0 at phase 0; each line adds ½.
    let integral = |phase: f64| {
        let line = phase.floor();
        let p = phase - line;
        let within = if p <= forward {
            0.5 * p * p / forward
        } else {
            let left = 1.0 - p;
            0.5 - 0.5 * left * left / back
        };
        0.5 * line + within
    };
    let start = turnaround * (0.5 - back);
    let values = (0..samples)
        .map(|k| {
            let phase = (line_hz * k as f64 / fs).fract() + start;
            if turnaround == 0.0 {
                if phase <= forward { phase / forward } else { (1.0 - phase) / back }
            } else {
                let half = 0.5 * turnaround;
                let mean = (integral(phase + half) - integral(phase - half)) / turnaround;
                ((mean - half) / (1.0 - turnaround)).clamp(0.0, 1.0)
            }
        })
        .collect();
    Shape { period_samples: whole_samples(fs / line_hz), ..Shape::plain(values) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reversal_curves_start_from_the_top_and_reach_every_reversal() {
        let values = reversal_curves(4, 1.0, 100.0).values;
        let mut turning = vec![values[0]];
        for w in values.windows(3) {
            if (w[1] - w[0]) * (w[2] - w[1]) < 0.0 {
                turning.push(w[1]);
            }
        }
        turning.push(values[values.len() - 1]);
        assert_eq!(turning, [0.0, 1.0, 0.75, 1.0, 0.5, 1.0, 0.25, 1.0, 0.0, 1.0, 0.0]);
        // One speed: 1/100 of the range a sample.
        assert!(values.windows(2).all(|w| ((w[1] - w[0]).abs() - 0.01).abs() < 1e-12));
        // Full ramps: up, 2·(¼ + ½ + ¾ + 1) = 5, down.
        assert_eq!(values.len(), 1 + 700);
    }

    #[test]
    fn staircase_holds_every_level_up_and_down() {
        let values = staircase(2, 0.03, 0.02, 100.0).values;
        assert_eq!(values.len(), 5 * 3 + 4 * 2);
        for (i, level) in [0.0, 0.5, 1.0, 0.5, 0.0].iter().enumerate() {
            assert_eq!(values[5 * i..5 * i + 3], [*level; 3]);
        }
        // Thirds of a raised cosine: ¼ and ¾ of the step.
        assert!((values[3] - 0.125).abs() < 1e-12 && (values[4] - 0.375).abs() < 1e-12);
        assert_eq!(staircase(1, 0.02, 0.0, 100.0).values, [0.0, 0.0, 1.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn sharp_raster_is_a_sawtooth_with_return() {
        let values = raster(1.0, 2.0, 0.2, 0.0, 100.0).values;
        assert_eq!(values.len(), 200);
        for (k, expected) in [(0, 0.0), (40, 0.5), (80, 1.0), (90, 0.5), (140, 0.5)] {
            assert!((values[k] - expected).abs() < 1e-12, "{k}");
        }
    }

    #[test]
    fn rounded_raster_keeps_range_and_speed_and_bounds_the_acceleration() {
        let (fs, back, turn) = (10_000.0, 0.3, 0.1);
        let shape = raster(1.0, 1.0, back, turn, fs);
        let v = &shape.values;
        assert_eq!(shape.period_samples, Some(10_000));
        assert!(v[0].abs() < 1e-12, "starts at the minimum: {}", v[0]);
        let peak = v.iter().copied().fold(0.0, f64::max);
        assert!((peak - 1.0).abs() < 1e-6, "{peak}");
        // Speeds of the straight parts, scaled by 1/(1 − turn).
        let slope: Vec<f64> = v.windows(2).map(|w| (w[1] - w[0]) * fs).collect();
        let (fastest, slowest) = slope.iter().fold((0.0f64, 0.0f64), |(h, l), &s| (h.max(s), l.min(s)));
        assert!((fastest - 1.0 / 0.7 / 0.9).abs() < 1e-6 && (slowest + 1.0 / 0.3 / 0.9).abs() < 1e-6);
        // Constant acceleration in a turnaround: change of speed over its duration.
        let bend = slope.windows(2).map(|w| ((w[1] - w[0]) * fs).abs()).fold(0.0, f64::max);
        let expected = (fastest - slowest) / turn;
        assert!(bend < expected * 1.001, "{bend} {expected}");
    }
}
