//! The voltage to which one monotone move gives an output: the exact inverse of a step of the hysteresis
//! block.

use super::Hysteresis;
use crate::real::Real;

/// Most evaluations of a search; four to seven are usual. Every third bisects the bracket, whatever the
/// operator.
pub const MOST_LOOKS: u8 = 48;

/// End of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached<T> {
    /// The voltage.
    pub voltage: T,
    /// Output of the block there.
    pub output: T,
    /// The target lies beyond the allowed voltages, or where the sides of a play cross; this is the last
    /// voltage before.
    pub missed: bool,
}

impl<T: Real> Hysteresis<'_, T> {
    /// The voltage between `low` and `high`, around the present one, at which one monotone move reaches
    /// `target`. No state changes. `output` is the present output, `slope` an estimate of dv/du along the
    /// move.
    ///
    /// The output must rise with the voltage along the move, so that the present voltage and one limit
    /// bracket the solution. Secants kept within the bracket (Illinois: M. Dowell, P. Jarratt, *BIT* 11
    /// (1971) 168–174, doi:10.1007/BF01934364) find it, to the rounding of the output, in at most
    /// [`MOST_LOOKS`] evaluations of the block.
    #[inline]
    pub fn reach(&self, output: T, target: T, [low, high]: [T; 2], slope: T) -> Reached<T> {
        let half = T::of(0.5);
        // Rate-dependent and creeping plays move at constant voltage.
        let output = if self.moves_at_rest() { self.look(self.voltage()) } else { output };
        let at = |voltage: T| Reached { voltage, output: self.look(voltage), missed: false };
        let mut near = Reached { voltage: self.voltage(), output, missed: false };
        let upwards = target > output;
        let end = if upwards { high } else { low };
        if target == output || end == near.voltage {
            return Reached { missed: target != output, ..near };
        }
        // A voltage at which sides of plays cross counts as beyond: the search ends before it.
        let beyond = |v: T| !(v.is_finite() && if upwards { v < target } else { v > target });
        // A step that overshoots a little, so that the search begins with a narrow bracket.
        let guess = near.voltage + T::of(1.25) * (target - output) / slope;
        let inside =
            if upwards { near.voltage < guess && guess < end } else { end < guess && guess < near.voltage };
        let mut far = at(if inside { guess } else { end });
        if inside && !beyond(far.output) {
            near = far;
            far = at(end);
        }
        if !beyond(far.output) {
            return Reached { missed: true, ..far };
        }
        let close = T::of(2.0) * T::EPSILON * (target.abs() + output.abs());
        let (mut near_excess, mut far_excess) = (near.output - target, far.output - target);
        let mut kept_near = None;
        for count in 2..MOST_LOOKS {
            if near_excess.abs() <= close || far_excess.abs() <= close {
                break;
            }
            let width = far.voltage - near.voltage;
            let share = near_excess / (near_excess - far_excess);
            let halve = count % 3 == 1 || !share.is_finite();
            let between = near.voltage + width * if halve { half } else { share };
            let between = if between == near.voltage || between == far.voltage {
                near.voltage + half * width
            } else {
                between
            };
            if between == near.voltage || between == far.voltage {
                break;
            }
            let next = at(between);
            // Illinois: halve the value of an end that is kept twice.
            if beyond(next.output) {
                (far, far_excess) = (next, next.output - target);
                if kept_near == Some(true) {
                    near_excess = half * near_excess;
                }
                kept_near = Some(true);
            } else {
                (near, near_excess) = (next, next.output - target);
                if kept_near == Some(false) {
                    far_excess = half * far_excess;
                }
                kept_near = Some(false);
            }
        }
        if !far.output.is_finite() {
            return Reached { missed: true, ..near };
        }
        if (near.output - target).abs() < (far.output - target).abs() { near } else { far }
    }
}
