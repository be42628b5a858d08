//! A device that is known: two actuators, two sensors, three modes, hysteresis of stress in feedback.

use std::f64::consts::TAU;

use hysteron_model::axes::{AxesRecord, FeedbackStrain, LevelLaw, ScheduledModes, StrainLaw};
use hysteron_model::record::{Channel, InterSample, Record, TimeBase};
use hysteron_numeric::Complex64;

pub const RATE: f64 = 1000.0;
pub const PERIOD: usize = 2048;
/// Levels \[V rms\].
pub const LOW: f64 = 0.2;
pub const HIGH: f64 = 0.6;

/// Numbers between 0 and 1 that look random.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Of variance 1: twelve uniform ones.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}

/// Frequencies at the highest level \[Hz\], damping, row of the inputs, column of the outputs.
pub const MODES: [(f64, f64, [f64; 2], [f64; 2]); 3] = [
    (95.0, 0.012, [1.0, 0.3], [0.9, 0.4]),
    (180.0, 0.010, [0.4, -1.0], [-0.3, 0.8]),
    (310.0, 0.015, [0.6, 0.7], [0.5, -0.5]),
];
/// Share by which every resonance falls from level 0 to the highest.
pub const SOFTENING: f64 = 0.02;

pub fn device() -> ScheduledModes {
    let (n, m, modes, steps) = (2, 2, MODES.len(), 2);
    let states = 2 * modes + n;
    let rate = RATE * steps as f64;
    let lag = (-TAU * 400.0 / rate).exp();
    let mut d = ScheduledModes {
        inputs: n,
        outputs: m,
        modes,
        sample_rate_hz: RATE,
        steps,
        level: LevelLaw { reference: HIGH, exponent: 1.0, lowest: LOW, highest: HIGH, time_constant_s: 2.0 },
        transition: Vec::new(),
        transition_slopes: vec![0.0; states],
        input: vec![0.0; states * n],
        strain_input: vec![0.0; states * n],
        output: vec![0.0; m * states],
        output_slopes: vec![0.0; m * states],
        feedthrough: vec![0.0; m * n],
        feedthrough_slopes: vec![0.0; m * n],
        strain_feedthrough: vec![0.0; m * n],
        feedback: None,
    };
    for (k, (frequency, damping, b, c)) in MODES.into_iter().enumerate() {
        let pole = (Complex64::new(-damping, 1.0) * (TAU * frequency / rate)).exp();
        let slope = pole * pole.ln() * -SOFTENING;
        d.transition.extend([pole.re, pole.im]);
        (d.transition_slopes[2 * k], d.transition_slopes[2 * k + 1]) = (slope.re, slope.im);
        // y = c b ω² / (s² + 2ζωs + ω²): residue of −i at the pole, whose force is b.
        let step = TAU * frequency / rate;
        for (i, b) in b.into_iter().enumerate() {
            d.input[2 * k * n + i] = step * b;
            d.strain_input[2 * k * n + i] = step * b;
        }
        for (o, c) in c.into_iter().enumerate() {
            d.output[o * states + 2 * k + 1] = c;
        }
    }
    for i in 0..n {
        d.transition.push(lag);
        d.input[(2 * modes + i) * n + i] = 1.0 - lag;
        d.output[i * states + 2 * modes + i] = 2.0;
    }
    // Extension by the modes' outputs, free stroke by the lag, stress their difference.
    let row = states + n;
    let (mut drive_rows, mut stress_rows) = (vec![0.0; n * row], vec![0.0; n * row]);
    for i in 0..n {
        for k in 0..modes {
            stress_rows[i * row + 2 * k + 1] = MODES[k].2[i] * 0.8;
        }
        drive_rows[i * row + 2 * modes + i] = 1.0;
        stress_rows[i * row + 2 * modes + i] = -1.0;
    }
    let law = |coefficients: [f64; 4], variance: f64| StrainLaw {
        coefficients: coefficients.to_vec(),
        radii: vec![0.15, 0.5],
        slopes: vec![0.7, 0.3],
        variance,
        reach: f64::INFINITY,
    };
    d.feedback = Some(FeedbackStrain {
        drive_rows,
        stress_rows,
        drive: law([0.0, 0.0, 0.04, 0.03], HIGH * HIGH),
        stress: vec![law([0.02, 0.0, 0.0, 0.0], HIGH * HIGH), law([-0.015, 0.0, 0.0, 0.0], HIGH * HIGH)],
    });
    d.validate().unwrap();
    d
}

/// One period of a multisine of the level for each input, with phases of its own, up to 420 Hz.
pub fn drive(level: f64, seed: u64) -> Vec<Vec<f64>> {
    let mut random = Random(seed);
    let lines = (420.0 / RATE * PERIOD as f64) as usize;
    let table: Vec<f64> = (0..PERIOD).map(|k| (TAU * k as f64 / PERIOD as f64).cos()).collect();
    let mut channel = || {
        let mut u = vec![0.0; PERIOD];
        for line in 1..=lines {
            let shift = (random.unit() * PERIOD as f64) as usize;
            for (k, u) in u.iter_mut().enumerate() {
                *u += table[(line * k + shift) % PERIOD];
            }
        }
        let rms = (u.iter().map(|u| u * u).sum::<f64>() / PERIOD as f64).sqrt();
        u.into_iter().map(|u| u * level / rms).collect()
    };
    vec![channel(), channel()]
}

/// The same without hysteresis.
pub fn linear_device() -> ScheduledModes {
    ScheduledModes { feedback: None, ..device() }
}

/// [`record_of`] the device.
pub fn record(level: f64, seed: u64, noise: f64) -> AxesRecord {
    record_of(&device(), level, seed, noise)
}

/// Two periods of a device's steady state, with noise of this rms on the outputs and an offset.
pub fn record_of(device: &ScheduledModes, level: f64, seed: u64, noise: f64) -> AxesRecord {
    let u: Vec<Vec<f64>> = drive(level, seed).into_iter().map(|u| u.repeat(2)).collect();
    let start = Some(PERIOD);
    let y = device.simulate(&u, RATE, InterSample::BandLimited, start).unwrap();
    let mut random = Random(seed + 1000);
    let mut channels = Vec::new();
    for (i, u) in u.into_iter().enumerate() {
        channels.push(Channel::new(&format!("u{}", i + 1), "V", u));
    }
    for (o, y) in y.into_iter().enumerate() {
        let noisy = y.into_iter().map(|y| 1e3 * (y + 3.0 + noise * random.normal())).collect();
        channels.push(Channel::new(&format!("y{}", o + 1), "nm", noisy));
    }
    let record =
        Record::new(&format!("level {level}, seed {seed}"), TimeBase::uniform(RATE), channels).unwrap();
    AxesRecord::new(&record, &["u1".into(), "u2".into()], &["y1".into(), "y2".into()]).unwrap()
}
