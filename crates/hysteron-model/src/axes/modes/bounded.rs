//! Square waves at the resonances: whether the motion comes to rest after them.
//!
//! The strains of the hysteresis are polynomials in drive and stress, identified along the records. A drive
//! within their range that puts all of it into a resonance leads to stresses beyond them, where the feedback may
//! be larger than the damping. [`StrainLaw::reach`](super::StrainLaw::reach) bounds the motion; it may still go
//! on by itself.

use super::simulate::Runner;
use super::{Mode, ScheduledModes};
use std::f64::consts::PI;

/// Decays e^(−1) of the slowest state that a square wave lasts, and as many after it; the most steps of either.
const FOLDS: f64 = 12.0;
const MOST_STEPS: usize = 200_000;
/// Share of the largest state that may be left.
const LEFT: f64 = 1e-2;
/// Halvings of the interval of amplitudes.
const HALVINGS: usize = 8;

/// A square wave on all inputs, about the middle of their range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquareWave {
    /// Frequency \[Hz\].
    pub frequency_hz: f64,
    /// Amplitude \[V\].
    pub amplitude: f64,
}

impl ScheduledModes {
    /// The smallest square wave at a resonance, within `low` to `high` \[V\], after which the motion does not
    /// come to rest, at the highest level; every input with the sign that moves the mode most. `None`: it does
    /// after all of them.
    pub fn goes_on_after(&self, [low, high]: [f64; 2]) -> Option<SquareWave> {
        self.feedback.as_ref()?;
        let s = self.level.state(self.level.highest);
        let (middle, most) = (0.5 * (low + high), 0.5 * (high - low));
        let wave = |(k, mode): (usize, Mode)| {
            let signs = self.signs(k);
            let goes_on = |amplitude: f64| self.goes_on(s, mode, &signs, (middle, amplitude));
            if !goes_on(most) {
                return None;
            }
            let (mut rests, mut goes) = (0.0, most);
            for _ in 0..HALVINGS {
                let amplitude = 0.5 * (rests + goes);
                if goes_on(amplitude) { goes = amplitude } else { rests = amplitude }
            }
            Some(SquareWave { frequency_hz: mode.frequency_hz, amplitude: goes })
        };
        let waves = self.modes_at(s).into_iter().enumerate().filter_map(wave);
        waves.min_by(|a, b| a.amplitude.total_cmp(&b.amplitude))
    }

