//! Reducing curves to what a drawing can show, without losing an extreme value.

use super::breaks::{finite, push_break, trim_break};
use super::passes::by_passes;

/// A curve in drawing coordinates `(x, y)` reduced to about what a raster of `cell` shows.
///
/// * A curve whose `x` never decreases (a time curve) keeps the first, lowest, highest and last point of
///   each column of width `cell`, in their order.
/// * Any other curve (a loop) is drawn pass by pass between the turns of `x`, each whole, to half a `cell`; a
///   pass that lies on those drawn before is left out, so that forty equal periods cost as much as one.
///
/// Cells grow until at most `limit` points remain (or 48, if `limit` is smaller).
///
/// Points that are not finite break the curve; a break comes back as one `(NaN, NaN)`. The points with the
/// smallest and largest `x` and `y` are always among those returned. `O(n)` time.
pub fn decimate(points: &[(f64, f64)], cell: f64, limit: usize) -> Vec<(f64, f64)> {
    if points.len() <= 2 || cell.is_nan() || cell <= 0.0 {
        return points.to_vec();
    }
    let monotonic = is_monotonic(points);
    let extremes = extreme_indices(points);
    let limit = limit.max(FEWEST);
    let mut cell = cell;
    let mut kept = Vec::new();
    for coarsening in 0..=MAX_COARSENING {
        // The last attempt is the result, however long.
        let most = if coarsening < MAX_COARSENING { limit } else { usize::MAX };
        kept = if monotonic { by_columns(points, cell) } else { by_passes(points, cell, &extremes, most) };
        if kept.len() <= limit {
            break;
        }
        cell *= 1.6;
    }
    kept
}

/// 1.6^32 ≈ 3e6: from a fraction of a pixel to far beyond any drawing. Only a curve made of gaps can still
/// be above the limit then.
const MAX_COARSENING: usize = 32;

/// A few passes with their ends and the extremes: a loop cannot be made of fewer points.
const FEWEST: usize = 48;

fn is_monotonic(points: &[(f64, f64)]) -> bool {
    let mut last = f64::NEG_INFINITY;
    points.iter().filter(|p| finite(**p)).all(|p| {
        let ordered = p.0 >= last;
        last = p.0;
        ordered
    })
}

/// Indices of the smallest and largest x and y.
fn extreme_indices(points: &[(f64, f64)]) -> [usize; 4] {
    let mut at = [usize::MAX; 4];
    for (i, p) in points.iter().enumerate().filter(|(_, p)| finite(**p)) {
        let better = |k: usize, is_better: fn(f64, f64) -> bool, coordinate: fn((f64, f64)) -> f64| {
            points.get(at[k]).is_none_or(|q| is_better(coordinate(*p), coordinate(*q)))
        };
        let wins = [
            better(0, |a, b| a < b, |q| q.0),
            better(1, |a, b| a > b, |q| q.0),
            better(2, |a, b| a < b, |q| q.1),
            better(3, |a, b| a > b, |q| q.1),
        ];
        for (slot, win) in at.iter_mut().zip(wins) {
            if win {
                *slot = i;
            }
        }
    }
    at
}

/// First, lowest, highest and last point of each column.
fn by_columns(points: &[(f64, f64)], cell: f64) -> Vec<(f64, f64)> {
    let mut out = Vec::new();
    let mut run: Option<(f64, [usize; 4])> = None;
    let flush = |run: &mut Option<(f64, [usize; 4])>, out: &mut Vec<(f64, f64)>| {
        if let Some((_, mut picks)) = run.take() {
            picks.sort_unstable();
            for (k, index) in picks.iter().enumerate() {
                if k == 0 || picks[k - 1] != *index {
                    out.push(points[*index]);
                }
            }
        }
    };
    for (i, p) in points.iter().enumerate() {
        if !finite(*p) {
            flush(&mut run, &mut out);
            push_break(&mut out);
            continue;
        }
        let column = (p.0 / cell).floor();
        match &mut run {
            Some((current, [_, low, high, last])) if *current == column => {
                if p.1 < points[*low].1 {
                    *low = i;
                }
                if p.1 > points[*high].1 {
                    *high = i;
                }
                *last = i;
            }
            _ => {
                flush(&mut run, &mut out);
                run = Some((column, [i; 4]));
            }
        }
    }
    flush(&mut run, &mut out);
    trim_break(&mut out);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn extremes(points: &[(f64, f64)]) -> [f64; 4] {
        points
            .iter()
            .filter(|p| finite(**p))
            .fold([f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY], |e, p| {
                [e[0].min(p.0), e[1].max(p.0), e[2].min(p.1), e[3].max(p.1)]
            })
    }

    #[test]
    fn a_spike_of_one_sample_among_a_million_survives() {
        let mut points: Vec<(f64, f64)> =
            (0..1_000_000).map(|k| (k as f64 * 6e-4, (k as f64 * 0.01).sin())).collect();
        points[654_321].1 = 7.0;
        let kept = decimate(&points, 1.0, 5000);
        assert!(kept.len() <= 4 * 601, "{}", kept.len());
        assert!(kept.contains(&points[654_321]));
    }

    #[test]
    fn forty_equal_periods_of_a_loop_cost_little_more_than_one() {
        let turn = |k: usize| {
            let phase = std::f64::consts::TAU * k as f64 / 500.0;
            (300.0 * phase.cos(), 100.0 * (phase - 0.2).cos())
        };
        let one: Vec<_> = (0..=500).map(turn).collect();
        let forty: Vec<_> = (0..=20_000).map(turn).collect();
        let (a, b) = (decimate(&one, 0.5, 100_000), decimate(&forty, 0.5, 100_000));
        assert!(b.len() <= a.len() + 40, "{} and {}", a.len(), b.len());
        assert_eq!(extremes(&one), extremes(&a));
    }

    #[test]
    fn gaps_stay_gaps() {
        let nan = f64::NAN;
        let kept =
            decimate(&[(0.0, 1.0), (1.0, nan), (2.0, nan), (3.0, 1.0), (4.0, 2.0), (5.0, nan)], 0.1, 100);
        let pattern: Vec<bool> = kept.iter().map(|p| finite(*p)).collect();
        assert_eq!(pattern, [true, false, true, true]);
        assert!(decimate(&[(nan, nan); 5], 0.1, 100).iter().all(|p| !finite(*p)));
    }

    proptest! {
        #[test]
        fn extremes_survive_whatever_the_order(
            points in prop::collection::vec((-100f64..100.0, -100f64..100.0), 3..400),
            cell in 0.01f64..60.0, limit in 0usize..200, sorted: bool,
        ) {
            let mut points = points;
            if sorted {
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
            }
            let kept = decimate(&points, cell, limit);
            prop_assert!(kept.len() <= limit.max(FEWEST), "{} points", kept.len());
            prop_assert_eq!(extremes(&points), extremes(&kept));
            prop_assert!(kept.iter().filter(|p| finite(**p)).all(|p| points.contains(p)));
        }
    }
}
