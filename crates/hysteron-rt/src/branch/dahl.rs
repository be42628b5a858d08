//! Dahl's law.

use super::law::{BranchLaw, law_numbers, not_negative, positive};
use crate::ParameterError;
use crate::real::{Real, Scalar};
use crate::series::{log_distance, passed, signed};

law_numbers! {
    /// dy/du = (1 − s y/`reach`)^`exponent` (P. R. Dahl 1976, doi:10.2514/3.61511): one state, exact.
    Dahl {
        /// Where y saturates, > 0.
        reach,
        /// Exponent, ≥ 0.
        exponent,
    }
}

impl<S: Scalar> BranchLaw<S> for Dahl<S> {
    const C: &'static str = include_str!("dahl.c");

    fn check(&self) -> Result<(), ParameterError<S::Real>> {
        positive("Dahl reach", self.reach.value())?;
        not_negative("Dahl exponent", self.exponent.value())
    }

    /// With x = 1 − s y/reach: x ← x exp(−ln(1 + (i − 1) q)/(i − 1)), q = xⁱ⁻¹ |Δ|/reach, continuous through
    /// i = 1; for i < 1 x reaches 0 and stays.
    #[inline]
    fn increment(&self, y: S, from: S, to: S) -> S {
        let Self { reach, exponent } = *self;
        let (zero, one) = (S::Real::of(0.0), S::Real::of(1.0));
        let by = to - from;
        let down = by.value() < zero;
        let x = (-(signed(y, down) / reach)).shift(one);
        if x.value() <= zero {
            return signed(reach * x, down);
        }
        let over = exponent.shift(-one);
        let q = x.powf(over) * (signed(by, down) / reach);
        if over.value() * q.value() > -one {
            signed(reach * (x * passed(log_distance(over, q))), down)
        } else {
            signed(reach * x, down)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For i < 1 the state reaches its end within finite way, and stays; from beyond it returns there.
    #[test]
    fn a_state_at_its_end_stays() {
        let law = Dahl { reach: 2.0_f64, exponent: 0.5 };
        for (y, from, to, moved) in
            [(2.0, 0.0, 1.0, 0.0), (-2.0, 1.0, 0.0, 0.0), (2.25, 0.0, 1.0, -0.25), (-2.25, 0.0, -1.0, 0.25)]
        {
            assert_eq!(law.increment(y, from, to), moved);
        }
    }
}
