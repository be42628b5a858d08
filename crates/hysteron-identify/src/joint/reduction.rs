//! Decimation of an oversampled record that leaves the fit nearly unchanged.
//!
//! G is linear and time-invariant, so a low-pass F commutes with it: F y = offset + Σ cᵢ G ∗ F(uⁱ − uⁱ(rest))
//! − α G ∗ F(ζ − ζ(rest)). Measured output and inputs of the dynamics pass the same F before decimation; F is
//! the anti-aliasing filter, and its pass band is kept exactly. White noise keeps its density in the pass
//! band, so that a reduced sample has the weight of `factor` samples.
//!
//! F extends beyond the ends of a record. The fit uses F of the residual, zero-padded at the ends, so that no
//! sample is lost: measured and modelled output must be 0 there. Before the first sample the model's is
//! (inputs, offset and drift are 0). Beyond the last one, for any extension of the inputs, it follows by
//! interpolation of the reduced output, and F of that part is subtracted.

use super::super::uncertainty::positive_sum;
use hysteron_model::record::low_pass;
use hysteron_numeric::{InstructionSet, dot, filter_every};

/// Half length of the low-pass, in reduced samples.
const REACH: usize = 16;
/// Reduced samples that determine F of the output beyond the end, from the first for which F extends to the
/// end.
const BEYOND: usize = 3 * REACH;

/// Low-pass filter and decimation.
#[derive(Clone, Debug)]
pub(in super::super) struct Reduction {
    factor: usize,
    /// F, of odd length and symmetric.
    kernel: Vec<f64>,
    /// Samples of the record.
    samples: usize,
    periodic: bool,
    /// F of the output beyond the end, one row for each of the last [`REACH`] reduced samples in the record.
    beyond: Vec<f64>,
    set: InstructionSet,
}

impl Reduction {
    /// For a record of `samples` samples, in a periodic one a multiple of `factor`.
    pub(super) fn new(factor: usize, samples: usize, periodic: bool) -> Self {
        let kernel = low_pass(factor, REACH);
        let beyond = if periodic { Vec::new() } else { beyond(&kernel, factor, samples) };
        Self { factor, kernel, samples, periodic, beyond, set: InstructionSet::detected() }
    }

    fn half(&self) -> usize {
        self.kernel.len() / 2
    }

    /// Reduced samples of white noise that carry the information of one that is independent: F leaves nothing
    /// between its cut-off and half the reduced rate.
    pub(super) fn correlation_time_of_white(&self) -> f64 {
        let later = |lag: usize| self.kernel.iter().skip(lag * self.factor);
        let products = (0..=REACH).map(|lag| self.kernel.iter().zip(later(lag)).map(|(a, b)| a * b).sum());
        positive_sum(&products.collect::<Vec<f64>>())
    }

    /// Reduced samples before the record, in which F, being non-causal, already responds to its inputs.
    fn lead(&self) -> usize {
        if self.periodic { 0 } else { REACH }
    }

    /// Number of reduced samples, including those before and beyond the record.
    pub(super) fn rows(&self) -> usize {
        let beyond = if self.periodic { 0 } else { 2 * REACH };
        self.lead() + self.samples.div_ceil(self.factor) + beyond
    }

    /// Index of a reduced sample in the record; it may be before the first or beyond the last sample.
    fn place(&self, row: usize) -> isize {
        (row * self.factor) as isize - (self.lead() * self.factor) as isize
    }

    /// Number of reduced samples that depend on the first `changed` samples of an input, and of the samples
    /// that these depend on.
    pub(super) fn beginning(&self, changed: usize) -> (usize, usize) {
        let whole = (self.rows(), self.samples);
        let rows = (changed + self.half()).div_ceil(self.factor) + self.lead();
        let before = self.lead() * self.factor;
        let needed = |rows: usize| ((rows.max(1) - 1) * self.factor + self.half() + 1).checked_sub(before);
        // The reduced samples beyond the end depend on the last ones of the record too.
        let beyond = needed(whole.0).map_or(0, |end| (2 * self.samples).saturating_sub(end + 1));
        match needed(rows) {
            Some(needed) if !self.periodic && needed < self.samples && changed <= beyond => (rows, needed),
            _ => whole,
        }
    }

    /// F of an input of the dynamics, extended by `before` ahead of its first sample and by point reflection
    /// beyond its last, which keeps value and slope. Of the beginning of an input the leading reduced samples
    /// ([`Self::beginning`]). Allocates nothing.
    pub(super) fn input(&self, x: &[f64], before: f64, out: &mut [f64]) {
        let last = x.len() - 1;
        self.filter(x, out, |k| match usize::try_from(k) {
            Ok(k) => 2.0 * x[last] - x[(2 * last).saturating_sub(k)],
            Err(_) => before,
        });
    }

