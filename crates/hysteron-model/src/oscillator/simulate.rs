//! Simulation along a drive.

use super::step::{Motion, State};
use super::{Drive, Oscillator, OscillatorError, OscillatorState};
use crate::hysteresis::RecordEnds;

/// Where the oscillator stands before the first sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// At rest without memory: y = ẏ = z = 0. The force sets in with the first sample.
    Rest,
    /// A known state at the first sample.
    State(OscillatorState),
    /// Steady state under the force repeated for ever.
    Periodic,
}

impl Start {
    /// The state at the first sample, where it is known.
    pub(super) fn state(self) -> Result<State, OscillatorError> {
        let Self::State(state) = self else { return Ok([0.0; 3]) };
        let OscillatorState { y, velocity, z } = state;
        if !(y.is_finite() && velocity.is_finite() && z.is_finite()) {
            return Err(OscillatorError::State { y, velocity, z });
        }
        Ok(state.into())
    }
}

impl Oscillator {
    /// Displacement under the force of `drive` into `out` (one value a sample); returns the state at the last sample, of a force that
    /// repeats that at the end of the period. Classical Runge–Kutta scheme of fourth order with the steps of the drive. Allocates nothing.
    ///
    /// # Errors
    /// [`OscillatorError`]: a parameter or a state out of range, an output of another length than the drive, a motion that runs
    /// away, a steady state that is not found.
    pub fn simulate(
        &self,
        drive: &Drive,
        start: Start,
        out: &mut [f64],
    ) -> Result<OscillatorState, OscillatorError> {
        self.validate()?;
        if out.len() != drive.len() {
            return Err(OscillatorError::Lengths { expected: drive.len(), found: out.len() });
        }
        let end = match start {
            Start::Periodic => settle(self, drive, out)?,
            _ => follow(&Motion::of(self), drive, start.state()?, out)?.0,
        };
        Ok(end.into())
    }
}

/// The motion from the state `first`: the state at the end, and the largest |y|, |ẏ| and |z| at a sample.
fn follow(
    motion: &Motion,
    drive: &Drive,
    first: State,
    out: &mut [f64],
) -> Result<(State, State), OscillatorError> {
    let mut x = first;
    let mut largest = first.map(f64::abs);
    let h = drive.step_s();
    let mut slots = out.iter_mut();
    let mut keep = |x: &State| {
        if let Some(slot) = slots.next() {
            *slot = x[0];
        }
    };
    keep(&x);
    for (k, interval) in drive.intervals().enumerate() {
        for u in interval.steps() {
            x = motion.step(&x, u, h);
        }
        if !(x[0] + x[1] + x[2]).is_finite() {
            return Err(OscillatorError::RunsAway { index: k + 1 });
        }
        for (largest, x) in largest.iter_mut().zip(x) {
            *largest = largest.max(x.abs());
        }
        keep(&x);
    }
    Ok((x, largest))
}

/// Periods simulated at most to find a steady state.
const PERIODS: usize = 400;
/// Change of the state over a period, as a share of its largest value, below which it is steady.
const STEADY: f64 = 1e-10;

/// Steady state: the period from rest, again and again, until its end is its beginning. `out` holds the last one. Hysteresis and
/// damping forget, mostly within a period or two.
pub(super) fn settle(
    oscillator: &Oscillator,
    drive: &Drive,
    out: &mut [f64],
) -> Result<State, OscillatorError> {
    if drive.ends() != RecordEnds::Periodic {
        return Err(OscillatorError::NotPeriodic);
    }
    let motion = Motion::of(oscillator);
    let mut first = [0.0; 3];
    let mut change = f64::INFINITY;
    for _ in 0..PERIODS {
        let (end, largest) = follow(&motion, drive, first, out)?;
        let share = |i: usize| if largest[i] > 0.0 { (end[i] - first[i]).abs() / largest[i] } else { 0.0 };
        change = (0..3).map(share).fold(0.0, f64::max);
        if change <= STEADY {
            return Ok(first);
        }
        first = end;
    }
    Err(OscillatorError::NotSettled { periods: PERIODS, change })
}
