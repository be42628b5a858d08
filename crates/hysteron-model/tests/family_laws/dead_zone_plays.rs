//! Plays in front of dead zones.

use super::*;

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn laws_of_plays_and_bands(
        share in 0.01..0.9_f64, reach in 0.3..5.0_f64, u in drive(), moves in moves(), rest in -3.0..3.0_f64,
        inner in vec(0.0..1.0_f64, 0..8),
    ) {
        let kernel = DeadZonePlays::regular([-4.0, 5.0], 4);
        let shape = [share, reach];
        only_turning_points_count(&kernel, &shape, &u, 7, 0.0)?;
        the_periodic_start_closes(&kernel, &shape, &u, 0.0)?;
        continuous(&kernel, &shape, &moves, 1.0)?;
        return_point_memory(&kernel, &shape, &u, &inner, 0.0)?;
        a_memory_is_a_move(&kernel, &shape, &u, (rest, 0.5))?;
        derivatives_are_differences(&kernel, &shape, &u, Start::Rest { voltage_v: rest }, 1e-6)?;
        derivatives_are_differences(&kernel, &shape, &u, Start::PERIODIC, 1e-6)?;
    }

    /// Bands of one slope each are Kuhnen's S(H\[u\]); no band falls where the voltage rises.
    #[test]
    fn bands_are_a_broken_line_of_the_plays(
        share in 0.0..0.9_f64,
        reach in 0.3..5.0_f64,
        u in drive(),
        slopes in prop::array::uniform5(0.0..2.0_f64),
    ) {
        // Corners at −2, −1, 0, 1, 2; none at 0, since both bands beside it have one slope.
        let kernel = DeadZonePlays::regular([-3.0, 3.0], 3);
        let [a, b, c, d, e] = slopes;
        let bands = [a, b, c, c, d, e];
        let law: Vec<f64> = kernel.thresholds.iter().map(|r| (-r / reach).exp()).collect();
        let total: f64 = law.iter().sum();
        let weights = law.iter().map(|g| share * g / total).collect();
        let plays = PrandtlIshlinskii::new(vec![1.0 - share], kernel.thresholds.clone(), weights).unwrap();
        let mut h = vec![0.0; u.len()];
        plays.simulate(&u, Start::Rest { voltage_v: 0.0 }, &mut [0.0; 3], &mut h).unwrap();
        // Kuhnen's S: the slope c about 0, and what each dead zone beyond a corner adds to it.
        let zones = [(-2.0, a - b), (-1.0, b - c), (1.0, d - c), (2.0, e - d)];
        let dead = |r: f64, x: f64| if r > 0.0 { (x - r).max(0.0) } else { (x - r).min(0.0) };
        let s = |x: f64| c * x + zones.iter().map(|(r, w)| w * dead(*r, x)).sum::<f64>();
        let v = h.into_iter().map(s);
        let all = rows(&kernel, &[share, reach], &u, REST);
        let sum = |row: &[f64]| row[3..].iter().zip(bands).map(|(band, s)| s * band).sum::<f64>();
        let zero = sum(&rows(&kernel, &[share, reach], &[0.0], REST)[0]);
        for (row, v) in all.iter().zip(v) {
            prop_assert!((sum(row) - zero - v).abs() < 1e-12, "{row:?} {v}");
        }
        for ((row, next), u) in all.iter().zip(&all[1..]).zip(u.windows(2)) {
            let rises = row.iter().zip(next).all(|(a, b)| (b - a) * (u[1] - u[0]) >= -1e-12);
            prop_assert!(rises, "{u:?} {row:?} {next:?}");
        }
    }

    #[test]
    fn turning_points_are_remembered_but_minor_loops_are_not_congruent(inner in vec(-3.0..5.0_f64, 0..8)) {
        let kernel = DeadZonePlays::regular([-4.0, 5.0], 4);
        let run = |u: &[f64]| rows(&kernel, &[0.6, 2.0], u, REST);
        let plain = run(&[7.0, -3.0, -5.0]);
        let with = run(&[&[7.0, -3.0], &inner[..], &[-3.0, -5.0]].concat());
        prop_assert_eq!(&plain[1], &with[with.len() - 2]);
        prop_assert_eq!(&plain[2], &with[with.len() - 1]);
        // −1 … 1 V, after 7 V and after −7 V: a band is cut elsewhere.
        let [above, below] = [7.0, -7.0].map(|from| run(&[from, -1.0, 1.0, -1.0]));
        let apart =
            (0..kernel.columns()).map(|j| ((above[2][j] - above[1][j]) - (below[2][j] - below[1][j])).abs());
        prop_assert!(apart.fold(0.0, f64::max) > 0.1);
    }
}
