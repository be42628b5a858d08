//! A plant in continuous time that is not the library's: exact exponentials, hysteresis by Runge–Kutta, each
//! voltage held for a period of the controller.

use std::f64::consts::TAU;

use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::invert::{InverseDrive, InverseOptions};
use hysteron_model::record::InterSample;

pub const RATE_HZ: f64 = 10_000.0;
/// Steps of the plant in a period of the controller.
pub const FINER: usize = 20;
pub const NATURAL: f64 = TAU * 280.0;
pub const DAMPING: f64 = 0.65;
pub const DELAY_S: f64 = 1.5e-4;
pub const ALPHA: f64 = 0.3;
pub const BETA: f64 = 0.12;
pub const GAMMA: f64 = -0.03;
pub const OFFSET: f64 = 0.4;

pub fn model() -> Model {
    let hysteresis = BoucWen::new(vec![1.1, 0.02, -0.001], ALPHA, BETA, GAMMA, 1.0).unwrap();
    let term = |coefficient, order| Term { coefficient, order };
    let numerator = vec![term(NATURAL * NATURAL, 0.0)];
    let denominator = vec![term(NATURAL * NATURAL, 0.0), term(2.0 * DAMPING * NATURAL, 1.0), term(1.0, 2.0)];
    Model {
        hysteresis: Hysteresis::from(hysteresis),
        dynamics: Dynamics::Integer(TransferFunction::new(numerator, denominator).unwrap()),
        offset: OFFSET,
        delay_s: DELAY_S,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: Some(2e4),
    }
}

/// Output of the plant [`FINER`] times a period, from rest, virgin, at `rest`.
pub fn plant(drive: &[f64], rest: f64) -> Vec<f64> {
    let on_time: Vec<usize> = (0..drive.len()).map(|k| k * FINER).collect();
    plant_with(drive, &on_time, rest)
}

/// The same, each voltage put out at a time of its own, in steps of the plant.
pub fn plant_with(drive: &[f64], at: &[usize], rest: f64) -> Vec<f64> {
    let mut z = 0.0;
    let mut u = rest;
    let v_of = |u: f64, z: f64| 1.1 * u + 0.02 * u * u - 0.001 * u * u * u - z;
    let mut held = Vec::new();
    for &next in drive {
        // z along the jump of the drive: dz/du = α − (β s sgn z + γ) |z|.
        let steps = 100;
        let du = (next - u) / f64::from(steps);
        let slope = |z: f64| ALPHA - (BETA * du.signum() * z.signum() + GAMMA) * z.abs();
        for _ in 0..steps {
            let a = slope(z);
            let b = slope(z + 0.5 * du * a);
            let c = slope(z + 0.5 * du * b);
            let d = slope(z + du * c);
            z += du / 6.0 * (a + 2.0 * b + 2.0 * c + d);
        }
        u = next;
        held.push(v_of(u, z));
    }
    let dt = 1.0 / (RATE_HZ * FINER as f64);
    let late = (DELAY_S / dt).round() as usize;
    let (sigma, omega) = (DAMPING * NATURAL, NATURAL * (1.0 - DAMPING * DAMPING).sqrt());
    let (mut x, mut rate) = (v_of(rest, 0.0), 0.0);
    let mut y = Vec::new();
    let mut arrived = 0;
    for k in 0..drive.len() * FINER {
        y.push(x + OFFSET);
        while at.get(arrived).is_some_and(|at| at + late <= k) {
            arrived += 1;
        }
        let v = if arrived == 0 { v_of(rest, 0.0) } else { held[arrived - 1] };
        // Free motion about v over dt, in closed form.
        let (e, c, s) = ((-sigma * dt).exp(), (omega * dt).cos(), (omega * dt).sin());
        let from = x - v;
        let quadrature = (rate + sigma * from) / omega;
        x = v + e * (from * c + quadrature * s);
        rate = e * ((quadrature * omega - sigma * from) * c - (from * omega + sigma * quadrature) * s);
    }
    y
}

/// About 5.5 µm, `amplitude` \[µm\] to either side.
pub fn sine(frequency_hz: f64, amplitude: f64, samples: usize, per_second: f64) -> impl Fn(usize) -> f64 {
    let whole = samples as f64 / per_second;
    // Grows from rest to its full amplitude in the first fifth.
    move |k| {
        let t = k as f64 / per_second;
        let grown = (t / (0.2 * whole)).min(1.0);
        let grown = grown * grown * (3.0 - 2.0 * grown);
        5.5 + amplitude * grown * (TAU * frequency_hz * t).sin()
    }
}

pub fn rms(x: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = x.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    (sum / count).sqrt()
}

pub fn roughness(u: &[f64]) -> f64 {
    rms(u.windows(3).map(|w| w[2] - 2.0 * w[1] + w[0]))
}

pub fn rest_of(drive: &InverseDrive) -> f64 {
    drive.rest.unwrap().voltage_v().unwrap()
}

pub fn options() -> InverseOptions {
    InverseOptions::within([-5.0, 25.0])
}

/// Error of the plant over what follows the growth, rms in per cent of stroke.
pub fn tracking_error(drive: &[f64], rest_v: f64, frequency_hz: f64, amplitude: f64, samples: usize) -> f64 {
    error_of(&plant(drive, rest_v), frequency_hz, amplitude, samples)
}

/// That of an output.
pub fn error_of(y: &[f64], frequency_hz: f64, amplitude: f64, samples: usize) -> f64 {
    let wanted = sine(frequency_hz, amplitude, samples * FINER, RATE_HZ * FINER as f64);
    let error = y.iter().enumerate().map(|(k, y)| y - wanted(k));
    let (from, to) = (samples * FINER * 3 / 10, samples * FINER * 9 / 10);
    100.0 * rms(error.skip(from).take(to - from)) / (2.0 * amplitude)
}
