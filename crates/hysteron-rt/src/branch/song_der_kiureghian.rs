//! Song's and Der Kiureghian's law of six coefficients: no symmetry between rising and falling.

use super::law::{BranchLaw, finite, law_numbers};
use crate::ParameterError;
use crate::real::{Real, Scalar};
use crate::series::signed;
use crate::state_law::unit_increment;

law_numbers! {
    /// dy/du = 1 − |y| (β₁ sgn(u̇y) + β₂ sgn(u u̇) + β₃ sgn(uy) + β₄ s + β₅ sgn y + β₆ sgn u) (J. Song, A.
    /// Der Kiureghian 2006, doi:10.1061/(ASCE)0733-9399(2006)132:6(610)): one state, exact.
    SongDerKiureghian {
        /// β₁.
        beta_1,
        /// β₂.
        beta_2,
        /// β₃.
        beta_3,
        /// β₄.
        beta_4,
        /// β₅.
        beta_5,
        /// β₆.
        beta_6,
    }
}

impl<S: Scalar> BranchLaw<S> for SongDerKiureghian<S> {
    const C: &'static str = include_str!("song_der_kiureghian.c");
    const IS_BOUNDED: bool = false;

    fn check(&self) -> Result<(), ParameterError<S::Real>> {
        let mut checked = Ok(());
        self.for_each_number(|_, beta| {
            checked = checked.and(finite("coefficient of Song and Der Kiureghian", beta.value()));
        });
        checked
    }

    /// At u of one sign a move is one of [`crate::StateLaw`] with β = β₁ + s (β₃ sgn u + β₅), γ = s (β₂ sgn u
    /// + β₄) + β₆ sgn u; it is split where u passes 0.
    #[inline]
    fn increment(&self, y: S, from: S, to: S) -> S {
        let zero = S::Real::of(0.0);
        let (below, ends_below) = (from.value() < zero, to.value() < zero);
        if from.value() * to.value() < zero {
            let first = self.leg(below, y, -from);
            return first + self.leg(ends_below, y + first, to);
        }
        self.leg(if to.value() == zero { below } else { ends_below }, y, to - from)
    }
}

impl<S: Scalar> SongDerKiureghian<S> {
    /// A move on one side of u = 0.
    #[inline(always)]
    fn leg(&self, negative: bool, y: S, by: S) -> S {
        let Self { beta_1: b1, beta_2: b2, beta_3: b3, beta_4: b4, beta_5: b5, beta_6: b6 } = *self;
        let down = by.value() < S::Real::of(0.0);
        let beta = b1 + signed(signed(b3, negative) + b5, down);
        let gamma = signed(signed(b2, negative) + b4, down) + signed(b6, negative);
        unit_increment(beta, gamma, y, by)
    }
}
