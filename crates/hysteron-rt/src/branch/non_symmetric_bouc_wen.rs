//! Zhu's and Wang's law: Bouc–Wen with a term that makes its loop asymmetric.

use super::law::{BranchLaw, Change, is_positive, law_numbers, single};
use super::{moments, rising_root};
use crate::increment::IncrementMemory;
use crate::real::Real;

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

impl<T: Real> BranchLaw<T> for NonSymmetricBoucWen<T> {
    const C: &'static str = include_str!("non_symmetric_bouc_wen.c");

    fn is_sound(&self, states: usize) -> bool {
        let Self { beta, gamma, delta } = *self;
        states == 1 && is_positive(beta) && beta >= gamma.abs() && delta.is_finite()
    }

    #[inline(always)]
    fn change(&self, memory: &[IncrementMemory<T>], from: T, to: T) -> Change<T> {
        let Self { beta, gamma, delta } = *self;
        Change::of_one(increment([beta, gamma, delta], single(memory), from, to))
    }
}

/// Where y and 1 + δ s u keep their signs, Δy = t m₀(κt) (s + δu − κy) + δ s t² m₁(κt), t = |Δu|, κ = β + s γ
/// sgn y; a move is split where one of them changes sign.
#[inline]
fn increment<T: Real>([beta, gamma, delta]: [T; 3], y: T, from: T, to: T) -> T {
    let zero = T::of(0.0);
    let s = if to < from { -T::of(1.0) } else { T::of(1.0) };
    let law = [beta, gamma, delta];
    if delta != zero {
        let turn = -s / delta;
        if (turn - from) * s > zero && (to - turn) * s > zero {
            let first = leg(law, s, y, from, turn);
            return first + leg(law, s, y + first, turn, to);
        }
    }
    leg(law, s, y, from, to)
}

/// A move on which 1 + δ s u keeps its sign.
fn leg<T: Real>([beta, gamma, delta]: [T; 3], s: T, y: T, from: T, to: T) -> T {
    let zero = T::of(0.0);
    let way = (to - from) * s;
    let drive = s + delta * (T::of(0.5) * from + T::of(0.5) * to);
    let negative = if y == zero { drive < zero } else { y < zero };
    let kappa = |negative: bool| beta + if negative { -(s * gamma) } else { s * gamma };
    let rate = kappa(negative);
    let end = along(delta, rate, s, from, y, way);
    if if negative { y + end <= zero } else { y + end >= zero } {
        return end;
    }
    // y passes 0 once, towards the drive, with the slope s + δu there.
    let outwards = |t: T| {
        let state = y + along(delta, rate, s, from, y, t);
        let slope = s + delta * (from + s * t) - rate * state;
        if negative { (state, slope) } else { (-state, -slope) }
    };
    let t = rising_root(outwards, zero, way, T::of(0.5) * way);
    -y + along(delta, kappa(!negative), s, from + s * t, zero, way - t)
}

/// Δy after a way t at the rate κ.
#[inline(always)]
fn along<T: Real>(delta: T, kappa: T, s: T, u: T, y: T, t: T) -> T {
    let [m_0, m_1, ..] = moments(kappa * t, 2);
    t * m_0 * (s + delta * u - kappa * y) + delta * s * t * t * m_1
}
