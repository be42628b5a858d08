//! Plays whose two sides are functions of the voltage, and what is put behind them.

use super::BrokenLine;
use crate::ParameterError;
use crate::real::Real;

/// Between which two sides a play stands at the voltage u: its state goes from x to max(low, min(high, x)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sides<T> {
    /// u ∓ (rⱼ + `widening` |Δu|), Δu the move of this sample: `widening` ≥ 0 is what a half-width grows for
    /// a move of 1 V a sample (M. Al Janaideh, P. Krejčí 2013, doi:10.1109/TMECH.2012.2205265); 0 for plays.
    Even {
        /// λ times the samples a second.
        widening: T,
    },
    /// From u − rⱼ to u: one-sided plays.
    Below,
    /// From tanh(a_r (u − c_r)) − rⱼ to tanh(a_l (u − c_l)) + rⱼ: generalised plays (M. Al Janaideh, S.
    /// Rakheja, C.-Y. Su 2011, doi:10.1109/TMECH.2010.2052366). A voltage at which the narrowest has no place
    /// to stand is out of range.
    Envelopes {
        /// a_r > 0, c_r.
        right: [T; 2],
        /// a_l > 0, c_l.
        left: [T; 2],
    },
    /// From ρ(u − pᵢ) to ρ(u − pⱼ), ρ(x) = max(−1, min(1, `steepness` x)), for every pair pⱼ ≤ pᵢ of lines p,
    /// in the order (0, 0), (1, 0), (1, 1), (2, 0), …: Krasnosel'skii–Pokrovskii kernels. The thresholds are
    /// the lines.
    Ramps {
        /// Twice the reciprocal of the length of a ramp.
        steepness: T,
    },
}

impl<T: Copy> Sides<T> {
    /// The sides with other numbers, or with these in another type.
    pub fn map<U>(self, of: impl Fn(T) -> U) -> Sides<U> {
        match self {
            Self::Even { widening } => Sides::Even { widening: of(widening) },
            Self::Below => Sides::Below,
            Self::Envelopes { right, left } => {
                Sides::Envelopes { right: right.map(&of), left: left.map(&of) }
            }
            Self::Ramps { steepness } => Sides::Ramps { steepness: of(steepness) },
        }
    }
}

/// A weighted sum Σ wⱼ Fⱼ of plays between [`Sides`], and a [`BrokenLine`] of their mean.
///
/// A step costs the same whatever the voltage does: two comparisons, a product and a sum a play, and the
/// sides. The states are the caller's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SidedPlays<'a, T> {
    sides: Sides<T>,
    thresholds: &'a [T],
    weights: &'a [T],
    line: Option<BrokenLine<'a, T>>,
}

impl<'a, T: Real> SidedPlays<'a, T> {
    /// The sum. Thresholds are positive and increase; the first of plays between envelopes may be 0, lines
    /// increase alone.
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

    /// Whether the plays see how far a sample moves: to the voltage where they stand, too, they are moved
    /// again.
    pub fn sees_rate(&self) -> bool {
        matches!(self.sides, Sides::Even { widening } if widening > T::of(0.0))
    }

    /// Output after a monotone move through `middle` to `u` in a sample that moves by `du`; not a number
    /// where a play has no place to stand. The middle, which may be u itself, matters to rate-dependent plays
    /// alone: a fast sample leaves one behind, and a slow one takes it to the sides where it begins.
    #[inline]
    pub fn look(&self, states: &[T], [middle, u]: [T; 2], du: T) -> T {
        let mut sum = T::of(0.0);
        let mut behind = T::of(0.0);
        let shares = self.line.map_or(&[][..], |line| line.shares());
        let mut shares = shares.iter();
        let stands = self.each([middle, u], du, states.iter().zip(self.weights), |(state, weight), sides| {
            let moved = between(sides, *state);
            sum = sum + *weight * moved;
            if let Some(share) = shares.next() {
                behind = behind + *share * (moved - u);
            }
        });
        match self.line {
            _ if !stands => T::of(f64::NAN),
            None => sum,
            Some(line) => sum + line.at(u + behind),
        }
    }

    /// Moves the plays, which are known to have a place there.
    #[inline]
    pub fn advance(&self, states: &mut [T], through: [T; 2], du: T) {
        self.each(through, du, states.iter_mut(), |state, sides| *state = between(sides, *state));
    }

