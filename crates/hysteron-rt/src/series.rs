//! Elementary functions with a removable singularity at 0, accurate through it.

use crate::real::{Real, Scalar};

/// 1/2!, −1/3!, 1/4!, … : coefficients of G(x) = (1 − E(x))/x = (e⁻ˣ − 1 + x)/x², where E(x) = (1 − e⁻ˣ)/x.
const G: [f64; 13] = [
    1.0 / 2.0,
    -1.0 / 6.0,
    1.0 / 24.0,
    -1.0 / 120.0,
    1.0 / 720.0,
    -1.0 / 5040.0,
    1.0 / 40320.0,
    -1.0 / 362880.0,
    1.0 / 3628800.0,
    -1.0 / 39916800.0,
    1.0 / 479001600.0,
    -1.0 / 6227020800.0,
    1.0 / 87178291200.0,
];

/// (e⁻ˣ, (1 − e⁻ˣ)/κ) for x = κ d; the second is d where κ = 0.
///
/// Up to |x| = [`Real::SMALL`] a polynomial of degree 6, up to ½ of degree 13 (truncation x¹⁴/15! ≤ 4.7e-17),
/// beyond that the exponential function: each within 2 units in the last place.
#[inline(always)]
pub(crate) fn relaxation<S: Scalar>(kappa: S, d: S) -> (S, S) {
    let (rate, distance) = (kappa.value(), d.value());
    if S::HAS_DERIVATIVES {
        let (decay, reach, slope) = relaxation_with_slope(rate, distance);
        let decays = kappa.join(d, decay, [-(distance * decay), -(rate * decay)]);
        (decays, kappa.join(d, reach, [slope, decay]))
    } else {
        let (decay, reach) = match small_remainder(rate * distance) {
            Some(g) => small_relaxation(rate * distance, distance, g),
            None => large_relaxation(rate, distance),
        };
        (S::constant(decay), S::constant(reach))
    }
}

/// 1 − e⁻ˣ.
#[inline(always)]
pub(crate) fn passed<S: Scalar>(x: S) -> S {
    let (decay, passed) = relaxation(S::Real::of(1.0), x.value());
    x.chain(passed, decay)
}

/// [`relaxation`] (bit for bit) and the derivative of its second result with respect to κ: d² E'(x), where
/// E'(x) = (1 + x) G(x) − 1 has no cancellation next to 0.
#[inline(always)]
pub(crate) fn relaxation_with_slope<T: Real>(kappa: T, d: T) -> (T, T, T) {
    let x = kappa * d;
    match small_remainder(x) {
        Some(g) => {
            let (decay, reach) = small_relaxation(x, d, g);
            (decay, reach, d * d * (g + x * g - T::of(1.0)))
        }
        None => {
            let (decay, reach) = large_relaxation(kappa, d);
            (decay, reach, (d * decay - reach) / kappa)
        }
    }
}

/// [`relaxation`] from `g` = G(x).
#[inline(always)]
fn small_relaxation<T: Real>(x: T, d: T, g: T) -> (T, T) {
    let one = T::of(1.0);
    let ratio = one - x * g;
    (one - x * ratio, d * ratio)
}

/// [`relaxation`] from the exponential function.
#[inline(always)]
fn large_relaxation<T: Real>(kappa: T, d: T) -> (T, T) {
    let e = (-(kappa * d)).exp();
    (e, (T::of(1.0) - e) / kappa)
}

/// G(x) where |x| ≤ ½, in independent parts to shorten the dependency chain.
#[inline(always)]
fn small_remainder<T: Real>(x: T) -> Option<T> {
    let size = x.abs();
    let pair = |i: usize| pair(x, i);
    if size <= T::SMALL {
        let x2 = x * x;
        return Some((pair(0) + pair(2) * x2) + pair(4) * (x2 * x2));
    }
    if size <= T::of(0.5) {
        let x2 = x * x;
        let x4 = x2 * x2;
        let low = pair(0) + pair(2) * x2;
        let middle = pair(4) + pair(6) * x2;
        let high = (pair(8) + pair(10) * x2) + x4 * T::of(G[12]);
        return Some(low + (middle + high * x4) * x4);
    }
    None
}

/// G_i + G_{i+1} x.
#[inline(always)]
fn pair<T: Real>(x: T, i: usize) -> T {
    match (G.get(i), G.get(i + 1)) {
        (Some(&low), Some(&high)) => x * T::of(high) + T::of(low),
        _ => T::of(0.0),
    }
}

