//! Plays that widen with the rate.

use super::*;

/// Polynomial and plays that widen by λ = `gain` times the rate.
fn rate_dependent(
    PrandtlIshlinskii { polynomial, thresholds, weights }: &PrandtlIshlinskii,
    gain: f64,
    u: &[f64],
    rate_hz: f64,
    start: Start<f64>,
) -> Vec<f64> {
    let kernel = RateDependentPlays { thresholds: thresholds.clone(), interval_s: 1.0 / rate_hz };
    let (polynomial, weights) = (polynomial.clone(), weights.clone());
    simulate(&ColumnModel { polynomial, kernel, shape: vec![1.0, gain], weights }, u, start)
}

#[test]
fn a_play_that_widens_with_the_rate_by_hand() {
    // r = 1 V, λ = 0.1 s; at 10 Hz a step of 1 V is 10 V/s and the half-width 2 V. Standing still it is 1 V
    // again.
    let model = PrandtlIshlinskii::new(vec![1.0], vec![1.0], vec![1.0]).unwrap();
    let u = [0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 3.5];
    let v = rate_dependent(&model, 0.1, &u, 10.0, Start::Rest { voltage_v: 0.0 });
    assert_eq!(v, [0.0, 1.0, 2.0, 4.0, 6.0, 7.0, 6.5]);
}

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn rate_dependent_plays_of_a_constant_rate_are_wider_plays(
        plays in prandtl_ishlinskii(), gain in 0.0..0.5_f64, step in 0.01..0.2_f64,
    ) {
        // A triangle between ±10 V or so in steps of one size, at 5 Hz.
        let top = (10.0 / step).round() as i32;
        let u: Vec<f64> = (-top..top).chain((1 - top..=top).rev()).map(|k| f64::from(k) * step).collect();
        let model = plays.clone();
        let PrandtlIshlinskii { polynomial, thresholds, weights } = plays;
        let wider = thresholds.iter().map(|r| r + gain * step * 5.0).collect();
        let plain = PrandtlIshlinskii::new(polynomial, wider, weights).unwrap();
        let mut want = vec![0.0; u.len()];
        plain.simulate(&u, Start::PERIODIC, &mut vec![0.0; plain.weights.len()], &mut want).unwrap();
        for (v, want) in rate_dependent(&model, gain, &u, 5.0, Start::PERIODIC).iter().zip(&want) {
            prop_assert!((v - want).abs() < 1e-10 * (1.0 + want.abs()), "{v} {want}");
        }
    }

    #[test]
    fn rate_dependent_plays_close_their_period_and_a_slower_drive_has_a_narrower_loop(
        plays in prandtl_ishlinskii(), u in vec(-6.0..6.0_f64, 2..30), gain in 0.0..0.5_f64,
    ) {
        let twice: Vec<f64> = u.iter().chain(&u).copied().collect();
        let once = rate_dependent(&plays, gain, &u, 3.0, Start::PERIODIC);
        let both = rate_dependent(&plays, gain, &twice, 3.0, Start::PERIODIC);
        prop_assert_eq!(&both[..u.len()], &once[..]);
        prop_assert_eq!(&both[u.len()..], &once[..]);
        // One play, a sine: the width at 0 V grows with the rate.
        let one = PrandtlIshlinskii::new(vec![1.0], vec![0.5], vec![1.0]).unwrap();
        let sine: Vec<f64> =
            (0..1000).map(|k| 5.0 * (std::f64::consts::TAU * f64::from(k) / 1000.0).sin()).collect();
        let width = |rate_hz: f64| {
            let v = rate_dependent(&one, 0.01, &sine, rate_hz, Start::PERIODIC);
            v[500] - v[0]
        };
        // 2 (r + λ 2π f A) at f = 1 and 2 Hz, the rate that of the chord.
        prop_assert!((width(1000.0) - 2.0 * (0.5 + 0.01 * 31.415_9)).abs() < 1e-4);
        prop_assert!((width(2000.0) - 2.0 * (0.5 + 0.02 * 31.415_9)).abs() < 1e-4);
    }
}
