//! Promise: the error of each scheme for article Eq. 13 on a 1–100 Hz sweep at 10 kHz (1.7e-2, 7.2e-4, 1.8e-4
//! of the largest output), against a reference that owes nothing to any of them at that rate.
//!
//! Reference: Tustin at 16 and 32 times the rate, extrapolated to step 0 (Richardson, second order); 8 and 16
//! times give the same within 1e-10.

#![allow(clippy::unwrap_used)]

use hysteron_model::Start;
use std::f64::consts::TAU;

use hysteron_model::dynamics::{Scheme, SimulationPlan, TransferFunction};

const SAMPLES: usize = 10_000;

/// sin of the phase: zero at the start, but with a corner there. 1 − cos: smooth start.
fn simulate(fold: usize, scheme: Scheme, drive: fn(f64) -> f64) -> Vec<f64> {
    let (samples, fs) = (SAMPLES * fold, 1e4 * fold as f64);
    let input: Vec<f64> = (0..samples)
        .map(|k| {
            let t = k as f64 / fs;
            drive(TAU * (t + 49.5 * t * t))
        })
        .collect();
    let plan = SimulationPlan::new(samples, fs, scheme, Start::ZERO).unwrap();
    let mut output = vec![0.0; samples];
    plan.simulate(&TransferFunction::article_eq13(), &input, &mut plan.workspace(), &mut output).unwrap();
    output.into_iter().step_by(fold).collect()
}

fn extrapolated(fold: usize, drive: fn(f64) -> f64) -> Vec<f64> {
    let (coarse, fine) = (simulate(fold, Scheme::Tustin, drive), simulate(2 * fold, Scheme::Tustin, drive));
    coarse.iter().zip(&fine).map(|(coarse, fine)| (4.0 * fine - coarse) / 3.0).collect()
}

/// Largest difference over the samples `range`, over the largest reference value.
fn error(found: &[f64], reference: &[f64], range: std::ops::Range<usize>) -> f64 {
    let largest = reference.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let pairs = found[range.clone()].iter().zip(&reference[range]);
    pairs.fold(0.0f64, |m, (a, b)| m.max((a - b).abs())) / largest
}

#[test]
fn sweep_errors_are_the_published_ones() {
    let reference = extrapolated(16, f64::sin);
    assert!(error(&extrapolated(8, f64::sin), &reference, 0..SAMPLES) < 1e-10);
    let published =
        [(Scheme::GrunwaldLetnikov, 1.7e-2, 1.0), (Scheme::Bdf2, 7.2e-4, 2.0), (Scheme::Tustin, 1.8e-4, 2.0)];
    for (scheme, expected, order) in published {
        let found = error(&simulate(1, scheme, f64::sin), &reference, 0..SAMPLES);
        let halved = error(&simulate(2, scheme, f64::sin), &reference, 0..SAMPLES);
        println!("{scheme}: {found:.2e}, at half the step {halved:.2e}");
        // Published to two digits.
        assert!((found / expected - 1.0).abs() < 0.02, "{scheme}: {found:e}");
        assert!(((found / halved).log2() - order).abs() < 0.02, "{scheme}: {halved:e}");
    }
}

#[test]
fn band_limited_is_exact_where_the_input_is_band_limited() {
    // Smooth at its start, the drive is band-limited but for its end, where the continuation matters.
    let drive: fn(f64) -> f64 = |phase| 1.0 - phase.cos();
    let reference = extrapolated(16, drive);
    let found = simulate(1, Scheme::BandLimited, drive);
    let (inside, end) = (error(&found, &reference, 0..SAMPLES - 500), error(&found, &reference, 0..SAMPLES));
    println!("inside {inside:.1e}, at the end {end:.1e}");
    assert!(inside < 1e-10, "{inside:e}");
    assert!(end < 1e-6, "{end:e}");
    // A corner at the start is not band-limited.
    let corner = error(&simulate(1, Scheme::BandLimited, f64::sin), &extrapolated(16, f64::sin), 0..SAMPLES);
    println!("with a corner {corner:.1e}");
    assert!(corner < 1e-5, "{corner:e}");
}
