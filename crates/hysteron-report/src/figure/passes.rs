//! Reducing loops: a curve that goes to and fro is drawn pass by pass, each whole or not at all, so that
//! nothing looks dashed.

use std::collections::HashSet;
use std::ops::RangeInclusive;

use super::breaks::{finite, push_break, trim_break};

/// A pass that lies within this many cells of those before is left out: lines closer than that run into each
/// other, and what is drawn below them could not be seen.
const APART: f64 = 4.0;
/// Most points at which a step between two samples is checked for the cells it crosses.
const MOST_BETWEEN: usize = 16;

/// The curve cut where `x` turns back by more than `cell`. On a raster of [`APART`] cells, a pass all of
/// whose squares are those that earlier passes crossed or neighbours of theirs is left out; the others keep
/// what is more than half a cell off the straight lines between the points kept. The points at `extremes` are
/// kept. Stops early beyond `most` points.
pub(super) fn by_passes(
    points: &[(f64, f64)],
    cell: f64,
    extremes: &[usize; 4],
    most: usize,
) -> Vec<(f64, f64)> {
    let mut covered: HashSet<(i64, i64)> = HashSet::new();
    let mut out = Vec::new();
    let mut drawn_to = None;
    for pass in passes(points, cell) {
        if out.len() > most {
            break;
        }
        let squares = squares(&points[pass.clone()], APART * cell);
        let forced: Vec<usize> = extremes.iter().copied().filter(|i| pass.contains(i)).collect();
        if forced.is_empty() && squares.iter().all(|c| covered.contains(c)) {
            continue;
        }
        for (x, y) in squares {
            covered.extend(
                (-1..=1).flat_map(|i| (-1..=1).map(move |j| (x.saturating_add(i), y.saturating_add(j)))),
            );
        }
        let mut kept = simplified(points, &pass, forced, cell);
        if drawn_to == Some(*pass.start()) {
            kept.remove(0);
        } else {
            push_break(&mut out);
        }
        out.extend(kept.into_iter().map(|i| points[i]));
        drawn_to = Some(*pass.end());
    }
    trim_break(&mut out);
    out
}

/// Ranges of finite points between the turns of x and the gaps; neighbours share their turning point.
fn passes(points: &[(f64, f64)], cell: f64) -> Vec<RangeInclusive<usize>> {
    let mut out = Vec::new();
    // Begin of the pass, its direction once it has one, the point farthest in this direction.
    let mut run: Option<(usize, f64, usize)> = None;
    let mut last = 0;
    for (i, p) in points.iter().enumerate() {
        if !finite(*p) {
            if let Some((begin, ..)) = run.take() {
                out.push(begin..=last);
            }
            continue;
        }
        last = i;
        let Some((begin, direction, farthest)) = &mut run else {
            run = Some((i, 0.0, i));
            continue;
        };
        let ahead = p.0 - points[*farthest].0;
        if *direction == 0.0 {
            if ahead.abs() > cell {
                (*direction, *farthest) = (ahead.signum(), i);
            }
        } else if ahead * *direction >= 0.0 {
            *farthest = i;
        } else if ahead.abs() > cell {
            out.push(*begin..=*farthest);
            (*begin, *direction, *farthest) = (*farthest, -*direction, i);
        }
    }
    if let Some((begin, ..)) = run {
        out.push(begin..=last);
    }
    out
}

/// Squares that a pass crosses.
fn squares(pass: &[(f64, f64)], side: f64) -> HashSet<(i64, i64)> {
    let of = |p: (f64, f64)| ((p.0 / side).floor() as i64, (p.1 / side).floor() as i64);
    let mut crossed: HashSet<(i64, i64)> = pass.first().map(|p| of(*p)).into_iter().collect();
    for pair in pass.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let apart = (b.0 - a.0).abs().max((b.1 - a.1).abs());
        let steps = ((apart / side).ceil() as usize).clamp(1, MOST_BETWEEN);
        for k in 1..=steps {
            let t = k as f64 / steps as f64;
            crossed.insert(of((a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1))));
        }
    }
    crossed
}

