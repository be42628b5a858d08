//! An oversampled record at a lower rate, such that a fit of it says the same as one of all samples.
//!
//! G is linear and time-invariant, so a low-pass F commutes with it: F y = offset + Σ cᵢ G ∗ F(uⁱ − uⁱ(rest))
//! − α G ∗ F(ζ − ζ(rest)). Measured output and inputs of the dynamics go through the same F before samples
//! are left out; F stops what would alias, and what it passes is kept exactly. White noise keeps its density
//! in the pass band, so that a reduced sample counts as `factor` samples.
//!
//! F reaches beyond the ends of a record. What is compared is F of the residual, taken 0 beyond the ends, so
//! that no sample is lost: the measured output counts as 0 there, and so must the model's. Before the first
//! sample it is (inputs are 0, and offset and drift count as 0 as well). Beyond the last one, whatever the
//! inputs are taken to do there, it follows from the reduced output between its samples, and F of that is
//! taken off.

use hysteron_model::record::low_pass;
use hysteron_numeric::{InstructionSet, dot, filter_every};

/// Reach of the low-pass to either side, in reduced samples.
const REACH: usize = 16;
/// Reduced samples that F of the output beyond the end is made from, from the first that F reaches the end
/// for.
const BEYOND: usize = 3 * REACH;

/// Low-pass, and every so many samples of what it passes.
#[derive(Clone, Debug)]
pub(in super::super) struct Reduction {
    factor: usize,
    /// F, an odd number of values, even about the middle one.
    kernel: Vec<f64>,
    /// Samples of the record.
    samples: usize,
    periodic: bool,
    /// F of the output beyond the end, for the last [`REACH`] reduced samples in the record, a row each.
    beyond: Vec<f64>,
    set: InstructionSet,
}

impl Reduction {
    /// For a record of `samples` samples; of a periodic one, `factor` divides them.
    pub(super) fn new(factor: usize, samples: usize, periodic: bool) -> Self {
        let kernel = low_pass(factor, REACH);
        let beyond = if periodic { Vec::new() } else { beyond(&kernel, factor, samples) };
        Self { factor, kernel, samples, periodic, beyond, set: InstructionSet::detected() }
    }

    fn half(&self) -> usize {
        self.kernel.len() / 2
    }

    /// Reduced samples before the first of the record, in which F sees its inputs coming.
    fn lead(&self) -> usize {
        if self.periodic { 0 } else { REACH }
    }

    /// Number of reduced samples, with those before and beyond the record.
    pub(super) fn rows(&self) -> usize {
        let beyond = if self.periodic { 0 } else { 2 * REACH };
        self.lead() + self.samples.div_ceil(self.factor) + beyond
    }

    /// Place of a reduced sample in the record; it may lie before its first sample or beyond its last.
    fn place(&self, row: usize) -> isize {
        (row * self.factor) as isize - (self.lead() * self.factor) as isize
    }

    /// F of an input of the dynamics, which is `before` ahead of its first sample. Beyond the last it is
    /// reflected about it, which keeps value and slope. Allocates nothing.
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

    /// F of `x`, which is `outside` beyond its ends.
    fn filter(&self, x: &[f64], out: &mut [f64], outside: impl Fn(isize) -> f64) {
        // Those that F stays within the record for: the first of them reaches to the first sample.
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

    /// Takes F of the model's output beyond the end off F of all of it. Allocates nothing.
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

    /// Weights of the reduced samples from those of the record's: 0 beyond its ends, and where F reaches a
    /// sample without.
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

/// The first reduced sample of a record, counted from its first, that F reaches beyond the last sample for.
fn first_cut(factor: usize, samples: usize) -> usize {
    (samples.saturating_sub(1) / factor + 1).saturating_sub(REACH)
}

/// F of the output beyond the end of a record, y_k = Σ_i φ_(k − factor·i) (reduced y)_i for k ≥ `samples`
/// with φ = factor · F (between its samples a reduced output follows from the low-pass itself), in the
/// reduced samples y_i.
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
