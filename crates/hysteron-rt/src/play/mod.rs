//! Play (backlash) operators, one monotone move at a time, and the exact inverse of the move.

mod broken_line;
mod error;
mod relaxing;
mod sided;
mod sides;

pub use broken_line::{BrokenLine, each_band};
pub use error::PlayError;
pub use relaxing::{RelaxingMove, RelaxingPlays, SLOPES, bernstein_integrals};
pub use sided::SidedPlays;
pub use sides::{Sides, between_ramps, ramp};

use crate::ParameterError;
use crate::real::{Real, Scalar};

/// State of a play operator of half-width `threshold` (r ≥ 0) after a monotone move of its input to `u`:
/// max(u − r, min(u + r, `state`)).
///
/// Units: all three in those of the input (V).
#[inline(always)]
pub fn play<S: Scalar>(threshold: S, state: S, u: S) -> S {
    between([u - threshold, u + threshold], state)
}

/// State of a play between two sides, max(`low`, min(`high`, `state`)): at `low` where they cross.
#[inline(always)]
pub fn between<S: Scalar>(sides: [S; 2], mut state: S) -> S {
    push(&mut state, sides);
    state
}

/// Moves a play [`between`] its sides: with derivatives it takes those of the side that pushes it, and keeps
/// its own where none does.
#[inline(always)]
fn push<S: Scalar>(state: &mut S, [low, high]: [S; 2]) {
    let (lowest, highest, before) = (low.value(), high.value(), state.value());
    if !S::HAS_DERIVATIVES {
        // Plain numbers by minimum and maximum, without a branch; duals are copied only where they change.
        let held = if before > highest { highest } else { before };
        *state = S::constant(if held < lowest { lowest } else { held });
    } else if before < lowest {
        *state = low;
    } else if before > highest {
        *state = if highest < lowest { low } else { high };
    }
}

/// A weighted sum of play operators, Σ wᵢ F_rᵢ\[u\], 0 < r₁ < r₂ < … (Prandtl–Ishlinskii operator).
///
/// The states of the plays, borrowed, are the whole memory: the present voltage is not needed. In one move
/// from states fᵢ the sum is continuous and piecewise linear in the voltage reached, with breakpoints fᵢ ±
/// rᵢ. Plays that share one history obey |fᵢ₊₁ − fᵢ| ≤ rᵢ₊₁ − rᵢ, so that they engage one after the other,
/// the narrowest first, and [`Self::inverse`] finds its piece in one scan.
///
/// Units: u, rᵢ and fᵢ in V, wᵢ in µm/V. Any other consistent set will do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlayBank<'a, T> {
    thresholds: &'a [T],
    weights: &'a [T],
    least_slope: T,
}

/// One linear piece of a move: all u with l(u) + `slope`·u = `rest`, where the sum is Σ wᵢ F_rᵢ = v − l(u).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearPiece<T> {
    /// Σ wᵢ over the plays that move.
    pub slope: T,
    /// v less what the plays add to slope·u.
    pub rest: T,
    /// Voltage at which the piece begins, where it does.
    pub low: Option<T>,
    /// Voltage at which the piece ends, where it does.
    pub high: Option<T>,
}

impl<'a, T: Real> PlayBank<'a, T> {
    /// The sum of plays with these thresholds and weights. Weights may have any sign.
    ///
    /// # Errors
    /// [`ParameterError`]: lengths that differ, thresholds not finite, positive and increasing, weights not
    /// finite.
    pub fn new(thresholds: &'a [T], weights: &'a [T]) -> Result<Self, ParameterError<T>> {
        let zero = T::of(0.0);
        if weights.len() != thresholds.len() {
            return Err(ParameterError::Lengths { thresholds: thresholds.len(), weights: weights.len() });
        }
        let (mut above, mut slope, mut least_slope) = (zero, zero, zero);
        for (index, (&threshold, &weight)) in thresholds.iter().zip(weights).enumerate() {
            if !(threshold.is_finite() && threshold > above) {
                return Err(ParameterError::Threshold { index, value: threshold, above });
            }
            if !weight.is_finite() {
                return Err(ParameterError::Weight { index, value: weight });
            }
            above = threshold;
            slope = slope + weight;
            if slope < least_slope {
                least_slope = slope;
            }
        }
        Ok(Self { thresholds, weights, least_slope })
    }

