//! Stability margins of a loop.

use std::f64::consts::{PI, TAU};

use crate::realise::LinearRealisation;
use hysteron_numeric::Complex64;

/// Points per decade, and linearly spaced points up to half the sample rate.
const PER_DECADE: usize = 200;
const EVEN: usize = 2000;
/// Lowest frequency, as a share of the sample rate.
const LOWEST: f64 = 1e-8;
/// |Im| over magnitude below which a value counts as real.
const REAL: f64 = 1e-6;
/// Points about a resonance.
const ABOUT: usize = 41;

/// Margins of a loop L, feedback negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Factor by which the gain of the loop may rise or fall; infinite where neither destabilises it.
    pub gain: f64,
    /// Frequency \[Hz\] of the oscillation at that limit.
    pub gain_at_hz: f64,
    /// Least angle \[degrees\] between L and −1 where |L| = 1; infinite where |L| never is.
    pub phase_deg: f64,
    /// Highest frequency \[Hz\] at which |L| = 1; 0 where it never is.
    pub crossover_hz: f64,
    /// Least |1 + L|: one over the largest sensitivity.
    pub modulus: f64,
    /// True if the closed loop is stable: L has no unstable pole, at most one integrator, and does not
    /// encircle −1.
    pub is_stable: bool,
}

impl Margins {
    /// Margins of a loop at rising frequencies \[Hz\] up to half the sample rate, with phase steps of less
    /// than 180°.
    pub fn of(points: &[(f64, Complex64)]) -> Self {
        let mut found = Self {
            gain: f64::INFINITY,
            gain_at_hz: 0.0,
            phase_deg: f64::INFINITY,
            crossover_hz: 0.0,
            modulus: f64::INFINITY,
            is_stable: false,
        };
        for (_, l) in points {
            found.modulus = found.modulus.min((1.0 + l).norm());
        }
        let mut consider_gain = |at_hz: f64, re: f64| {
            let factor = (-re).max(-1.0 / re);
            if re < 0.0 && factor < found.gain {
                (found.gain, found.gain_at_hz) = (factor, at_hz);
            }
        };
        let mut turned = points.first().map_or(f64::NAN, |(_, l)| (1.0 + l).arg());
        for pair in points.windows(2) {
            let [(f, a), (g, b)] = [pair[0], pair[1]];
            turned += ((1.0 + b) / (1.0 + a)).arg();
            if (a.im < 0.0) != (b.im < 0.0) {
                let share = a.im / (a.im - b.im);
                consider_gain(f + share * (g - f), a.re + share * (b.re - a.re));
            }
            if (a.norm() < 1.0) != (b.norm() < 1.0) {
                let share = (1.0 - a.norm()) / (b.norm() - a.norm());
                let there = a + share * (b - a);
                found.phase_deg = found.phase_deg.min((-there).arg().abs().to_degrees());
                found.crossover_hz = f + share * (g - f);
            }
        }
        if let Some((f, last)) = points.last()
            && last.im.abs() <= REAL * last.norm()
        {
            // At half the sample rate L is real.
            consider_gain(*f, last.re);
        }
        // 1 + L begins at an angle of 0, or of −90° behind an integral, and ends at 0 unless −1 was
        // encircled.
        found.is_stable = turned.abs() < 0.5 * PI;
        found
    }
}

/// Frequency grid \[Hz\] for the loop around these dynamics: dense about their resonances, up to half the
/// sample rate.
pub fn loop_frequencies(dynamics: &LinearRealisation, sample_rate_hz: f64) -> Vec<f64> {
    let half = 0.5 * sample_rate_hz;
    let decades = (0.5 / LOWEST).log10();
    let count = (decades * PER_DECADE as f64).ceil() as usize;
    let mut found: Vec<f64> =
        (0..=count).map(|k| half * 10f64.powf(decades * (k as f64 / count as f64 - 1.0))).collect();
    found.extend((1..EVEN).map(|k| half * k as f64 / EVEN as f64));
    for section in dynamics.sections.iter().filter(|s| s.is_pair()) {
        let pole = 1.0 - section.gain;
        let (angle, width) = (pole.arg().abs(), -pole.norm().ln());
        let offsets = (0..ABOUT).map(|k| (PI * ((k as f64 + 0.5) / ABOUT as f64 - 0.5)).tan());
        found.extend(offsets.map(|x| (angle + width * x) / TAU * sample_rate_hz));
    }
    found.retain(|f| *f > 0.0 && *f <= half);
    found.sort_by(f64::total_cmp);
    found.dedup();
    found
}
