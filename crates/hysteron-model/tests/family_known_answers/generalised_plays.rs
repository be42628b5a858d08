//! Generalised plays and Krasnosel'skii–Pokrovskii kernels.

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
        let shape = vec![rise, centre, rise, centre];
        let model = ColumnModel { polynomial: vec![0.0], kernel, shape, weights: weights.clone() };
        let plays = PrandtlIshlinskii::new(vec![0.0], thresholds, weights).unwrap();
        let through: Vec<f64> = u.iter().map(|&u| gamma(u)).collect();
        let mut want = vec![0.0; u.len()];
        plays.simulate(&through, Start::Rest { voltage_v: gamma(rest) }, &mut [0.0; 3], &mut want).unwrap();
        for (v, want) in simulate(&model, &u, Start::Rest { voltage_v: rest }).iter().zip(&want) {
            prop_assert!((v - want).abs() < 1e-14, "{v} {want}");
        }
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
                let play = play(0.5 * (high - low), &u);
                let at = (i * (i + 1) / 2 + j) * u.len();
                for (xi, play) in out[at..at + u.len()].iter().zip(&play) {
                    prop_assert!((xi - (play - 0.5 * (low + high)) / 20.0).abs() < 1e-14);
                }
            }
        }
    }
}
