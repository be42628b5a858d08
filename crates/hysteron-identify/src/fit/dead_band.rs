//! Dead band of the drive: whether a record is described by a drive that moves nothing below a threshold.
//!
//! No search: a linear regression of the output on what counts of the drive,
//! y = c₀ + Σᵢⱼ cᵢⱼ (hⱼ ∗ fᵢ)(v), v = [`DeadBand::of`] (u), fᵢ the powers v, v², v³ and plays of v, hⱼ the
//! identity and lags of 3, 10, … intervals, is compared with the same regression on the drive itself: both
//! have the same number of columns, so that what is gained is the dead band's.
//!
//! Compared is what a regression on the rest of the record, with a small penalty on c, leaves of each tenth of
//! it. The residual of all of it cannot tell in a record of few moves: as many columns follow anything there.
//! It must not be larger with the dead band, though: what is left out of few moves is large by chance.

use hysteron_model::record::{DeadBand, InputOutput, TimeBase, range_of};
use hysteron_rt::play;
use nalgebra::{DMatrix, DVector};

use crate::Stop;

/// Samples of the record that are filtered, and rows of the regression.
const MOST: usize = 100_000;
const ROWS: usize = 2500;
/// Half-widths of the plays, as shares of half the range of what counts of the drive.
const WIDTHS: [f64; 3] = [0.1, 0.3, 0.6];
/// The shortest lag in intervals, the factor from one to the next, and their number at most.
const LAGS: (f64, f64, i32) = (3.0, 3.3, 6);
/// Shares of the samples within the dead bands that are tried first, and one above them.
const WITHIN: std::ops::RangeInclusive<usize> = 1..=17;
const SHARE: f64 = 0.05;
/// Least threshold, as a share of the largest drive: a smaller one cannot be why a model is poor.
const LEAST: f64 = 0.02;
/// Thresholds that are tried between the neighbours of the best of these, twice.
const BETWEEN: usize = 8;
/// Parts of the record that are left out one by one.
const PARTS: usize = 10;
/// Penalty on the square of a coefficient, for a row and a column of unit variance.
const PENALTY: f64 = 1e-5;

/// A dead band and what regressions leave of the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    pub(super) band: DeadBand,
    /// Rms error on the parts left out with the dead band, in % of the standard deviation of the output.
    pub(super) left_percent: f64,
    /// The same without it.
    pub(super) without_percent: f64,
}

/// The dead band that describes a record best; `None` where nothing can be compared, and after a stop.
pub(super) fn best(record: &InputOutput, stop: &Stop) -> Option<Found> {
    let record = record.first_samples(MOST);
    let rows: Vec<usize> = (0..record.len()).filter(|k| record.is_valid(*k)).collect();
    let rows: Vec<usize> = rows.iter().step_by(rows.len().div_ceil(ROWS).max(1)).copied().collect();
    let target = DVector::from_iterator(rows.len(), rows.iter().map(|k| record.y[*k]));
    let power = target.variance() * rows.len() as f64;
    if rows.len() < 200 || power.is_nan() || power <= 0.0 {
        return None;
    }
    let decays = decays(&record);
    let left = |of: &dyn Fn(f64) -> f64| {
        let v: Vec<f64> = record.u.iter().map(|u| of(*u)).collect();
        errors(&v, &decays, (&rows, &target)).map(|square| 100.0 * (square / power).sqrt())
    };
    let [without_percent, most] = left(&|u| u);
    let best_of = |bands: Vec<DeadBand>, so_far: Option<Found>| {
        bands.into_iter().try_fold(so_far, |best, band| {
            if stop.is_requested() {
                return None;
            }
            let [left_percent, fitted] = left(&|u| band.of(u));
            let is_better = best.is_none_or(|best| left_percent < best.left_percent);
            Some(if is_better && fitted <= most {
                Some(Found { band, left_percent, without_percent })
            } else {
                best
            })
        })?
    };
    let (least, thresholds) = thresholds(rows.iter().map(|k| record.u[*k].abs()).collect());
    let forms = [DeadBand::Jump, DeadBand::Excess];
    let first = thresholds.iter().take(thresholds.len().saturating_sub(1));
    let mut best = best_of(first.flat_map(|at| forms.map(|form| form(*at))).collect(), None)?;
    let form = forms[usize::from(matches!(best.band, DeadBand::Excess(_)))];
    let place = thresholds.partition_point(|at| *at < best.band.threshold());
    let mut low = place.checked_sub(1).map_or(least, |before| thresholds[before]);
    let mut high = thresholds[place + 1];
    for _ in 0..2 {
        let step = (high - low) / (BETWEEN + 1) as f64;
        best = best_of((1..=BETWEEN).map(|k| form(low + k as f64 * step)).collect(), Some(best))?;
        let middle = best.band.threshold();
        (low, high) = ((middle - step).max(least), middle + step);
    }
    Some(best)
}

