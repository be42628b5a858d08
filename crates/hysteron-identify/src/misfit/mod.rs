//! Fit of a misfit model to the residuals of an identification.
//!
//! The residuals of the training records cannot give the band of a record of another kind, whose error lies in
//! directions that the training did not excite; no factor repairs that at a fair width. A Gaussian model of the
//! misfit can ([`hysteron_model::misfit`]): its coefficients by Bayesian linear regression (`evidence`), the
//! scale of their prior by evidence, on columns scaled by a fixed reference drive (`reference`).

mod evidence;
mod reference;

use std::sync::Arc;

use hysteron_model::hammerstein::Model;
use hysteron_model::misfit::{Basis, COLUMNS, ColumnGroup, MisfitError, MisfitModel, TimedRun};
use hysteron_model::record::{InputOutput, Timing};
use hysteron_numeric::display::short;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::facts::amplitudes;
use crate::{Finding, FindingKind, Identification, RecordFit};
use evidence::{Posterior, Prior, Sums};

/// Rows of all records together from which records are averaged in blocks, as far as the reference frequency
/// allows, and from which they are whatever it is: the columns must fit in memory.
const MOST_ROWS: (usize, usize) = (24_000, 96_000);
/// Least rows in a period of the reference frequency.
const LEAST_RATE: f64 = 6.0;
/// Longest time that counts as one independent residual, in periods of the reference frequency and in seconds.
const INDEPENDENT: (f64, f64) = (3.0, 0.015);
/// Reference frequency: at most this share of the sample rate; at least a lower share of it, or a multiple of
/// the fastest motion where that is less.
const HIGHEST: f64 = 0.1;
const LOWEST: (f64, f64) = (0.025, 50.0);
/// Share of the residual's power that the columns explain from which a device counts as outside the class. In
/// the class it is 0.002 to 0.03, from the coefficients fitted to noise.
pub const OUTSIDE: f64 = 0.06;
/// Parts of each record that are left out in turn.
const FOLDS: usize = 8;
/// Significant digits of the numbers in the file.
const DIGITS: usize = 6;

/// Misfit model of an identification.
#[derive(Clone, Debug)]
pub enum Misfit {
    /// The device is outside the class.
    Outside(Box<MisfitModel>),
    /// The columns explain no more than noise: the band of the class holds.
    InsideClass {
        /// Share of the power of the residual that they explain.
        explained: f64,
    },
    /// There is none.
    Absent(Arc<MisfitError>),
}

/// Topic of the findings.
const TOPIC: &str = "band";

impl Misfit {
    /// What the band of a new measurement rests on, where that is more than the model class.
    pub fn findings(&self) -> Vec<Finding> {
        match self {
            Self::Outside(misfit) => {
                let text = format!(
                    "The device is outside the model class: plays, branches, rates and creep beside the model \
                     explain {} % of the power of its residual. The 95 % band of a new measurement includes a \
                     model of this misfit; errors of parameters and the band of the model's output do not.",
                    short((100.0 * misfit.explained).round())
                );
                let one_amplitude = misfit.one_amplitude.then(|| {
                    let text = format!(
                        "The records hold loops of one amplitude: the band of smaller loops rests on other \
                         devices rather than on these records. Add {}.",
                        ColumnGroup::Memory.missing_record()
                    );
                    Finding::new(FindingKind::Advice, TOPIC, text)
                });
                std::iter::once(Finding::new(FindingKind::Verdict, TOPIC, text))
                    .chain(one_amplitude)
                    .collect()
            }
            Self::InsideClass { .. } => Vec::new(),
            Self::Absent(error) => {
                let text = format!(
                    "Whether the device is outside the model class was not tested, since {error}: the band of \
                     a new measurement assumes the class."
                );
                vec![Finding::new(FindingKind::Advice, TOPIC, text)]
            }
        }
    }
}

impl Identification {
    /// Fits the misfit model to the residuals of the records. The parameters of the model are not changed.
    pub fn misfit(&self) -> Misfit {
        let records = if self.runs.is_empty() { &self.records } else { &self.runs };
        match posterior(&self.model, records, self.excited_hz) {
            Ok(Some((basis, found, left_out))) if found.explained >= OUTSIDE => {
                let one_amplitude = holds_one_amplitude(records);
                Misfit::Outside(Box::new(stored(basis, &found, left_out, one_amplitude)))
            }
            Ok(found) => {
                Misfit::InsideClass { explained: found.map_or(0.0, |(_, found, _)| found.explained) }
            }
            Err(error) => Misfit::Absent(Arc::new(error)),
        }
    }
}