    /// Half-widths rᵢ.
    pub fn thresholds(&self) -> &'a [T] {
        self.thresholds
    }

    /// Weights wᵢ.
    pub fn weights(&self) -> &'a [T] {
        self.weights
    }

    /// Smallest slope along a move: min over k ≥ 0 of w₁ + … + w_k. Never positive: just after a reversal no
    /// play moves.
    pub fn least_slope(&self) -> T {
        self.least_slope
    }

    /// Moves the plays monotonically to `u` and returns Σ wᵢ F_rᵢ.
    ///
    /// # Errors
    /// [`PlayError::Lengths`], [`PlayError::NotFinite`] (u, or a state), [`PlayError::Overflow`]; the states
    /// are then as they were.
    #[inline]
    pub fn step(&self, states: &mut [T], u: T) -> Result<T, PlayError<T>> {
        self.check(states)?;
        if !u.is_finite() {
            return Err(PlayError::NotFinite);
        }
        let sum = self.look(states, u);
        if !sum.is_finite() {
            let sound = states.iter().all(|state| state.is_finite());
            return Err(if sound { PlayError::Overflow } else { PlayError::NotFinite });
        }
        self.advance(states, u);
        Ok(sum)
    }

    /// Σ wᵢ F_rᵢ after a monotone move to `u`; no state changes.
    #[inline(always)]
    pub fn look(&self, states: &[T], u: T) -> T {
        let plays = self.thresholds.iter().zip(self.weights).zip(states);
        plays
            .fold(T::of(0.0), |sum, ((threshold, weight), state)| sum + *weight * play(*threshold, *state, u))
    }

    /// Moves the plays to `u`.
    #[inline(always)]
    pub fn advance(&self, states: &mut [T], u: T) {
        for (&threshold, state) in self.thresholds.iter().zip(states) {
            *state = play(threshold, *state, u);
        }
    }

    /// The voltage u to which one monotone move from `states` gives slope·u + Σ wᵢ F_rᵢ = `v`, exact but for
    /// rounding; one scan of the plays. The states are not moved: follow with [`Self::step`].
    ///
    /// It exists for every v and is unique where every partial slope, slope + w₁ + … + w_k for k ≥ 0, is
    /// positive (P. Krejčí, K. Kuhnen, *IEE Proc. Control Theory Appl.* 148 (2001) 185–192,
    /// doi:10.1049/ip-cta:20010375).
    ///
    /// # Errors
    /// [`PlayError::Slope`] where a partial slope is not positive; otherwise as [`Self::piece`].
    pub fn inverse(&self, slope: T, states: &[T], v: T) -> Result<T, PlayError<T>> {
        let least = slope + self.least_slope;
        if !(slope.is_finite() && least > T::of(0.0)) {
            return Err(PlayError::Slope { least });
        }
        let piece = self.piece(states, v, |u| slope * u)?;
        let u = piece.rest / (slope + piece.slope);
        if u.is_finite() { Ok(u) } else { Err(PlayError::Overflow) }
    }

    /// The piece of the move on which l(u) + Σ wᵢ F_rᵢ reaches `v`. l must be so steep that the whole
    /// increases with u (l' + [`Self::least_slope`] > 0); it is evaluated at breakpoints alone.
    ///
    /// # Errors
    /// [`PlayError`]: lengths that differ, numbers that are not finite, or states that no common history
    /// produces.
    pub fn piece(
        &self,
        states: &[T],
        v: T,
        mut l: impl FnMut(T) -> T,
    ) -> Result<LinearPiece<T>, PlayError<T>> {
        self.check(states)?;
        self.check_history(states)?;
        let plays = || self.thresholds.iter().zip(self.weights).zip(states);
        let mut rest = v;
        for ((_, &weight), &state) in plays() {
            rest = rest - weight * state;
        }
        if !rest.is_finite() {
            return Err(if v.is_finite() { PlayError::Overflow } else { PlayError::NotFinite });
        }
        // Upwards the plays engage at fᵢ + rᵢ, downwards at fᵢ − rᵢ; each then adds wᵢ (u − its breakpoint).
        let mut piece = LinearPiece { slope: T::of(0.0), rest, low: None, high: None };
        for ((&threshold, &weight), &state) in plays() {
            let from = state + threshold;
            if l(from) + piece.slope * from >= piece.rest {
                piece.high = Some(from);
                break;
            }
            piece = LinearPiece {
                slope: piece.slope + weight,
                rest: piece.rest + weight * from,
                low: Some(from),
                high: None,
            };
        }
        if piece.low.is_some() {
            return Ok(piece);
        }
        for ((&threshold, &weight), &state) in plays() {
            let from = state - threshold;
            if l(from) + piece.slope * from <= piece.rest {
                piece.low = Some(from);
                break;
            }
            piece = LinearPiece {
                slope: piece.slope + weight,
                rest: piece.rest + weight * from,
                low: None,
                high: Some(from),
            };
        }
        Ok(piece)
    }

    fn check(&self, states: &[T]) -> Result<(), PlayError<T>> {
        if states.len() == self.thresholds.len() {
            Ok(())
        } else {
            Err(PlayError::Lengths { expected: self.thresholds.len(), found: states.len() })
        }
    }

    /// |fᵢ₊₁ − fᵢ| ≤ rᵢ₊₁ − rᵢ, but for rounding.
    fn check_history(&self, states: &[T]) -> Result<(), PlayError<T>> {
        let mut plays = self.thresholds.iter().zip(states);
        let Some((mut r, mut f)) = plays.next() else { return Ok(()) };
        if !f.is_finite() {
            return Err(PlayError::NotFinite);
        }
        for (index, (next_r, next_f)) in plays.enumerate() {
            if !next_f.is_finite() {
                return Err(PlayError::NotFinite);
            }
            // Each state is one rounded difference of a voltage and a threshold.
            let rounding = T::of(4.0) * T::EPSILON * (f.abs() + next_f.abs() + *next_r);
            if (*next_f - *f).abs() > *next_r - *r + rounding {
                return Err(PlayError::History { index: index + 1 });
            }
            (r, f) = (next_r, next_f);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dual;

    /// max(low, min(high, state)) and the derivative of the one that it is, where sides cross too.
    #[test]
    fn a_play_takes_the_derivative_of_the_side_that_holds_it() {
        let at = |value: f64, index: usize| Dual::<f64, 3>::variable(value, index);
        for (low, high, state, holds) in [
            (-1.0, 2.0, 5.0, 1),
            (-1.0, 2.0, -5.0, 0),
            (-1.0, 2.0, 0.5, 2),
            (3.0, 2.0, 5.0, 0),
            (3.0, 2.0, 1.0, 0),
        ] {
            let found = between([at(low, 0), at(high, 1)], at(state, 2));
            assert_eq!(found.value, f64::max(low, f64::min(high, state)));
            assert_eq!(found.value, between([low, high], state));
            let expected = [0, 1, 2].map(|k| f64::from(u8::from(k == holds)));
            assert_eq!(found.partials, expected, "{low} {high} {state}");
        }
    }
}
