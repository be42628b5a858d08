//! Promise: laws of every family of hysteresis columns, whatever its parameters, and where a law does not hold.
#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron::hysteresis::{
    BrokenLine, ColumnKernel, ColumnSensitivities, ColumnStart, Dahl, DeadZones, DensityLaw, Duhem,
    GeneralisedPlays, HysteresisError, JilesAtherton, KrasnoselskiiPokrovskii, MaxwellSlip,
    ModifiedPrandtlIshlinskii, NonSymmetricBoucWen, OneSidedPlays, PlayStart, Plays, PrandtlIshlinskii,
    Preisach, PreisachDensity, SongDerKiureghian,
};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;

const REST: ColumnStart = ColumnStart::Virgin { u: 0.0 };

fn drive() -> impl Strategy<Value = Vec<f64>> {
    vec(-6.0..6.0_f64, 1..25)
}

/// `count` voltages on a monotone way, the last one `to`.
fn way(from: f64, to: f64, count: usize) -> impl Iterator<Item = f64> {
    let (low, high) = (from.min(to), from.max(to));
    (1..=count).map(move |k| {
        if k == count { to } else { (from + (to - from) * k as f64 / count as f64).clamp(low, high) }
    })
}

/// The voltages, each reached in `count` steps from the one before it (0 before the first).
fn dense(turns: &[f64], count: usize) -> Vec<f64> {
    let from = std::iter::once(&0.0).chain(turns);
    from.zip(turns).flat_map(|(&from, &to)| way(from, to, count)).collect()
}

/// Rows of K columns, one a sample.
fn rows<K: ColumnKernel>(kernel: &K, shape: &[f64], u: &[f64], start: ColumnStart) -> Vec<Vec<f64>> {
    let columns = kernel.columns();
    let mut out = vec![0.0; columns * u.len()];
    kernel.simulate_every(shape, 1, u, start, &mut out).unwrap();
    (0..u.len()).map(|k| (0..columns).map(|j| out[j * u.len() + k]).collect()).collect()
}

/// Largest difference of two rows.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn size(rows: &[Vec<f64>]) -> f64 {
    rows.iter().flatten().fold(1.0, |m: f64, x| m.max(x.abs()))
}

/// Samples between turning points change nothing; so do a factor and single steps.
fn only_turning_points_count<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    turns: &[f64],
    between: usize,
    tolerance: f64,
) -> TestCaseResult {
    let direct = rows(kernel, shape, turns, REST);
    let fine = dense(turns, between);
    let all = rows(kernel, shape, &fine, REST);
    let bound = tolerance * size(&all);
    for (a, b) in direct.iter().zip(all.iter().skip(between - 1).step_by(between)) {
        prop_assert!(apart(a, b) <= bound, "{a:?} {b:?}");
    }
    // Every `between`-th sample from the first turn on, after one move from rest.
    let columns = kernel.columns();
    let mut every = vec![0.0; columns * turns.len()];
    kernel.simulate_every(shape, between, &fine[between - 1..], REST, &mut every).unwrap();
    let mut state = kernel.virgin(shape, 0.0);
    let mut row = vec![0.0; columns];
    for (k, &u) in fine.iter().enumerate().skip(between - 1) {
        kernel.step(shape, &mut state, u, &mut row).unwrap();
        if (k + 1) % between == 0 {
            let at = (k + 1) / between - 1;
            let batch: Vec<f64> = (0..columns).map(|j| every[j * turns.len() + at]).collect();
            prop_assert_eq!(&row, &batch);
        }
    }
    Ok(())
}

/// −u gives minus the columns.
fn odd<K: ColumnKernel>(kernel: &K, shape: &[f64], u: &[f64], tolerance: f64) -> TestCaseResult {
    let mirrored: Vec<f64> = u.iter().map(|u| -u).collect();
    let (a, b) = (rows(kernel, shape, u, REST), rows(kernel, shape, &mirrored, REST));
    let bound = tolerance * size(&a);
    for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
        prop_assert!((a + b).abs() <= bound, "{a} {b}");
    }
    Ok(())
}