    /// F of the measured output, or of an offset or drift.
    pub(super) fn output(&self, y: &[f64], out: &mut [f64]) {
        self.filter(y, out, |_| 0.0);
    }

    /// F of `x`, extended by `outside` beyond its ends.
    fn filter(&self, x: &[f64], out: &mut [f64], outside: impl Fn(isize) -> f64) {
        // Rows for which F stays within the record; for the first of them it begins at the first sample.
        let start = (self.lead() + REACH).min(out.len());
        let inside = x.len().checked_sub(self.kernel.len()).map_or(0, |left| left / self.factor + 1);
        let end = (start + inside).min(out.len());
        filter_every(self.set, &self.kernel, self.factor, x, &mut out[start..end]);
        let count = x.len() as isize;
        for row in (0..start).chain(end..out.len()) {
            let first = self.place(row) - self.half() as isize;
            let at = |k: isize| match usize::try_from(k) {
                _ if self.periodic => x[k.rem_euclid(count) as usize],
                Ok(inside) if inside < x.len() => x[inside],
                _ => outside(k),
            };
            out[row] = (first..).zip(&self.kernel).map(|(k, h)| h * at(k)).sum();
        }
    }

    /// Subtracts F of the model's output beyond the end from F of the whole output. Allocates nothing.
    pub(super) fn end(&self, model: &mut [f64]) {
        if self.periodic {
            return;
        }
        let start = first_cut(self.factor, self.samples) + self.lead();
        let mut cut = [0.0; REACH];
        for (cut, row) in cut.iter_mut().zip(self.beyond.chunks_exact(BEYOND)) {
            *cut = dot(row, &model[start..start + BEYOND]);
        }
        model[start..].iter_mut().zip(&cut).for_each(|(x, cut)| *x -= cut);
    }

    /// Values at the samples of the record by straight lines between reduced ones, at its ends by those of the
    /// nearest of which F reaches neither end.
    pub(super) fn at_samples(&self, reduced: &[f64]) -> Vec<f64> {
        let inside = self.samples.div_ceil(self.factor);
        let own = &reduced[self.lead()..self.lead() + inside];
        let margin = if self.periodic { 0 } else { REACH.min((inside - 1) / 2) };
        let value = |row: usize| match row {
            row if row == inside && self.periodic => own[0],
            row => own[row.clamp(margin, inside - 1 - margin)],
        };
        let at = |k: usize| {
            let (row, share) = (k / self.factor, (k % self.factor) as f64 / self.factor as f64);
            (1.0 - share) * value(row) + share * value(row + 1)
        };
        (0..self.samples).map(at).collect()
    }

    /// Weights of the reduced samples from those of the record: 0 beyond its ends, and where F covers an
    /// excluded sample.
    pub(super) fn weights(&self, weight: &[f64]) -> Vec<f64> {
        let density = (self.factor as f64).sqrt();
        let (half, count) = (self.half() as isize, weight.len() as isize);
        let mut missing = vec![0usize; weight.len() + 1];
        for (k, weight) in weight.iter().enumerate() {
            missing[k + 1] = missing[k] + usize::from(*weight <= 0.0);
        }
        let complete = |place: isize| {
            if self.periodic {
                return (place - half..=place + half).all(|k| weight[k.rem_euclid(count) as usize] > 0.0);
            }
            let ends = [place - half, place + half + 1].map(|k| missing[k.clamp(0, count) as usize]);
            ends[0] == ends[1]
        };
        (0..self.rows())
            .map(|row| match usize::try_from(self.place(row)) {
                Ok(place) if place < weight.len() && complete(place as isize) => weight[place] * density,
                _ => 0.0,
            })
            .collect()
    }
}

/// Index of the first reduced sample of a record for which F extends beyond the last sample.
fn first_cut(factor: usize, samples: usize) -> usize {
    (samples.saturating_sub(1) / factor + 1).saturating_sub(REACH)
}

/// F of the output beyond the end of a record, y_k = Σ_i φ_(k − factor·i) (reduced y)_i for k ≥ `samples`
/// with φ = factor · F (the low-pass itself interpolates the reduced output), in the reduced samples y_i.
fn beyond(kernel: &[f64], factor: usize, samples: usize) -> Vec<f64> {
    let half = (kernel.len() / 2) as isize;
    let start = first_cut(factor, samples);
    let place = |i: usize| ((start + i) * factor) as isize;
    let entry = |j: usize, i: usize| -> f64 {
        let (own, other) = (place(j), place(i));
        let from = (samples as isize).max(other - half);
        let to = half + own.min(other);
        (from..=to)
            .map(|k| kernel[(half + k - own) as usize] * kernel[(half + k - other) as usize])
            .sum::<f64>()
            * factor as f64
    };
    (0..REACH).flat_map(|j| (0..BEYOND).map(move |i| entry(j, i))).collect()
}

#[cfg(test)]
mod tests;
