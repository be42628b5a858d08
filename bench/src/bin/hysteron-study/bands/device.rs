//! A simulated device: hysteresis of some sort, a resonance, noise. It shares no code with the library.

use std::f64::consts::TAU;

use hysteron_identify::CampaignRecord;

use super::draw::Draw;
use super::sorts::{Hysteresis, Sort};
use crate::Outcome;
use crate::campaign::record;
use crate::device::HIGH_V;

/// Sample rate of every record \[Hz\].
pub const RATE_HZ: f64 = 2000.0;
/// Steps of the simulation in a sample.
const FINER: usize = 8;
/// Stroke, about \[µm\], and the noise of the sensor.
const STROKE_UM: f64 = 20.0;
const NOISE_UM: f64 = 0.005;

/// A device with its sensor.
pub struct Device {
    pub sort: Sort,
    seed: u64,
    natural_hz: f64,
    damping: f64,
    /// Output of the hysteresis at 0 and at full drive, on first loading.
    ends: (f64, f64),
}

impl Device {
    pub fn new(sort: Sort, seed: u64) -> Self {
        let mut draw = Draw::new(seed ^ 0x5eed);
        let (natural_hz, damping) = (draw.between(180.0, 500.0), draw.between(0.03, 0.2));
        let mut device = Self { sort, seed, natural_hz, damping, ends: (0.0, 1.0) };
        let mut law = device.law();
        let slow = 4000;
        let first = law.step(0.0, 1e-3);
        let last = (0..=slow).map(|k| law.step(f64::from(k) / f64::from(slow), 1e-3)).last();
        device.ends = (first, last.unwrap_or(1.0));
        device
    }

    fn law(&self) -> Hysteresis {
        Hysteresis::at_random(self.sort, &mut Draw::new(self.seed))
    }

    /// Record of a drive, from rest at its first sample, straight between samples.
    pub fn answer(&self, name: &str, drive_v: &[f64], stream: u64) -> Outcome<CampaignRecord> {
        let mut law = self.law();
        let step_s = 1.0 / (RATE_HZ * FINER as f64);
        let scale = STROKE_UM / (self.ends.1 - self.ends.0);
        let mut static_um =
            |drive_v: f64, step_s: f64| scale * (law.step(drive_v / HIGH_V, step_s) - self.ends.0);
        let rest_v = drive_v.first().copied().unwrap_or(0.0);
        // A device that creeps has crept.
        let rest = (0..200).map(|_| static_um(rest_v, 0.5)).last().unwrap_or(0.0);
        let mut mode = Resonator::new(TAU * self.natural_hz * step_s, self.damping, rest);
        let mut noise = Draw::new(self.seed.wrapping_mul(1009).wrapping_add(stream));
        let mut before = rest_v;
        let answer = |&to: &f64| {
            let mut y = 0.0;
            for fine in 1..=FINER {
                let u = before + (to - before) * fine as f64 / FINER as f64;
                y = mode.step(static_um(u, step_s));
            }
            before = to;
            y + NOISE_UM * noise.normal()
        };
        let output: Vec<f64> = drive_v.iter().map(answer).collect();
        record(name, RATE_HZ, drive_v, &output)
    }
}

/// ÿ + 2ζω ẏ + ω² y = ω² x by the trapezoidal rule.
struct Resonator {
    a: [f64; 2],
    gain: f64,
    x: [f64; 2],
    y: [f64; 2],
}

impl Resonator {
    /// `angle`: ω times the step.
    fn new(angle: f64, damping: f64, rest: f64) -> Self {
        let k = 2.0 / angle;
        let lead = k * k + 2.0 * damping * k + 1.0;
        let a = [2.0 * (1.0 - k * k) / lead, (k * k - 2.0 * damping * k + 1.0) / lead];
        Self { a, gain: 1.0 / lead, x: [rest; 2], y: [rest; 2] }
    }

    fn step(&mut self, x: f64) -> f64 {
        let forced = self.gain * (x + 2.0 * self.x[0] + self.x[1]);
        let y = forced - self.a[0] * self.y[0] - self.a[1] * self.y[1];
        self.x = [x, self.x[0]];
        self.y = [y, self.y[0]];
        y
    }
}
