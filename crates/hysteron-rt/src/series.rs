//! Elementary functions with a removable singularity at 0, accurate through it.

use crate::real::{Real, Scalar};

/// 1/1!, −1/2!, 1/3!, … : coefficients of E(x) = (1 − e⁻ˣ)/x.
const E: [f64; 14] = [
    1.0,
    -1.0 / 2.0,
    1.0 / 6.0,
    -1.0 / 24.0,
    1.0 / 120.0,
    -1.0 / 720.0,
    1.0 / 5040.0,
    -1.0 / 40320.0,
    1.0 / 362880.0,
    -1.0 / 3628800.0,
    1.0 / 39916800.0,
    -1.0 / 479001600.0,
    1.0 / 6227020800.0,
    -1.0 / 87178291200.0,
];

/// (e⁻ˣ, (1 − e⁻ˣ)/κ) for x = κ d; the second is d where κ = 0.
///
/// Up to |x| = [`Real::SMALL`] a polynomial of degree 6, up to ½ of degree 13 (truncation x¹⁴/15! ≤ 4.7e-17), beyond
/// that the exponential function: each within 2 units in the last place.
#[inline(always)]
pub(crate) fn relaxation<S: Scalar>(kappa: S, d: S) -> (S, S) {
    let x = kappa * d;
    let size = x.value().abs();
    let of = S::Real::of;
    if size <= S::Real::SMALL {
        // 1 − e⁻ˣ = x E(x), evaluated in independent halves to shorten the chain of dependent operations.
        let x2 = x * x;
        let x4 = x2 * x2;
        let low = x.scale(of(E[1])).shift(of(E[0]));
        let mid = x.scale(of(E[3])).shift(of(E[2]));
        let high = x.scale(of(E[5])).shift(of(E[4])) + x2.scale(of(E[6]));
        let ratio = low + (mid * x2 + high * x4);
        ((-(x * ratio)).shift(of(1.0)), d * ratio)
    } else if size <= of(0.5) {
        let ratio = E.iter().rev().fold(S::constant(of(0.0)), |sum, &c| (sum * x).shift(of(c)));
        ((-(x * ratio)).shift(of(1.0)), d * ratio)
    } else {
        let e = (-x).exp();
        (e, (-e).shift(of(1.0)) / kappa)
    }
}

/// ln(1 + κ r)/κ; r where κ = 0.
#[inline]
pub(crate) fn log_distance<S: Scalar>(kappa: S, r: S) -> S {
    let y = kappa * r;
    if y.value().abs() <= S::Real::of(1e-3) {
        // ln(1 + y)/y = 1 − y/2 + y²/3 − … , truncation y⁶/7.
        let ratio =
            (1..=6).rev().fold(S::constant(S::Real::of(0.0)), |sum, k| -(sum * y) + reciprocal::<S>(k));
        r * ratio
    } else {
        y.ln_1p() / kappa
    }
}

/// 1/k as a constant.
#[inline]
pub(crate) fn reciprocal<S: Scalar>(k: u8) -> S {
    S::constant(S::Real::of(1.0 / f64::from(k)))
}

/// Coefficients of tanh(√y)/√y = tan(√−y)/√−y.
const T: [f64; 8] = [
    1.0,
    -1.0 / 3.0,
    2.0 / 15.0,
    -17.0 / 315.0,
    62.0 / 2835.0,
    -1382.0 / 155925.0,
    21844.0 / 6081075.0,
    -929569.0 / 638512875.0,
];

/// How tanh(√(aκ) h)/√(aκ) continues for aκ < 0.
pub(crate) enum Tangent<S> {
    /// The value T.
    Finite(S),
    /// aκ < 0 and √(−aκ) h ≥ π/2: the tangent has gone through its pole.
    PastPole,
}

/// T = tanh(√q h)/√q, = tan(√−q h)/√−q for q < 0, = h for q = 0; q = a κ, h ≥ 0.
#[inline]
pub(crate) fn tangent<S: Scalar>(a: S, kappa: S, h: S) -> Tangent<S> {
    let y = (a * h) * (kappa * h);
    let of = S::Real::of;
    if y.value().abs() <= of(0.015625) {
        // Truncation 5.9e-4 y⁸ ≤ 2e-18.
        let ratio = T.iter().rev().fold(S::constant(of(0.0)), |sum, &c| (sum * y).shift(of(c)));
        return Tangent::Finite(h * ratio);
    }
    // Root by root: a κ may overflow where its root does not.
    let root = absolute(a).sqrt() * absolute(kappa).sqrt();
    let angle = root * h;
    if (a.value() > of(0.0)) == (kappa.value() > of(0.0)) {
        Tangent::Finite(angle.tanh() / root)
    } else if angle.value() >= of(core::f64::consts::FRAC_PI_2) {
        Tangent::PastPole
    } else {
        Tangent::Finite(angle.tan() / root)
    }
}

/// The h ≥ 0 at which [`tangent`] is t ≥ 0 (for q > 0: √q t < 1).
#[inline]
pub(crate) fn inverse_tangent<S: Scalar>(a: S, kappa: S, t: S) -> S {
    let of = S::Real::of;
    let y = (a * t) * (kappa * t);
    if y.value().abs() <= of(1e-3) {
        // artanh(√y)/√y = 1 + y/3 + y²/5 + …, truncation y⁶/13.
        let ratio = (0..6_u8).rev().fold(S::constant(of(0.0)), |sum, k| sum * y + reciprocal::<S>(2 * k + 1));
        return t * ratio;
    }
    let root = absolute(a).sqrt() * absolute(kappa).sqrt();
    let x = root * t;
    let angle = if (a.value() > of(0.0)) == (kappa.value() > of(0.0)) {
        (x.scale(of(2.0)) / (-x).shift(of(1.0))).ln_1p().scale(of(0.5))
    } else {
        x.atan()
    };
    angle / root
}

/// |x|.
#[inline(always)]
pub(crate) fn absolute<S: Scalar>(x: S) -> S {
    if x.value() < S::Real::of(0.0) { -x } else { x }
}
