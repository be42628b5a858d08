//! Weights of the samples of a record.
//!
//! A sample is weighted by its expected error. Model error is proportional to the swing, so that small
//! oscillations beside large moves need larger weights to count equally: residuals are weighted by the swing
//! of their segment. The mean level of a small oscillation is set by the large moves before it, with their
//! error. So the mean of every period is weighted as large moves are, and the deviation from it as small
//! ones: two orthogonal parts of the residual.

use std::ops::Range;

use hysteron_model::record::{InputOutput, UniformSegment, oscillation_hz, span, turning_points};
use hysteron_numeric::dot;

/// Model error, as a share of the swing.
const MISFIT: f64 = 0.002;
/// Weights within this factor are not distinguished from those of large moves.
const SEVERAL: f64 = 2.0;
/// Least range of an oscillation, as a share of the drive's range in the record.
const OSCILLATES: f64 = 1e-4;
/// Samples kept by thinning, per swing and in a segment without reversals: a polygon with half as many samples
/// a swing is 0.14 % off, as much as the model, and leads a search astray.
const KEPT_A_SWING: f64 = 48.0;
const KEPT_A_PIECE: f64 = 60.0;
/// Least reversal kept by thinning, as a share of the range of its segment.
const REVERSAL: f64 = 0.1;

/// Weights of the samples of a record.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Weighting {
    /// Weight of each sample, 0 for excluded ones.
    pub(in super::super) weight: Vec<f64>,
    /// Periods of oscillations.
    pub(in super::super) periods: Vec<Level>,
}

/// A period with different weights for its mean and the deviation from it.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) struct Level {
    /// Its samples; those of weight 0 do not count.
    pub(in super::super) rows: Range<usize>,
    /// Weight of the weighted mean over that of the deviations from it, above 0.
    pub(in super::super) share: f64,
}

impl From<Vec<f64>> for Weighting {
    fn from(weight: Vec<f64>) -> Self {
        Self { weight, periods: Vec::new() }
    }
}

impl Weighting {
    /// Applies the weights to a column.
    pub(super) fn apply(&self, column: &mut [f64]) {
        column.iter_mut().zip(&self.weight).for_each(|(x, w)| *x *= w);
        self.scale_levels(column, |share| share);
    }

    /// Removes the weights from a column; excluded samples become 0.
    pub(super) fn undo(&self, column: &mut [f64]) {
        self.scale_levels(column, |share| 1.0 / share);
        column.iter_mut().zip(&self.weight).for_each(|(x, w)| *x = if *w > 0.0 { *x / w } else { 0.0 });
    }

    /// Excludes samples that are not valid.
    pub(super) fn mask(&mut self, valid: Option<&[bool]>) {
        let masked = self.weight.iter_mut().zip(valid.unwrap_or_default()).filter(|(_, valid)| !**valid);
        masked.for_each(|(weight, _)| *weight = 0.0);
    }

    /// Weights for these rows only, each representing the samples up to the next.
    pub(super) fn of_rows(&self, kept: &[usize]) -> Self {
        let weight = kept.iter().enumerate().map(|(at, &k)| {
            let next = kept.get(at + 1).copied().unwrap_or(self.weight.len());
            self.weight[k] * ((next - k) as f64).sqrt()
        });
        let place = |row: usize| kept.partition_point(|k| *k < row);
        let level = |level: &Level| Level { rows: place(level.rows.start)..place(level.rows.end), ..*level };
        Self { weight: weight.collect(), periods: self.periods.iter().map(level).collect() }
    }

    /// Scales the mean of every period in a weighted column, Σ w² x / Σ w² of the x that were weighted: what is
    /// kept by thinning has the weight of the samples that it represents, and these differ at turning points.
    fn scale_levels(&self, column: &mut [f64], factor: impl Fn(f64) -> f64) {
        for Level { rows, share } in &self.periods {
            let (Some(own), Some(weight)) = (column.get_mut(rows.clone()), self.weight.get(rows.clone()))
            else {
                continue;
            };
            let power = dot(weight, weight);
            if power > 0.0 {
                let change = (factor(*share) - 1.0) * dot(own, weight) / power;
                own.iter_mut().zip(weight).for_each(|(x, w)| *x += change * w);
            }
        }
    }
}

