//! Draws what hysteresis in feedback looks like: loops of the restoring force, and a resonance that moves
//! with the force.
//!
//! ```text
//! cargo run --release -p hysteron-report --example oscillator -- FILE.svg
//! ```

use std::f64::consts::TAU;

use hysteron_model::Start;
use hysteron_model::hysteresis::RecordEnds;
use hysteron_model::oscillator::{Drive, Oscillator};
use hysteron_model::record::InterSample;
use hysteron_report::figure::{Axis, Figure, Panel, Series, Style};

/// In N, mm and s: 35.6 Hz at small motion, 25.2 Hz where the loop has saturated.
const DEVICE: Oscillator =
    Oscillator { mass: 2e-3, damping: 0.01, stiffness: 50.0, alpha: 50.0, beta: 0.9, gamma: 0.3, n: 1.0 };
/// Amplitudes of the force \[N\].
const FORCES: [f64; 3] = [3.0, 15.0, 40.0];
/// Points a period.
const POINTS: usize = 400;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("give the file to write")?;
    let mut loops =
        Panel::new(Axis::linear("displacement", "mm"), Axis::linear("restoring force k y + z", "N"));
    let mut resonance =
        Panel::new(Axis::linear("frequency", "Hz"), Axis::linear("displacement over force", "mm/N"));
    for (i, force) in FORCES.into_iter().enumerate() {
        let label = format!("{force} N");
        let (y, restoring) = steady(force, 20.0)?;
        loops = loops.series(Series::line(label.clone(), y, restoring, Style::nth(i)));
        let frequencies: Vec<f64> = (0..=120).map(|k| 15.0 + 0.25 * f64::from(k)).collect();
        let gain = |f: &f64| -> Result<f64, Box<dyn std::error::Error>> {
            let (y, _) = steady(force, *f)?;
            Ok(y.iter().fold(0.0, |m: f64, y| m.max(y.abs())) / force)
        };
        let gains = frequencies.iter().map(gain).collect::<Result<Vec<f64>, _>>()?;
        resonance = resonance.series(Series::line(label, frequencies, gains, Style::nth(i)));
    }
    let figure = Figure::new("A mass on a hysteretic spring, driven by sines of three amplitudes")
        .in_columns(2)
        .panel(loops.titled("Restoring force, 20 Hz"))
        .panel(resonance.titled("Largest displacement over force"));
    std::fs::write(path, figure.to_svg())?;
    Ok(())
}

/// Displacement and restoring force over one steady period (closed) under a sine of this amplitude \[N\] and
/// frequency \[Hz\].
fn steady(amplitude: f64, frequency_hz: f64) -> Result<(Vec<f64>, Vec<f64>), Box<dyn std::error::Error>> {
    let u: Vec<f64> = (0..POINTS).map(|k| amplitude * (TAU * k as f64 / POINTS as f64).sin()).collect();
    let rate = POINTS as f64 * frequency_hz;
    let drive = Drive::new(&u, rate, InterSample::Linear, RecordEnds::Periodic, 2)?;
    let mut y = vec![0.0; POINTS];
    let first = DEVICE.simulate(&drive, Start::PERIODIC, &mut y)?;
    y.push(first.y);
    let operator = hysteron_model::hysteresis::BoucWen::new(
        vec![0.0],
        DEVICE.alpha,
        DEVICE.beta,
        DEVICE.gamma,
        DEVICE.n,
    )?;
    let mut z = vec![0.0; y.len()];
    let start = hysteron_model::hysteresis::BoucWenState { u: first.y, z: first.z };
    operator.simulate(&y, Start::from(start), &mut z)?;
    // v = l[u] − z with l = 0.
    let restoring = y.iter().zip(&z).map(|(y, z)| DEVICE.stiffness * y - z).collect();
    Ok((y, restoring))
}