/// The periodic start closes the loop.
fn the_periodic_start_closes<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    u: &[f64],
    tolerance: f64,
) -> TestCaseResult {
    let count = kernel.columns() * u.len();
    let (mut first, mut second) = (vec![0.0; count], vec![0.0; count]);
    let mut state = kernel.simulate_every(shape, 1, u, ColumnStart::Periodic, &mut first).unwrap();
    kernel.continue_every(shape, &mut state, 1, u, &mut second).unwrap();
    let bound = tolerance * first.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
    prop_assert!(apart(&first, &second) <= bound, "{} {bound}", apart(&first, &second));
    Ok(())
}

/// |ΔH| ≤ slope |Δu| for moves of every size, most of them reversals.
fn continuous<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    moves: &[(f64, f64)],
    slope: f64,
) -> TestCaseResult {
    let mut u = vec![0.0];
    for &(to, exponent) in moves {
        let last = u[u.len() - 1];
        u.push(last + (to - last) * 10.0_f64.powf(exponent));
    }
    let all = rows(kernel, shape, &u, REST);
    let rounding = 1e-12 * size(&all);
    for (u, rows) in u.windows(2).zip(all.windows(2)) {
        prop_assert!(apart(&rows[0], &rows[1]) <= slope * (u[1] - u[0]).abs() + rounding);
    }
    Ok(())
}

fn moves() -> impl Strategy<Value = Vec<(f64, f64)>> {
    vec((-6.0..6.0_f64, -12.0..0.0_f64), 1..30)
}

/// Fourth-order central difference.
fn difference(step: f64, f: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| f(k * step));
    (0..a.len()).map(|i| ((a[i] - d[i]) + 8.0 * (c[i] - b[i])) / (12.0 * step)).collect()
}

/// Exact derivatives against differences of the plain simulation. Where differences of two step sizes disagree (a kink
/// between their points) nothing is compared; cases with many of them are rejected, of which proptest allows few.
fn derivatives_are_differences<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    u: &[f64],
    start: ColumnStart,
    tolerance: f64,
) -> TestCaseResult {
    let mut exact = ColumnSensitivities::default();
    kernel.simulate_with_sensitivities(shape, 1, u, start, &mut exact).unwrap();
    let plain = |shape: &[f64], start| {
        let mut out = vec![0.0; kernel.columns() * u.len()];
        kernel.simulate_every(shape, 1, u, start, &mut out).unwrap();
        out
    };
    let bound = |values: &[f64]| values.iter().fold(1.0, |m: f64, x| m.max(x.abs())) * tolerance;
    let value = plain(shape, start);
    prop_assert!(apart(&value, &exact.columns) <= 1e-4 * bound(&value));
    let moved = |index: usize, by: f64| {
        let mut shape = shape.to_vec();
        shape[index] += by;
        plain(&shape, start)
    };
    let mut wanted: Vec<(&[f64], [Vec<f64>; 2])> = exact
        .d_shape
        .iter()
        .enumerate()
        .map(|(i, d)| {
            let step = 1e-4 * shape[i].abs().max(0.1);
            (d.as_slice(), [step, 0.3 * step].map(|step| difference(step, |by| moved(i, by))))
        })
        .collect();
    if let ColumnStart::Virgin { u: at } = start {
        let from = |by: f64| plain(shape, ColumnStart::Virgin { u: at + by });
        wanted.push((&exact.d_start, [1e-4, 3e-5].map(|step| difference(step, from))));
    } else {
        prop_assert!(exact.d_start.iter().all(|d| *d == 0.0));
    }
    for (d, [coarse, fine]) in wanted {
        let bound = bound(d);
        let mut kinks = 0;
        for ((d, coarse), fine) in d.iter().zip(&coarse).zip(&fine) {
            if (coarse - fine).abs() > bound {
                kinks += 1;
            } else {
                prop_assert!((d - fine).abs() <= 2.0 * bound, "{d} {fine}");
            }
        }
        // A play that only just moves has a kink wherever it stands from then on: another case, then.
        prop_assume!(4 * kinks <= d.len());
    }
    Ok(())
}

