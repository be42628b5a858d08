//! Takács' law: branches of hyperbolic tangents.

use super::law::{BranchLaw, finite, law_numbers, not_negative, positive};
use crate::ParameterError;
use crate::real::{Real, Scalar};
use crate::series::{passed, signed};

law_numbers! {
    /// y = s (1 − A (1 − tanh z)), z = (s (u − `centre`) − `coercive`)/`width`, A such that a branch begins
    /// where the last one ended: one state, exact. Branches after J. Takács 2001,
    /// doi:10.1108/EUM0000000005771.
    Takacs {
        /// Voltage in the middle of the loop.
        centre,
        /// Voltage along which a branch rises, > 0.
        width,
        /// Coercive voltage a₀, ≥ 0.
        coercive,
    }
}

impl<S: Scalar> BranchLaw<S> for Takacs<S> {
    const C: &'static str = include_str!("takacs.c");

    fn check(&self) -> Result<(), ParameterError<S::Real>> {
        finite("centre of Takács' loop", self.centre.value())?;
        positive("width of Takács' branches", self.width.value())?;
        not_negative("coercive voltage of Takács' loop", self.coercive.value())
    }

    /// s (1 − s y) (1 − e^(−2|Δu|/width)) (1 + tanh z)/2, z at the end.
    #[inline]
    fn increment(&self, y: S, from: S, to: S) -> S {
        let Self { centre, width, coercive } = *self;
        let down = to.value() < from.value();
        let way = signed(to - from, down) / width;
        let z = (signed(to - centre, down) - coercive) / width;
        let change =
            signed(y, !down).shift(S::Real::of(1.0)) * (passed(way.scale(S::Real::of(2.0))) * risen(z));
        signed(change, down)
    }

    /// Demagnetised state: limit of ever smaller loops about `u`, with equal slopes upwards and downwards.
    #[inline]
    fn virgin(&self, u: S) -> S {
        let Self { centre, width, coercive } = *self;
        let one = S::Real::of(1.0);
        let x = (u - centre) / width;
        let negative = x.value() < S::Real::of(0.0);
        let tail = |x: S| x.scale(S::Real::of(-2.0)).exp();
        let q = tail(signed(x, negative));
        let tails = q * q;
        let sum = tails.shift(one) + (q * tail(coercive / width)).scale(S::Real::of(2.0));
        signed((-tails).shift(one) / sum, negative)
    }
}

/// (1 + tanh z)/2.
#[inline(always)]
fn risen<S: Scalar>(z: S) -> S {
    let (one, two) = (S::Real::of(1.0), S::Real::of(2.0));
    if z.value() < S::Real::of(0.0) {
        let tail = z.scale(two).exp();
        return tail / tail.shift(one);
    }
    S::constant(one) / (-z.scale(two)).exp().shift(one)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::increment::IncrementMemory;

    const LAW: Takacs<f64> = Takacs { centre: 0.7, width: 1.3, coercive: 0.4 };

    /// Change of y along a branch by its definition.
    fn branch(law: Takacs<f64>, y: f64, from: f64, to: f64) -> f64 {
        let s = if to < from { -1.0 } else { 1.0 };
        let below = |u: f64| 1.0 - libm::tanh((s * (u - law.centre) - law.coercive) / law.width);
        let amplitude = (1.0 - s * y) / below(from);
        s * (1.0 - amplitude * below(to))
    }

    #[test]
    fn a_move_follows_its_branch() {
        let (mut y, mut u) = (LAW.virgin(0.2), 0.2);
        for to in [1.5, -1.0, 0.3, 0.31, 3.0, -2.5, -2.4, 2.0, 0.7] {
            let wanted = branch(LAW, y, u, to);
            y += LAW.increment(y, u, to);
            u = to;
            assert!((y - wanted).abs() < 1e-14, "{to}: {y} {wanted}");
        }
    }

    #[test]
    fn far_out_it_is_saturated_and_finite() {
        for far in [60.0, 1e3, 1e200, f64::MAX] {
            for y in [-0.9, 0.0, 0.5] {
                let (up, down) = (LAW.increment(y, -far, far), LAW.increment(y, far, -far));
                assert!((y + up - 1.0).abs() < 1e-15 && (y + down + 1.0).abs() < 1e-15, "{far} {y}");
                assert!(LAW.increment(y, -2.0 * far, -far).abs() < 1e-15);
            }
            assert_eq!([LAW.virgin(far), LAW.virgin(-far)], [1.0, -1.0]);
        }
    }

    #[test]
    fn single_precision_does_not_drift_in_small_moves() {
        let single = LAW.map(|x| x as f32);
        let mut memory = [IncrementMemory::new(single.virgin(0.0))];
        let (mut y, mut u, mut worst) = (LAW.virgin(0.0), 0.0, 0.0_f64);
        // Ramps of 4 V in 2¹⁶ samples.
        for k in 0..(5_u32 << 16) {
            let ramp = f64::from(k & 0xffff) / f64::from(1_u32 << 14);
            let to = if (k >> 16) & 1 == 0 { ramp } else { 4.0 - ramp };
            let increment = single.increment(memory[0].z(), u as f32, to as f32);
            memory[0].advance(increment);
            y += LAW.increment(y, u, to);
            u = to;
            worst = worst.max((f64::from(memory[0].z()) - y).abs());
        }
        assert!(worst < 32.0 * f64::from(f32::EPSILON), "{worst:e}");
    }

    #[test]
    fn numbers_that_are_none_are_refused() {
        assert_eq!(LAW.check(), Ok(()));
        for bad in [
            Takacs { centre: f64::NAN, ..LAW },
            Takacs { width: 0.0, ..LAW },
            Takacs { width: f64::INFINITY, ..LAW },
            Takacs { coercive: -0.1, ..LAW },
            Takacs { coercive: f64::INFINITY, ..LAW },
        ] {
            assert!(bad.check().is_err(), "{bad:?}");
        }
    }
}
