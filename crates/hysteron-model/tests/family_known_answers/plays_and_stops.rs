//! Plays, one-sided plays and stops.

use super::*;

#[test]
fn a_stop_by_hand() {
    let model =
        ColumnModel::new(vec![1.0], MaxwellSlip { thresholds: vec![1.0] }, vec![1.0], vec![-2.0]).unwrap();
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
        let stops = ColumnModel::<MaxwellSlip>::from(&plays);
        stops.validate().unwrap();
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
        let back = PrandtlIshlinskii::from(&stops);
        prop_assert_eq!(&back.thresholds, &plays.thresholds);
        prop_assert_eq!(&back.weights, &plays.weights);
        prop_assert!((back.polynomial[0] - plays.polynomial[0]).abs() < 1e-14);
        prop_assert_eq!(&back.polynomial[1..], &plays.polynomial[1..]);
    }

    #[test]
    fn columns_of_plays_are_the_plays_of_prandtl_ishlinskii(
        plays in prandtl_ishlinskii(), scale in 0.3..3.0_f64, u in vec(-6.0..6.0_f64, 1..40),
    ) {
        let PrandtlIshlinskii { polynomial, thresholds, weights } = plays;
        let scaled = thresholds.iter().map(|r| scale * r).collect();
        let model = PrandtlIshlinskii::new(polynomial.clone(), scaled, weights.clone()).unwrap();
        let columns = ColumnModel::new(polynomial, Plays { thresholds }, vec![scale], weights).unwrap();
        let mut want = vec![0.0; u.len()];
        model.simulate(&u, Start::Rest { voltage_v: 1.0 }, &mut vec![0.0; model.weights.len()], &mut want).unwrap();
        for (v, want) in simulate(&columns, &u, Start::Rest { voltage_v: 1.0 }).iter().zip(&want) {
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
        let play = column(&Plays { thresholds: vec![0.5 * width] }, &[1.0], &u, REST);
        for (one, play) in one.iter().zip(&play) {
            prop_assert!((one - (play - 0.5 * width)).abs() < 1e-14);
        }
    }
}
