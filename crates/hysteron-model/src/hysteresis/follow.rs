//! Inverse of an operator: the drive for a wanted output, one monotone move at a time.
//!
//! A move from the present state to the voltage u gives an output that increases with u wherever the operator
//! can be inverted; the voltage sought is bracketed by the present one and an end of what the limits allow,
//! and found by secants kept within the bracket. There is no one-sample delay: the inverse is exact in one
//! step, for every family.

use hysteron_numeric::Meter;
use hysteron_rt::Limited;

use super::columns::ColumnKernel;
use super::{Hysteresis, HysteresisError};

/// Limits of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveLimits {
    /// Least and largest voltage \[V\].
    pub range: [f64; 2],
    /// Largest change from one sample to the next \[V\]; infinite for none.
    pub step: f64,
    /// Seconds from one sample to the next, where they are known (see [`super::DriveGrid`]).
    pub interval_s: Option<f64>,
}

/// A drive and the operator's output for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Followed {
    /// Drive \[V\].
    pub drive: Vec<f64>,
    /// Output of the operator \[µm\]: the one wanted, except where a limit is active.
    pub output: Vec<f64>,
    /// Limit active at each sample: the range of the drive, its largest step, or none.
    pub limited: Vec<Limited>,
}

impl Followed {
    /// Samples limited by this.
    pub fn count(&self, by: Limited) -> usize {
        self.limited.iter().filter(|limited| **limited == by).count()
    }
}

impl Hysteresis {
    /// The drive for the output `wanted` \[µm\], sample by sample, as far as `limits` allow. The device rests
    /// at the voltage `rest` \[V\] before, with a `memory` in the operator's own scale (see
    /// [`crate::Start::Remembering`]), virgin where there is none.
    ///
    /// # Errors
    /// Those of [`Self::validate`]; [`HysteresisError::Range`] and [`HysteresisError::Step`] for empty
    /// limits; [`HysteresisError::RestOutside`] for a device that rests outside of them;
    /// [`HysteresisError::Wanted`] where an output is not finite; [`HysteresisError::NotIncreasing`] where
    /// the output falls as the voltage rises, so that the drive is not unique.
    pub fn follow(
        &self,
        wanted: &[f64],
        rest: f64,
        memory: Option<f64>,
        limits: &DriveLimits,
    ) -> Result<Followed, HysteresisError> {
        self.follow_metered(wanted, rest, memory, limits, &Meter::silent())
    }

    /// [`Self::follow`], whose samples `meter` counts.
    ///
    /// # Errors
    /// Those of [`Self::follow`]; [`HysteresisError::Stopped`].
    pub(crate) fn follow_metered(
        &self,
        wanted: &[f64],
        rest: f64,
        memory: Option<f64>,
        limits: &DriveLimits,
        meter: &Meter<'_>,
    ) -> Result<Followed, HysteresisError> {
        self.validate()?;
        let [low, high] = limits.range;
        if !(low < high && (high - low).is_finite()) {
            return Err(HysteresisError::Range { low, high });
        }
        if !(low..=high).contains(&rest) {
            return Err(HysteresisError::RestOutside { rest, low, high });
        }
        if limits.step.is_nan() || limits.step <= 0.0 {
            return Err(HysteresisError::Step { step: limits.step });
        }
        if let Some(index) = wanted.iter().position(|v| !v.is_finite()) {
            return Err(HysteresisError::Wanted { index });
        }
        let interval_s = self.form().interval(limits.interval_s)?;
        self.form().family().follow(self, interval_s, wanted, (rest, memory), (limits, meter))
    }
}

