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
        derivatives_are_differences(&kernel, &[], &u, ColumnStart::Virgin { u: rest }, 1e-12)?;
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
            model.simulate_every(1, u, PlayStart::Rest { u: 0.0 }, &mut [0.0; 2], &mut v).unwrap();
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
