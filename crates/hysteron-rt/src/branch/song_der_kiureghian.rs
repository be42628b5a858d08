//! Song's and Der Kiureghian's law: Bouc–Wen without the symmetry of rising and falling.

use super::law::{BranchLaw, Change, law_numbers, single};
use crate::bouc_wen::BoucWen;
use crate::increment::IncrementMemory;
use crate::real::Real;

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

impl<T: Real> BranchLaw<T> for SongDerKiureghian<T> {
    const C: &'static str = include_str!("song_der_kiureghian.c");

    fn is_sound(&self, states: usize) -> bool {
        let mut finite = true;
        self.for_each_number(|_, beta| finite &= beta.is_finite());
        states == 1 && finite
    }

    #[inline(always)]
    fn change(&self, memory: &[IncrementMemory<T>], from: T, to: T) -> Change<T> {
        Change::of_one(self.increment(single(memory), from, to))
    }
}

impl<T: Real> SongDerKiureghian<T> {
    /// At u of one sign a move is one of Bouc–Wen with β = β₁ + s (β₃ sgn u + β₅), γ = s (β₂ sgn u + β₄) + β₆
    /// sgn u; it is split where u passes 0.
    #[inline]
    fn increment(&self, y: T, from: T, to: T) -> T {
        let zero = T::of(0.0);
        let Self { beta_1: b1, beta_2: b2, beta_3: b3, beta_4: b4, beta_5: b5, beta_6: b6 } = *self;
        let leg = |negative: bool, y: T, by: T| {
            let side = |x: T| if negative { -x } else { x };
            let s = |x: T| if by < zero { -x } else { x };
            let (beta, gamma) = (b1 + s(side(b3) + b5), s(side(b2) + b4) + side(b6));
            match BoucWen::unit(beta, gamma, T::of(1.0)) {
                Ok(operator) => operator.increment(y, by),
                Err(_) => T::of(f64::NAN),
            }
        };
        if from * to < zero {
            let first = leg(from < zero, y, -from);
            return first + leg(to < zero, y + first, to);
        }
        leg(if to == zero { from < zero } else { to < zero }, y, to - from)
    }
}
