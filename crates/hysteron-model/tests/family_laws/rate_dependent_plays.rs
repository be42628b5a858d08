//! Plays that widen with the rate, as columns.

use super::*;

/// The columns against their definition, play by play.
fn columns_as_defined(u: &[f64], gain: f64, interval_s: f64, periodic: bool) -> TestCaseResult {
    let thresholds = [0.4, 1.1, 2.5];
    let kernel = RateDependentPlays { thresholds: thresholds.to_vec(), interval_s };
    let start = if periodic { Start::PERIODIC } else { REST };
    let all = rows(&kernel, &[1.0, gain], u, start);
    for (j, r) in thresholds.into_iter().enumerate() {
        let low_high = u.iter().fold([u[0]; 2], |[low, high], &u| [low.min(u), high.max(u)]);
        let (mut play, mut before) =
            if periodic { (0.5 * (low_high[0] + low_high[1]), u[u.len() - 1]) } else { (0.0, u[0]) };
        // A period more where the drive repeats.
        for pass in if periodic { 0..2 } else { 1..2 } {
            for (k, &u) in u.iter().enumerate() {
                let half_width = r + gain * ((u - before) / interval_s).abs();
                play = play.clamp(u - half_width, u + half_width);
                before = u;
                if pass == 1 {
                    prop_assert!((all[k][j] - play).abs() < 1e-12 * (1.0 + play.abs()), "{k} {j}");
                }
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn laws(
        gain in 0.01..0.3_f64,
        scale in 0.3..2.0_f64,
        interval_s in 0.05..2.0_f64,
        u in drive(),
        rest in -3.0..3.0_f64,
    ) {
        let kernel = RateDependentPlays { thresholds: vec![0.5, 1.5, 3.0], interval_s };
        let shape = [scale, gain];
        the_periodic_start_closes(&kernel, &shape, &u, 0.0)?;
        a_memory_is_a_move(&kernel, &shape, &u, (rest, 0.5))?;
        derivatives_are_differences(&kernel, &shape, &u, Start::Rest { voltage_v: rest }, 1e-6)?;
        derivatives_are_differences(&kernel, &shape, &u, Start::PERIODIC, 1e-6)?;
        columns_as_defined(&u, gain, interval_s, false)?;
        columns_as_defined(&u, gain, interval_s, true)?;
    }

    #[test]
    fn without_a_gain_they_are_plays_whatever_the_time(
        scale in 0.3..2.0_f64, interval_s in 1e-6..2.0_f64, u in drive(),
    ) {
        let thresholds = vec![0.5, 1.5, 3.0];
        let kernel = RateDependentPlays { thresholds: thresholds.clone(), interval_s };
        for (j, r) in thresholds.into_iter().enumerate() {
            let mut play = 0.0_f64;
            for (row, u) in rows(&kernel, &[scale, 0.0], &u, REST).iter().zip(&u) {
                play = play.clamp(u - scale * r, u + scale * r);
                prop_assert_eq!(row[j], play);
            }
        }
    }

    /// Twice as fast with half the gain is the same.
    #[test]
    fn time_enters_with_the_gain_alone(gain in 0.0..0.3_f64, u in drive()) {
        let kernel = |interval_s| RateDependentPlays { thresholds: vec![0.5, 1.5], interval_s };
        let slow = rows(&kernel(0.5), &[1.0, gain], &u, REST);
        let fast = rows(&kernel(0.25), &[1.0, 0.5 * gain], &u, REST);
        prop_assert_eq!(slow, fast);
    }
}

#[test]
fn a_family_that_sees_the_rate_asks_for_the_time() {
    let form = "rate-dependent-plays".parse::<HysteresisForm>().unwrap().with_elements(2).unwrap();
    let model = form.operator(vec![1.0], &[0.5, 0.2], &[3.0, 0.1]).unwrap();
    let origin = Start::Rest { voltage_v: 0.0 };
    let untimed = model.simulate_every(1, &[0.0, 1.0], origin, &mut [0.0; 2]);
    assert!(matches!(untimed, Err(HysteresisError::Interval)));
    assert!(matches!(FamilyStream::new(&model, None), Err(HysteresisError::Interval)));
    // r = 1 and 2 V; at 10 V/s the first is 2 V wide and the second 3 V.
    let mut v = [0.0; 5];
    let grid = DriveGrid::new(Some(10.0), 1, 1);
    model.simulate_every(grid, &[0.0, 1.0, 2.0, 3.0, 3.0], origin, &mut v).unwrap();
    assert_eq!(v, [0.0, 1.0, 2.0, 3.5, 4.2]);
}
