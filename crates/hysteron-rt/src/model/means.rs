//! Mean of a hysteresis operator between two samples.

use crate::real::Real;
use crate::saved::Tape;

/// Corrects the outputs v of a hysteresis operator so that their linear interpolation has the means of v.
///
/// Over a linear move the output is curved. By Simpson's rule its mean exceeds that of the chord from v₀ to
/// v₁ by c = ⅔ (v_½ − ½ (v₀ + v₁)), the only effect on dynamics much slower than a sample. With w = v + c at
/// the end of each move, the interpolated w has the mean of v over two equal moves. (The batch simulation
/// adds half the c of either side, and so needs the next move.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Means<T> {
    last: T,
}

impl<T: Real> Means<T> {
    /// Starts from rest at the output `v`.
    pub fn at(v: T) -> Self {
        Self { last: v }
    }

    /// Its members.
    pub(super) fn each_member(&mut self, tape: &mut Tape<'_>) {
        tape.number(&mut self.last);
    }

    /// w at the end of a move, from v half-way and at the end.
    #[inline(always)]
    pub fn join(&mut self, middle: T, v: T) -> T {
        let left_out = T::of(2.0 / 3.0) * (middle - T::of(0.5) * (self.last + v));
        self.last = v;
        v + left_out
    }
}