/// After a larger excursion and back nothing is left of what was before; an inner loop closes.
fn return_point_memory<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    history: &[f64],
    inner: &[f64],
    tolerance: f64,
) -> TestCaseResult {
    let straight = rows(kernel, shape, &[-7.0, 7.0, 1.0], REST);
    let after = rows(kernel, shape, &[history, &[-7.0, 7.0, 1.0]].concat(), REST);
    let bound = tolerance * size(&after);
    let last = |rows: &[Vec<f64>]| rows[rows.len() - 1].clone();
    prop_assert!(apart(&last(&straight), &last(&after)) <= bound);
    // From 7 V down to −3 V; a detour between −3 and 5 V; on to −5 V.
    let detour: Vec<f64> = inner.iter().map(|share| -3.0 + 8.0 * share).collect();
    let plain = rows(kernel, shape, &[-7.0, 7.0, -3.0, -5.0], REST);
    let with = rows(kernel, shape, &[&[-7.0, 7.0, -3.0], &detour[..], &[-3.0, -5.0]].concat(), REST);
    let at = with.len() - 2;
    prop_assert!(apart(&plain[2], &with[at]) <= bound, "{:?} {:?}", plain[2], with[at]);
    prop_assert!(apart(&plain[3], &with[at + 1]) <= bound);
    Ok(())
}

/// Loops between the same voltages have the same form after every history.
fn congruent<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    histories: [&[f64]; 2],
    ends: (f64, f64),
    tolerance: f64,
) -> TestCaseResult {
    let period: Vec<f64> = way(ends.0, ends.1, 9).chain(way(ends.1, ends.0, 9)).collect();
    let [a, b] = histories.map(|history| {
        let all = rows(kernel, shape, &[history, &[ends.0], &period, &period].concat(), REST);
        all[all.len() - period.len() - 1..].to_vec()
    });
    let bound = tolerance * size(&a);
    for (x, y) in a.iter().zip(&b) {
        for (j, (x, y)) in x.iter().zip(y).enumerate() {
            prop_assert!(((x - a[0][j]) - (y - b[0][j])).abs() <= bound, "{x} {y}");
        }
    }
    Ok(())
}

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        failure_persistence: None,
        max_global_rejects: cases,
        ..ProptestConfig::with_cases(cases)
    }
}

mod duhem {
    use super::*;

    fn model() -> impl Strategy<Value = (Duhem, [f64; 1])> {
        (0..5_usize, 0.02..2.0_f64).prop_map(|(degree, rate)| (Duhem { degree }, [rate]))
    }

    proptest! {
        #![proptest_config(config(150))]

        #[test]
        fn laws(
            (kernel, shape) in model(), u in drive(), between in 1..20_usize, moves in moves(), rest in -3.0..3.0_f64,
        ) {
            only_turning_points_count(&kernel, &shape, &u, between, 1e-12)?;
            odd(&Duhem { degree: 0 }, &shape, &u, 1e-15)?;
            the_periodic_start_closes(&kernel, &shape, &u, 1e-12)?;
            // |y'| ≤ |u|ʲ + b |y|, |y| ≤ 6ʲ/b.
            continuous(&kernel, &shape, &moves, 2.0 * 6.0_f64.powi(kernel.degree as i32))?;
            derivatives_are_differences(&kernel, &shape, &u, ColumnStart::Virgin { u: rest }, 1e-8)?;
            let period = [&[-2.0, 3.0], &u[..]].concat();
            derivatives_are_differences(&kernel, &shape, &period, ColumnStart::Periodic, 1e-8)?;
        }
    }

