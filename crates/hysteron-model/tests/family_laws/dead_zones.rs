//! Dead zones, and plays in front of them.

use super::*;

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn laws(u in drive(), moves in moves(), rest in -3.0..3.0_f64) {
        let kernel = DeadZones { thresholds: vec![-2.0, -0.5, 1.0, 3.0] };
        only_turning_points_count(&kernel, &[], &u, 7, 0.0)?;
        the_periodic_start_closes(&kernel, &[], &u, 0.0)?;
        continuous(&kernel, &[], &moves, 1.0)?;
        // Without memory.
        derivatives_are_differences(&kernel, &[], &u, Start::Rest { voltage_v: rest }, 1e-12)?;
    }

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
        share in 0.0..0.9_f64, reach in 0.3..5.0_f64, u in drive(), slopes in prop::array::uniform5(0.0..2.0_f64),
    ) {
        // Corners at −2, −1, 0, 1, 2; none at 0, since both bands beside it have one slope.
        let kernel = DeadZonePlays::regular([-3.0, 3.0], 3);
        let [a, b, c, d, e] = slopes;
        let bands = [a, b, c, c, d, e];
        let law: Vec<f64> = kernel.thresholds.iter().map(|r| (-r / reach).exp()).collect();
        let total: f64 = law.iter().sum();
        let weights = law.iter().map(|g| share * g / total).collect();
        let plays = PrandtlIshlinskii::new(vec![1.0 - share], kernel.thresholds.clone(), weights).unwrap();
        let thresholds = vec![-2.0, -1.0, 1.0, 2.0];
        let line = BrokenLine { linear: c, thresholds, weights: vec![a - b, b - c, d - c, e - d] };
        let model = ModifiedPrandtlIshlinskii::new(plays, line).unwrap();
        let mut v = vec![0.0; u.len()];
        model.simulate_every(1, &u, Start::Rest { voltage_v: 0.0 }, &mut [0.0; 3], &mut v).unwrap();
        let all = rows(&kernel, &[share, reach], &u, REST);
        let sum = |row: &[f64]| row[3..].iter().zip(bands).map(|(band, s)| s * band).sum::<f64>();
        let zero = sum(&rows(&kernel, &[share, reach], &[0.0], REST)[0]);
        for (row, v) in all.iter().zip(&v) {
            prop_assert!((sum(row) - zero - v).abs() < 1e-12, "{row:?} {v}");
        }
        for ((row, next), u) in all.iter().zip(&all[1..]).zip(u.windows(2)) {
            let rises = row.iter().zip(next).all(|(a, b)| (b - a) * (u[1] - u[0]) >= -1e-12);
            prop_assert!(rises, "{u:?} {row:?} {next:?}");
        }
    }

    #[test]
    fn the_modified_operator_remembers_turning_points_but_its_minor_loops_are_not_congruent(
        inner in vec(-3.0..5.0_f64, 0..8),
    ) {
        let plays = PrandtlIshlinskii::new(vec![0.3], vec![0.5, 2.0], vec![1.0, 0.6]).unwrap();
        let line = BrokenLine { linear: 1.0, thresholds: vec![-2.0, 3.0], weights: vec![0.4, -0.5] };
        let model = ModifiedPrandtlIshlinskii::new(plays, line).unwrap();
        let run = |u: &[f64]| {
            let mut v = vec![0.0; u.len()];
            model.simulate_every(1, u, Start::Rest { voltage_v: 0.0 }, &mut [0.0; 2], &mut v).unwrap();
            v
        };
        let plain = run(&[7.0, -3.0, -5.0]);
        let with = run(&[&[7.0, -3.0], &inner[..], &[-3.0, -5.0]].concat());
        prop_assert_eq!(plain[1], with[with.len() - 2]);
        prop_assert_eq!(plain[2], with[with.len() - 1]);
        // −1 … 1 V, after 7 V and after −7 V.
        let [above, below] = [7.0, -7.0].map(|from| run(&[from, -1.0, 1.0, -1.0]));
        prop_assert!(((above[2] - above[1]) - (below[2] - below[1])).abs() > 0.1);
    }
}
