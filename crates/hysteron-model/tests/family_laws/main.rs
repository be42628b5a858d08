//! Promise: laws of every family of hysteresis columns, whatever its parameters, and where a law does not
//! hold.
// Helpers outside the test functions; a failure is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

mod any_input;
mod asymmetric_bouc_wen;
mod dahl;
mod dead_zone_plays;
mod duhem;
mod generalised_plays;
mod jiles_atherton;
mod krasnoselskii_pokrovskii;
mod plays_and_stops;
mod preisach;
mod rate_dependent_plays;

use hysteron_model::Start;
use hysteron_model::hysteresis::{
    ColumnKernel, ColumnSensitivities, Dahl, DeadZonePlays, DensityLaw, DriveGrid, Duhem, FamilyStream,
    GeneralisedPlays, HysteresisError, HysteresisForm, JilesAtherton, KrasnoselskiiPokrovskii, MaxwellSlip,
    NonSymmetricBoucWen, OneSidedPlays, PrandtlIshlinskii, Preisach, PreisachDensity, RateDependentPlays,
    SongDerKiureghian,
};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;

const REST: Start<f64> = Start::Rest { voltage_v: 0.0 };

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
fn rows<K: ColumnKernel>(kernel: &K, shape: &[f64], u: &[f64], start: Start<f64>) -> Vec<Vec<f64>> {
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
    let mut state = kernel.simulate_every(shape, 1, u, Start::PERIODIC, &mut first).unwrap();
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

/// Columns one after the other, 0 beyond their end.
fn whole(columns: &[Vec<f64>], samples: usize) -> Vec<f64> {
    columns.iter().flat_map(|c| c.iter().copied().chain(std::iter::repeat(0.0)).take(samples)).collect()
}

/// Exact derivatives against differences of the plain simulation. Where differences of two step sizes
/// disagree (a kink between their points) nothing is compared; cases with many of them are rejected, of which
/// proptest allows few.
fn derivatives_are_differences<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    u: &[f64],
    start: Start<f64>,
    tolerance: f64,
) -> TestCaseResult {
    let mut exact = ColumnSensitivities::default();
    kernel.simulate_with_sensitivities(shape, 1, u, start, &mut exact).unwrap();
    let plain = |shape: &[f64], start| {
        let mut out = vec![0.0; kernel.columns() * u.len()];
        kernel.simulate_every(shape, 1, u, start, &mut out).unwrap();
        out
    };
    let size = |values: &[f64]| values.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
    let value = plain(shape, start);
    prop_assert!(apart(&value, &exact.columns.concat()) <= 1e-4 * tolerance * size(&value));
    // What rounding, or the settling of a steady state, leaves of each value that a difference is made of.
    let left = if start == Start::PERIODIC { 1e-13 } else { 8.0 * f64::EPSILON } * size(&value);
    let moved = |index: usize, by: f64| {
        let mut shape = shape.to_vec();
        shape[index] += by;
        plain(&shape, start)
    };
    let d_shape: Vec<Vec<f64>> = exact.d_shape.iter().map(|columns| whole(columns, u.len())).collect();
    let d_start = whole(&exact.d_start, u.len());
    let mut wanted: Vec<_> = d_shape
        .iter()
        .enumerate()
        .map(|(i, d)| {
            let step = 1e-4 * shape[i].abs().max(0.1);
            (d.as_slice(), step, [step, 0.3 * step].map(|step| difference(step, |by| moved(i, by))))
        })
        .collect();
    if let Start::Rest { voltage_v: at } = start {
        let from = |by: f64| plain(shape, Start::Rest { voltage_v: at + by });
        wanted.push((d_start.as_slice(), 1e-4, [1e-4, 3e-5].map(|step| difference(step, from))));
    } else {
        prop_assert!(d_start.iter().all(|d| *d == 0.0));
    }
    for (d, step, [coarse, fine]) in wanted {
        let bound = tolerance * size(d) + left / (0.3 * step);
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

/// A device that was virgin at `virgin` and moved to `rest` is one that was driven there in a sample of its
/// own: columns, derivatives, and what they are before the first sample, to the last bit.
fn a_memory_is_a_move<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    u: &[f64],
    (virgin, rest): (f64, f64),
) -> TestCaseResult {
    let run = |u: &[f64], start| {
        let mut plain = vec![0.0; kernel.columns() * u.len()];
        kernel.simulate_every(shape, 1, u, start, &mut plain).unwrap();
        let mut all = ColumnSensitivities::default();
        kernel.simulate_with_sensitivities(shape, 1, u, start, &mut all).unwrap();
        (plain, all)
    };
    let longer = [&[rest], u].concat();
    let (plain, all) = run(u, Start::Remembering { voltage_v: rest, memory: virgin });
    let (plain_longer, all_longer) = run(&longer, Start::Rest { voltage_v: virgin });
    let first = |columns: &[f64]| columns.iter().step_by(longer.len()).copied().collect::<Vec<f64>>();
    let others =
        |columns: &[f64]| columns.chunks(longer.len()).flat_map(|c| c[1..].to_vec()).collect::<Vec<f64>>();
    prop_assert_eq!(&plain, &others(&plain_longer));
    let (columns, d_start) = (all_longer.columns.concat(), whole(&all_longer.d_start, longer.len()));
    prop_assert_eq!(&all.columns.concat(), &others(&columns));
    prop_assert_eq!(&whole(&all.d_start, u.len()), &others(&d_start));
    prop_assert_eq!(&all.rest, &first(&columns));
    prop_assert_eq!(&all.d_start_rest, &first(&d_start));
    for (index, d) in all_longer.d_shape.iter().enumerate() {
        let d = whole(d, longer.len());
        prop_assert_eq!(&whole(&all.d_shape[index], u.len()), &others(&d));
        prop_assert_eq!(&all.d_shape_rest[index], &first(&d));
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