/// Columns and residual of a record, and the weight of its rows.
type Rows = (DMatrix<f64>, DVector<f64>, f64);

fn posterior(
    model: &Model,
    records: &[RecordFit],
    excited_hz: Option<(f64, f64)>,
) -> Result<Option<(Basis, Posterior, Option<f64>)>, MisfitError> {
    let rates = records.iter().map(|r| rates_hz(&r.data).ok_or(MisfitError::NoTimes));
    let rates = rates.collect::<Result<Vec<(f64, f64)>, _>>()?;
    let lowest_rate = rates.iter().map(|(mean, _)| *mean).fold(f64::INFINITY, f64::min);
    let highest_rate = rates.iter().map(|(_, highest)| *highest).fold(0.0, f64::max);
    let drives = records.iter().flat_map(|r| &r.data.u);
    let (low_v, high_v) = drives.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), u| (a.min(*u), b.max(*u)));
    if records.is_empty() || high_v <= low_v || records.iter().any(|r| r.simulated.iter().any(|y| y.is_nan()))
    {
        return Ok(None);
    }
    // Of a random drive no highest frequency is known: the upper end of the range.
    let fastest = excited_hz.map(|(_, fastest)| fastest).filter(|fastest| *fastest > 0.0);
    let fastest = fastest.unwrap_or(HIGHEST * highest_rate);
    let frequency_hz =
        fastest.max((LOWEST.0 * lowest_rate).min(LOWEST.1 * fastest)).min(HIGHEST * highest_rate);
    let basis = Basis { low_v, high_v, frequency_hz };
    let prior = reference::prior(&basis, model, holds_one_amplitude(records))?;
    let samples: usize = records.iter().map(|r| r.data.len()).sum();
    let of_record = |(record, (rate_hz, _)): (&RecordFit, (f64, f64))| {
        let most = (rate_hz / (LEAST_RATE * frequency_hz)).floor().max(1.0) as usize;
        let factor = samples.div_ceil(MOST_ROWS.0).clamp(1, most).max(samples.div_ceil(MOST_ROWS.1));
        let timing = Timing::from(&record.data.time);
        let drive = TimedRun { samples_v: &record.data.u, timing, start: &record.start };
        let columns = basis.columns(model, &drive, factor)?;
        let independent_s = (INDEPENDENT.0 / frequency_hz).min(INDEPENDENT.1);
        let weight = |row: usize| (row_s(timing, row, factor) / independent_s).min(1.0);
        Ok(rows(record, &columns, factor, weight))
    };
    let parts: Vec<Result<_, MisfitError>> = records.par_iter().zip(rates).map(of_record).collect();
    let parts: Vec<Option<Rows>> = parts.into_iter().collect::<Result<_, _>>()?;
    let parts: Vec<Rows> = parts.into_iter().flatten().collect();
    let mut sums = Sums::new(COLUMNS);
    parts.iter().for_each(|(columns, residual, weight)| sums.add(columns, residual, *weight));
    Ok(sums.posterior(&prior).map(|found| {
        // Inside the class nobody asks.
        let left_out = if found.explained >= OUTSIDE { left_out(&sums, &parts, &prior) } else { None };
        (basis, found, left_out)
    }))
}

/// Error with the predicted discrepancy over that without it, on each part left out of its fit in turn.
fn left_out(all: &Sums, parts: &[Rows], prior: &Prior) -> Option<f64> {
    let without = |k: usize| {
        let mut fold = Sums::new(COLUMNS);
        for (columns, residual, weight) in parts {
            let of_fold = residual.len().div_ceil(FOLDS);
            let (from, to) = ((k * of_fold).min(residual.len()), ((k + 1) * of_fold).min(residual.len()));
            let count = to - from;
            fold.add(&columns.rows(from, count).into(), &residual.rows(from, count).into(), *weight);
        }
        Some(fold.power_left(&all.without(&fold).posterior(prior)?.mean))
    };
    // Summed in the order of the folds, independently of the threads.
    let left: Vec<Option<f64>> = (0..FOLDS).into_par_iter().map(without).collect();
    let after: f64 = left.into_iter().sum::<Option<f64>>()?;
    Some((after.max(0.0) / all.power).sqrt())
}

