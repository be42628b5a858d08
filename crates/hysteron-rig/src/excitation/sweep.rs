//! Swept sines.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{SAMPLE_ROUNDING, Shape};

/// Frequency law of a sweep from f₀ to f₁ over T.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SweepLaw {
    /// f = f₀ + (f₁ − f₀) t/T.
    Linear,
    /// f = f₀ (f₁/f₀)^(t/T): equal time for every octave.
    #[default]
    Logarithmic,
}

/// (1 − cos φ)/2 with φ' = 2πf(t).
pub(super) fn sweep(law: SweepLaw, start_hz: f64, end_hz: f64, duration_s: f64, fs: f64) -> Shape {
    let samples = (duration_s * fs - SAMPLE_ROUNDING).ceil().max(1.0) as usize;
    let values = (0..samples)
        .map(|k| {
            let cycles = cycles(law, start_hz, end_hz, duration_s, k as f64 / fs);
            0.5 * (1.0 - (TAU * cycles.fract()).cos())
        })
        .collect();
    Shape::plain(values)
}

/// Phase after t in cycles: ∫f dt.
fn cycles(law: SweepLaw, start_hz: f64, end_hz: f64, duration_s: f64, t: f64) -> f64 {
    match law {
        SweepLaw::Linear => start_hz * t + 0.5 * (end_hz - start_hz) * t * t / duration_s,
        SweepLaw::Logarithmic => {
            // f₀ (e^{rt} − 1)/r, r = ln(f₁/f₀)/T; r → 0 is a sine.
            let rate = (end_hz / start_hz).ln() / duration_s;
            if rate == 0.0 { start_hz * t } else { start_hz * (rate * t).exp_m1() / rate }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instantaneous_frequency_follows_the_law() {
        for (law, middle_hz) in [(SweepLaw::Linear, 50.5), (SweepLaw::Logarithmic, 10.0)] {
            let frequency = |t: f64| {
                let d = 1e-5;
                (cycles(law, 1.0, 100.0, 10.0, t + d) - cycles(law, 1.0, 100.0, 10.0, t - d)) / (2.0 * d)
            };
            for (t, f) in [(0.0, 1.0), (5.0, middle_hz), (10.0, 100.0)] {
                assert!((frequency(t) / f - 1.0).abs() < 1e-6, "{law:?} at {t} s: {}", frequency(t));
            }
        }
    }

    /// Counting the maxima of the samples themselves: whole cycles of ∫f dt.
    #[test]
    fn the_samples_hold_as_many_cycles_as_the_law_says() {
        // Linear: (1 + 100)/2·10 = 505; logarithmic: 10·99/ln 100 = 214.97.
        for (law, expected) in [(SweepLaw::Linear, 505), (SweepLaw::Logarithmic, 214)] {
            let s = sweep(law, 1.0, 100.0, 10.0, 10_000.0);
            assert_eq!(s.values.len(), 100_000);
            let crossings = s.values.windows(2).filter(|w| w[0] < 0.5 && w[1] >= 0.5).count();
            assert!(crossings.abs_diff(expected) <= 1, "{law:?}: {crossings}");
            assert_eq!(s.values[0], 0.0);
        }
    }

    #[test]
    fn a_sweep_may_go_down_or_stay() {
        let down = sweep(SweepLaw::Logarithmic, 100.0, 1.0, 1.0, 1000.0).values;
        assert!(down.iter().all(|x| (0.0..=1.0).contains(x)));
        let still = sweep(SweepLaw::Logarithmic, 10.0, 10.0, 0.1, 1000.0).values;
        assert!((still[50] - 1.0).abs() < 1e-12);
    }
}
