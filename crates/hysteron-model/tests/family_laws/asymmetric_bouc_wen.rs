//! Bouc–Wen with asymmetric extensions.

use super::*;

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn laws_of_six_coefficients(
        first in 0.6..1.5_f64, others in prop::array::uniform5(-0.1..0.1_f64),
        u in drive(), between in 1..20_usize, moves in moves(), rest in -3.0..3.0_f64,
    ) {
        let [a, b, c, d, e] = others;
        let shape = [first, a, b, c, d, e];
        only_turning_points_count(&SongDerKiureghian, &shape, &u, between, 1e-11)?;
        the_periodic_start_closes(&SongDerKiureghian, &shape, &u, 1e-11)?;
        // 1 + (β' + |γ'|) |ζ| with |ζ| ≤ 1/(β' − |γ'|).
        continuous(&SongDerKiureghian, &shape, &moves, 1.0 + 2.0 / 0.1)?;
        odd(&SongDerKiureghian, &[first, a, b, 0.0, 0.0, 0.0], &u, 1e-13)?;
        derivatives_are_differences(&SongDerKiureghian, &shape, &u, Start::Rest { voltage_v: rest }, 1e-6)?;
        let period = [&[-4.0, 4.0], &u[..]].concat();
        derivatives_are_differences(&SongDerKiureghian, &shape, &period, Start::PERIODIC, 1e-6)?;
    }

    #[test]
    fn laws_of_the_delta_term(
        beta in 0.2..1.5_f64, part in -0.9..0.9_f64, delta in -0.3..0.3_f64,
        u in drive(), between in 1..20_usize, moves in moves(), rest in -3.0..3.0_f64,
    ) {
        let shape = [beta, part * beta, delta];
        only_turning_points_count(&NonSymmetricBoucWen, &shape, &u, between, 1e-11)?;
        the_periodic_start_closes(&NonSymmetricBoucWen, &shape, &u, 1e-11)?;
        // |ζ'| ≤ 1 + |δ| 6 + 2β |ζ|, |ζ| ≤ (1 + |δ| 6)/(β − |γ|).
        continuous(&NonSymmetricBoucWen, &shape, &moves, (1.0 + 1.8) * (1.0 + 2.0 / 0.1))?;
        odd(&NonSymmetricBoucWen, &shape, &u, 1e-13)?;
        derivatives_are_differences(&NonSymmetricBoucWen, &shape, &u, Start::Rest { voltage_v: rest }, 1e-6)?;
        let period = [&[-4.0, 4.0], &u[..]].concat();
        derivatives_are_differences(&NonSymmetricBoucWen, &shape, &period, Start::PERIODIC, 1e-6)?;
    }
}

#[test]
fn minor_loops_of_bouc_wen_do_not_close() {
    let shape = [0.5, 0.2, 0.0];
    assert!(return_point_memory(&NonSymmetricBoucWen, &shape, &[], &[1.0], 1e-3).is_err());
    assert!(congruent(&NonSymmetricBoucWen, &shape, [&[], &[6.0]], (-0.5, 0.5), 1e-3).is_err());
}

#[test]
fn six_coefficients_that_run_away_are_an_error_with_its_sample() {
    let run = SongDerKiureghian.simulate_every(
        &[-1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        1,
        &[1.0, 800.0],
        REST,
        &mut [0.0; 2],
    );
    assert!(matches!(run, Err(HysteresisError::RunsAway { index: 1, .. })), "{run:?}");
}
