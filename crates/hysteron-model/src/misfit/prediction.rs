//! The misfit predicted for one drive, and the band that it gives.

use std::f64::consts::PI;
use std::ops::Range;

use hysteron_numeric::normal::{probability, quantile};
use rayon::prelude::*;

use super::basis::{ColumnGroup, GROUPS};
use super::{COLUMNS, MisfitModel};

/// Factor on the half-width of the Gaussian model, for what the basis does not hold. It was set on simulated
/// devices of the first four sorts in `docs/theory/uncertainty.md`; the study scores other sorts.
pub(super) const WIDENING: f64 = 1.6;
/// Rows processed at a time.
const ROWS: usize = 512;

/// Predicted misfit for one drive.
#[derive(Clone, Debug, PartialEq)]
pub struct MisfitPrediction {
    /// Predicted discrepancy y − m about its mean at each sample \[output unit\].
    pub discrepancy: Vec<f64>,
    /// Standard deviation of the discrepancy at each sample \[output unit\].
    pub std_dev: Vec<f64>,
    /// Standard deviation of the residual that the columns do not explain \[output unit\].
    pub noise: f64,
    /// Share of the expected square of the error that rests on the prior, i.e. on other devices, because the
    /// training records do not excite it.
    pub unexcited: f64,
    /// The group of columns with most of it.
    pub unexcited_group: ColumnGroup,
    /// The training records hold loops of one amplitude only.
    pub one_amplitude: bool,
    /// Share of the error that a correction leaves on left-out parts of the training records; 1 where unknown.
    pub left_out: f64,
}

impl MisfitPrediction {
    /// `columns` are means over `factor` samples of a drive of `samples`.
    pub(super) fn new(
        of: &MisfitModel,
        mut columns: Vec<Vec<f64>>,
        (factor, samples): (usize, usize),
    ) -> Self {
        columns.iter_mut().for_each(|column| about_mean(column));
        let rows = columns.first().map_or(0, Vec::len);
        let (mut mean, mut std_dev) = (vec![0.0; rows], vec![0.0; rows]);
        let sums: Vec<Sums> = mean
            .par_chunks_mut(ROWS)
            .zip(std_dev.par_chunks_mut(ROWS))
            .enumerate()
            .map(|(chunk, (mean, std_dev))| {
                let from = chunk * ROWS;
                let part: Vec<&[f64]> = columns.iter().map(|c| &c[from..from + mean.len()]).collect();
                add_product(&part, &of.mean, mean);
                deviation(of, &part, std_dev)
            })
            .collect();
        // In order, independently of the threads.
        let mut total = Sums::default();
        for sums in sums {
            total.variance += sums.variance;
            total.unexcited += sums.unexcited;
            total.groups.iter_mut().zip(sums.groups).for_each(|(to, x)| *to += x);
        }
        let power = mean.iter().map(|m| m * m).sum::<f64>() + rows as f64 * of.noise * of.noise;
        let expected = power + total.variance;
        let groups = GROUPS.iter().zip(total.groups);
        let largest = groups.max_by(|(_, a), (_, b)| a.total_cmp(b)).map(|((group, _), _)| *group);
        Self {
            discrepancy: at_samples(&mean, factor, samples),
            std_dev: at_samples(&std_dev, factor, samples),
            noise: of.noise,
            unexcited: if expected > 0.0 { total.unexcited / expected } else { 0.0 },
            unexcited_group: largest.unwrap_or(ColumnGroup::Memory),
            one_amplitude: of.one_amplitude,
            left_out: of.left_out.unwrap_or(1.0),
        }
    }

    /// Prediction for a part of the drive; the shares are those of the whole.
    #[must_use]
    pub fn part(&self, samples: Range<usize>) -> Self {
        let of = |values: &[f64]| values.get(samples.clone()).unwrap_or_default().to_vec();
        Self { discrepancy: of(&self.discrepancy), std_dev: of(&self.std_dev), ..self.clone() }
    }

    /// What is expected to remain of the misfit beside a model that is corrected by the predicted discrepancy:
    /// its spread alone.
    #[must_use]
    pub fn remaining(mut self) -> Self {
        self.discrepancy.fill(0.0);
        self
    }

    /// What may remain of the misfit beside a corrected model, for its band: the spread, and the share of the
    /// predicted discrepancy that a correction leaves on left-out parts of the training records.
    #[must_use]
    pub fn possibly_remaining(mut self) -> Self {
        self.discrepancy.iter_mut().for_each(|d| *d *= self.left_out);
        self
    }