    #[test]
    fn a_period_that_never_moves_determines_no_derivative() {
        let mut out = ColumnSensitivities::default();
        let run = Duhem { degree: 0 }.simulate_with_sensitivities(
            &[0.3],
            1,
            &[2.0, 2.0],
            ColumnStart::Periodic,
            &mut out,
        );
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
}

mod dahl {
    use super::*;

    proptest! {
        #![proptest_config(config(150))]

        #[test]
        fn laws(
            reach in 0.2..8.0_f64, exponent in prop_oneof![0.2..3.0_f64, Just(1.0), 0.9999..1.0001_f64],
            u in drive(), between in 1..20_usize, moves in moves(), rest in -3.0..3.0_f64,
        ) {
            let shape = [reach, exponent];
            only_turning_points_count(&Dahl, &shape, &u, between, 1e-12)?;
            odd(&Dahl, &shape, &u, 1e-15)?;
            the_periodic_start_closes(&Dahl, &shape, &u, 1e-11)?;
            // (1 − s ζ/u_c)ⁱ ≤ 2ⁱ.
            continuous(&Dahl, &shape, &moves, 8.0)?;
            if exponent >= 0.9 {
                derivatives_are_differences(&Dahl, &shape, &u, ColumnStart::Virgin { u: rest }, 1e-7)?;
            }
        }

        #[test]
        fn derivatives_of_a_steady_state(
            reach in 0.5..8.0_f64, exponent in 0.9..2.0_f64, top in 1.0..6.0_f64, dip in -0.9..0.9_f64,
        ) {
            let u = [0.5 * top, top, dip * top, 0.3 * top, -top];
            derivatives_are_differences(&Dahl, &[reach, exponent], &u, ColumnStart::Periodic, 1e-7)?;
        }
    }
}

mod plays_and_stops {
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
        derivatives_are_differences(kernel, shape, u, ColumnStart::Virgin { u: rest }, 1e-8)?;
        derivatives_are_differences(kernel, shape, u, ColumnStart::Periodic, 1e-8)
    }