    /// Output of the plays, virgin at `u`; not a number where one has no place to stand.
    pub fn output_at_rest(&self, u: T) -> T {
        let mut sum = T::of(0.0);
        let stands = self.each_at_rest(u, self.weights.iter(), |weight, at| sum = sum + *weight * at);
        match self.line {
            _ if !stands => T::of(f64::NAN),
            None => sum,
            Some(line) => sum + line.at(u),
        }
    }

    /// Makes the plays virgin at `u`: at u, in the middle of the envelopes, on the ramp half-way between
    /// their lines.
    pub fn rest_at(&self, states: &mut [T], u: T) {
        self.each_at_rest(u, states.iter_mut(), |state, at| *state = at);
    }

    /// Hands each item the sides of its play. Whether every one has a place to stand.
    #[inline(always)]
    fn each<I>(
        &self,
        [middle, u]: [T; 2],
        du: T,
        items: impl Iterator<Item = I>,
        mut take: impl FnMut(I, [T; 2]),
    ) -> bool {
        match self.sides {
            Sides::Even { widening } => {
                let wider = widening * du.abs();
                // First the sides in the middle, then those at the end: upwards the low one at the end
                // decides, downwards the high one.
                let (low, high) = if middle > u { (middle, u) } else { (u, middle) };
                for (item, &threshold) in items.zip(self.thresholds) {
                    let r = threshold + wider;
                    let (low, high) = (low - r, high + r);
                    take(item, [if middle > u && low > high { high } else { low }, high]);
                }
            }
            Sides::Below => {
                for (item, &r) in items.zip(self.thresholds) {
                    take(item, [u - r, u]);
                }
            }
            Sides::Envelopes { right, left } => {
                let (right, left) = (envelope(right, u), envelope(left, u));
                if !self.stands_between(right, left) {
                    return false;
                }
                for (item, &r) in items.zip(self.thresholds) {
                    take(item, [right - r, left + r]);
                }
            }
            Sides::Ramps { steepness } => {
                let mut items = items;
                for (index, &line) in self.thresholds.iter().enumerate() {
                    let low = ramp(steepness, u - line);
                    for (&other, item) in self.thresholds.iter().take(index + 1).zip(&mut items) {
                        take(item, [low, ramp(steepness, u - other)]);
                    }
                }
            }
        }
        true
    }

    /// Whether the narrowest play has a place to stand between these values of the envelopes.
    #[inline(always)]
    fn stands_between(&self, right: T, left: T) -> bool {
        let narrowest = self.thresholds.first().copied().unwrap_or(T::of(0.0));
        right - left <= T::of(2.0) * narrowest + T::of(4.0) * T::EPSILON
    }

    /// Hands each item where its play is virgin. Whether every one has a place to stand.
    fn each_at_rest<I>(&self, u: T, items: impl Iterator<Item = I>, mut take: impl FnMut(I, T)) -> bool {
        match self.sides {
            Sides::Even { .. } | Sides::Below => items.for_each(|item| take(item, u)),
            Sides::Envelopes { right, left } => {
                let (right, left) = (envelope(right, u), envelope(left, u));
                let middle = T::of(0.5) * (right + left);
                items.for_each(|item| take(item, middle));
                return self.stands_between(right, left);
            }
            Sides::Ramps { steepness } => {
                let mut items = items;
                for (index, &line) in self.thresholds.iter().enumerate() {
                    for (&other, item) in self.thresholds.iter().take(index + 1).zip(&mut items) {
                        take(item, ramp(steepness, u - (T::of(0.5) * line + T::of(0.5) * other)));
                    }
                }
            }
        }
        true
    }
}

/// `state`, pushed as far as its sides push it; at `low` where they cross.
#[inline(always)]
fn between<T: Real>([low, high]: [T; 2], state: T) -> T {
    let held = if state > high { high } else { state };
    if held < low { low } else { held }
}

#[inline(always)]
fn envelope<T: Real>([rise, centre]: [T; 2], u: T) -> T {
    (rise * (u - centre)).tanh()
}

#[inline(always)]
fn ramp<T: Real>(steepness: T, x: T) -> T {
    let one = T::of(1.0);
    between([-one, one], steepness * x)
}
