//! Plays with thermally activated edges: against a plain integration of their equation, and in the limits
//! where they are known.

use super::*;
use hysteron_model::hysteresis::{ActivatedPlays, DriveGrid};
use hysteron_model::record::paces_on;
use hysteron_rt::RelaxingMove;

/// z after the equation's own Runge–Kutta steps; z = 0 is where the speed has a corner, and small steps.
fn integrated(sigma: f64, r: f64, mut z: f64, rate: f64, seconds: f64) -> f64 {
    let speed = |z: f64| rate - if z == 0.0 { 0.0 } else { z.signum() * ((z.abs() - r) / sigma).exp() };
    let mut left = seconds;
    while left > 0.0 {
        let fastest = rate.abs() + ((z.abs() - r) / sigma).exp();
        let h = left.min(2e-3 * sigma / fastest);
        let a = speed(z);
        let b = speed(z + 0.5 * h * a);
        z += h * b;
        left -= h;
    }
    z
}

proptest! {
    #![proptest_config(config(200))]

    #[test]
    fn a_move_solves_its_equation(
        sigma in 0.05..0.4_f64,
        r in 0.3..2.0_f64,
        start in -1.0..1.0_f64,
        by in -3.0..3.0_f64,
        seconds in 0.01..5.0_f64,
    ) {
        // From within the reach of the play.
        let z = start * (r + 0.3);
        let got = RelaxingMove::new(sigma, by, seconds).distance(r, z);
        let want = integrated(sigma, r, z, by / seconds, seconds);
        prop_assert!((got - want).abs() < 5e-3 * sigma, "{got} {want}");
    }

    #[test]
    fn a_move_in_parts_is_one_move(
        sigma in 0.05..0.4_f64,
        r in 0.1..2.0_f64,
        start in -1.0..1.0_f64,
        by in -3.0..3.0_f64,
        seconds in 0.01..5.0_f64,
        share in 0.01..0.99_f64,
    ) {
        let z = start * r;
        let whole = RelaxingMove::new(sigma, by, seconds).distance(r, z);
        let first = RelaxingMove::new(sigma, share * by, share * seconds).distance(r, z);
        let both = RelaxingMove::new(sigma, (1.0 - share) * by, (1.0 - share) * seconds).distance(r, first);
        prop_assert!((whole - both).abs() < 1e-12, "{whole} {both}");
    }

    #[test]
    fn without_activation_they_are_plays(u in vec(-6.0..6.0_f64, 1..30), r in 0.1..3.0_f64) {
        let sigma = 1e-4;
        let (mut z, mut from) = (0.0, 0.0);
        for (p, &u) in play(r, &u).iter().zip(&u) {
            z = RelaxingMove::new(sigma, u - from, 1.0).distance(r, z);
            from = u;
            // Wider by σ ln(rate/v₀).
            prop_assert!((u - z - p).abs() < 10.0 * sigma, "{} {p}", u - z);
        }
    }
}

#[test]
fn a_play_that_stands_still_creeps_with_the_logarithm_of_time() {
    // |z| = r − σ ln(v₀ t/σ) once t is beyond what it had: σ ln 10 for each decade.
    let (sigma, r) = (0.2, 3.0);
    let at = |seconds: f64| RelaxingMove::new(sigma, 0.0, seconds).distance(r, 3.0);
    let decade: f64 = at(1e4) - at(1e5);
    assert!((decade - sigma * 10f64.ln()).abs() < 1e-3 * sigma, "{decade}");
    // Ten times the rate: wider by σ ln 10.
    let width = |seconds: f64| RelaxingMove::new(sigma, 20.0, seconds).distance(r, 0.0);
    let wider: f64 = width(1.0) - width(10.0);
    assert!((wider - sigma * 10f64.ln()).abs() < 1e-9, "{wider}");
    // And it comes to rest, where it has nothing left.
    assert_eq!(RelaxingMove::new(sigma, 0.0, 1e9).distance(0.1, 0.05), 0.0);
}

#[test]
fn columns_add_up_to_the_drive_where_nothing_holds_the_plays() {
    // Slopes of one: Σ_k B_k = p − low; plays that follow at once are the drive.
    let kernel = ActivatedPlays::new([0.0, 10.0], 1, 1e12);
    let mut out = [0.0; 9];
    kernel.simulate_every(&[0.05], 1, &[2.0, -1.0, 11.0], Start::Rest { voltage_v: 2.0 }, &mut out).unwrap();
    for (k, u) in [2.0, -1.0, 11.0].into_iter().enumerate() {
        let sum: f64 = (0..3).map(|j| out[3 * j + k]).sum();
        assert!((sum - u).abs() < 0.05 * 10.0, "{sum} {u}");
    }
}

#[test]
fn stamps_and_an_even_grid_agree() {
    let u: Vec<f64> = (0..200).map(|k| 5.0 - 5.0 * (0.05 * f64::from(k)).cos()).collect();
    let times: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
    let kernel = ActivatedPlays::new([0.0, 10.0], 3, 0.01);
    let run = |grid: DriveGrid<'_>| {
        let mut out = vec![0.0; 9 * u.len()];
        kernel.simulate_every(&[0.2], grid, &u, Start::Rest { voltage_v: 0.0 }, &mut out).unwrap();
        out
    };
    let paces = paces_on(&times, &u);
    let (even, stamped) = (run(DriveGrid::new(Some(100.0), 1, 1)), run(DriveGrid::of_paces(&paces, 1)));
    assert!(even.iter().zip(&stamped).all(|(a, b)| (a - b).abs() < 1e-12));
}