/// The least threshold that is tried, and those tried first from the sizes of the drive, with one more above
/// them.
fn thresholds(mut sizes: Vec<f64>) -> (f64, Vec<f64>) {
    sizes.sort_by(f64::total_cmp);
    let least = LEAST * sizes.last().copied().unwrap_or(0.0);
    let at =
        |within: usize| sizes[((within as f64 * SHARE * sizes.len() as f64) as usize).min(sizes.len() - 1)];
    let mut all: Vec<f64> = WITHIN.map(at).filter(|at| *at > least).collect();
    all.dedup();
    (least, all)
}

/// exp(−Δt/T) of every interval, lag by lag.
fn decays(record: &InputOutput) -> Vec<Vec<f64>> {
    let intervals: Vec<f64> = match &record.time {
        TimeBase::NonUniform { times_s } => {
            let all = times_s.windows(2).map(|two| two[1] - two[0]);
            std::iter::once(0.0).chain(all).collect()
        }
        _ => vec![1.0; record.len()],
    };
    let mean = intervals.iter().sum::<f64>() / intervals.len() as f64;
    let (shortest, factor, count) = LAGS;
    let lags = (0..count).map(|k| shortest * factor.powi(k));
    lags.take_while(|lag| *lag < record.len() as f64 / 2.0)
        .map(|lag| intervals.iter().map(|dt| (-dt / (lag * mean)).exp()).collect())
        .collect()
}

/// Squared errors of the regression of `target` at `rows` on a drive `v`: on the parts left out, and where all
/// are fitted.
fn errors(v: &[f64], decays: &[Vec<f64>], (rows, target): (&[usize], &DVector<f64>)) -> [f64; 2] {
    let Some(columns) = columns(v, decays, rows) else { return [f64::INFINITY; 2] };
    let samples = rows.len();
    let (normal, moments) = (columns.tr_mul(&columns), columns.tr_mul(target));
    // Of rows `from` to `to`, where `out` of all are left out.
    let of_rows = |from: usize, to: usize, out: usize| {
        let (own, y) = (columns.rows(from, to - from), target.rows(from, to - from));
        let left_out = (columns.rows(from, out), target.rows(from, out));
        let mut rest = &normal - left_out.0.tr_mul(&left_out.0);
        // All but the mean.
        (1..columns.ncols()).for_each(|k| rest[(k, k)] += PENALTY * samples as f64);
        let coefficients = rest.cholesky()?.solve(&(&moments - left_out.0.tr_mul(&left_out.1)));
        Some((y - own * coefficients).norm_squared())
    };
    let parts = (0..PARTS).map(|part| (part * samples / PARTS, (part + 1) * samples / PARTS));
    let left_out = parts.map(|(from, to)| of_rows(from, to, to - from)).sum::<Option<f64>>();
    [left_out, of_rows(0, samples, 0)].map(|square| square.unwrap_or(f64::INFINITY))
}

/// Columns of the regression on a drive `v` at `rows`: 1, then the others with the mean 0 and the variance 1;
/// `None` for a drive that does not move.
fn columns(v: &[f64], decays: &[Vec<f64>], rows: &[usize]) -> Option<DMatrix<f64>> {
    let (low, high) = range_of(v);
    let half = 0.5 * (high - low);
    if half.is_nan() || half <= 0.0 {
        return None;
    }
    let scaled = |v: &f64| (v - low) / half - 1.0;
    let of_plays = |width: f64| {
        let mut state = v.first().map_or(0.0, scaled);
        let moved = v.iter().map(|v| {
            state = play(width, state, scaled(v));
            state
        });
        moved.collect::<Vec<f64>>()
    };
    let powers = (1..=3).map(|power| v.iter().map(|v| scaled(v).powi(power)).collect());
    let mut columns = vec![DVector::repeat(rows.len(), 1.0)];
    for f in powers.chain(WIDTHS.into_iter().map(of_plays)) {
        let f: Vec<f64> = f;
        let at_rows = |x: &[f64]| {
            let mut column = DVector::from_iterator(rows.len(), rows.iter().map(|k| x[*k]));
            column.add_scalar_mut(-column.mean());
            let deviation = column.variance().sqrt();
            column / if deviation > 0.0 { deviation } else { 1.0 }
        };
        columns.push(at_rows(&f));
        for decay in decays {
            let mut state = f.first().copied().unwrap_or(0.0);
            let lagged: Vec<f64> = f
                .iter()
                .zip(decay)
                .map(|(f, decay)| {
                    state = f + decay * (state - f);
                    state
                })
                .collect();
            columns.push(at_rows(&lagged));
        }
    }
    Some(DMatrix::from_columns(&columns))
}
