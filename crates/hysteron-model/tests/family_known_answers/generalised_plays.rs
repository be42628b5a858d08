//! Generalised plays, Krasnosel'skii–Pokrovskii kernels, dead zones and the modified operator.

use super::*;

#[test]
fn a_generalised_play_by_hand() {
    // γ_r = tanh(u − 1), γ_l = tanh(u + 1), r = 0.2: between them from rest, which is 0.
    let play = column(
        &GeneralisedPlays { thresholds: vec![0.2] },
        &[1.0, 1.0, 1.0, -1.0],
        &[0.5, 2.0, 1.0, -1.0],
        REST,
    );
    let want = [0.0, 1.0_f64.tanh() - 0.2, 1.0_f64.tanh() - 0.2, 0.2];
    for (play, want) in play.iter().zip(want) {
        assert!((play - want).abs() < 1e-15, "{play} {want}");
    }
}

#[test]
fn a_kernel_of_krasnoselskii_and_pokrovskii_by_hand() {
    // Grid {−1, 1}, ramps of 2 V: column 1 is (−1, 1), up from 0 to 2 V, down from 0 to −2 V.
    let kernel = KrasnoselskiiPokrovskii { range: [-1.0, 1.0], lines: 2 };
    let u = [0.5, 1.5, 0.0, -1.25, -0.5, 0.25, 3.0];
    let mut out = [0.0; 21];
    kernel.simulate_every(&[2.0], 1, &u, REST, &mut out).unwrap();
    assert_eq!(out[7..14], [0.0, 0.5, 0.5, -0.25, -0.25, -0.25, 1.0]);
    // Equal ends: the ramp itself.
    assert_eq!(out[..7], u.map(|u: f64| (u + 1.0).clamp(-1.0, 1.0)));
    assert_eq!(out[14..], u.map(|u: f64| (u - 1.0).clamp(-1.0, 1.0)));
}

#[test]
fn a_broken_line_by_hand() {
    let line = BrokenLine { linear: 1.0, thresholds: vec![-1.0, 2.0], weights: vec![1.0, -0.5] };
    for (x, y) in [(-3.0, -5.0), (-1.0, -1.0), (0.5, 0.5), (2.0, 2.0), (4.0, 3.0)] {
        assert_eq!(line.at(x), y);
    }
    let inverse = line.inverse().unwrap();
    assert_eq!(inverse, BrokenLine { linear: 1.0, thresholds: vec![-1.0, 2.0], weights: vec![-0.5, 1.0] });
    let falling = BrokenLine { weights: vec![1.0, -1.5], ..line };
    assert_eq!(falling.inverse(), Err(HysteresisError::PartialSlope { plays: 1, slope: -0.5 }));
    assert_eq!(column(&DeadZones { thresholds: vec![1.0] }, &[], &[0.5, 3.0, -2.0], REST), [0.0, 2.0, 0.0]);
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn generalised_plays_between_equal_envelopes_are_plays_of_the_envelope(
        rise in 0.05..0.5_f64, centre in -1.0..1.0_f64, weights in vec(-1.0..1.0_f64, 3),
        u in vec(-6.0..6.0_f64, 1..40), rest in -2.0..2.0_f64,
    ) {
        let thresholds = vec![0.1, 0.25, 0.6];
        let gamma = |u: f64| (rise * (u - centre)).tanh();
        let kernel = GeneralisedPlays { thresholds: thresholds.clone() };
        let model =
            ColumnModel::new(vec![0.0], kernel, vec![rise, centre, rise, centre], weights.clone()).unwrap();
        let plays = PrandtlIshlinskii::new(vec![0.0], thresholds, weights).unwrap();
        let through: Vec<f64> = u.iter().map(|&u| gamma(u)).collect();
        let mut want = vec![0.0; u.len()];
        plays.simulate(&through, Start::Rest { voltage_v: gamma(rest) }, &mut [0.0; 3], &mut want).unwrap();
        for (v, want) in simulate(&model, &u, Start::Rest { voltage_v: rest }).iter().zip(&want) {
            prop_assert!((v - want).abs() < 1e-14, "{v} {want}");
        }
    }

    #[test]
    fn the_inverse_of_generalised_plays_gives_the_output_back(
        right in (0.1..0.3_f64, 0.0..0.5_f64), left in (0.1..0.3_f64, -0.5..0.0_f64),
        weights in vec(0.05..1.0_f64, 4), shares in vec(-0.9..0.9_f64, 1..30),
    ) {
        let kernel = GeneralisedPlays { thresholds: vec![0.25, 0.35, 0.4, 0.6] };
        let shape = vec![right.0, right.1, left.0, left.1];
        // Within reach of every play: Σ w (1 − r) less something.
        let top: f64 = kernel.thresholds.iter().zip(&weights).map(|(r, w)| w * (1.0 - r)).sum();
        let model = ColumnModel::new(vec![0.0], kernel, shape.clone(), weights.clone()).unwrap();
        let mut state = model.kernel.virgin(&shape, 0.0);
        let mut row = [0.0; 4];
        for share in shares {
            let v = share * top;
            let u = model.inverse_step(&state, v).unwrap();
            model.kernel.step(&shape, &mut state, u, &mut row).unwrap();
            let got: f64 = row.iter().zip(&weights).map(|(f, w)| f * w).sum();
            prop_assert!((got - v).abs() < 1e-13, "{got} {v}");
        }
        let beyond = model.inverse_step(&state, 2.0 * top);
        let refused = matches!(beyond, Err(HysteresisError::OutOfReach { .. }));
        prop_assert!(refused, "{beyond:?}");
    }

    #[test]
    fn kernels_within_their_ramps_are_plays(u in vec(-6.0..6.0_f64, 1..40)) {
        // Ramps of 40 V: ξ = (2/a) (F_r − (p₁ + p₂)/2), r = (p₂ − p₁)/2.
        let kernel = KrasnoselskiiPokrovskii { range: [-3.0, 3.0], lines: 4 };
        let mut out = vec![0.0; 10 * u.len()];
        kernel.simulate_every(&[40.0], 1, &u, REST, &mut out).unwrap();
        for i in 0..4 {
            for j in 0..i {
                let (low, high) = (kernel.line(j), kernel.line(i));
                let play = column(&Plays { thresholds: vec![0.5 * (high - low)] }, &[1.0], &u, REST);
                let at = (i * (i + 1) / 2 + j) * u.len();
                for (xi, play) in out[at..at + u.len()].iter().zip(&play) {
                    prop_assert!((xi - (play - 0.5 * (low + high)) / 20.0).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn the_modified_operator_and_its_inverse_undo_each_other(
        weights in vec(0.0..1.0_f64, 3), line in vec(-0.2..1.0_f64, 4), u in vec(-6.0..6.0_f64, 1..40),
    ) {
        let plays = PrandtlIshlinskii::new(vec![0.5], vec![0.5, 1.0, 2.5], weights).unwrap();
        let line = BrokenLine { linear: 0.8, thresholds: vec![-3.0, -0.5, 1.0, 2.0], weights: line };
        let model = ModifiedPrandtlIshlinskii::new(plays, line).unwrap();
        let start = Start::Rest { voltage_v: 0.0 };
        let (mut v, mut back) = (vec![0.0; u.len()], vec![0.0; u.len()]);
        model.simulate_every(1, &u, start, &mut [0.0; 3], &mut v).unwrap();
        model.inverse().unwrap().simulate(&v, start, &mut [0.0; 3], &mut back).unwrap();
        for (u, back) in u.iter().zip(&back) {
            prop_assert!((u - back).abs() < 1e-12, "{u} {back}");
        }
    }
}