/// Indices of the points of a pass that its drawing needs: ends, `forced`, and a Ramer–Douglas–Peucker
/// simplification (doi:10.1016/S0146-664X(72)80017-0, doi:10.3138/FM57-6770-U75U-7727) to half a `cell` of
/// the first, lowest, highest and last point of each column of half a cell.
fn simplified(
    points: &[(f64, f64)],
    pass: &RangeInclusive<usize>,
    forced: Vec<usize>,
    cell: f64,
) -> Vec<usize> {
    let (begin, end) = (*pass.start(), *pass.end());
    let sign = if points[end].0 < points[begin].0 { -1.0 } else { 1.0 };
    let mut candidates = forced.clone();
    // Columns are counted from the pass's begin, and only forwards: a wavering x stays in its column.
    let mut column = 0.0;
    let mut picks = [begin; 4];
    for i in pass.clone() {
        let now = (sign * (points[i].0 - points[begin].0) / (0.5 * cell)).floor();
        if now > column {
            candidates.extend(picks);
            (column, picks) = (now, [i; 4]);
        }
        if points[i].1 < points[picks[1]].1 {
            picks[1] = i;
        }
        if points[i].1 > points[picks[2]].1 {
            picks[2] = i;
        }
        picks[3] = i;
    }
    candidates.extend(picks);
    candidates.extend([begin, end]);
    candidates.sort_unstable();
    candidates.dedup();

    let mut keep: Vec<bool> =
        candidates.iter().map(|i| *i == begin || *i == end || forced.contains(i)).collect();
    let fixed: Vec<usize> = (0..keep.len()).filter(|&k| keep[k]).collect();
    let mut open: Vec<(usize, usize)> = fixed.windows(2).map(|w| (w[0], w[1])).collect();
    while let Some((a, b)) = open.pop() {
        let (from, to) = (points[candidates[a]], points[candidates[b]]);
        let farthest = (a + 1..b)
            .map(|k| (k, distance(points[candidates[k]], from, to)))
            .max_by(|(_, one), (_, other)| one.total_cmp(other));
        if let Some((k, far)) = farthest
            && far > 0.5 * cell
        {
            keep[k] = true;
            open.extend([(a, k), (k, b)]);
        }
    }
    candidates.into_iter().zip(keep).filter(|(_, keep)| *keep).map(|(i, _)| i).collect()
}

/// Distance of `p` from the straight piece between `a` and `b`.
fn distance(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length2 = dx * dx + dy * dy;
    let along = if length2 > 0.0 { ((p.0 - a.0) * dx + (p.1 - a.1) * dy) / length2 } else { 0.0 };
    let t = along.clamp(0.0, 1.0);
    (p.0 - a.0 - t * dx).hypot(p.1 - a.1 - t * dy)
}

#[cfg(test)]
mod tests {
    use super::super::decimate::decimate;
    use super::*;

    /// A sweep whose loop opens with the frequency: 200 passes that lie close to each other.
    fn sweep() -> Vec<(f64, f64)> {
        (0..100_000)
            .map(|k| {
                let t = k as f64 / 100_000.0;
                let phase = std::f64::consts::TAU * 50.0 * (t + t * t);
                (300.0 - 280.0 * phase.cos(), 150.0 - 100.0 * (phase - 0.1 - 0.4 * t).cos())
            })
            .collect()
    }

    #[test]
    fn what_is_drawn_of_a_dense_sweep_is_whole_passes() {
        let points = sweep();
        let kept = decimate(&points, 0.6, 4000);
        assert!(kept.len() <= 4000, "{}", kept.len());
        for piece in kept.split(|p| !finite(*p)).filter(|piece| !piece.is_empty()) {
            let (low, high) =
                piece.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), p| (l.min(p.0), h.max(p.0)));
            assert!(high - low > 550.0, "a dash from {low} to {high}");
        }
    }

    #[test]
    fn every_point_left_out_is_near_the_drawing() {
        let points = sweep();
        let kept = decimate(&points, 0.6, 4000);
        let near = |p: (f64, f64)| {
            let pieces = kept.windows(2).filter(|w| finite(w[0]) && finite(w[1]));
            pieces.map(|w| distance(p, w[0], w[1])).fold(f64::INFINITY, f64::min)
        };
        let worst = points.iter().step_by(997).map(|p| near(*p)).fold(0.0, f64::max);
        // Within two squares of the raster, each of 4 · 0.6 px.
        assert!(worst < 2.0 * APART * 0.6, "{worst} px");
    }

    #[test]
    fn an_x_that_wavers_at_its_turn_is_still_one_pass() {
        let points: Vec<(f64, f64)> = (0..400)
            .map(|k| {
                let x = if k < 200 { f64::from(k) } else { f64::from(400 - k) };
                (x + 0.3 * f64::from(k % 2), 0.5 * f64::from(k))
            })
            .collect();
        assert_eq!(passes(&points, 0.6).len(), 2);
    }
}