/// ln(1 + κ r)/κ, accurate through κ = 0, where it is r.
#[inline]
pub(crate) fn log_distance<S: Scalar>(kappa: S, r: S) -> S {
    let one = S::Real::of(1.0);
    let (rate, way) = (kappa.value(), r.value());
    let y = rate * way;
    let (value, slope) = if y.abs() <= S::Real::of(1e-3) {
        // ln(1 + y)/y = 1 − y/2 + y²/3 − … , truncation y⁶/7, and its derivative.
        let (mut ratio, mut slope) = (S::Real::of(0.0), S::Real::of(0.0));
        for k in (1..=6).rev() {
            slope = -(ratio + slope * y);
            ratio = reciprocal::<S::Real>(k) - ratio * y;
        }
        (way * ratio, way * way * slope)
    } else {
        let value = y.ln_1p() / rate;
        (value, (way / (one + y) - value) / rate)
    };
    kappa.join(r, value, [slope, one / (one + y)])
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

/// tanh(√(aκ) h)/√(aκ), continued to aκ < 0.
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

/// −x where `negative`, else x.
#[inline(always)]
pub(crate) fn signed<S: Scalar>(x: S, negative: bool) -> S {
    if negative { -x } else { x }
}

/// |x|.
#[inline(always)]
pub(crate) fn absolute<S: Scalar>(x: S) -> S {
    signed(x, x.value() < S::Real::of(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance in units of ε of the wanted value.
    fn units(got: f64, want: f64, epsilon: f64) -> f64 {
        ((got - want) / (want * epsilon)).abs()
    }

    #[test]
    fn relaxation_is_within_two_units_of_libm_on_every_tier() {
        let (mut worst, mut worst_single) = (0.0_f64, 0.0_f64);
        for k in -40_000..=40_000_i32 {
            // From 1e-9 to 20, dense about every seam.
            let x = f64::from(k.signum()) * 20.0 * (f64::from(k.abs()) / 40_000.0).powi(6) + 1e-9;
            let (e, reach) = relaxation(x, 1.0);
            worst = worst.max(units(e, libm::exp(-x), f64::EPSILON));
            worst = worst.max(units(reach, -libm::expm1(-x) / x, f64::EPSILON));
            let single = x as f32;
            let x = f64::from(single);
            let (e, reach) = relaxation(single, 1.0);
            worst_single = worst_single.max(units(f64::from(e), libm::exp(-x), f64::from(f32::EPSILON)));
            worst_single =
                worst_single.max(units(f64::from(reach), -libm::expm1(-x) / x, f64::from(f32::EPSILON)));
        }
        assert!(worst <= 2.0, "f64: {worst} units");
        assert!(worst_single <= 2.0, "f32: {worst_single} units");
        assert_eq!(relaxation(0.0, 3.0), (1.0, 3.0));
    }

    #[test]
    fn derivatives_of_the_relaxation_are_those_of_its_definition() {
        for (kappa, d) in [(0.3, 1.7), (-2.5, 0.8), (4.0, 0.01)] {
            let of = |value: f64, index: usize| crate::Dual::<f64, 2>::variable(value, index);
            let (decay, reach) = relaxation(of(kappa, 0), of(d, 1));
            let e = libm::exp(-kappa * d);
            let wanted = [[-d * e, -kappa * e], [(d * e - (1.0 - e) / kappa) / kappa, e]];
            for (found, wanted) in [decay, reach].iter().zip(wanted) {
                for (found, wanted) in found.partials.iter().zip(wanted) {
                    assert!((found - wanted).abs() < 1e-11 * wanted.abs(), "{kappa} {d}: {found} {wanted}");
                }
            }
        }
    }

    #[test]
    fn slope_of_the_relaxation_is_its_series_on_every_tier() {
        // d² E'(x), E'(x) = Σ (−1)ᵏ k xᵏ⁻¹/(k+1)!: up to |x| = 2 the series is an oracle good to a few units.
        for k in -4000..=4000_i32 {
            let x = f64::from(k.signum()) * 2.0 * (f64::from(k.abs()) / 4000.0).powi(4);
            let (mut term, mut want) = (1.0, 0.0);
            for k in 1..40_i32 {
                term *= -1.0 / f64::from(k + 1);
                want += f64::from(k) * term * x.powi(k - 1);
            }
            let d = 1.25;
            let (decay, reach, slope) = relaxation_with_slope(x / d, d);
            assert_eq!((decay, reach), relaxation(x / d, d));
            assert!(units(slope, d * d * want, f64::EPSILON) <= 12.0, "x {x:e}: {slope:e} {want:e}");
        }
    }

    #[test]
    fn tangent_and_its_inverse_meet_libm_through_zero() {
        for k in -3000..=3000_i32 {
            let a = f64::from(k) / 1500.0;
            let h = 1.1_f64;
            let root = a.abs().sqrt();
            let want = if a > 0.0 {
                libm::tanh(root * h) / root
            } else if a < 0.0 {
                libm::tan(root * h) / root
            } else {
                h
            };
            match tangent(a, 1.0, h) {
                Tangent::Finite(t) => {
                    // The tangent loses (condition number) what it gains in size towards its pole.
                    let condition = 1.0 + root * h * (1.0 + (root * want).powi(2)) / (root * want).max(0.1);
                    assert!(units(t, want, f64::EPSILON) <= 3.0 * condition, "a {a}: {t} {want}");
                    let inverse_condition = if a > 0.0 { (2.0 * root * h).exp() } else { 1.0 };
                    let back = inverse_tangent(a, 1.0, t);
                    assert!(units(back, h, f64::EPSILON) <= 6.0 * inverse_condition, "a {a}: {back}");
                }
                Tangent::PastPole => assert!(a < 0.0 && root * h > core::f64::consts::FRAC_PI_2, "a {a}"),
            }
        }
    }

    #[test]
    fn log_distance_inverts_the_relaxation() {
        for kappa in [-0.7, -1e-4, -1e-12, 0.0, 1e-12, 9e-4, 1.1e-3, 0.4, 3.0] {
            let d = 1.3;
            // From z = −r with rise 1 and rate κ: 0 is reached where r = (e^{κd} − 1)/κ.
            let r = if kappa == 0.0 { d } else { libm::expm1(kappa * d) / kappa };
            let bound = 4.0 * (1.0 + kappa.abs() * r);
            assert!(units(log_distance(kappa, r), d, f64::EPSILON) <= bound, "κ {kappa}");
        }
    }
}