    proptest! {
        #![proptest_config(config(100))]

        #[test]
        fn laws(
            thresholds in thresholds(), scale in 0.3..3.0_f64, u in drive(), moves in moves(), rest in -3.0..3.0_f64,
            inner in vec(0.0..1.0_f64, 0..8),
        ) {
            let record = (&u[..], &moves[..], rest);
            let plays = Plays { thresholds: thresholds.clone() };
            laws_of(&plays, &[scale], record, &inner)?;
            odd(&plays, &[scale], &u, 0.0)?;
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
}

mod generalised_plays {
    use super::*;

    /// Thresholds wide enough for any envelopes of these shapes: |γ_r − γ_l| < 0.6.
    fn model() -> impl Strategy<Value = (GeneralisedPlays, Vec<f64>)> {
        let shape = (0.15..0.2_f64, -0.5..0.5_f64, 0.15..0.2_f64, -0.5..0.5_f64);
        (vec(0.02..0.2_f64, 1..5), shape).prop_map(|(gaps, (a, b, c, d))| {
            let mut r = 0.3;
            let mut next = |gap: f64| {
                r += gap;
                r
            };
            let thresholds = gaps.into_iter().map(&mut next).collect();
            (GeneralisedPlays { thresholds }, vec![a, b, c, d])
        })
    }

    proptest! {
        #![proptest_config(config(100))]

        #[test]
        fn laws(
            (kernel, shape) in model(), u in drive(), moves in moves(), rest in -3.0..3.0_f64,
            inner in vec(0.0..1.0_f64, 0..8),
        ) {
            only_turning_points_count(&kernel, &shape, &u, 7, 0.0)?;
            the_periodic_start_closes(&kernel, &shape, &u, 0.0)?;
            continuous(&kernel, &shape, &moves, 0.2)?;
            return_point_memory(&kernel, &shape, &u, &inner, 0.0)?;
            congruent(&kernel, &shape, [&u, &[]], (-3.0, 2.0), 1e-14)?;
            derivatives_are_differences(&kernel, &shape, &u, ColumnStart::Virgin { u: rest }, 1e-8)?;
            derivatives_are_differences(&kernel, &shape, &u, ColumnStart::Periodic, 1e-8)?;
            // Envelopes that mirror each other.
            odd(&kernel, &[shape[0], shape[1], shape[0], -shape[1]], &u, 1e-15)?;
        }
    }

    #[test]
    fn envelopes_that_cross_too_far_are_refused_where_they_do() {
        let kernel = GeneralisedPlays { thresholds: vec![0.1] };
        let shape = [1.0, -1.0, 1.0, 1.0];
        let run = kernel.simulate_every(&shape, 1, &[20.0, 0.0], REST, &mut [0.0; 2]);
        assert!(matches!(run, Err(HysteresisError::Envelopes { u: 0.0, .. })), "{run:?}");
    }
}

mod krasnoselskii_pokrovskii {
    use super::*;

    const KERNEL: KrasnoselskiiPokrovskii = KrasnoselskiiPokrovskii { range: [-4.0, 4.0], lines: 5 };

    proptest! {
        #![proptest_config(config(60))]

        #[test]
        fn laws(
            rise in 0.3..6.0_f64, u in drive(), moves in moves(), rest in -3.0..3.0_f64,
            inner in vec(0.0..1.0_f64, 0..8),
        ) {
            let shape = [rise];
            only_turning_points_count(&KERNEL, &shape, &u, 7, 0.0)?;
            the_periodic_start_closes(&KERNEL, &shape, &u, 0.0)?;
            continuous(&KERNEL, &shape, &moves, 2.0 / rise)?;
            return_point_memory(&KERNEL, &shape, &u, &inner, 0.0)?;
            congruent(&KERNEL, &shape, [&u, &[]], (-3.0, 2.0), 1e-14)?;
            derivatives_are_differences(&KERNEL, &shape, &u, ColumnStart::Virgin { u: rest }, 1e-8)?;
            derivatives_are_differences(&KERNEL, &shape, &u, ColumnStart::Periodic, 1e-8)?;
            // A grid symmetric about 0: the column of (p₁, p₂) mirrored is that of (−p₂, −p₁).
            let mirrored: Vec<f64> = u.iter().map(|u| -u).collect();
            let (a, b) = (rows(&KERNEL, &shape, &u, REST), rows(&KERNEL, &shape, &mirrored, REST));
            let at = |i: usize, j: usize| i * (i + 1) / 2 + j;
            for (a, b) in a.iter().zip(&b) {
                for i in 0..5 {
                    for j in 0..=i {
                        prop_assert!((a[at(i, j)] + b[at(4 - j, 4 - i)]).abs() <= 1e-15);
                    }
                }
            }
        }
    }
}

mod dead_zones {
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
}

mod preisach {
    use super::*;

    fn plane() -> impl Strategy<Value = Preisach> {
        vec(0.5..3.0_f64, 1..6).prop_map(|gaps| {
            let mut at = -5.0;
            let above = gaps.into_iter().map(|gap| {
                at += gap;
                at
            });
            Preisach { levels: std::iter::once(-5.0).chain(above).collect() }
        })
    }

    proptest! {
        #![proptest_config(config(100))]

        #[test]
        fn laws(
            plane in plane(), u in drive(), moves in moves(), rest in -3.0..3.0_f64, inner in vec(0.0..1.0_f64, 0..8),
        ) {
            only_turning_points_count(&plane, &[], &u, 7, 1e-13)?;
            the_periodic_start_closes(&plane, &[], &u, 1e-13)?;
            continuous(&plane, &[], &moves, 2.0 / 0.5)?;
            return_point_memory(&plane, &[], &u, &inner, 1e-13)?;
            congruent(&plane, &[], [&u, &[]], (-3.0, 2.0), 1e-13)?;
            derivatives_are_differences(&plane, &[], &u, ColumnStart::Virgin { u: rest }, 1e-8)?;
        }

        #[test]
        fn a_plane_symmetric_about_zero_is_odd(u in drive(), count in 2..7_usize) {
            // The cell (i, j) mirrored is (n − 1 − j, n − 1 − i).
            let plane = Preisach::regular([-4.0, 4.0], count);
            let n = count - 1;
            let mirrored: Vec<f64> = u.iter().map(|u| -u).collect();
            let (a, b) = (rows(&plane, &[], &u, REST), rows(&plane, &[], &mirrored, REST));
            let at = |i: usize, j: usize| i * (i + 1) / 2 + j;
            for (a, b) in a.iter().zip(&b) {
                for i in 0..n {
                    for j in 0..=i {
                        prop_assert!((a[at(i, j)] + b[at(n - 1 - j, n - 1 - i)]).abs() <= 1e-13);
                    }
                }
            }
        }
    }

    proptest! {
        #![proptest_config(config(25))]

        #[test]
        fn laws_of_a_density(
            law in prop_oneof![Just(DensityLaw::Gaussian), Just(DensityLaw::Lorentzian)],
            half_width in 0.5..2.0_f64, spreads in (0.5..2.0_f64, 0.5..2.0_f64), bias in -1.0..1.0_f64,
            u in drive(), rest in -3.0..3.0_f64, inner in vec(0.0..1.0_f64, 0..8),
        ) {
            let kernel = PreisachDensity { plane: Preisach::regular([-5.0, 5.0], 9), law };
            let shape = [half_width, spreads.0, bias, spreads.1];
            only_turning_points_count(&kernel, &shape, &u, 7, 1e-13)?;
            the_periodic_start_closes(&kernel, &shape, &u, 1e-13)?;
            return_point_memory(&kernel, &shape, &u, &inner, 1e-13)?;
            congruent(&kernel, &shape, [&u, &[]], (-3.0, 2.0), 1e-13)?;
            odd(&kernel, &[half_width, spreads.0, 0.0, spreads.1], &u, 1e-13)?;
            derivatives_are_differences(&kernel, &shape, &u, ColumnStart::Virgin { u: rest }, 1e-8)?;
            derivatives_are_differences(&kernel, &shape, &u, ColumnStart::Periodic, 1e-8)?;
        }
    }
}

mod jiles_atherton {
    use super::*;

    fn shape() -> impl Strategy<Value = [f64; 4]> {
        (0.5..3.0_f64, 0.3..3.0_f64, 0.0..1.0_f64, 0.0..0.8_f64)
            .prop_map(|(a, k, c, part)| [a, k, c, part * 3.0 * a])
    }

    proptest! {
        #![proptest_config(config(60))]

        #[test]
        fn laws(
            shape in shape(), u in drive(), between in 1..20_usize, moves in moves(), rest in -3.0..3.0_f64,
        ) {
            only_turning_points_count(&JilesAtherton, &shape, &u, between, 1e-12)?;
            odd(&JilesAtherton, &shape, &u, 1e-13)?;
            the_periodic_start_closes(&JilesAtherton, &shape, &u, 1e-11)?;
            // Susceptibility between 0 and 1/(3a − α).
            continuous(&JilesAtherton, &shape, &moves, 1.0 / (3.0 * shape[0] - shape[3]))?;
            derivatives_are_differences(&JilesAtherton, &shape, &u, ColumnStart::Virgin { u: rest }, 1e-6)?;
        }

        #[test]
        fn derivatives_of_a_steady_state(shape in shape(), top in 3.0..6.0_f64, dip in -0.9..0.9_f64) {
            let u = [0.5 * top, top, dip * top, 0.3 * top, -top];
            derivatives_are_differences(&JilesAtherton, &shape, &u, ColumnStart::Periodic, 1e-6)?;
        }
    }

    #[test]
    fn minor_loops_do_not_close() {
        let m = rows(&JilesAtherton, &[1.0, 2.0, 0.1, 0.5], &[7.0, -0.5, 1.0, -0.5], REST).concat();
        assert!((m[3] - m[1]).abs() > 0.01, "{m:?}");
    }

    #[test]
    fn a_coupling_that_folds_the_anhysteretic_curve_is_refused() {
        let run = JilesAtherton.simulate_every(&[1.0, 0.5, 0.0, 3.0], 1, &[1.0], REST, &mut [0.0]);
        assert!(matches!(run, Err(HysteresisError::ShapeParameter { value: 3.0, .. })), "{run:?}");
    }
}

mod asymmetric_bouc_wen {
    use super::*;

    proptest! {
        #![proptest_config(config(60))]

        #[test]
        fn laws_of_six_coefficients(
            first in 0.6..1.5_f64, others in prop::array::uniform5(-0.1..0.1_f64),
            n in prop_oneof![Just(1.0), Just(2.0), 1.0..3.0_f64],
            u in drive(), between in 1..20_usize, moves in moves(), rest in -3.0..3.0_f64,
        ) {
            let [a, b, c, d, e] = others;
            let shape = [first, a, b, c, d, e];
            let kernel = SongDerKiureghian { n };
            only_turning_points_count(&kernel, &shape, &u, between, 1e-11)?;
            the_periodic_start_closes(&kernel, &shape, &u, 1e-11)?;
            // 1 + (β' + |γ'|) |ζ|ⁿ with |ζ|ⁿ ≤ 1/(β' − |γ'|).
            continuous(&kernel, &shape, &moves, 1.0 + 2.0 / 0.1)?;
            odd(&kernel, &[first, a, b, 0.0, 0.0, 0.0], &u, 1e-13)?;
            derivatives_are_differences(&kernel, &shape, &u, ColumnStart::Virgin { u: rest }, 1e-6)?;
            let period = [&[-4.0, 4.0], &u[..]].concat();
            derivatives_are_differences(&kernel, &shape, &period, ColumnStart::Periodic, 1e-6)?;
        }

        #[test]
        fn laws_of_the_delta_term(
            beta in 0.2..1.5_f64, part in -0.9..0.9_f64, delta in -0.3..0.3_f64,
            u in drive(), between in 1..20_usize, moves in moves(), rest in -3.0..3.0_f64,
        ) {
            let shape = [beta, part * beta, delta];
            only_turning_points_count(&NonSymmetricBoucWen, &shape, &u, between, 1e-11)?;
            the_periodic_start_closes(&NonSymmetricBoucWen, &shape, &u, 1e-11)?;
            // |ζ'| ≤ 1 + |δ| 6 + 2β |ζ|, |ζ| ≤ (1 + |δ| 6)/(β − |γ|).
            continuous(&NonSymmetricBoucWen, &shape, &moves, (1.0 + 1.8) * (1.0 + 2.0 / 0.1))?;
            odd(&NonSymmetricBoucWen, &shape, &u, 1e-13)?;
            derivatives_are_differences(&NonSymmetricBoucWen, &shape, &u, ColumnStart::Virgin { u: rest }, 1e-6)?;
            let period = [&[-4.0, 4.0], &u[..]].concat();
            derivatives_are_differences(&NonSymmetricBoucWen, &shape, &period, ColumnStart::Periodic, 1e-6)?;
        }
    }

    #[test]
    fn minor_loops_of_bouc_wen_do_not_close() {
        let shape = [0.5, 0.2, 0.0];
        assert!(return_point_memory(&NonSymmetricBoucWen, &shape, &[], &[1.0], 1e-3).is_err());
        assert!(congruent(&NonSymmetricBoucWen, &shape, [&[], &[6.0]], (-0.5, 0.5), 1e-3).is_err());
    }
}
