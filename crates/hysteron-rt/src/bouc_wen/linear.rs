//! n = 1: dz/d|u| = sα − κ z, relaxation towards sα/κ, with κ = β + s γ sign z (s = sign Δu).

use crate::dual::Dual;
use crate::real::{Real, Scalar};
use crate::series::{log_distance, relaxation, relaxation_with_slope};

/// z after a monotone move by `du`: z e^(−κd) + sα (1 − e^(−κd))/κ, split where z passes 0.
#[inline]
pub(super) fn advance<S: Scalar>(alpha: S, beta: S, gamma: S, z: S, du: S) -> S {
    let zero = S::Real::of(0.0);
    let (rise, turn, d) = if du.value() < zero { (-alpha, -gamma, -du) } else { (alpha, gamma, du) };
    // The sign of z on this leg: on leaving 0 it is the sign of the rise.
    let lead = if z.value() == zero { rise.value() } else { z.value() };
    let kappa = if lead < zero { beta - turn } else { beta + turn };
    let (decay, reach) = relaxation(kappa, d);
    let end = z * decay + rise * reach;
    if z.value() == zero || (end.value() < zero) == (z.value() < zero) || rise.value() == zero {
        return end;
    }
    from_zero([alpha, beta, gamma], rise, d - log_distance(kappa, -(z / rise)))
}

/// z at the distance `rest` after its zero crossing, with κ = β + γ sign α there; the crossing is at d₀ =
/// ln(1 + κr)/κ, r = −z/(sα).
#[inline]
fn from_zero<S: Scalar>([alpha, beta, gamma]: [S; 3], rise: S, rest: S) -> S {
    let zero = S::Real::of(0.0);
    if rest.value() <= zero {
        return rise * rest;
    }
    let kappa = if alpha.value() < zero { beta - gamma } else { beta + gamma };
    rise * relaxation(kappa, rest).1
}

/// Change of z in a monotone move by `du`: (sα − κz)(1 − e^(−κd))/κ, split where z passes 0.
#[inline(always)]
pub(super) fn increment<S: Scalar>(alpha: S, beta: S, gamma: S, z: S, du: S) -> S {
    let zero = S::Real::of(0.0);
    let (rise, turn, d) = if du.value() < zero { (-alpha, -gamma, -du) } else { (alpha, gamma, du) };
    let lead = if z.value() == zero { rise.value() } else { z.value() };
    let along = |kappa: S| (rise - kappa * z) * relaxation(kappa, d).1;
    // Two branches, not a choice of κ: the exponential then depends on the voltage alone, not on z.
    let change = if lead < zero { along(beta - turn) } else { along(beta + turn) };
    let end = z.value() + change.value();
    if (end < zero && z.value() > zero) || (end > zero && z.value() < zero) {
        let kappa = if lead < zero { beta - turn } else { beta + turn };
        return from_zero([alpha, beta, gamma], rise, d - log_distance(kappa, -(z / rise))) - z;
    }
    change
}

/// z and its derivatives along the voltages `u`, starting from `z` at `u_last`; `sink` receives each
/// sample's. The partials are ∂/∂β, ∂/∂γ, then any others, carried by z alone; P = 0 is the plain simulation.
///
/// The arithmetic is that of [`advance`], arranged so that only one multiplication and one addition a sample
/// depend on the sample before: z is assumed to keep its sign, and [`advance`] recomputes a sample where it
/// does not. With z⁺ = z e^(−κd) + sα r(κ), r = (1 − e^(−κd))/κ, each derivative is z⁺' = e^(−κd) z' + κ' (sα
/// r'(κ) − d e^(−κd) z), κ' = 1 for β, ±1 for γ: one exponential for all of them.
#[inline(always)]
pub(super) fn run<T: Real, const P: usize>(
    (alpha, beta, gamma): (T, T, T),
    (mut u_last, mut z): (T, Dual<T, P>),
    u: &[T],
    mut sink: impl FnMut(Dual<T, P>),
) -> Dual<T, P> {
    let [zero, one] = [T::of(0.0), T::of(1.0)];
    let sign_of = |z: T| {
        if z > zero {
            one
        } else if z < zero {
            -one
        } else {
            zero
        }
    };
    let duals = (Dual::constant(alpha), Dual::variable(beta, 0), Dual::variable(gamma, 1));
    let mut sign = sign_of(z.value);
    let (mut kappa_up, mut kappa_down) = (beta + sign * gamma, beta - sign * gamma);
    for &u_next in u {
        let du = u_next - u_last;
        u_last = u_next;
        let (rise, kappa, turn, d) =
            if du < zero { (-alpha, kappa_down, -sign, -du) } else { (alpha, kappa_up, sign, du) };
        let (decay, reach, reach_slope) = relaxation_with_slope(kappa, d);
        let end = z.value * decay + rise * reach;
        if end * sign > zero {
            let own = rise * reach_slope - d * decay * z.value;
            let mut partials = z.partials.map(|p| decay * p);
            for (p, own) in partials.iter_mut().zip([own, turn * own]) {
                *p = *p + own;
            }
            z = Dual { value: end, partials }.without_vanished(2);
        } else {
            z = advance(duals.0, duals.1, duals.2, z, Dual::constant(du));
            sign = sign_of(z.value);
            kappa_up = beta + sign * gamma;
            kappa_down = beta - sign * gamma;
        }
        sink(z);
    }
    z
}
