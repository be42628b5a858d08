//! Plays, one-sided plays and stops.

use super::*;

#[test]
fn a_stop_by_hand() {
    let kernel = MaxwellSlip { thresholds: vec![1.0] };
    let model = ColumnModel { polynomial: vec![1.0], kernel, shape: vec![1.0], weights: vec![-2.0] };
    assert_eq!(simulate(&model, &[0.5, 3.0, 2.0, -1.0], REST), [-0.5, 1.0, 2.0, 1.0]);
    // Dahl's exponent 0.
    let stop = column(&MaxwellSlip { thresholds: vec![1.0] }, &[1.0], &[0.5, 3.0, 2.5, 0.0], REST);
    assert_eq!(stop, column(&Dahl, &[1.0, 0.0], &[0.5, 3.0, 2.5, 0.0], REST));
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn stops_are_plays_in_other_coordinates(
        plays in prandtl_ishlinskii(), u in vec(-6.0..6.0_f64, 1..40), rest in -2.0..2.0_f64,
    ) {
        // l₁ + Σ w and stiffnesses −w.
        let mut polynomial = plays.polynomial.clone();
        polynomial[0] += plays.weights.iter().sum::<f64>();
        let kernel = MaxwellSlip { thresholds: plays.thresholds.clone() };
        let weights = plays.weights.iter().map(|w| -w).collect();
        let stops = ColumnModel { polynomial, kernel, shape: vec![1.0], weights };
        let mut states = vec![0.0; plays.weights.len()];
        let mut want = vec![0.0; u.len()];
        plays.simulate(&u, Start::Rest { voltage_v: rest }, &mut states, &mut want).unwrap();
        for (v, want) in simulate(&stops, &u, Start::Rest { voltage_v: rest }).iter().zip(&want) {
            prop_assert!((v - want).abs() < 1e-12 * (1.0 + want.abs()), "{v} {want}");
        }
        plays.simulate(&u, Start::PERIODIC, &mut states, &mut want).unwrap();
        for (v, want) in simulate(&stops, &u, Start::PERIODIC).iter().zip(&want) {
            prop_assert!((v - want).abs() < 1e-12 * (1.0 + want.abs()), "{v} {want}");
        }
    }

    #[test]
    fn a_one_sided_play_is_a_play_of_half_the_width(
        width in 0.2..4.0_f64, u in vec(0.0..6.0_f64, 1..40),
    ) {
        // Once both have been taken along, they differ by r/2.
        let u: Vec<f64> = [-10.0, 10.0].into_iter().chain(u).collect();
        let one = column(&OneSidedPlays { thresholds: vec![width] }, &[1.0], &u, REST);
        let play = play(0.5 * width, &u);
        for (one, play) in one.iter().zip(&play) {
            prop_assert!((one - (play - 0.5 * width)).abs() < 1e-14);
        }
    }
}
