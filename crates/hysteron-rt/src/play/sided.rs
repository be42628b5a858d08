//! Weighted sums of plays between [`Sides`], and a piecewise-linear output function.

use super::{BrokenLine, Sides, between};
use crate::ParameterError;
use crate::real::Real;

/// A weighted sum Σ wⱼ Fⱼ of plays between [`Sides`], and a [`BrokenLine`] of their mean.
///
/// A step has a constant cost: two comparisons, a product and a sum a play, and the sides. The states are
/// borrowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SidedPlays<'a, T> {
    sides: Sides<T>,
    thresholds: &'a [T],
    weights: &'a [T],
    line: Option<BrokenLine<'a, T>>,
}

impl<'a, T: Real> SidedPlays<'a, T> {
    /// The sum. Thresholds are positive and increase; the first of plays between envelopes may be 0, lines
    /// need only increase.
    ///
    /// # Errors
    /// [`ParameterError`].
    pub fn new(sides: Sides<T>, thresholds: &'a [T], weights: &'a [T]) -> Result<Self, ParameterError<T>> {
        let zero = T::of(0.0);
        let positive = |x: T| x.is_finite() && x > zero;
        let (sound, count) = match sides {
            Sides::Even { widening } => (widening.is_finite() && widening >= zero, thresholds.len()),
            Sides::Below => (true, thresholds.len()),
            Sides::Envelopes { right: [a_r, c_r], left: [a_l, c_l] } => {
                (positive(a_r) && positive(a_l) && c_r.is_finite() && c_l.is_finite(), thresholds.len())
            }
            Sides::Ramps { steepness } => {
                (positive(steepness), thresholds.len() * (thresholds.len() + 1) / 2)
            }
        };
        if !sound {
            return Err(ParameterError::Sides);
        }
        if weights.len() != count {
            return Err(ParameterError::Lengths { thresholds: count, weights: weights.len() });
        }
        let mut above = match sides {
            Sides::Even { .. } | Sides::Below => zero,
            Sides::Envelopes { .. } => -T::LEAST_NORMAL,
            Sides::Ramps { .. } => T::of(f64::NEG_INFINITY),
        };
        for (index, &value) in thresholds.iter().enumerate() {
            if !(value.is_finite() && value > above) {
                return Err(ParameterError::Threshold { index, value, above });
            }
            above = value;
        }
        for (index, &value) in weights.iter().enumerate() {
            if !value.is_finite() {
                return Err(ParameterError::Weight { index, value });
            }
        }
        Ok(Self { sides, thresholds, weights, line: None })
    }

    /// These plays with a [`BrokenLine`] of their mean added to the output.
    ///
    /// # Errors
    /// [`ParameterError::Lengths`] where there is not one share a play.
    pub fn with_line(self, line: BrokenLine<'a, T>) -> Result<Self, ParameterError<T>> {
        let (thresholds, weights) = (self.weights.len(), line.shares().len());
        if thresholds != weights {
            return Err(ParameterError::Lengths { thresholds, weights });
        }
        Ok(Self { line: Some(line), ..self })
    }

    /// Number of plays.
    pub fn count(&self) -> usize {
        self.weights.len()
    }

    /// Whether the plays depend on the rate: they then move at constant voltage, too.
    pub fn sees_rate(&self) -> bool {
        matches!(self.sides, Sides::Even { widening } if widening > T::of(0.0))
    }

    /// Output after a monotone move through `middle` to `u` in a sample that moves by `du`; NaN where the
    /// sides of a play cross. The middle, which may be u itself, matters to plays that depend on the rate
    /// alone, whose sides contract when a sample is slower than the last.
    #[inline]
    pub fn look(&self, states: &[T], [middle, u]: [T; 2], du: T) -> T {
        let mut sum = T::of(0.0);
        let mut behind = T::of(0.0);
        let shares = self.line.map_or(&[][..], |line| line.shares());
        let mut shares = shares.iter();
        let plays = states.iter().zip(self.weights);
        let stands = self.sides.each(self.thresholds(), [middle, u], du, plays, |(state, weight), sides| {
            let moved = between(sides, *state);
            sum = sum + *weight * moved;
            if let Some(share) = shares.next() {
                behind = behind + *share * (moved - u);
            }
        });
        match self.line {
            _ if stands.is_err() => T::of(f64::NAN),
            None => sum,
            Some(line) => sum + line.at(u + behind),
        }
    }

    /// Moves the plays, whose sides are known not to cross there.
    #[inline]
    pub fn advance(&self, states: &mut [T], through: [T; 2], du: T) {
        let _ = self.sides.advance(self.thresholds(), states, through, du);
    }

    /// Output of the plays, virgin at `u`; NaN where the sides of one cross.
    pub fn output_at_rest(&self, u: T) -> T {
        let mut sum = T::of(0.0);
        let weights = self.weights.iter();
        let take = |weight: &T, at| sum = sum + *weight * at;
        let stands = self.sides.each_at_rest(self.thresholds(), u, weights, take);
        match self.line {
            _ if stands.is_err() => T::of(f64::NAN),
            None => sum,
            Some(line) => sum + line.at(u),
        }
    }

    /// Makes the plays virgin at `u` ([`Sides::rest_at`]).
    pub fn rest_at(&self, states: &mut [T], u: T) {
        let _ = self.sides.rest_at(self.thresholds(), states, u);
    }

    fn thresholds(&self) -> impl Iterator<Item = T> + Clone + 'a {
        self.thresholds.iter().copied()
    }
}
