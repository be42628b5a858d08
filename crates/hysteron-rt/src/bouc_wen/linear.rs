//! n = 1: dz/d|u| = sα − κ z, relaxation towards sα/κ, with κ = β + s γ sign z (s = sign Δu).

use crate::real::{Real, Scalar};
use crate::series::{log_distance, relaxation};

/// z after a monotone move by `du`: z e^(−κd) + sα (1 − e^(−κd))/κ, split where z passes 0.
#[inline]
pub(super) fn advance<S: Scalar>(alpha: S, beta: S, gamma: S, z: S, du: S::Real) -> S {
    let zero = S::Real::of(0.0);
    let (rise, turn, distance) = if du < zero { (-alpha, -gamma, -du) } else { (alpha, gamma, du) };
    // The sign of z on this leg: on leaving 0 it is the sign of the rise.
    let lead = if z.value() == zero { rise.value() } else { z.value() };
    let kappa = if lead < zero { beta - turn } else { beta + turn };
    let d = S::constant(distance);
    let (decay, reach) = relaxation(kappa, d);
    let end = z * decay + rise * reach;
    if z.value() == zero || (end.value() < zero) == (z.value() < zero) || rise.value() == zero {
        return end;
    }
    // z reaches 0 after d₀ = ln(1 + κr)/κ, r = −z/(sα), and leaves it with κ = β + γ sign α.
    let to_zero = log_distance(kappa, -(z / rise));
    let rest = d - to_zero;
    if rest.value() <= zero {
        return rise * rest;
    }
    let kappa = if alpha.value() < zero { beta - gamma } else { beta + gamma };
    rise * relaxation(kappa, rest).1
}

/// z along the voltages `u`, starting from z at `u_start`; `sink` is handed each sample's z.
///
/// Same arithmetic as [`advance`], arranged so that only one multiplication and one addition a sample depend on the
/// sample before: the sign of z is taken to stay, and the sample redone by [`advance`] where it did not.
#[inline(always)]
pub(super) fn run<T: Real>(
    (alpha, beta, gamma): (T, T, T),
    (mut u_last, mut z): (T, T),
    u: &[T],
    mut sink: impl FnMut(T),
) -> T {
    let zero = T::of(0.0);
    let sign_of = |z: T| {
        if z > zero {
            T::of(1.0)
        } else if z < zero {
            T::of(-1.0)
        } else {
            zero
        }
    };
    let mut sign = sign_of(z);
    let (mut kappa_up, mut kappa_down) = (beta + sign * gamma, beta - sign * gamma);
    for &u_next in u {
        let du = u_next - u_last;
        u_last = u_next;
        let (rise, kappa, d) = if du < zero { (-alpha, kappa_down, -du) } else { (alpha, kappa_up, du) };
        let (decay, reach) = relaxation(kappa, d);
        let end = z * decay + rise * reach;
        if end * sign > zero {
            z = end;
        } else {
            z = advance(alpha, beta, gamma, z, du);
            sign = sign_of(z);
            kappa_up = beta + sign * gamma;
            kappa_down = beta - sign * gamma;
        }
        sink(z);
    }
    z
}
