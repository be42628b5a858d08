//! Bandwidth under the current limit of an amplifier.

use std::f64::consts::PI;

use super::StraightLine;
use super::strategy::SLOW;
use crate::realise::LinearRealisation;

/// Bisections of the search for a frequency.
const HALVINGS: usize = 60;

/// I = C du/dt: the largest rate of the drive \[V/s\] from current \[A\] and capacitance \[F\].
pub fn slew_of_current(current_a: f64, capacitance_f: f64) -> f64 {
    current_a / capacitance_f
}

/// Highest frequency of a sine of one amplitude within the limits of slew rate and range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Amplitude \[µm\].
    pub amplitude: f64,
    /// Voltage amplitude of a slow sine \[V\].
    pub amplitude_v: f64,
    /// Highest frequency \[Hz\] at which neither slew rate nor range limits the drive; half the sample rate
    /// where neither ever does.
    pub highest_hz: f64,
}

/// The highest frequency f at which a sine of an amplitude (displacement, about the middle of the range)
/// keeps to the limits: with U(f) = amplitude/(slope
/// |P(f)|), P the dynamics over their quasi-static gain, 2π f U(f) ≤ slew and 2 U(f) ≤ range. Held samples
/// move by the secant: 2 sin(π f T) U/T in place of 2π f U.
pub fn reach(
    line: &StraightLine,
    dynamics: &LinearRealisation,
    sample_rate_hz: f64,
    range_v: [f64; 2],
    slew_v_per_s: f64,
    amplitude: f64,
) -> Reach {
    let slow = dynamics.response(SLOW * sample_rate_hz, sample_rate_hz).norm();
    let voltage =
        |f: f64| amplitude * slow / (line.slope.abs() * dynamics.response(f, sample_rate_hz).norm());
    let rate = |f: f64| 2.0 * (PI * f / sample_rate_hz).sin() * sample_rate_hz * voltage(f);
    let keeps = |f: f64| rate(f) <= slew_v_per_s && 2.0 * voltage(f) <= range_v[1] - range_v[0];
    let half = 0.5 * sample_rate_hz;
    // The first frequency that violates a limit, on a fine grid, then by bisection: beyond a resonance the
    // limits may hold again.
    let grid = |k: usize| half * 10f64.powf(6.0 * (k as f64 / 2400.0 - 1.0));
    let first = (0..=2400).map(grid).find(|f| !keeps(*f));
    let highest_hz = first.map_or(half, |broken| {
        let (mut low, mut high) = (broken / 10f64.powf(6.0 / 2400.0), broken);
        for _ in 0..HALVINGS {
            let between = 0.5 * (low + high);
            if keeps(between) { low = between } else { high = between }
        }
        low
    });
    Reach { amplitude, amplitude_v: voltage(SLOW * sample_rate_hz), highest_hz }
}
