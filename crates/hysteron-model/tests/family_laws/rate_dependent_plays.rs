//! Plays that widen with the rate, as columns.

use super::*;

/// A kernel without rate, and the operator of the same plays as its oracle.
fn columns_of_the_operator(u: &[f64], gain: f64, interval_s: f64, periodic: bool) -> TestCaseResult {
    let (thresholds, weights) = (vec![0.4, 1.1, 2.5], vec![0.7, 0.3, 0.2]);
    let kernel = RateDependentPlays { thresholds: thresholds.clone(), interval_s };
    let model = RateDependentPrandtlIshlinskii::new(vec![1.0], thresholds, weights.clone(), gain).unwrap();
    let (start, own) =
        if periodic { (Start::PERIODIC, Start::PERIODIC) } else { (REST, Start::Rest { voltage_v: 0.0 }) };
    let mut v = vec![0.0; u.len()];
    model.simulate_every(1, u, 1.0 / interval_s, own, &mut [0.0; 3], &mut v).unwrap();
    for ((row, u), v) in rows(&kernel, &[1.0, gain], u, start).iter().zip(u).zip(&v) {
        let sum: f64 = row.iter().zip(&weights).map(|(h, w)| h * w).sum();
        prop_assert!((u + sum - v).abs() < 1e-12 * (1.0 + v.abs()), "{row:?} {v}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn laws(
        gain in 0.01..0.3_f64, scale in 0.3..2.0_f64, interval_s in 0.05..2.0_f64, u in drive(), rest in -3.0..3.0_f64,
    ) {
        let kernel = RateDependentPlays { thresholds: vec![0.5, 1.5, 3.0], interval_s };
        let shape = [scale, gain];
        the_periodic_start_closes(&kernel, &shape, &u, 0.0)?;
        a_memory_is_a_move(&kernel, &shape, &u, (rest, 0.5))?;
        derivatives_are_differences(&kernel, &shape, &u, Start::Rest { voltage_v: rest }, 1e-6)?;
        derivatives_are_differences(&kernel, &shape, &u, Start::PERIODIC, 1e-6)?;
        columns_of_the_operator(&u, gain, interval_s, false)?;
        columns_of_the_operator(&u, gain, interval_s, true)?;
    }

    #[test]
    fn without_a_gain_they_are_plays_whatever_the_time(
        scale in 0.3..2.0_f64, interval_s in 1e-6..2.0_f64, u in drive(),
    ) {
        let thresholds = vec![0.5, 1.5, 3.0];
        let kernel = RateDependentPlays { thresholds: thresholds.clone(), interval_s };
        let plays = Plays { thresholds };
        prop_assert_eq!(rows(&kernel, &[scale, 0.0], &u, REST), rows(&plays, &[scale], &u, REST));
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
    let form = FamilyForm::RateDependentPlays { plays: 2 };
    let model = Family::new(vec![1.0], form, vec![3.0, 0.1], vec![0.5, 0.2]).unwrap();
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
