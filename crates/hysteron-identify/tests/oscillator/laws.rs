//! Laws of the equations of motion that any simulation must keep.

use hysteron_model::Start;
use hysteron_model::hysteresis::{InterSample, RecordEnds};
use hysteron_model::oscillator::{Drive, Oscillator};
use proptest::prelude::*;

use crate::oracles::multisine;

fn simulate(p: &Oscillator, u: &[f64], rate: f64) -> Vec<f64> {
    let drive = Drive::new(u, rate, InterSample::Linear, RecordEnds::Open, 6).unwrap();
    let mut y = vec![0.0; u.len()];
    p.simulate(&drive, Start::AsIdentified, &mut y).unwrap();
    y
}

/// Oscillators in the bounded class: β ≥ |γ|.
fn oscillator() -> impl Strategy<Value = Oscillator> {
    (0.5..4.0f64, 1.0..40.0f64, 0.0..8e4f64, 1e4..8e4f64, 10.0..900.0f64, -1.0..1.0f64, 0..3usize).prop_map(
        |(mass, damping, stiffness, alpha, size, share, power)| {
            let n = [1.0, 1.5, 2.0][power];
            let beta = size * 50f64.powf(1.0 - n);
            Oscillator { mass, damping, stiffness, alpha, beta, gamma: share * beta, n }
        },
    )
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| x.abs().max(m))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_opposite_force_moves_it_the_opposite_way(p in oscillator(), seed in 1u64..1000) {
        let u = multisine(200, seed);
        let opposite: Vec<f64> = u.iter().map(|u| -u).collect();
        let (y, mirrored) = (simulate(&p, &u, 750.0), simulate(&p, &opposite, 750.0));
        prop_assert!(y.iter().zip(&mirrored).all(|(a, b)| *a == -b));
    }

    #[test]
    fn other_units_of_force_length_and_time_give_the_same_motion(
        p in oscillator(),
        seed in 1u64..1000,
        (force, length, time) in (0.1..10.0f64, 1e-3..1e6f64, 0.01..100.0f64),
    ) {
        let u = multisine(200, seed);
        let other = Oscillator {
            mass: p.mass * force * time * time / length,
            damping: p.damping * force * time / length,
            stiffness: p.stiffness * force / length,
            alpha: p.alpha * force / length,
            beta: p.beta * force.powf(1.0 - p.n) / length,
            gamma: p.gamma * force.powf(1.0 - p.n) / length,
            n: p.n,
        };
        let scaled: Vec<f64> = u.iter().map(|u| u * force).collect();
        let (y, in_other) = (simulate(&p, &u, 750.0), simulate(&other, &scaled, 750.0 / time));
        let bound = 1e-9 * largest(&y);
        prop_assert!(y.iter().zip(&in_other).all(|(a, b)| (a - b / length).abs() <= bound));
    }

    #[test]
    fn a_loop_of_the_bounded_class_takes_energy_out_of_every_period(p in oscillator(), seed in 1u64..1000) {
        // Over a steady period the work of the force, ∮ u dy, is what damping and loop dissipate. A loop that
        // slips holds the mass nowhere: without a spring beside it there need be no steady period.
        let p = Oscillator { stiffness: p.stiffness + 0.2 * p.alpha, ..p };
        let u = multisine(256, seed);
        let drive = Drive::new(&u, 750.0, InterSample::BandLimited, RecordEnds::Periodic, 8).unwrap();
        let mut y = vec![0.0; u.len()];
        let period = 256.0 / 750.0;
        p.simulate(&drive, Start::PERIODIC, &mut y).unwrap();
        let count = u.len();
        // Both are band-limited well enough for the spectral sum, here as central differences of high order.
        let slope = |x: &[f64], k: usize| {
            let at = |d: i64| x[(k as i64 + d).rem_euclid(count as i64) as usize];
            (45.0 * (at(1) - at(-1)) - 9.0 * (at(2) - at(-2)) + at(3) - at(-3)) / 60.0
        };
        let work: f64 = (0..count).map(|k| u[k] * slope(&y, k)).sum();
        let viscous: f64 =
            (0..count).map(|k| slope(&y, k).powi(2)).sum::<f64>() * p.damping * count as f64 / period;
        prop_assert!(work > 0.9 * viscous, "work {work}, dissipated by damping {viscous}");
    }
}
