//! Sines and slow loops: the waveforms that show the hysteresis block.

use std::f64::consts::TAU;

use super::{Shape, whole_samples};

/// (1 − cos 2πft)/2 over `periods`.
pub(super) fn sine(frequency_hz: f64, periods: f64, fs: f64) -> Shape {
    let samples = (periods / frequency_hz * fs).round() as usize;
    let values = (0..samples).map(|k| raised_cosine(frequency_hz * k as f64 / fs)).collect();
    Shape { period_samples: whole_samples(fs / frequency_hz), ..Shape::plain(values) }
}

/// Loops of the given amplitudes, all from and back to the low end.
pub(super) fn nested_loops(frequency_hz: f64, amplitudes: &[f64], periods_each: u32, fs: f64) -> Shape {
    let samples = (amplitudes.len() as f64 * f64::from(periods_each) / frequency_hz * fs).round() as usize;
    let values = (0..samples)
        .map(|k| {
            let cycles = frequency_hz * k as f64 / fs;
            let index = (cycles / f64::from(periods_each)) as usize;
            amplitudes.get(index).map_or(0.0, |a| a * raised_cosine(cycles))
        })
        .collect();
    Shape::plain(values)
}

/// (1 − cos 2πc)/2 without loss of digits for many cycles.
fn raised_cosine(cycles: f64) -> f64 {
    0.5 * (1.0 - (TAU * cycles.fract()).cos())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_starts_and_turns_where_it_should() {
        let s = sine(5.0, 2.0, 1000.0);
        assert_eq!(s.values.len(), 400);
        assert_eq!(s.period_samples, Some(200));
        assert_eq!(s.values[0], 0.0);
        assert!((s.values[50] - 0.5).abs() < 1e-12 && (s.values[100] - 1.0).abs() < 1e-15);
        assert_eq!(sine(7.0, 1.0, 1000.0).period_samples, None);
    }

    #[test]
    fn nested_loops_reach_their_amplitudes_in_order() {
        let s = nested_loops(2.0, &[1.0, 0.5, 0.25], 2, 1000.0);
        assert_eq!(s.values.len(), 3000);
        for (i, a) in [1.0, 0.5, 0.25].iter().enumerate() {
            let part = &s.values[1000 * i..1000 * (i + 1)];
            let peak = part.iter().copied().fold(0.0, f64::max);
            assert!((peak - a).abs() < 1e-12);
            assert!(part[0].abs() < 1e-15 && part[500].abs() < 1e-12);
        }
    }
}