/// Weights of a record in segments: `largest` for moves over the whole `stroke`, larger for small
/// oscillations by their expected model error and `noise`, independently of their number of samples.
pub(super) fn by_swing(data: &InputOutput, largest: f64, noise: f64, stroke: f64) -> Weighting {
    let mut weighting = Weighting::from(vec![largest; data.len()]);
    let expected = |swing: f64| noise.hypot(MISFIT * swing);
    let mut small = Vec::new();
    for (piece, samples) in oscillations(data) {
        let Some(samples) = samples else { continue };
        let count = (piece.samples.len() as f64 / samples).floor().max(1.0) as usize;
        let from = |period: usize| match period {
            period if period == count => piece.samples.end,
            period => piece.samples.start + (period as f64 * samples).round() as usize,
        };
        let periods: Vec<Range<usize>> = (0..count).map(|period| from(period)..from(period + 1)).collect();
        let mut swings: Vec<f64> = periods.iter().map(|rows| span(&data.y[rows.clone()])).collect();
        swings.sort_by(f64::total_cmp);
        let gain = expected(stroke) / expected(swings[count / 2]);
        if gain >= SEVERAL {
            small.push((piece.samples, periods, gain));
        }
    }
    // Each oscillation determines one gain and one phase, however many samples it has: all have equal weight.
    let most = small.iter().map(|(rows, ..)| rows.len()).max().unwrap_or(1);
    for (rows, periods, gain) in small {
        let gain = gain * (most as f64 / rows.len() as f64).sqrt();
        weighting.weight[rows].iter_mut().for_each(|weight| *weight *= gain);
        weighting.periods.extend(periods.into_iter().map(|rows| Level { rows, share: 1.0 / gain }));
    }
    weighting
}

/// Samples of a record in segments that resolve every swing of its drive, including reversals and segment
/// ends.
pub(super) fn thinned(data: &InputOutput) -> Vec<usize> {
    let mut kept = Vec::new();
    for (piece, samples) in oscillations(data) {
        let own = &data.u[piece.samples.clone()];
        let swing = samples.map_or(own.len() as f64 / KEPT_A_PIECE, |samples| 0.5 * samples / KEPT_A_SWING);
        let stride = (swing as usize).max(1);
        let mut within: Vec<usize> = (0..own.len()).step_by(stride).chain(own.len().checked_sub(1)).collect();
        within.extend(turning_points(own, REVERSAL * span(own)).iter().map(|turn| turn.index));
        within.sort_unstable();
        within.dedup();
        kept.extend(within.into_iter().map(|k| piece.samples.start + k));
    }
    kept
}

/// The segments of a record, each with the samples per period of its oscillation, if any.
fn oscillations(data: &InputOutput) -> impl Iterator<Item = (UniformSegment, Option<f64>)> {
    // Computed once: there may be as many segments as samples.
    let least_range = OSCILLATES * span(&data.u);
    data.time.pieces(data.len()).into_iter().map(move |piece| {
        let hz = oscillation_hz(&data.u, &piece, least_range);
        let samples = hz.map(|hz| 1.0 / (hz * piece.period_s));
        (piece, samples)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_scaled_alone_and_back() {
        let weighting = Weighting {
            weight: vec![1.0, 2.0, 2.0, 0.0, 2.0],
            periods: vec![Level { rows: 1..5, share: 0.25 }],
        };
        // Mean 3 with deviations −1, 0, 1, weighted by 2: mean 1.5 with deviations −2, 0, 2.
        let mut column = [7.0, 2.0, 3.0, 9.0, 4.0];
        weighting.apply(&mut column);
        assert_eq!(column, [7.0, -0.5, 1.5, 0.0, 3.5]);
        weighting.undo(&mut column);
        assert_eq!(column, [7.0, 2.0, 3.0, 0.0, 4.0]);
    }

    /// A kept sample that stands for four of the record counts as these in the mean of its period.
    #[test]
    fn thinning_keeps_the_mean_of_a_period() {
        let whole = Weighting { weight: vec![3.0; 10], periods: vec![Level { rows: 1..10, share: 0.1 }] };
        let kept = [0, 1, 5, 6];
        let thin = whole.of_rows(&kept);
        let values = [4.0, 7.0, 7.0, 7.0, 7.0, -1.0, 2.0, 2.0, 2.0, 2.0];
        let (mut all, mut few) = (values, kept.map(|k| values[k]));
        whole.apply(&mut all);
        thin.apply(&mut few);
        let power = |column: &[f64]| dot(column, column);
        assert!((power(&all) - power(&few)).abs() < 1e-12 * power(&all), "{all:?} {few:?}");
        thin.undo(&mut few);
        assert!(few.iter().zip(kept).all(|(x, k)| (x - values[k]).abs() < 1e-12), "{few:?}");
    }
}
