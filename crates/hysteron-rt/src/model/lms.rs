//! Adaptive feedforward by filtered-x LMS.

use super::ModelError;
use super::operator::in_range;
use crate::real::Real;

/// Filtered-x LMS: c = Σ wᵢ xᵢ, x the newest samples of the reference, every `stride`th of them, and
///
/// w ← (1 − leak) w + rate · e M x'/(ε + x'ᵀ M x'),  x' = s ∗ x,
///
/// s the impulse response from c to the displacement, e the measured error (D. R. Morgan, *IEEE Trans.
/// Acoust. Speech Signal Process.* 28 (1980) 454–467, doi:10.1109/TASSP.1980.1163430). The weights are
/// borrowed and start from their present values; at 0 there is no correction.
///
/// Samples of a slow reference are strongly correlated, and with M = 1 directions of small variance converge
/// slowly. M, the inverse of the expected covariance of x', makes all directions converge equally fast
/// (LMS–Newton: B. Widrow, S. D. Stearns, *Adaptive Signal Processing*, Prentice-Hall 1985, chapter 8).
#[derive(Debug)]
pub struct FilteredLms<'a, T> {
    filter: LmsFilter<'a, T>,
    memory: LmsMemory<'a, T>,
    at: usize,
    settings: LmsSettings<T>,
}

/// Weights and transforms of a [`FilteredLms`].
#[derive(Debug)]
pub struct LmsFilter<'a, T> {
    /// w.
    pub weights: &'a mut [T],
    /// s, the newest first.
    pub secondary: &'a [T],
    /// M row by row, symmetric and positive definite; empty for M = 1.
    pub whitening: &'a [T],
    /// Samples from one weight to the next.
    pub stride: usize,
}

/// State of a [`FilteredLms`].
#[derive(Debug)]
pub struct LmsMemory<'a, T> {
    /// Ring buffer of [`LmsFilter::ring`] samples of the reference.
    pub references: &'a mut [T],
    /// Ring buffer of the reference filtered by the secondary path, of the same length.
    pub filtered: &'a mut [T],
    /// M x', as many as weights.
    pub turned: &'a mut [T],
}

impl<T> LmsFilter<'_, T> {
    /// Length of the ring buffers, for weights × stride and for the secondary path.
    pub fn ring(&self) -> usize {
        self.weights.len().saturating_mul(self.stride.max(1)).max(self.secondary.len()).max(1)
    }
}

/// Step size and leakage of the weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LmsSettings<T> {
    /// Step size, the fraction of the error that a step removes, 0 < rate < 2.
    pub rate: T,
    /// Leakage of the weights in a step, 0 ≤ leak < 1.
    pub leak: T,
    /// Regulariser ε > 0 of the normalisation.
    pub floor: T,
}

impl<'a, T: Real> FilteredLms<'a, T> {
    /// The filter with zero history.
    ///
    /// # Errors
    /// [`ModelError::Memory`] where the lengths do not fit, [`ModelError::Coefficient`] for a number that is
    /// not allowed.
    pub fn new(
        filter: LmsFilter<'a, T>,
        memory: LmsMemory<'a, T>,
        settings: LmsSettings<T>,
    ) -> Result<Self, ModelError<T>> {
        let (ring, taps) = (filter.ring(), filter.weights.len());
        let square = if filter.whitening.is_empty() { 0 } else { taps.saturating_mul(taps) };
        for (expected, found) in [
            (ring, memory.references.len()),
            (ring, memory.filtered.len()),
            (taps, memory.turned.len()),
            (square, filter.whitening.len()),
        ] {
            if found != expected {
                return Err(ModelError::Memory { expected, found });
            }
        }
        let zero = T::of(0.0);
        let LmsSettings { rate, leak, floor } = settings;
        let mut numbers = filter.weights.iter().chain(filter.secondary).chain(filter.whitening);
        let sound = rate > zero
            && rate < T::of(2.0)
            && leak >= zero
            && leak < T::of(1.0)
            && floor > zero
            && floor.is_finite()
            && numbers.all(|x| x.is_finite());
        if !sound {
            return Err(ModelError::Coefficient);
        }
        memory.references.fill(zero);
        memory.filtered.fill(zero);
        let filter = LmsFilter { stride: filter.stride.max(1), ..filter };
        Ok(Self { filter, memory, at: 0, settings })
    }

    /// The correction for the next period, from the newest of the reference (less its level) and the newest
    /// error, reference less displacement; numbers that are not finite, or above [`Real::LARGEST`], count as
    /// 0.
    #[inline]
    pub fn step(&mut self, reference: T, error: T) -> T {
        let Self { filter, memory, at, settings } = self;
        let zero = T::of(0.0);
        let clean = |x: T| if x.is_finite() { x } else { zero };
        let sane = |x: T| if in_range(x) { x } else { zero };
        let (reference, error) = (sane(reference), sane(error));
        // The error belongs to past corrections: update first.
        let seen = || strided(memory.filtered, *at, filter.stride);
        let mut power = settings.floor;
        if filter.whitening.is_empty() {
            for (turned, x) in memory.turned.iter_mut().zip(seen()) {
                *turned = x;
                power = power + x * x;
            }
        } else {
            let rows = filter.whitening.chunks(filter.weights.len().max(1));
            for ((turned, x), row) in memory.turned.iter_mut().zip(seen()).zip(rows) {
                *turned = zero;
                for (m, x) in row.iter().zip(seen()) {
                    *turned = *turned + *m * x;
                }
                power = power + x * *turned;
            }
        }
        let gain = settings.rate * error / power;
        let keep = T::of(1.0) - settings.leak;
        for (w, turned) in filter.weights.iter_mut().zip(memory.turned.iter()) {
            *w = clean(keep * *w + gain * *turned);
        }
        if let Some(slot) = memory.references.get_mut(*at) {
            *slot = reference;
        }
        let next = if *at + 1 >= memory.references.len() { 0 } else { *at + 1 };
        let mut behind = zero;
        for (s, x) in filter.secondary.iter().zip(strided(memory.references, next, 1)) {
            behind = behind + *s * x;
        }
        if let Some(slot) = memory.filtered.get_mut(*at) {
            *slot = behind;
        }
        *at = next;
        let mut correction = zero;
        for (w, x) in filter.weights.iter().zip(strided(memory.references, next, filter.stride)) {
            correction = correction + *w * x;
        }
        correction
    }

    /// The weights.
    pub fn weights(&self) -> &[T] {
        self.filter.weights
    }
}

/// Samples of a ring, the newest first, every `stride`th.
fn strided<T: Real>(ring: &[T], at: usize, stride: usize) -> impl Iterator<Item = T> + '_ {
    let (older, newer) = ring.split_at_checked(at).unwrap_or((&[], ring));
    older.iter().rev().chain(newer.iter().rev()).copied().step_by(stride.max(1))
}
