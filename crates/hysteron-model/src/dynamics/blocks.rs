//! Blocks that a plan works through: frequencies, polynomials at them, and the powers r^k.

use std::f64::consts::{PI, TAU};

use super::{Scheme, Term};
use hysteron_numeric::{InstructionSet, accumulate_power, scale};

/// Frequencies worked on at a time: the buffers stay in the first-level cache.
pub(super) const BLOCK: usize = 256;

/// (ln |s|, arg s) of `count` bins from `first` on, s = δ(z) · `sample_rate_hz` at
/// z = exp(−`damping` − 2πi·bin/`length`).
pub(super) fn frequencies(
    scheme: Scheme,
    length: usize,
    damping: f64,
    sample_rate_hz: f64,
    first: usize,
    count: usize,
) -> (Vec<f64>, Vec<f64>) {
    let at = |bin: usize| {
        // Exactly π at the Nyquist frequency, so that δ is exactly real there.
        let theta = if 2 * bin == length { PI } else { TAU * bin as f64 / length as f64 };
        let (log_abs, angle) = scheme.log_delta(damping, theta);
        // Where s is 0 or ∞ on the unit circle the response is taken as a limit, see `edges`.
        if log_abs.is_finite() { (log_abs + sample_rate_hz.ln(), angle) } else { (0.0, 0.0) }
    };
    (first..first + count).map(at).unzip()
}

/// Values of a polynomial over one block of frequencies; slot 0 is the last value of the block before.
pub(super) struct Polynomial {
    pub(super) re: [f64; BLOCK + 1],
    pub(super) im: [f64; BLOCK + 1],
}

impl Polynomial {
    pub(super) fn new() -> Self {
        Self { re: [0.0; BLOCK + 1], im: [0.0; BLOCK + 1] }
    }

    pub(super) fn evaluate(&mut self, set: InstructionSet, terms: &[Term], log_abs: &[f64], angle: &[f64]) {
        let constant = terms.iter().filter(|term| term.order == 0.0).map(|term| term.coefficient).sum();
        let (re, im) = (&mut self.re[1..=log_abs.len()], &mut self.im[1..=log_abs.len()]);
        re.fill(constant);
        im.fill(0.0);
        for term in terms.iter().filter(|term| term.order != 0.0 && term.coefficient != 0.0) {
            accumulate_power(set, term.coefficient, term.order, log_abs, angle, re, im);
        }
    }

    pub(super) fn carry(&mut self, last: usize) {
        self.re[0] = self.re[last];
        self.im[0] = self.im[last];
    }
}

/// scale · e^(rate·k), as the product of a coarse and a fine table: less memory to read than one table, for
/// one rounding more.
#[derive(Debug)]
pub(super) struct Exponential {
    coarse: Vec<f64>,
    fine: [f64; BLOCK],
}

impl Exponential {
    pub(super) fn new(rate: f64, scale: f64, count: usize) -> Self {
        let coarse = (0..count.div_ceil(BLOCK)).map(|k| scale * (rate * (k * BLOCK) as f64).exp()).collect();
        Self { coarse, fine: std::array::from_fn(|k| (rate * k as f64).exp()) }
    }

    /// to_k = (from_k + before) · scale · e^(rate·k) + after; false if any result is not finite.
    pub(super) fn multiply(
        &self,
        set: InstructionSet,
        from: &[f64],
        before: f64,
        after: f64,
        to: &mut [f64],
    ) -> bool {
        let mut finite = true;
        for ((to, from), &coarse) in to.chunks_mut(BLOCK).zip(from.chunks(BLOCK)).zip(&self.coarse) {
            finite &= scale(set, from, before, coarse, &self.fine, after, to);
        }
        finite
    }
}
