//! The public Bouc–Wen benchmark (J. P. Noël, M. Schoukens, *Hysteretic benchmark with a dynamic
//! nonlinearity*, 2016) with its true parameters: the inter-sample rule of the drive decides the error.
//!
//! The data state no licence of their own: they are read through `HYSTERON_DATA` and the test is skipped
//! without.
#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use std::path::{Path, PathBuf};

use hysteron_model::hysteresis::{InterSample, RecordEnds};

/// Integration steps a sample.
const STEPS: usize = 40;

fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("HYSTERON_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from);
    let file = folder.join("boucwen-benchmark/test_multisine.csv");
    file.is_file().then_some(file)
}

/// Steady-state displacement under one period of force given at `2 * STEPS` points a sample:
/// m ÿ + c ẏ + k y + z = u, z following y; classical Runge–Kutta for y and ẏ, z stepped exactly along y.
fn steady_state(force: &[f64]) -> Vec<f64> {
    let (m, c, k) = (2.0, 10.0, 5e4);
    let operator = hysteron_rt::BoucWen::new(5e4, 800.0, -1100.0, 1.0).unwrap();
    let h = 1.0 / (750.0 * STEPS as f64);
    let (mut y, mut v, mut z) = (0.0, 0.0, 0.0);
    let mut out = Vec::new();
    for period in 0..2 {
        for (step, u) in force.chunks_exact(2).enumerate() {
            if period == 1 && step % STEPS == 0 {
                out.push(y);
            }
            let u_end = force[(2 * step + 2) % force.len()];
            let z_at = |dy: f64| operator.advance(z, dy).unwrap();
            let acceleration = |dy: f64, v: f64, u: f64| (u - c * v - k * (y + dy) - z_at(dy)) / m;
            let (v1, a1) = (v, acceleration(0.0, v, u[0]));
            let (v2, a2) = (v + 0.5 * h * a1, acceleration(0.5 * h * v1, v + 0.5 * h * a1, u[1]));
            let (v3, a3) = (v + 0.5 * h * a2, acceleration(0.5 * h * v2, v + 0.5 * h * a2, u[1]));
            let (v4, a4) = (v + h * a3, acceleration(h * v3, v + h * a3, u_end));
            let dy = h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
            v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
            z = z_at(dy);
            y += dy;
        }
    }
    out
}

#[test]
fn the_drive_between_samples_decides_the_error_on_the_public_benchmark() {
    let Some(file) = data() else {
        println!("skipped: boucwen-benchmark/test_multisine.csv not found (set HYSTERON_DATA)");
        return;
    };
    let text = std::fs::read_to_string(file).unwrap();
    let rows: Vec<(f64, f64)> = text
        .lines()
        .filter(|line| line.starts_with(|c: char| c.is_ascii_digit()))
        .map(|line| {
            let mut fields = line.split(',').skip(1).map(|field| field.trim().parse::<f64>().unwrap());
            (fields.next().unwrap(), fields.next().unwrap())
        })
        .collect();
    let (u, y): (Vec<f64>, Vec<f64>) = rows.into_iter().unzip();
    assert_eq!(u.len(), 8192);
    let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
    let error = |rule: InterSample| {
        let force = rule.upsample(&u, 2 * STEPS, RecordEnds::Periodic).unwrap();
        let difference: Vec<f64> = steady_state(&force).iter().zip(&y).map(|(a, b)| a - b).collect();
        100.0 * rms(&difference) / rms(&y)
    };
    let errors = [InterSample::Hold, InterSample::Linear, InterSample::BandLimited].map(error);
    println!("relative rms error, %: hold, linear, band-limited = {errors:?}");
    assert!((errors[0] - 16.0).abs() < 0.5, "hold: {} %", errors[0]);
    assert!((errors[1] - 1.1).abs() < 0.05, "linear: {} %", errors[1]);
    assert!((errors[2] - 0.035).abs() < 0.002, "band-limited: {} %", errors[2]);
}
