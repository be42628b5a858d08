//! States updated by increments with compensated summation.

use crate::real::Real;
use crate::saved::Tape;

/// x ← x + δ by compensated summation (W. Kahan 1965, doi:10.1145/363707.363723).
#[inline(always)]
pub(crate) fn accumulate<T: Real>(x: &mut T, carry: &mut T, delta: T) {
    let delta = delta + *carry;
    let sum = *x + delta;
    *carry = delta - (sum - *x);
    *x = sum;
}

/// State updated by increments, with its Kahan compensation. Equality compares these two only.
#[derive(Clone, Copy, Debug)]
pub struct IncrementMemory<T> {
    z: T,
    carry: T,
    /// Both before the last move, read only where that move is taken back.
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

    /// Adds an increment and returns the state.
    #[inline(always)]
    pub(crate) fn advance(&mut self, increment: T) -> T {
        self.before = (self.z, self.carry);
        accumulate(&mut self.z, &mut self.carry, increment);
        self.z
    }

    /// Its members; a move is not taken back once restored.
    pub(crate) fn each_member(&mut self, tape: &mut Tape<'_>) {
        tape.number(&mut self.z);
        tape.number(&mut self.carry);
        self.before = (self.z, self.carry);
    }

    /// Undoes the last move.
    #[inline(always)]
    pub(crate) fn take_back(&mut self) {
        (self.z, self.carry) = self.before;
    }
}