    /// Half the width of the band around the model that holds a measurement with a probability of `level`,
    /// 0 < `level` < 1, at each sample \[output unit\].
    pub fn half_width(&self, level: f64) -> Vec<f64> {
        let ends = (quantile(level), quantile(0.5 + 0.5 * level));
        let of = |(mean, sd): (&f64, &f64)| WIDENING * half_width(*mean, sd.hypot(self.noise), level, ends);
        self.discrepancy.iter().zip(&self.std_dev).map(of).collect()
    }
}

/// g with P(|N(`mean`, `sd`²)| ≤ g) = `level`: `sd` z + |`mean`|, z between the quantiles `ends` at `level`
/// and at ½ + ½ `level`, by Newton's method.
pub fn half_width(mean: f64, sd: f64, level: f64, (one_sided, two_sided): (f64, f64)) -> f64 {
    let mean = mean.abs();
    if sd <= 0.0 {
        return mean;
    }
    let ratio = mean / sd;
    let density = |x: f64| (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
    // Beyond three standard deviations the far tail is below 1e-6 at the usual levels.
    let mut z = if ratio > 3.0 { one_sided } else { two_sided };
    for _ in 0..30 {
        let excess = probability(z) - probability(-z - 2.0 * ratio) - level;
        let step = excess / (density(z) + density(z + 2.0 * ratio));
        z = (z - step).clamp(one_sided, two_sided.max(one_sided));
        if step.abs() < 1e-10 {
            break;
        }
    }
    mean + sd * z
}

/// Sums over rows.
#[derive(Clone, Copy, Default)]
struct Sums {
    variance: f64,
    unexcited: f64,
    groups: [f64; GROUPS.len()],
}

/// Standard deviation √(Σ_k (f_kᵀ φ)²) of each row.
fn deviation(of: &MisfitModel, columns: &[&[f64]], std_dev: &mut [f64]) -> Sums {
    let mut sums = Sums::default();
    let (mut all, mut part) = (vec![0.0; std_dev.len()], vec![0.0; std_dev.len()]);
    for (direction, information) in of.directions.iter().zip(&of.information) {
        let rests_on_prior = *information < 1.0;
        all.fill(0.0);
        if rests_on_prior {
            let mut first = 0;
            for (sum, (_, count)) in sums.groups.iter_mut().zip(GROUPS) {
                let own = first..(first + count).min(COLUMNS);
                part.fill(0.0);
                add_product(&columns[own.clone()], &direction[own], &mut part);
                all.iter_mut().zip(&part).for_each(|(all, part)| *all += part);
                *sum += part.iter().map(|x| x * x).sum::<f64>();
                first += count;
            }
        } else {
            add_product(columns, direction, &mut all);
        }
        let square: f64 = all.iter().map(|x| x * x).sum();
        sums.variance += square;
        sums.unexcited += if rests_on_prior { square } else { 0.0 };
        std_dev.iter_mut().zip(&all).for_each(|(variance, x)| *variance += x * x);
    }
    std_dev.iter_mut().for_each(|variance| *variance = variance.sqrt());
    sums
}

/// Adds Σ_j `coefficients`\[j\] · column j.
fn add_product(columns: &[&[f64]], coefficients: &[f64], to: &mut [f64]) {
    for (column, c) in columns.iter().zip(coefficients) {
        to.iter_mut().zip(*column).for_each(|(to, x)| *to += c * x);
    }
}

fn about_mean(values: &mut [f64]) {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter_mut().for_each(|v| *v -= mean);
}

/// Values at the centres of blocks of `factor` samples, taken to `samples` samples by straight lines.
fn at_samples(rows: &[f64], factor: usize, samples: usize) -> Vec<f64> {
    if factor <= 1 {
        return rows.to_vec();
    }
    let last = rows.len().saturating_sub(1);
    let centre = 0.5 * (factor - 1) as f64;
    let value = |k: usize| {
        let at = ((k as f64 - centre) / factor as f64).clamp(0.0, last as f64);
        let row = (at.floor() as usize).min(last);
        let share = at - row as f64;
        let of = |row: usize| rows.get(row.min(last)).copied().unwrap_or(0.0);
        (1.0 - share) * of(row) + share * of(row + 1)
    };
    (0..samples).map(value).collect()
}
