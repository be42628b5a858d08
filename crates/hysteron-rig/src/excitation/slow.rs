//! Sines and slow loops, the waveforms for the hysteresis block.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::random::fill_range;
use super::{SAMPLE_ROUNDING, Shape, whole_samples};

/// One sine of a sum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tone {
    /// Frequency \[Hz\].
    pub frequency_hz: f64,
    /// Amplitude relative to the other tones.
    pub amplitude: f64,
    /// Phase of the sine at the start \[degree\].
    #[serde(default)]
    pub phase_deg: f64,
}

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

/// Sum of sines scaled to 0 … 1.
pub(super) fn sines(tones: &[Tone], duration_s: f64, fs: f64) -> Shape {
    let samples = (duration_s * fs - SAMPLE_ROUNDING).ceil().max(1.0) as usize;
    let mut values: Vec<f64> = (0..samples)
        .map(|k| {
            let t = k as f64 / fs;
            tones
                .iter()
                .map(|tone| {
                    let phase = TAU * (tone.frequency_hz * t).fract() + tone.phase_deg.to_radians();
                    tone.amplitude * phase.sin()
                })
                .sum()
        })
        .collect();
    fill_range(&mut values);
    let mut excited_hz: Vec<f64> = tones.iter().map(|t| t.frequency_hz).collect();
    excited_hz.sort_by(f64::total_cmp);
    Shape { excited_hz, ..Shape::plain(values) }
}

/// ½ − ½ ratio^c cos 2πc.
pub(super) fn decaying(frequency_hz: f64, cycles: f64, ratio: f64, fs: f64) -> Shape {
    let samples = (cycles / frequency_hz * fs).round().max(1.0) as usize;
    let values = (0..=samples)
        .map(|k| {
            let c = frequency_hz * k as f64 / fs;
            0.5 - 0.5 * ratio.powf(c) * (TAU * c.fract()).cos()
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

    #[test]
    fn decaying_turning_points_shrink_geometrically_about_the_middle() {
        let values = decaying(1.0, 20.0, 0.8, 1000.0).values;
        for cycle in 0..20 {
            let low = values[1000 * cycle];
            assert!((low - 0.5 * (1.0 - 0.8f64.powi(cycle as i32))).abs() < 1e-12);
        }
        assert!((values[20_000] - 0.5).abs() < 0.006 && values.len() == 20_001);
        assert!(values.iter().all(|x| (0.0..=1.0).contains(x)));
    }

    #[test]
    fn sum_of_sines_has_the_amplitude_ratios_asked_for() {
        let tone = |frequency_hz, amplitude, phase_deg| Tone { frequency_hz, amplitude, phase_deg };
        let shape = sines(&[tone(30.0, 1.0, 90.0), tone(10.0, 3.0, 0.0)], 1.0, 1000.0);
        assert_eq!(shape.excited_hz, [10.0, 30.0]);
        // Correlation with sine and cosine over whole periods.
        let line = |f: f64| {
            let (mut s, mut c) = (0.0, 0.0);
            for (k, x) in shape.values.iter().enumerate() {
                let (sin, cos) = (TAU * f * k as f64 / 1000.0).sin_cos();
                s += x * sin;
                c += x * cos;
            }
            (s, c)
        };
        let ((s10, c10), (s30, c30)) = (line(10.0), line(30.0));
        assert!(c10.abs() < 1e-9 && s30.abs() < 1e-9 && (s10 / c30 - 3.0).abs() < 1e-9);
        let (low, high) = shape.values.iter().fold((1.0f64, 0.0f64), |(l, h), &x| (l.min(x), h.max(x)));
        assert_eq!((low, high), (0.0, 1.0));
    }
}
