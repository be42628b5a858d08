//! Dahl's law.

use super::law::{BranchLaw, Change, is_positive, law_numbers, single};
use crate::increment::IncrementMemory;
use crate::real::Real;
use crate::series::{log_distance, relaxation};

law_numbers! {
    /// dy/du = (1 − s y/`reach`)^`exponent` (P. R. Dahl 1976, doi:10.2514/3.61511): one state, exact.
    Dahl {
        /// Where y saturates, > 0.
        reach,
        /// Exponent, ≥ 0.
        exponent,
    }
}

impl<T: Real> BranchLaw<T> for Dahl<T> {
    const C: &'static str = include_str!("dahl.c");

    fn is_sound(&self, states: usize) -> bool {
        let Self { reach, exponent } = *self;
        states == 1 && is_positive(reach) && exponent.is_finite() && exponent >= T::of(0.0)
    }

    #[inline(always)]
    fn change(&self, memory: &[IncrementMemory<T>], from: T, to: T) -> Change<T> {
        Change::of_one(self.increment(single(memory), to - from))
    }
}

impl<T: Real> Dahl<T> {
    /// With x = 1 − s y/reach: x ← x exp(−ln(1 + (i − 1) q)/(i − 1)), q = xⁱ⁻¹ |Δ|/reach, through i = 1
    /// without a seam; for i < 1 x comes to 0 and stays.
    #[inline]
    fn increment(&self, y: T, by: T) -> T {
        let Self { reach, exponent } = *self;
        let (zero, one) = (T::of(0.0), T::of(1.0));
        let turn = |x: T| if by < zero { -x } else { x };
        let x = one - turn(y) / reach;
        if x <= zero {
            return turn(reach * x);
        }
        let over = exponent - one;
        let q = x.powf(over) * (turn(by) / reach);
        let lost = if over * q > -one { relaxation(one, log_distance(over, q)).1 } else { one };
        turn(reach * (x * lost))
    }
}
