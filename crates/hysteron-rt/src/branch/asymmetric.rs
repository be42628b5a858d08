//! Bouc–Wen operators without the symmetry of rising and falling.

use super::duhem::moments;
use super::root::rising_root;
use crate::bouc_wen::BoucWen;
use crate::real::Real;

/// At u of one sign a move is one of Bouc–Wen with β = β₁ + s (β₃ sgn u + β₅), γ = s (β₂ sgn u + β₄) + β₆ sgn u; it is split where u passes 0.
#[inline]
pub(super) fn song_der_kiureghian<T: Real>(betas: [T; 6], y: T, from: T, to: T) -> T {
    let zero = T::of(0.0);
    let [b1, b2, b3, b4, b5, b6] = betas;
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

/// Where y and 1 + δ s u keep their signs, Δy = t m₀(κt) (s + δu − κy) + δ s t² m₁(κt), t = |Δu|, κ = β + s γ sgn y; a move is split where
/// one of them changes sign.
#[inline]
pub(super) fn non_symmetric<T: Real>([beta, gamma, delta]: [T; 3], y: T, from: T, to: T) -> T {
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
