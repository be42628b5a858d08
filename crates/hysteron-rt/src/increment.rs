//! States that move by increments, without losing what rounding takes from them.

use crate::real::Real;

/// x + δ without losing what is smaller than half a unit of x (W. Kahan 1965, doi:10.1145/363707.363723).
#[inline(always)]
pub(crate) fn accumulate<T: Real>(x: &mut T, carry: &mut T, delta: T) {
    let delta = delta + *carry;
    let sum = *x + delta;
    *carry = delta - (sum - *x);
    *x = sum;
}

/// A state that moves by increments (z of a Bouc–Wen operator, say), and what rounding has left of them. Two
/// are equal where they go on alike.
#[derive(Clone, Copy, Debug)]
pub struct IncrementMemory<T> {
    z: T,
    carry: T,
    /// Both before the last move. Nothing waits for them unless that move is taken back.
    before: (T, T),
}

impl<T: PartialEq> PartialEq for IncrementMemory<T> {
    fn eq(&self, other: &Self) -> bool {
        self.z == other.z && self.carry == other.carry
    }
}

impl<T: Real> IncrementMemory<T> {
    /// The state `z`.
    pub fn new(z: T) -> Self {
        Self { z, carry: T::of(0.0), before: (z, T::of(0.0)) }
    }

    /// The state.
    #[inline(always)]
    pub fn z(&self) -> T {
        self.z
    }

    /// Moves by an increment; the state after it.
    #[inline(always)]
    pub(crate) fn advance(&mut self, increment: T) -> T {
        self.before = (self.z, self.carry);
        accumulate(&mut self.z, &mut self.carry, increment);
        self.z
    }

    /// As it was before the last move.
    #[inline(always)]
    pub(crate) fn take_back(&mut self) {
        (self.z, self.carry) = self.before;
    }
}
