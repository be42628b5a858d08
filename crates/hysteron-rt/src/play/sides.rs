//! Sides of plays, and their motion.

use super::{between, push};
use crate::real::{Real, Scalar};

/// The two sides of a play at the voltage u: its state x becomes max(low, min(high, x)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sides<T> {
    /// u ∓ (rⱼ + `widening` |Δu|), Δu the move of this sample: `widening` ≥ 0 is the growth of a half-width
    /// for a move of 1 V a sample (M. Al Janaideh, P. Krejčí 2013, doi:10.1109/TMECH.2012.2205265); 0 for
    /// plays.
    Even {
        /// λ times the sample rate.
        widening: T,
    },
    /// From u − rⱼ to u: one-sided plays.
    Below,
    /// From tanh(a_r (u − c_r)) − rⱼ to tanh(a_l (u − c_l)) + rⱼ: generalised plays (M. Al Janaideh, S.
    /// Rakheja, C.-Y. Su 2011, doi:10.1109/TMECH.2010.2052366). A voltage at which the sides of the narrowest
    /// cross is out of range.
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
    /// The sides with their parameters mapped, e.g. to another number type.
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

impl<S: Scalar> Sides<S> {
    /// Moves plays of these thresholds (lines of ramps) monotonically through `middle` to `u` in a sample
    /// that moves by `du`, as [`super::SidedPlays::look`].
    ///
    /// # Errors
    /// Height of the right envelope above the left where the sides of the narrowest play cross; no state
    /// changes then.
    #[inline(always)]
    pub fn advance(
        &self,
        thresholds: impl Iterator<Item = S> + Clone,
        states: &mut [S],
        through: [S; 2],
        du: S::Real,
    ) -> Result<(), S::Real> {
        let items = states.iter_mut();
        self.each(thresholds, through, du, items, |state, sides| push(state, sides))
    }

    /// Makes plays of these thresholds virgin at `u`: at u, in the middle of the envelopes, on the ramp
    /// half-way between their lines.
    ///
    /// # Errors
    /// Those of [`Self::advance`]; the plays are moved nevertheless.
    pub fn rest_at(
        &self,
        thresholds: impl Iterator<Item = S> + Clone,
        states: &mut [S],
        u: S,
    ) -> Result<(), S::Real> {
        self.each_at_rest(thresholds, u, states.iter_mut(), |state, at| *state = at)
    }

    /// Calls `take` with each item and the sides of its play.
    #[inline(always)]
    pub(super) fn each<I>(
        &self,
        thresholds: impl Iterator<Item = S> + Clone,
        [middle, u]: [S; 2],
        du: S::Real,
        items: impl Iterator<Item = I>,
        mut take: impl FnMut(I, [S; 2]),
    ) -> Result<(), S::Real> {
        match *self {
            Self::Even { widening } => {
                let wider = widening.scale(du.abs());
                // First the sides in the middle, then those at the end: upwards the low one at the end
                // decides, downwards the high one.
                let falls = middle.value() > u.value();
                let (low, high) = if falls { (middle, u) } else { (u, middle) };
                for (item, threshold) in items.zip(thresholds) {
                    let r = threshold + wider;
                    let (low, high) = (low - r, high + r);
                    take(item, [if falls && low.value() > high.value() { high } else { low }, high]);
                }
            }
            Self::Below => items.zip(thresholds).for_each(|(item, r)| take(item, [u - r, u])),
            Self::Envelopes { right, left } => {
                let (right, left) = (envelope(right, u), envelope(left, u));
                has_place(thresholds.clone(), right, left)?;
                items.zip(thresholds).for_each(|(item, r)| take(item, [right - r, left + r]));
            }
            Self::Ramps { steepness } => {
                each_pair(thresholds, |line| ramp(steepness, u - line), items, take);
            }
        }
        Ok(())
    }

    /// Calls `take` with each item and the virgin state of its play.
    pub(super) fn each_at_rest<I>(
        &self,
        thresholds: impl Iterator<Item = S> + Clone,
        u: S,
        items: impl Iterator<Item = I>,
        mut take: impl FnMut(I, S),
    ) -> Result<(), S::Real> {
        let half = S::Real::of(0.5);
        match *self {
            Self::Even { .. } | Self::Below => items.for_each(|item| take(item, u)),
            Self::Envelopes { right, left } => {
                let (right, left) = (envelope(right, u), envelope(left, u));
                let middle = (right + left).scale(half);
                items.for_each(|item| take(item, middle));
                return has_place(thresholds, right, left);
            }
            Self::Ramps { steepness } => {
                each_pair(
                    thresholds,
                    |line| line.scale(half),
                    items,
                    |item, [line, other]| {
                        take(item, ramp(steepness, u - (line + other)));
                    },
                );
            }
        }
        Ok(())
    }
}

/// Checks that the sides of the narrowest play do not cross at these values of the envelopes.
#[inline(always)]
fn has_place<S: Scalar>(mut thresholds: impl Iterator<Item = S>, right: S, left: S) -> Result<(), S::Real> {
    let narrowest = thresholds.next().map_or(S::Real::of(0.0), S::value);
    let rounding = S::Real::of(4.0) * S::Real::EPSILON;
    let by = right.value() - left.value();
    if by <= S::Real::of(2.0) * narrowest + rounding { Ok(()) } else { Err(by) }
}

/// Calls `take` with each item and its pair of mapped lines, in the order (0, 0), (1, 0), (1, 1), (2, 0), ….
#[inline(always)]
fn each_pair<L, S: Copy, I>(
    lines: impl Iterator<Item = L> + Clone,
    of: impl Fn(L) -> S,
    mut items: impl Iterator<Item = I>,
    mut take: impl FnMut(I, [S; 2]),
) {
    for (index, line) in lines.clone().enumerate() {
        let (own, others) = (of(line), lines.clone().take(index + 1));
        others.zip(items.by_ref()).for_each(|(other, item)| take(item, [own, of(other)]));
    }
}

/// Moves Krasnosel'skii–Pokrovskii kernels ([`Sides::Ramps`]), given the [`ramp`] of each line.
#[inline]
pub fn between_ramps<S: Scalar>(ramps: &[S], states: &mut [S]) {
    let take = |state: &mut S, [low, high]: [&S; 2]| push(state, [*low, *high]);
    each_pair(ramps.iter(), |ramp| ramp, states.iter_mut(), take);
}

/// ρ(x) = max(−1, min(1, `steepness` x)).
#[inline(always)]
pub fn ramp<S: Scalar>(steepness: S, x: S) -> S {
    let one = S::Real::of(1.0);
    between([S::constant(-one), S::constant(one)], steepness * x)
}

/// tanh(`rise` (u − `centre`)).
#[inline(always)]
fn envelope<S: Scalar>([rise, centre]: [S; 2], u: S) -> S {
    (rise * (u - centre)).tanh()
}
