//! Mean of a hysteresis operator between two samples.

use crate::real::Real;

/// Joins the outputs v of a hysteresis operator so that a polygon through what comes out has the means of v.
///
/// Driven along a straight line an operator puts out a curve. By Simpson's rule the line from v₀ to v₁ leaves
/// out the mean c = ⅔ (v_½ − ½ (v₀ + v₁)), and dynamics much slower than a sample see nothing else of it.
/// Polygon w with w = v + c at the end of the move: over two like moves its mean is that of v. (The batch
/// simulation adds half the c of either side, and so needs the move to come.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Means<T> {
    last: T,
}

impl<T: Real> Means<T> {
    /// After a rest at the output `v`.
    pub fn at(v: T) -> Self {
        Self { last: v }
    }

    /// w at the end of a move, from v half-way and at the end.
    #[inline(always)]
    pub fn join(&mut self, middle: T, v: T) -> T {
        let left_out = T::of(2.0 / 3.0) * (middle - T::of(0.5) * (self.last + v));
        self.last = v;
        v + left_out
    }
}
