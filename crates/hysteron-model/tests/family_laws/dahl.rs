//! Dahl.

use super::*;

proptest! {
    #![proptest_config(config(150))]

    #[test]
    fn laws(
        reach in 0.2..8.0_f64, exponent in prop_oneof![0.2..3.0_f64, Just(1.0), 0.9999..1.0001_f64],
        u in drive(), between in 1..20_usize, moves in moves(), rest in -3.0..3.0_f64,
    ) {
        let shape = [reach, exponent];
        only_turning_points_count(&Dahl, &shape, &u, between, 1e-12)?;
        odd(&Dahl, &shape, &u, 1e-15)?;
        the_periodic_start_closes(&Dahl, &shape, &u, 1e-11)?;
        // (1 − s ζ/u_c)ⁱ ≤ 2ⁱ.
        continuous(&Dahl, &shape, &moves, 8.0)?;
        if exponent >= 0.9 {
            derivatives_are_differences(&Dahl, &shape, &u, Start::Rest { voltage_v: rest }, 1e-7)?;
        }
    }

    #[test]
    fn derivatives_of_a_steady_state(
        reach in 0.5..8.0_f64, exponent in 0.9..2.0_f64, top in 1.0..6.0_f64, dip in -0.9..0.9_f64,
    ) {
        let u = [0.5 * top, top, dip * top, 0.3 * top, -top];
        derivatives_are_differences(&Dahl, &[reach, exponent], &u, Start::PERIODIC, 1e-7)?;
    }
}
