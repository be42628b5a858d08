//! Zhu's and Wang's law: Bouc–Wen with a term that makes its loop asymmetric.

use super::law::{BranchLaw, finite, law_numbers, number};
use super::moments::moments;
use super::root::rising_root;
use crate::ParameterError;
use crate::real::{Real, Scalar};
use crate::series::signed;

law_numbers! {
    /// dy/du = 1 − (β s + γ sgn y) y + δ s u, β ≥ |γ| (W. Zhu, D.-H. Wang 2012,
    /// doi:10.1016/j.sna.2012.03.048): one state, exact.
    NonSymmetricBoucWen {
        /// β > 0.
        beta,
        /// γ.
        gamma,
        /// δ.
        delta,
    }
}

impl<S: Scalar> BranchLaw<S> for NonSymmetricBoucWen<S> {
    const C: &'static str = include_str!("non_symmetric_bouc_wen.c");

    fn check(&self) -> Result<(), ParameterError<S::Real>> {
        let [beta, gamma, delta] = [self.beta, self.gamma, self.delta].map(S::value);
        finite("non-symmetrical Bouc–Wen γ", gamma)?;
        finite("non-symmetrical Bouc–Wen δ", delta)?;
        let is_sound = beta.is_finite() && beta > S::Real::of(0.0) && beta >= gamma.abs();
        number("non-symmetrical Bouc–Wen β", beta, is_sound, "finite, positive and at least |γ|")
    }

    /// Where y and 1 + δ s u keep their signs, Δy = t m₀(κt) (s + δu − κy) + δ s t² m₁(κt), t = |Δu|, κ = β +
    /// s γ sgn y; a move is split where one of them changes sign.
    #[inline]
    fn increment(&self, y: S, from: S, to: S) -> S {
        let zero = S::Real::of(0.0);
        let down = to.value() < from.value();
        if self.delta.value() != zero {
            let turn = S::constant(signed(S::Real::of(-1.0), down)) / self.delta;
            if signed(turn - from, down).value() > zero && signed(to - turn, down).value() > zero {
                let first = self.leg(down, y, from, turn);
                return first + self.leg(down, y + first, turn, to);
            }
        }
        self.leg(down, y, from, to)
    }
}

impl<S: Scalar> NonSymmetricBoucWen<S> {
    /// A move on which 1 + δ s u keeps its sign.
    fn leg(&self, down: bool, y: S, from: S, to: S) -> S {
        let [zero, half] = [0.0, 0.5].map(S::Real::of);
        let s = signed(S::Real::of(1.0), down);
        let way = signed(to - from, down);
        let drive = s + self.delta.value() * (half * from.value() + half * to.value());
        let negative = if y.value() == zero { drive < zero } else { y.value() < zero };
        let kappa =
            |negative: bool| if negative == down { self.beta + self.gamma } else { self.beta - self.gamma };
        let rate = kappa(negative);
        let end = along([self.delta, rate, from, y], s, way);
        let state = y.value() + end.value();
        if if negative { state <= zero } else { state >= zero } {
            return end;
        }
        // y passes 0 once, towards the drive, with the slope s + δu there.
        let values = [self.delta, rate, from, y].map(S::value);
        let [delta, kappa_there, u, _] = values;
        let outwards = |t: S::Real| {
            let state = y.value() + along(values, s, t);
            let slope = s + delta * (u + s * t) - kappa_there * state;
            if negative { (state, slope) } else { (-state, -slope) }
        };
        let t = rising_root(outwards, zero, way.value(), half * way.value());
        let t = S::implicit(t, || s + delta * (u + s * t), |t| y + along([self.delta, rate, from, y], s, t));
        -y + along([self.delta, kappa(!negative), from + signed(t, down), S::constant(zero)], s, way - t)
    }
}

/// Δy over the distance t from u at the rate κ.
#[inline(always)]
fn along<S: Scalar>([delta, kappa, u, y]: [S; 4], s: S::Real, t: S) -> S {
    let [m_0, m_1, ..] = moments(kappa * t, 2);
    t * m_0 * ((delta * u).shift(s) - kappa * y) + delta.scale(s) * t * t * m_1
}
