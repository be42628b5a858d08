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
use hysteron_model::misfit::{Basis, COLUMNS, ColumnGroup, MisfitError, MisfitModel, UniformDrive};
use hysteron_model::record::Timing;
use hysteron_numeric::display::short;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::facts::amplitudes;
use crate::{Finding, FindingKind, Identification, RecordFit};
use evidence::{Posterior, Sums};

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
            Ok(Some((basis, found))) if found.explained >= OUTSIDE => {
                let one_amplitude = holds_one_amplitude(records);
                Misfit::Outside(Box::new(stored(basis, &found, one_amplitude)))
            }
            Ok(found) => Misfit::InsideClass { explained: found.map_or(0.0, |(_, found)| found.explained) },
            Err(error) => Misfit::Absent(Arc::new(error)),
        }
    }
}

fn posterior(
    model: &Model,
    records: &[RecordFit],
    excited_hz: Option<(f64, f64)>,
) -> Result<Option<(Basis, Posterior)>, MisfitError> {
    let rates = records.iter().map(|r| r.data.sample_rate_hz().ok_or(MisfitError::NotUniform));
    let rates = rates.collect::<Result<Vec<f64>, _>>()?;
    let lowest_rate = rates.iter().copied().fold(f64::INFINITY, f64::min);
    let highest_rate = rates.iter().copied().fold(0.0, f64::max);
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
    let of_record = |(record, rate_hz): (&RecordFit, f64)| {
        let most = (rate_hz / (LEAST_RATE * frequency_hz)).floor().max(1.0) as usize;
        let factor = samples.div_ceil(MOST_ROWS.0).clamp(1, most).max(samples.div_ceil(MOST_ROWS.1));
        let timing = Timing::Rate(rate_hz);
        let drive = UniformDrive::new(&record.data.u, timing, &record.start)?;
        let columns = basis.columns(model, &drive, factor)?;
        let independent_s = (INDEPENDENT.0 / frequency_hz).min(INDEPENDENT.1);
        let weight = (factor as f64 / (independent_s * rate_hz)).min(1.0);
        Ok(rows(record, &columns, factor).map(|(columns, residual)| (columns, residual, weight)))
    };
    let parts: Vec<Result<_, MisfitError>> = records.par_iter().zip(rates).map(of_record).collect();
    let mut sums = Sums::new(COLUMNS);
    for part in parts {
        if let Some((columns, residual, weight)) = part? {
            sums.add(&columns, &residual, weight);
        }
    }
    Ok(sums.posterior(&prior).map(|found| (basis, found)))
}

fn holds_one_amplitude(records: &[RecordFit]) -> bool {
    amplitudes(records.iter().map(|record| record.data.u.as_slice())) <= 1
}

/// The rows of a record whose samples all count, columns and residual about their means; `None` of none.
fn rows(record: &RecordFit, columns: &[Vec<f64>], factor: usize) -> Option<(DMatrix<f64>, DVector<f64>)> {
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
    Some((kept_columns, residual))
}

/// The model with numbers of [`DIGITS`] digits: deviations need no more, and a model file stays small.
fn stored(basis: Basis, found: &Posterior, one_amplitude: bool) -> MisfitModel {
    let rounded = |x: f64| format!("{x:.DIGITS$e}").parse().unwrap_or(x);
    MisfitModel {
        basis,
        noise: found.noise,
        explained: found.explained,
        mean: found.mean.iter().copied().collect(),
        directions: found.directions.column_iter().map(|f| f.iter().map(|x| rounded(*x)).collect()).collect(),
        information: found.information.iter().map(|x| rounded(*x)).collect(),
        one_amplitude,
    }
}
