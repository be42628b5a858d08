//! One-sided plays and stops.

use super::*;

fn thresholds() -> impl Strategy<Value = Vec<f64>> {
    vec(0.1..1.5_f64, 1..6).prop_map(|gaps| {
        let sums = gaps.iter().scan(0.0, |sum, gap| {
            *sum += gap;
            Some(*sum)
        });
        sums.collect()
    })
}

fn laws_of<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    (u, moves, rest): (&[f64], &[(f64, f64)], f64),
    inner: &[f64],
) -> TestCaseResult {
    only_turning_points_count(kernel, shape, u, 7, 0.0)?;
    the_periodic_start_closes(kernel, shape, u, 0.0)?;
    continuous(kernel, shape, moves, 1.0)?;
    return_point_memory(kernel, shape, u, inner, 0.0)?;
    congruent(kernel, shape, [u, &[]], (-3.0, 2.0), 1e-14)?;
    derivatives_are_differences(kernel, shape, u, Start::Rest { voltage_v: rest }, 1e-8)?;
    derivatives_are_differences(kernel, shape, u, Start::PERIODIC, 1e-8)
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn laws(
        thresholds in thresholds(),
        scale in 0.3..3.0_f64,
        u in drive(),
        moves in moves(),
        rest in -3.0..3.0_f64,
        inner in vec(0.0..1.0_f64, 0..8),
    ) {
        let record = (&u[..], &moves[..], rest);
        laws_of(&OneSidedPlays { thresholds: thresholds.clone() }, &[scale], record, &inner)?;
        let stops = MaxwellSlip { thresholds };
        laws_of(&stops, &[scale], record, &inner)?;
        odd(&stops, &[scale], &u, 0.0)?;
    }
}

#[test]
fn one_sided_plays_are_not_odd() {
    let kernel = OneSidedPlays { thresholds: vec![1.0] };
    assert!(odd(&kernel, &[1.0], &[2.0, -2.0], 0.1).is_err());
}
