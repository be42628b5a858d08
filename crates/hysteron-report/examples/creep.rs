//! Draws what follows a unit step with each kind of creep, and the frequency response.
//!
//! ```text
//! cargo run --release -p hysteron-report --example creep -- FILE.svg
//! ```

use hysteron_model::dynamics::{Creep, DynamicForm, DynamicsError, Modes, Scheme, TransferFunction};
use hysteron_report::figure::{Axis, Figure, Panel, Series, Style};

/// Samples over which each decade of time is simulated.
const SAMPLES: usize = 2000;

/// Kinds with parameters that agree at about one second.
const KINDS: [(&str, Creep, &[f64]); 3] = [
    ("fractional: k = 0.05, μ = 0.15", Creep::Fractional, &[0.05, 0.15]),
    ("logarithmic: γ = 0.02, t₀ = 0.01 s", Creep::Logarithmic, &[0.02, 0.01]),
    (
        "Kelvin–Voigt: k = 0.03 and 0.03, τ = 0.1 s and 10 s",
        Creep::KelvinVoigt { elements: 2 },
        &[0.03, 0.1, 0.03, 10.0],
    ),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("give the file to write")?;
    let mut steps = Panel::new(Axis::log("time", "s"), Axis::linear("after a unit step", ""));
    let mut response = Panel::new(Axis::log("frequency", "Hz"), Axis::linear("gain", ""));
    for (index, (label, creep, p)) in KINDS.into_iter().enumerate() {
        let tf = DynamicForm { modes: Modes::None, creep }.transfer_function(p)?;
        let (time, y) = step(&tf)?;
        steps = steps.series(Series::line(label, time, y, Style::nth(index)));
        let frequency_hz: Vec<f64> = (-80..=40).map(|k| 10f64.powf(0.05 * f64::from(k))).collect();
        let gain = tf.frequency_response(&frequency_hz, 0.0).iter().map(|g| g.norm()).collect();
        response = response.series(Series::line(label, frequency_hz, gain, Style::nth(index)));
    }
    let figure = Figure::new("Creep of three kinds")
        .subtitled("simulated")
        .in_columns(2)
        .panel(steps.titled("Step"))
        .panel(response.titled("Frequency response"));
    std::fs::write(path, figure.to_svg())?;
    Ok(())
}

/// Step response from 1 ms to 10 000 s, each decade at a sample rate of its own.
fn step(tf: &TransferFunction) -> Result<(Vec<f64>, Vec<f64>), DynamicsError> {
    let (mut time, mut y) = (Vec::new(), Vec::new());
    for decade in -2..=4 {
        let end = 10f64.powi(decade);
        let rate = (SAMPLES - 1) as f64 / end;
        let response = tf.step_response(SAMPLES, rate, Scheme::Tustin)?;
        for k in (SAMPLES / 10..SAMPLES).step_by(20) {
            time.push(k as f64 / rate);
            y.push(response[k]);
        }
    }
    Ok((time, y))
}
