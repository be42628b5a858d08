//! Feedforward that adapts: what the reference leaves behind, taken off by weights that learn.

use super::ModelError;
use crate::real::Real;

/// Filtered-x LMS: c = Σ wᵢ xᵢ, x the newest samples of the reference, every `stride`th of them, and
///
/// w ← (1 − leak) w + rate · e x'/(ε + |x'|²),  x' = s ∗ x,
///
/// s the answer of the displacement to c, e the error that was seen (D. R. Morgan, *IEEE Trans. Acoust. Speech Signal Process.* 28 (1980) 454–467,
/// doi:10.1109/TASSP.1980.1163430). The weights are the caller's and start where they stand: 0 changes nothing.
#[derive(Debug)]
pub struct FilteredLms<'a, T> {
    weights: &'a mut [T],
    /// The reference and the same behind the secondary path, rings: `at` is where the newest goes next.
    references: &'a mut [T],
    filtered: &'a mut [T],
    secondary: &'a [T],
    stride: usize,
    at: usize,
    settings: LmsSettings<T>,
}

/// How fast weights learn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LmsSettings<T> {
    /// Share of the error that a step takes off, 0 < rate < 2.
    pub rate: T,
    /// Share of the weights that a step forgets, 0 ≤ leak < 1.
    pub leak: T,
    /// Least |x'|² that is divided by.
    pub floor: T,
}

impl<'a, T: Real> FilteredLms<'a, T> {
    /// The filter, its past 0. The rings are of one length, which holds weights × stride and the secondary path.
    ///
    /// # Errors
    /// [`ModelError::Memory`] where the lengths do not fit, [`ModelError::Coefficient`] for a number that is not allowed.
    pub fn new(
        weights: &'a mut [T],
        secondary: &'a [T],
        [references, filtered]: [&'a mut [T]; 2],
        stride: usize,
        settings: LmsSettings<T>,
    ) -> Result<Self, ModelError<T>> {
        let taps = weights.len().saturating_mul(stride.max(1)).max(secondary.len()).max(1);
        for found in [references.len(), filtered.len()] {
            if found != taps {
                return Err(ModelError::Memory { expected: taps, found });
            }
        }
        let zero = T::of(0.0);
        let LmsSettings { rate, leak, floor } = settings;
        let sound = rate > zero
            && rate < T::of(2.0)
            && leak >= zero
            && leak < T::of(1.0)
            && floor > zero
            && floor.is_finite()
            && weights.iter().chain(secondary.iter()).all(|x| x.is_finite());
        if !sound {
            return Err(ModelError::Coefficient);
        }
        references.fill(zero);
        filtered.fill(zero);
        Ok(Self { weights, references, filtered, secondary, stride: stride.max(1), at: 0, settings })
    }

    /// The correction for the next period, from the newest of the reference (less its level) and the newest error, reference less displacement; numbers
    /// that are not finite count as 0.
    #[inline]
    pub fn step(&mut self, reference: T, error: T) -> T {
        let zero = T::of(0.0);
        let clean = |x: T| if x.is_finite() { x } else { zero };
        let (reference, error) = (clean(reference), clean(error));
        // The error belongs to what was put out before: learn first.
        let mut power = self.settings.floor;
        for x in strided(self.filtered, self.at, self.stride).take(self.weights.len()) {
            power = power + x * x;
        }
        let gain = self.settings.rate * error / power;
        let keep = T::of(1.0) - self.settings.leak;
        for (w, x) in self.weights.iter_mut().zip(strided(self.filtered, self.at, self.stride)) {
            *w = clean(keep * *w + gain * x);
        }
        if let Some(slot) = self.references.get_mut(self.at) {
            *slot = reference;
        }
        let next = if self.at + 1 >= self.references.len() { 0 } else { self.at + 1 };
        let mut behind = zero;
        for (s, x) in self.secondary.iter().zip(strided(self.references, next, 1)) {
            behind = behind + *s * x;
        }
        if let Some(slot) = self.filtered.get_mut(self.at) {
            *slot = behind;
        }
        self.at = next;
        let mut correction = zero;
        for (w, x) in self.weights.iter().zip(strided(self.references, self.at, self.stride)) {
            correction = correction + *w * x;
        }
        correction
    }

    /// The weights.
    pub fn weights(&self) -> &[T] {
        self.weights
    }
}

/// Samples of a ring, the newest first, every `stride`th.
fn strided<T: Real>(ring: &[T], at: usize, stride: usize) -> impl Iterator<Item = T> + '_ {
    let (older, newer) = ring.split_at_checked(at).unwrap_or((&[], ring));
    older.iter().rev().chain(newer.iter().rev()).copied().step_by(stride.max(1))
}
