//! Duhem.

use super::*;

fn model() -> impl Strategy<Value = (Duhem, [f64; 1])> {
    (0..5_usize, 0.02..2.0_f64).prop_map(|(degree, rate)| (Duhem { degree }, [rate]))
}

proptest! {
    #![proptest_config(config(150))]

    #[test]
    fn laws(
        (kernel, shape) in model(),
        u in drive(),
        between in 1..20_usize,
        moves in moves(),
        rest in -3.0..3.0_f64,
    ) {
        only_turning_points_count(&kernel, &shape, &u, between, 1e-12)?;
        odd(&Duhem { degree: 0 }, &shape, &u, 1e-15)?;
        the_periodic_start_closes(&kernel, &shape, &u, 1e-12)?;
        // |y'| ≤ |u|ʲ + b |y|, |y| ≤ 6ʲ/b.
        continuous(&kernel, &shape, &moves, 2.0 * 6.0_f64.powi(kernel.degree as i32))?;
            a_memory_is_a_move(&kernel, &shape, &u, (rest, 0.5))?;
        derivatives_are_differences(&kernel, &shape, &u, Start::Rest { voltage_v: rest }, 1e-8)?;
        let period = [&[-2.0, 3.0], &u[..]].concat();
        derivatives_are_differences(&kernel, &shape, &period, Start::PERIODIC, 1e-8)?;
    }
}

#[test]
fn a_period_that_never_moves_determines_no_derivative() {
    let mut out = ColumnSensitivities::default();
    let run =
        Duhem { degree: 0 }.simulate_with_sensitivities(&[0.3], 1, &[2.0, 2.0], Start::PERIODIC, &mut out);
    assert_eq!(run, Err(HysteresisError::NotContracting { slope: 1.0 }));
}

#[test]
fn minor_loops_do_not_close_and_memory_fades_instead() {
    // 7 V, −3 V, up to 5 V, back to −3 V: not where it was.
    let (kernel, shape) = (Duhem { degree: 0 }, [0.3]);
    let y: Vec<f64> = rows(&kernel, &shape, &[7.0, -3.0, 5.0, -3.0], REST).concat();
    assert!((y[3] - y[1]).abs() > 0.05, "{y:?}");
    assert!(return_point_memory(&kernel, &shape, &[2.0], &[1.0], 1e-3).is_err());
    // Between the same ends loops become congruent only after many periods.
    assert!(congruent(&kernel, &shape, [&[], &[6.0]], (-1.0, 1.0), 1e-3).is_err());
}
