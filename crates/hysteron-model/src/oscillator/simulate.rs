//! Simulation along a drive.

use super::step::{Motion, State};
use super::{Drive, Oscillator, OscillatorState, SimulationError};
use crate::hysteresis::RecordEnds;
use crate::start::Start;

/// A state at the first sample; the force at rest does not matter.
impl From<OscillatorState> for Start<OscillatorState> {
    fn from(memory: OscillatorState) -> Self {
        Self::Remembering { voltage_v: 0.0, memory }
    }
}

/// The state at the first sample: without memory at rest, where the force sets in with that sample, whatever
/// it was before; `None` for a steady state under the force, which repeats.
pub(super) fn first_state(
    start: Start<OscillatorState>,
    drive: &Drive,
) -> Result<Option<State>, SimulationError> {
    match start {
        Start::AsIdentified | Start::Rest { .. } => Ok(Some([0.0; 3])),
        Start::Remembering { memory, .. } => {
            let OscillatorState { y, velocity, z } = memory;
            if !(y.is_finite() && velocity.is_finite() && z.is_finite()) {
                return Err(SimulationError::State { y, velocity, z });
            }
            Ok(Some(memory.into()))
        }
        Start::Settled { period_samples: Some(samples), .. } if samples != drive.len() => {
            Err(SimulationError::Period { samples: drive.len(), period_samples: samples })
        }
        Start::Settled { .. } => Ok(None),
    }
}

impl Oscillator {
    /// Displacement under the force of `drive` into `out` (one value per sample); returns the state at the
    /// last sample, of a force that repeats that at the end of the period. Classical Runge–Kutta scheme of
    /// fourth order with the steps of the drive. Allocates nothing.
    ///
    /// # Errors
    /// [`SimulationError`]: a parameter or a state out of range, an output of another length than the drive,
    /// a motion that runs away, a steady state that is not found.
    pub fn simulate(
        &self,
        drive: &Drive,
        start: Start<OscillatorState>,
        out: &mut [f64],
    ) -> Result<OscillatorState, SimulationError> {
        self.validate()?;
        if out.len() != drive.len() {
            return Err(SimulationError::Lengths { expected: drive.len(), found: out.len() });
        }
        let end = match first_state(start, drive)? {
            None => settle(self, drive, out)?,
            Some(first) => follow(&Motion::of(self), drive, first, out)?.0,
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
) -> Result<(State, State), SimulationError> {
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
            return Err(motion.parameters().overflow(k + 1));
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

/// Steady state: the period is repeated from rest until its end equals its beginning. `out` holds the last
/// one. Hysteresis and damping settle mostly within a period or two.
pub(super) fn settle(
    oscillator: &Oscillator,
    drive: &Drive,
    out: &mut [f64],
) -> Result<State, SimulationError> {
    if drive.ends() != RecordEnds::Periodic {
        return Err(SimulationError::NotPeriodic);
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
    Err(SimulationError::NotSettled { periods: PERIODS, change })
}