/// Mean and highest sample rate of a record \[Hz\]; `None` without times.
fn rates_hz(data: &InputOutput) -> Option<(f64, f64)> {
    match Timing::from(&data.time) {
        Timing::Rate(rate_hz) => Some((rate_hz, rate_hz)),
        Timing::Stamps(times_s) => {
            let steps = || times_s.windows(2).map(|two| two[1] - two[0]).filter(|step| *step > 0.0);
            let shortest_s = steps().fold(f64::INFINITY, f64::min);
            let count = steps().count();
            (count > 0).then(|| (count as f64 / steps().sum::<f64>(), 1.0 / shortest_s))
        }
        Timing::Unknown => None,
    }
}

/// Duration of a block of `factor` samples \[s\].
fn row_s(timing: Timing<'_>, row: usize, factor: usize) -> f64 {
    match timing {
        Timing::Rate(rate_hz) => factor as f64 / rate_hz,
        Timing::Stamps(times_s) => {
            // The step to the sample before the block counts as its own; that of the first block is the next one.
            let from = (row * factor).max(1) - 1;
            let to = (from + factor).min(times_s.len() - 1);
            times_s[to] - times_s[from]
        }
        Timing::Unknown => 0.0,
    }
}

fn holds_one_amplitude(records: &[RecordFit]) -> bool {
    amplitudes(records.iter().map(|record| record.data.u.as_slice())) <= 1
}

/// The rows of a record whose samples all count, columns and residual about their means, and the mean of their
/// `weight`, rows of another weight being scaled; `None` of none.
fn rows(
    record: &RecordFit,
    columns: &[Vec<f64>],
    factor: usize,
    weight: impl Fn(usize) -> f64,
) -> Option<Rows> {
    let RecordFit { data, simulated, scores, .. } = record;
    let invalid = (0..data.len()).filter(|k| !data.is_valid(*k)).count();
    // Those skipped at the start.
    let first = scores.skipped_samples.saturating_sub(invalid);
    let counts = |k: usize| k >= first && data.is_valid(k);
    let total = columns.first().map_or(0, Vec::len);
    let kept: Vec<usize> = (0..total).filter(|row| (row * factor..(row + 1) * factor).all(counts)).collect();
    if kept.is_empty() {
        return None;
    }
    let mean = |row: &usize| {
        let samples = row * factor..(row + 1) * factor;
        samples.map(|k| data.y[k] - simulated[k] - scores.offset).sum::<f64>() / factor as f64
    };
    let mut residual = DVector::from_iterator(kept.len(), kept.iter().map(mean));
    let mut kept_columns = DMatrix::from_fn(kept.len(), columns.len(), |i, j| columns[j][kept[i]]);
    residual.add_scalar_mut(-residual.mean());
    for mut column in kept_columns.column_iter_mut() {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
    }
    let weights: Vec<f64> = kept.iter().map(|row| weight(*row)).collect();
    if weights.iter().all(|weight| *weight == weights[0]) {
        return Some((kept_columns, residual, weights[0]));
    }
    let mean = weights.iter().sum::<f64>() / weights.len() as f64;
    for (k, weight) in weights.iter().enumerate() {
        let scale = (weight / mean).sqrt();
        residual[k] *= scale;
        kept_columns.row_mut(k).scale_mut(scale);
    }
    Some((kept_columns, residual, mean))
}

/// The model with numbers of [`DIGITS`] digits: deviations need no more, and a model file stays small.
fn stored(basis: Basis, found: &Posterior, left_out: Option<f64>, one_amplitude: bool) -> MisfitModel {
    let rounded = |x: f64| format!("{x:.DIGITS$e}").parse().unwrap_or(x);
    MisfitModel {
        basis,
        noise: found.noise,
        explained: found.explained,
        mean: found.mean.iter().copied().collect(),
        directions: found.directions.column_iter().map(|f| f.iter().map(|x| rounded(*x)).collect()).collect(),
        information: found.information.iter().map(|x| rounded(*x)).collect(),
        one_amplitude,
        left_out: left_out.map(rounded),
    }
}
