//! Jiles–Atherton.

use super::*;

/// Not so near the ends of their ranges that a difference would leave them.
fn shape() -> impl Strategy<Value = [f64; 4]> {
    (0.5..3.0_f64, 0.3..3.0_f64, 0.01..0.99_f64, 0.01..0.8_f64)
        .prop_map(|(a, k, c, part)| [a, k, c, part * 3.0 * a])
}

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn laws(
        shape in shape(), u in drive(), between in 1..20_usize, moves in moves(), rest in -3.0..3.0_f64,
    ) {
        only_turning_points_count(&JilesAtherton, &shape, &u, between, 1e-12)?;
        odd(&JilesAtherton, &shape, &u, 1e-13)?;
        the_periodic_start_closes(&JilesAtherton, &shape, &u, 1e-11)?;
        // Susceptibility between 0 and 1/(3a − α).
        continuous(&JilesAtherton, &shape, &moves, 1.0 / (3.0 * shape[0] - shape[3]))?;
            a_memory_is_a_move(&JilesAtherton, &shape, &u, (rest, 0.5))?;
        derivatives_are_differences(&JilesAtherton, &shape, &u, Start::Rest { voltage_v: rest }, 1e-6)?;
    }

    #[test]
    fn derivatives_of_a_steady_state(shape in shape(), top in 3.0..6.0_f64, dip in -0.9..0.9_f64) {
        let u = [0.5 * top, top, dip * top, 0.3 * top, -top];
        derivatives_are_differences(&JilesAtherton, &shape, &u, Start::PERIODIC, 1e-6)?;
    }
}

#[test]
fn minor_loops_do_not_close() {
    let m = rows(&JilesAtherton, &[1.0, 2.0, 0.1, 0.5], &[7.0, -0.5, 1.0, -0.5], REST).concat();
    assert!((m[3] - m[1]).abs() > 0.01, "{m:?}");
}

#[test]
fn a_coupling_that_folds_the_anhysteretic_curve_is_refused() {
    let run = JilesAtherton.simulate_every(&[1.0, 0.5, 0.0, 3.0], 1, &[1.0], REST, &mut [0.0]);
    assert!(matches!(run, Err(HysteresisError::ShapeParameter { value: 3.0, .. })), "{run:?}");
}