/// [`Hysteresis::follow`] for the columns of a kernel of this shape.
pub(super) fn columns<K: ColumnKernel>(
    kernel: &K,
    (shape, model): (&[f64], &Hysteresis),
    wanted: &[f64],
    (rest, memory): (f64, Option<f64>),
    limits: (&DriveLimits, &Meter<'_>),
) -> Result<Followed, HysteresisError> {
    let mut state = kernel.virgin(shape, memory.unwrap_or(rest));
    if memory.is_some() {
        kernel.advance(shape, &mut state, rest)?;
    }
    let mut row = vec![0.0; kernel.columns()];
    along(state, rest, wanted, limits, |state, u| {
        kernel.step(shape, state, u, &mut row)?;
        Ok(model.polynomial_at(u) + hysteron_numeric::dot(model.weights(), &row))
    })
}

/// End point of a move, and the output there.
#[derive(Clone, Copy)]
struct Point {
    u: f64,
    v: f64,
}

/// Every output of `wanted` in turn, counted by the meter; `step` moves a state and returns the output.
pub(super) fn along<S: Clone>(
    mut state: S,
    rest: f64,
    wanted: &[f64],
    (limits, meter): (&DriveLimits, &Meter<'_>),
    mut step: impl FnMut(&mut S, f64) -> Result<f64, HysteresisError>,
) -> Result<Followed, HysteresisError> {
    let mut followed = Followed {
        drive: Vec::with_capacity(wanted.len()),
        output: Vec::with_capacity(wanted.len()),
        limited: Vec::with_capacity(wanted.len()),
    };
    let [low, high] = limits.range;
    // On a clone, so that the next move remains the first from rest.
    let mut now = Point { u: rest, v: step(&mut state.clone(), rest)? };
    let mut slope = None;
    for (index, &target) in wanted.iter().enumerate() {
        meter.at_sample(index)?;
        let allowed = [(now.u - limits.step).max(low), (now.u + limits.step).min(high)];
        let mut trial = |u: f64| -> Result<Point, HysteresisError> {
            let v = step(&mut state.clone(), u).map_err(|error| error.at_sample(index))?;
            if v.is_finite() { Ok(Point { u, v }) } else { Err(HysteresisError::Overflow { index }) }
        };
        // Output at constant voltage, which a rate-dependent operator has not reached yet.
        let still = trial(now.u)?;
        let found = reach(trial, still, target, allowed, slope).map_err(|refused| match refused {
            Refused::Move(error) => error,
            Refused::Falls(u) => HysteresisError::NotIncreasing { index, u },
        })?;
        let end = if target > found.at.v { high } else { low };
        followed.limited.push(match found.missed {
            false => Limited::No,
            true if found.at.u == end => Limited::Range,
            true => Limited::Step,
        });
        if found.at.u != now.u {
            slope = Some((found.at.v - still.v) / (found.at.u - now.u));
        }
        now =
            Point { u: found.at.u, v: step(&mut state, found.at.u).map_err(|error| error.at_sample(index))? };
        followed.drive.push(now.u);
        followed.output.push(now.v);
    }
    Ok(followed)
}

/// Result of [`reach`].
struct Reached {
    at: Point,
    /// The target lies beyond what is allowed.
    missed: bool,
}

/// Why a move was not found.
enum Refused {
    Move(HysteresisError),
    /// Near this voltage \[V\] the output falls as the voltage rises.
    Falls(f64),
}

/// Steps of the search at most. A secant takes a few; bisection alone reaches the last place in 60.
const STEPS: usize = 120;
/// Part of an output's change by which rounding may make it fall.
const ROUNDING: f64 = 1e-9;
/// Roundings of the output within which it is the target.
const CLOSE: f64 = 4.0 * f64::EPSILON;

/// The voltage within `allowed` to which a move from `now` gives `target`, to the last place or so.
fn reach(
    mut trial: impl FnMut(f64) -> Result<Point, HysteresisError>,
    now: Point,
    target: f64,
    allowed: [f64; 2],
    slope: Option<f64>,
) -> Result<Reached, Refused> {
    let mut trial = |u: f64| trial(u).map_err(Refused::Move);
    if target == now.v {
        return Ok(Reached { at: now, missed: false });
    }
    let upwards = target > now.v;
    let close = CLOSE * (target.abs() + now.v.abs());
    let beyond = |v: f64| if upwards { v >= target } else { v <= target };
    let mut near = now;
    // The end of the bracket is sought by a step that overshoots a little, so that secants begin close to the
    // target.
    let end = if upwards { allowed[1] } else { allowed[0] };
    let mut far = None;
    if let Some(slope) = slope.filter(|slope| *slope > 0.0) {
        let guess = now.u + 1.25 * (target - now.v) / slope;
        if (now.u.min(end) < guess) && (guess < now.u.max(end)) && guess != now.u {
            let at = trial(guess)?;
            if beyond(at.v) { far = Some(at) } else { near = at }
        }
    }
    let mut far = match far {
        Some(far) => far,
        None => trial(end)?,
    };
    let falls = |from: Point, to: Point| {
        let rise = (to.v - from.v) * if upwards { 1.0 } else { -1.0 };
        rise < -ROUNDING * (target - now.v).abs().max(f64::EPSILON * target.abs())
    };
    if falls(now, near) || falls(near, far) {
        return Err(Refused::Falls(far.u));
    }
    if !beyond(far.v) {
        return Ok(Reached { at: far, missed: true });
    }
    // Regula falsi with the values of an end that stays halved (Illinois), bisection where that is slow.
    let (mut near_excess, mut far_excess) = (near.v - target, far.v - target);
    let mut side = 0;
    for count in 0..STEPS {
        let width = far.u - near.u;
        if width.abs() <= f64::EPSILON * now.u.abs().max(far.u.abs()) {
            break;
        }
        let share = near_excess / (near_excess - far_excess);
        let mut u = near.u + width * if count % 8 == 7 || !share.is_finite() { 0.5 } else { share };
        if u == near.u || u == far.u {
            u = near.u + 0.5 * width;
        }
        if u == near.u || u == far.u {
            break;
        }
        let at = trial(u)?;
        if falls(near, at) || falls(at, far) {
            return Err(Refused::Falls(u));
        }
        if beyond(at.v) {
            (far, far_excess) = (at, at.v - target);
            near_excess *= if side == 1 { 0.5 } else { 1.0 };
            side = 1;
        } else {
            (near, near_excess) = (at, at.v - target);
            far_excess *= if side == -1 { 0.5 } else { 1.0 };
            side = -1;
        }
        if (at.v - target).abs() <= close {
            return Ok(Reached { at, missed: false });
        }
    }
    let best = if (near.v - target).abs() <= (far.v - target).abs() { near } else { far };
    Ok(Reached { at: best, missed: false })
}
