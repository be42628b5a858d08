//! Increment of z over a move, in a bounded number of operations, without the cancellation of z(u + Δu) −
//! z(u).

use super::{BoucWen, Law, linear, quadratic};
use crate::real::Real;
use crate::series::relaxation;

/// Fewest and most sub-steps of a move for n other than 1 and 2.
const LEAST_SUB_STEPS: u8 = 2;
const MOST_SUB_STEPS: u8 = 32;
/// Intended limit of a sub-step, as a fraction of the saturation, or of |z| beyond it.
const SHARE: f64 = 0.125;

impl<T: Real> BoucWen<T> {
    /// z(u + `du`) − z(u) for a monotone move from `z`. Not finite where there is no finite result.
    ///
    /// n = 1 and 2: exact, as [`Self::advance`]. Other n: that series takes as many terms as the move needs,
    /// a controller needs a bounded number of operations; hence sub-steps of an exponential Rosenbrock method
    /// of order 3 (exprb32: M. Hochbruck, A. Ostermann, J. Schweitzer, *SIAM J. Numer. Anal.* 47 (2009)
    /// 786–803, doi:10.1137/080717717), at least two, more where one would change z by over an eighth of its
    /// saturation, at most 32; |z| is clamped to its saturation. Error of one move relative to the
    /// saturation, n from 1.2 to 3, γ ≥ 0, for moves of 0.003 and 0.03 of the voltage over which z saturates,
    /// and for any longer one: below 1e-10, 1e-6 and 1e-3 away from z = 0, where |z|ⁿ is not smooth; below
    /// 2e-7, 2e-5 and 1.2e-3 anywhere. Where z moves inwards faster than outwards (β − γ five times β + γ):
    /// 1e-8, 5e-5 and 1e-3, and 2e-7, 5e-5 and 4e-3 (`tests/model.rs`). Moves into saturation end correctly.
    ///
    /// For a move much smaller than that voltage the increment is small against z: compensated summation
    /// keeps its accuracy.
    #[inline]
    pub fn increment(&self, z: T, du: T) -> T {
        match self.law {
            Law::Linear => linear::increment(self.alpha, self.beta, self.gamma, z, du),
            Law::Quadratic => self.quadratic_increment(z, du),
            Law::Power => self.power_increment(z, du),
        }
    }

    /// By the [change](quadratic::change) of |z|.
    #[inline]
    fn quadratic_increment(&self, z: T, du: T) -> T {
        let zero = T::of(0.0);
        let down = du < zero;
        let rise = if down { -self.alpha } else { self.alpha };
        let lead = if z == zero { rise } else { z };
        let negative = lead < zero;
        let kappa = if down == negative { self.beta + self.gamma } else { self.beta - self.gamma };
        let mirror = |x: T| if negative { -x } else { x };
        match quadratic::change(mirror(rise), kappa, mirror(z), du.abs()) {
            Some(change) => mirror(change),
            None => self.exact_increment(z, du),
        }
    }

    /// By [`Self::advance`], for moves through z = 0 and those without a finite result.
    #[inline(never)]
    fn exact_increment(&self, z: T, du: T) -> T {
        match self.advance(z, du) {
            Ok(end) => end - z,
            Err(_) => T::of(f64::INFINITY),
        }
    }

    /// dz/dσ = sα − (β + sγ sign z) z|z|ⁿ⁻¹ over σ = |Δu|, in sub-steps h: with J the derivative of the
    /// right-hand side f, U = z + h φ₁(hJ) f(z), z⁺ = U + 2h φ₃(hJ) (f(U) − f(z) − J (U − z)).
    #[inline]
    fn power_increment(&self, z: T, du: T) -> T {
        let (zero, one) = (T::of(0.0), T::of(1.0));
        let (rise, turn, distance) =
            if du < zero { (-self.alpha, -self.gamma, -du) } else { (self.alpha, self.gamma, du) };
        let longest = distance * T::of(1.0 / f64::from(LEAST_SUB_STEPS));
        let outwards = if self.alpha < zero { self.beta - self.gamma } else { self.beta + self.gamma };
        let saturation = (self.alpha.abs() / outwards).powf(one / self.n);
        let inwards = if self.alpha < zero { self.beta + self.gamma } else { self.beta - self.gamma };
        // Outside the bounded class z has no bound.
        let bound = if outwards > zero && inwards >= zero {
            if z.abs() > saturation { z.abs() } else { saturation }
        } else {
            T::of(f64::INFINITY)
        };
        let held = |z: T| {
            if z > bound {
                bound
            } else if z < -bound {
                -bound
            } else {
                z
            }
        };
        // f and −J.
        let slopes = |z: T| {
            let kappa = if z < zero { self.beta - turn } else { self.beta + turn };
            let pull = kappa * z.abs().powf(self.n - one);
            (rise - pull * z, self.n * pull)
        };
        let (mut now, mut change, mut left) = (z, zero, distance);
        for count in 1..=MOST_SUB_STEPS {
            let (f, rate) = slopes(now);
            let scale = if now.abs() > saturation { now.abs() } else { saturation };
            let fair = T::of(SHARE) * scale / f.abs();
            let h = if fair < longest { fair } else { longest };
            let h = if h < left && count < MOST_SUB_STEPS { h } else { left };
            left = left - h;
            let (_, reach) = relaxation(rate, h);
            let stage = held(now + reach * f);
            let (f_stage, _) = slopes(stage);
            let curve = f_stage - f + rate * (stage - now);
            let own = reach * f + h * phi3(rate * h) * (curve + curve);
            let kept = held(now + own);
            // Within the bound the sum of the increments is more accurate than the difference.
            change = if kept == now + own { change + own } else { kept - z };
            now = kept;
            if left <= zero {
                break;
            }
        }
        change
    }
}

/// φ₃(−x) = (½ − (1 − (1 − e^(−x))/x)/x)/x.
#[inline(always)]
fn phi3<T: Real>(x: T) -> T {
    if x.abs() <= T::of(0.5) {
        // Σ (−x)ᵏ/(k + 3)!, truncation x¹⁰/13!.
        let series =
            [6.0, 24.0, 120.0, 720.0, 5040.0, 40320.0, 362_880.0, 3_628_800.0, 39_916_800.0, 479_001_600.0];
        series.iter().rev().fold(T::of(0.0), |sum, &factorial| T::of(1.0 / factorial) - x * sum)
    } else {
        let (_, phi1) = relaxation(x, T::of(1.0));
        let phi2 = (T::of(1.0) - phi1) / x;
        (T::of(0.5) - phi2) / x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phi3_is_continuous_through_its_seam_and_at_zero() {
        assert_eq!(phi3(0.0_f64), 1.0 / 6.0);
        let (below, above): (f64, f64) = (phi3(0.499_999_999_9), phi3(0.500_000_000_1));
        assert!((below - above).abs() < 1e-10);
        // φ₃(−1) = ½ − e⁻¹.
        assert!((phi3(1.0_f64) - (0.5 - libm::exp(-1.0))).abs() < 1e-15);
        // φ₃(x) for x = 1 (−x = −1 of the function): e − 5/2.
        assert!((phi3(-1.0_f64) - (libm::exp(1.0) - 2.5)).abs() < 1e-14);
    }
}
