//! n = 1: dz/d|u| = sα − κ z, relaxation towards sα/κ, with κ = β + s γ sign z (s = sign Δu).

use super::BoucWen;
use crate::dual::Dual;
use crate::real::{Real, Scalar};
use crate::series::{log_distance, relaxation};

/// Change of z in a monotone move by `du`: (sα − κz)(1 − e^(−κd))/κ, d = |Δu|, split where z passes 0.
#[inline(always)]
pub(super) fn increment<S: Scalar>(alpha: S, beta: S, gamma: S, z: S, du: S) -> S {
    let zero = S::Real::of(0.0);
    let (rise, turn, d) = if du.value() < zero { (-alpha, -gamma, -du) } else { (alpha, gamma, du) };
    // The sign of z on this leg: on leaving 0 it is the sign of the rise.
    let lead = if z.value() == zero { rise.value() } else { z.value() };
    let along = |kappa: S| (rise - kappa * z) * relaxation(kappa, d).1;
    // Two branches, not a choice of κ: the exponential then depends on the voltage alone, not on z.
    let change = if lead < zero { along(beta - turn) } else { along(beta + turn) };
    let end = z.value() + change.value();
    // Without a rise z decays towards 0: beyond it is rounding.
    let crosses = (end < zero && z.value() > zero) || (end > zero && z.value() < zero);
    if crosses && rise.value() != zero {
        let kappa = if lead < zero { beta - turn } else { beta + turn };
        return from_zero([alpha, beta, gamma], rise, d - log_distance(kappa, -(z / rise))) - z;
    }
    change
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

impl<T: Real> BoucWen<T> {
    /// [`Self::advance_with_shape`] for n = 1 by a move `du` whose relaxation is known, z keeping its sign,
    /// which is `sign` (1 or −1): z⁺ = z e^(−κd) + α r. `None` where z does not keep it, or is 0.
    ///
    /// `relaxation` is e^(−κd), r = sign Δu (1 − e^(−κd))/κ and its derivative r'(κ). They do not depend on
    /// z, so that many moves can be computed at once; only one multiplication and one addition a sample then
    /// wait for the sample before. All derivatives share one exponential: z⁺' = e^(−κd) z' + κ' (α r'(κ) − d
    /// e^(−κd) z), κ' = 1 for β, s sign z for γ.
    #[inline(always)]
    pub fn advance_on_one_side<const P: usize>(
        &self,
        sign: T,
        z: Dual<T, P>,
        du: T,
        [decay, reach, slope]: [T; 3],
    ) -> Option<Dual<T, P>> {
        let zero = T::of(0.0);
        let end = z.value * decay + self.alpha * reach;
        if !(end * sign > zero && z.value != zero) {
            return None;
        }
        let own = self.alpha * slope - du.abs() * decay * z.value;
        let turn = if du < zero { -sign } else { sign };
        let mut partials = z.partials.map(|p| decay * p);
        for (p, own) in partials.iter_mut().zip([own, turn * own]) {
            *p = *p + own;
        }
        Some(Dual { value: end, partials }.without_vanished(2))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;

    #[test]
    fn a_move_on_one_side_is_that_of_any_move() {
        let (alpha, beta, gamma) = (0.8_f64, 0.05, 0.02);
        let law = BoucWen::new(alpha, beta, gamma, 1.0).unwrap();
        let mut taken = 0;
        for (value, du) in
            [(3.0, 7.0), (9.0, -2.0), (-4.0, -11.0), (-9.0, 1.5), (1.0, -5.0), (-1.0, 5.0), (0.0, 1.0)]
        {
            let z = Dual { value, partials: [0.4, -0.7, 0.9] };
            let (sign, s, d) = (libm::copysign(1.0, value), libm::copysign(1.0, du), f64::abs(du));
            let kappa = beta + s * gamma * sign;
            let decay = libm::exp(-kappa * d);
            let reach = s * (1.0 - decay) / kappa;
            let slope = s * (d * decay - (1.0 - decay) / kappa) / kappa;
            let expected = law.advance_with_shape(z, du).unwrap();
            match law.advance_on_one_side(sign, z, du, [decay, reach, slope]) {
                // 1 − e^(−κd) as it stands here is less accurate than the relaxation.
                Some(end) => {
                    assert!((end.value - expected.value).abs() < 1e-13, "{end:?} instead of {expected:?}");
                    for (own, expected) in end.partials.iter().zip(expected.partials) {
                        assert!((own - expected).abs() < 1e-11, "{own} instead of {expected}");
                    }
                    taken += 1;
                }
                // From 0, or to the other side.
                None => assert!(value == 0.0 || expected.value * value < 0.0, "{value} by {du}"),
            }
        }
        assert_eq!(taken, 4);
    }
}