    /// Signs of the inputs with which they move mode `k` in the same sense.
    fn signs(&self, k: usize) -> Vec<f64> {
        let row = |part: usize| &self.input[(2 * k + part) * self.inputs..][..self.inputs];
        let (re, im) = (row(0), row(1));
        let size = |n: &usize| re[*n].hypot(im[*n]);
        let largest = (0..self.inputs).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0);
        let along = |n: usize| re[n] * re[largest] + im[n] * im[largest];
        (0..self.inputs).map(|n| if along(n) < 0.0 { -1.0 } else { 1.0 }).collect()
    }

    fn goes_on(&self, s: f64, mode: Mode, signs: &[f64], (middle, amplitude): (f64, f64)) -> bool {
        let a_step = 2.0 * PI * mode.frequency_hz / self.step_rate_hz();
        let steps = self.settling_steps(s, FOLDS).min(MOST_STEPS);
        let period = (2.0 * PI / a_step).ceil() as usize;
        let mut runner = Runner::new(self, s);
        let mut u = vec![0.0; self.inputs];
        let mut largest: f64 = 0.0;
        for step in 0..steps {
            let half = (a_step * step as f64 / PI) as u64;
            let side = if half.is_multiple_of(2) { amplitude } else { -amplitude };
            u.iter_mut().zip(signs).for_each(|(u, sign)| *u = middle + sign * side);
            runner.step(&u);
            largest = runner.x.iter().fold(largest, |most, x| most.max(x.abs()));
        }
        u.fill(middle);
        (0..steps).for_each(|_| runner.step(&u));
        let mut ends: Vec<[f64; 2]> = runner.x.iter().map(|x| [*x, *x]).collect();
        for _ in 0..period {
            runner.step(&u);
            for ([low, high], x) in ends.iter_mut().zip(&runner.x) {
                (*low, *high) = (low.min(*x), high.max(*x));
            }
        }
        let left = ends.iter().fold(0.0, |most: f64, [low, high]| most.max(high - low));
        left > LEFT * largest || runner.x.iter().any(|x| !x.is_finite())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use crate::axes::{FeedbackStrain, LevelLaw, StrainLaw, pole};
    use proptest::prelude::*;

    const MODE: Mode = Mode { frequency_hz: 100.0, damping: 0.02 };

    /// One mode at 100 Hz, sampled at 2 kHz, whose strain is a cube of its velocity times `weight`.
    fn with_cube(weight: f64, reach: f64) -> ScheduledModes {
        let p = pole(MODE, 2000.0);
        let law = |weight: f64| StrainLaw {
            coefficients: vec![0.0, weight],
            radii: vec![],
            slopes: vec![],
            variance: 1e-6,
            reach,
        };
        ScheduledModes {
            inputs: 1,
            outputs: 1,
            modes: 1,
            sample_rate_hz: 2000.0,
            steps: 1,
            level: LevelLaw {
                reference: 1.0,
                exponent: 1.0,
                lowest: 1.0,
                highest: 1.0,
                time_constant_s: 1.0,
            },
            transition: vec![p.re, p.im, 0.5],
            transition_slopes: vec![0.0; 3],
            input: vec![0.05, 0.0, 0.0],
            strain_input: vec![0.05, 0.0, 0.0],
            output: vec![1.0, 0.0, 0.0],
            output_slopes: vec![0.0; 3],
            feedthrough: vec![0.0],
            feedthrough_slopes: vec![0.0],
            strain_feedthrough: vec![0.0],
            feedback: Some(FeedbackStrain {
                drive_rows: vec![0.0; 4],
                // Real part of the state: what acts on it with this sign drives the motion on.
                stress_rows: vec![1.0, 0.0, 0.0, 0.0],
                drive: law(0.0),
                stress: vec![law(weight)],
            }),
        }
    }

    #[test]
    fn a_strain_that_drives_the_motion_on_is_found_at_its_amplitude() {
        let range = [-1.0, 1.0];
        // In the mean over a cycle of amplitude a, 0.05 c z³ adds 0.05 · 3/8 c a³ a step and the damping takes
        // ζωT a: the motion goes on from a² = ζωT/(0.05 · 3/8 c) on.
        let (weight, decay) = (1.0, 0.02 * 2.0 * PI * 100.0 / 2000.0);
        let rest: f64 = (decay / (0.05 * 3.0 / 8.0 * weight)).sqrt();
        let model = with_cube(weight, f64::INFINITY);
        let found = model.goes_on_after(range).unwrap();
        assert_eq!(found.frequency_hz, model.modes_at(0.0)[0].frequency_hz);
        // A square wave of amplitude u has a fundamental of 4/π u and adds 0.05/2 of it: more than the damping
        // takes less what the cube adds, ζωT rest · 2/(3√3) at most, where a = rest/√3.
        let most = decay * rest * 2.0 / (3.0 * 3.0_f64.sqrt());
        let added = 0.5 * 0.05 * 4.0 / PI * found.amplitude;
        // Just above, the motion grows for longer than the wave lasts.
        assert!((1.0..1.2).contains(&(added / most)), "{added} of {most}");
        // The reach below that amplitude: it comes to rest.
        assert_eq!(with_cube(weight, 0.5 * rest).goes_on_after(range), None);
        assert_eq!(with_cube(-weight, 0.5 * rest).goes_on_after(range), None);
        assert_eq!(ScheduledModes { feedback: None, ..model }.goes_on_after(range), None);
    }

    proptest! {
        /// |x| ≤ Σ |p|^k |force| over all steps: 0.05 (|u| + |w|)/(1 − |p|).
        #[test]
        fn strains_within_a_reach_keep_the_motion_bounded(
            weight in -1e3..1e3f64,
            reach in 1e-3..1e3f64,
            amplitude in 1e-3..1e3f64,
        ) {
            let model = with_cube(weight, reach);
            let mut runner = Runner::new(&model, 0.0);
            let strain = weight.abs() * (reach.powi(3) + 3e-6 * reach);
            let bound = 0.05 * (amplitude + strain) / (1.0 - model.largest_pole(0.0).0);
            for step in 0..3000 {
                let side = if step / 10 % 2 == 0 { amplitude } else { -amplitude };
                runner.step(&[side]);
                prop_assert!(runner.x[0].hypot(runner.x[1]) <= bound * (1.0 + 1e-9));
            }
        }
    }
}
