//! Dead band of the drive: whether a record is described by a drive that moves nothing below a threshold.
//!
//! No search: a linear regression of the output on what counts of the drive,
//! y = c₀ + Σᵢⱼ cᵢⱼ (hⱼ ∗ fᵢ)(v), v = [`DeadBand::of`] (u), fᵢ the powers v, v², v³ and plays of v, hⱼ the
//! identity and lags of 3, 10, … intervals, is compared with the same regression on the drive itself: both
//! have the same number of columns, so that what is gained is the dead band's.

use hysteron_model::record::{DeadBand, InputOutput, TimeBase, range_of};
use hysteron_numeric::dot;
use hysteron_rt::play;

use crate::Stop;
use crate::projection::Projection;

/// Samples of the record that are filtered, and rows of the regression.
const MOST: usize = 100_000;
const ROWS: usize = 2500;
/// Half-widths of the plays, as shares of half the range of what counts of the drive.
const WIDTHS: [f64; 3] = [0.1, 0.3, 0.6];
/// The shortest lag in intervals, the factor from one to the next, and their number at most.
const LAGS: (f64, f64, i32) = (3.0, 3.3, 6);
/// Shares of the samples within the dead bands that are tried first.
const WITHIN: std::ops::RangeInclusive<usize> = 1..=16;
const SHARE: f64 = 0.05;
/// Least threshold, as a share of the largest drive: a smaller one cannot be why a model is poor.
const LEAST: f64 = 0.02;
/// Thresholds that are tried between the neighbours of the best of these, twice.
const BETWEEN: usize = 8;

/// A dead band and what regressions leave of the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    pub(super) band: DeadBand,
    /// Rms residual with the dead band, in % of the standard deviation of the output.
    pub(super) left_percent: f64,
    /// The same without it.
    pub(super) without_percent: f64,
}

/// The dead band that describes a record best; `None` where nothing can be compared, and after a stop.
pub(super) fn best(record: &InputOutput, stop: &Stop) -> Option<Found> {
    let record = record.first_samples(MOST);
    let rows: Vec<usize> = (0..record.len()).filter(|k| record.is_valid(*k)).collect();
    let rows: Vec<usize> = rows.iter().step_by(rows.len().div_ceil(ROWS).max(1)).copied().collect();
    let mut target: Vec<f64> = rows.iter().map(|k| record.y[*k]).collect();
    let mean = target.iter().sum::<f64>() / target.len() as f64;
    target.iter_mut().for_each(|y| *y -= mean);
    let power = dot(&target, &target);
    let mut sizes: Vec<f64> = rows.iter().map(|k| record.u[*k].abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let largest = sizes.last().copied().unwrap_or(0.0);
    if rows.len() < 200 || power.is_nan() || power <= 0.0 {
        return None;
    }
    let decays = decays(&record);
    let left = |band: Option<DeadBand>| {
        let v: Vec<f64> = record.u.iter().map(|u| band.map_or(*u, |band| band.of(*u))).collect();
        100.0 * (residual_power(&v, &decays, (&rows, &target)) / power).sqrt()
    };
    let without_percent = left(None);
    let at =
        |within: usize| sizes[((within as f64 * SHARE * sizes.len() as f64) as usize).min(sizes.len() - 1)];
    let mut best: Option<(Found, usize)> = None;
    let mut consider = |band: DeadBand, within: usize| {
        let left_percent = left(Some(band));
        if best.is_none_or(|(found, _)| left_percent < found.left_percent) {
            best = Some((Found { band, left_percent, without_percent }, within));
        }
        best
    };
    let forms = [DeadBand::Jump, DeadBand::Excess];
    let mut found = None;
    for within in WITHIN.filter(|within| at(*within) > LEAST * largest) {
        for form in forms {
            if stop.is_requested() {
                return None;
            }
            found = consider(form(at(within)), within);
        }
    }
    let (first, within) = found?;
    let form = forms[usize::from(matches!(first.band, DeadBand::Excess(_)))];
    let (mut low, mut high) = (if within > 1 { at(within - 1) } else { 0.0 }, at(within + 1));
    for _ in 0..2 {
        let step = (high - low) / (BETWEEN + 1) as f64;
        for k in 1..=BETWEEN {
            found = consider(form(low + k as f64 * step), within);
        }
        let middle = found.map_or(low, |(found, _)| found.band.threshold());
        (low, high) = ((middle - step).max(0.0), middle + step);
    }
    found.map(|(found, _)| found)
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

/// Squared residual of the regression of `target` at `rows` on a drive `v`.
fn residual_power(v: &[f64], decays: &[Vec<f64>], (rows, target): (&[usize], &[f64])) -> f64 {
    let (low, high) = range_of(v);
    let half = 0.5 * (high - low);
    if half.is_nan() || half <= 0.0 {
        return f64::INFINITY;
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
    let mut columns = Projection::new(rows.len(), 1 + (3 + WIDTHS.len()) * (1 + decays.len()));
    columns.push(|column| column.fill(1.0));
    let powers = (1..=3).map(|power| v.iter().map(|v| scaled(v).powi(power)).collect());
    for f in powers.chain(WIDTHS.into_iter().map(of_plays)) {
        let f: Vec<f64> = f;
        columns.push(|column| column.iter_mut().zip(rows).for_each(|(x, k)| *x = f[*k]));
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
            columns.push(|column| column.iter_mut().zip(rows).for_each(|(x, k)| *x = lagged[*k]));
        }
    }
    let mut rest = target.to_vec();
    columns.project(&mut rest);
    dot(&rest, &rest)
}
