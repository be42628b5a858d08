$DESCRIPTION
//{ root|inverse
//!
//}
//{ root
//! ```
//! let mut memory = $name::Memory::new()?;
//! let mut model = memory.model()?;
//! model.rest_at(0.0)?;
//! let displacement = model.step(1.0)?;
//! assert!(displacement.is_finite());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]
//{ has_inverse

pub mod inverse;
//}
//{ has_controller
pub mod controller;
//}
//}
//{ inverse
//! ```
//! use $crate::inverse::{Memory, PREVIEW};
//!
//! let mut memory = Memory::new()?;
//! let mut compensator = memory.compensator()?;
//! let displacement = compensator.rest_at(0.0)?;
//! for _ in 0..PREVIEW {
//!     compensator.know(displacement);
//! }
//! let drive = compensator.step(displacement);
//! assert!(drive.voltage >= compensator.limits().low);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//}

//{ states
use hysteron_rt::{IncrementMemory, StateLaw};
//}
//{ branch
use hysteron_rt::{Branch, IncrementMemory, branch};
//}
//{ plays
use hysteron_rt::PlayBank;
//}
//{ line
use hysteron_rt::BrokenLine;
//}
//{ sided
use hysteron_rt::{SidedPlays, Sides};
//}
//{ relaxing
use hysteron_rt::RelaxingPlays;
//}
//{ plane
use hysteron_rt::{Plane, Turn, Turns};
//}
//{ real_poles|pairs
use hysteron_rt::Compensated;
//}
//{ real_poles
use hysteron_rt::{LANES, RealPoles};
//}
//{ pairs
use hysteron_rt::PolePair;
//}
//{ inverse
use hysteron_rt::{Compensator, Law, Limits};
//}
//{ root|observed
use hysteron_rt::Model;
//}
//{ law
use hysteron_rt::Feedback;
//}
//{ !law
use hysteron_rt::{Hysteresis, Operator};
//}
//{ root|inverse
use hysteron_rt::SavedError;
//}
use hysteron_rt::{Linear, ModelError, Sections, SectionsMemory};
//{ !root

use crate::Real;
//}
//{ root

/// The number type of everything in here.
pub type Real = $real;

/// Samples a second \[Hz\]. The coefficients belong to this rate.
pub const SAMPLE_RATE_HZ: Real = $RATE;
//{ range
/// Range of the voltage that the model was identified in \[$INPUT_UNIT\].
pub const VOLTAGE_RANGE: (Real, Real) = ($RANGE_LOW, $RANGE_HIGH);
//}
//}
//{ inverse

/// Samples that the reference handed to a step is ahead.
pub const PREVIEW: usize = $N_PREVIEW;
//}

$TABLES
//{ plane
/// Turning points that are remembered at once.
const TURNS: usize = $N_TURNS;
//}
//{ root|inverse
/// Marks the saved states of this export: those of another model, rate, number type or version have another.
const MARK: u64 = $MARK;
/// Bytes of a saved state.
pub const SAVED_BYTES: usize = $SAVED_BYTES;
//}
//{ law
/// Gain on the error.
const PROPORTIONAL: Real = $PROPORTIONAL;
/// Gain on the sum of errors.
const INTEGRAL: Real = $INTEGRAL;
//}

/// What is remembered: the caller's, one for each device.
#[derive(Clone, Debug)]
pub struct Memory {
//{ states
    laws: [StateLaw<Real>; STATES.len()],
    z: [IncrementMemory<Real>; STATES.len()],
//}
//{ branch
    states: [IncrementMemory<Real>; WEIGHT.len()],
//}
//{ plays|sided
    plays: [Real; WEIGHT.len()],
//}
//{ relaxing
    plays: [Real; THRESHOLD.len()],
//}
//{ plane
    turns: [Turn<Real>; TURNS],
//}
//{ real_poles
    real: [Compensated<Real, LANES>; REAL.len()],
//}
//{ pairs
    pairs: [Compensated<Real, 2>; PAIRS.len()],
//}
    delay: [Real; $N_DELAY],
//{ inverse
    ring: [Real; LAW_REFERENCE.len()],
//}
}

impl Memory {
//{ inverse
    /// Memory for [`Self::compensator`].
//}
//{ root|observed
    /// Memory for [`Self::model`].
//}
//{ law
    /// Memory for [`Self::feedback`].
//}
    ///
    /// # Errors
    /// None with the tables as they were exported: whoever changes them learns here what a parameter must be.
    pub fn new() -> Result<Self, ModelError<Real>> {
        Ok(Self {
//{ states
            laws: laws().ok_or(ModelError::Coefficient)?,
            z: [IncrementMemory::new(0.0); STATES.len()],
//}
//{ branch
            states: [IncrementMemory::new(0.0); WEIGHT.len()],
//}
//{ plays|sided
            plays: [0.0; WEIGHT.len()],
//}
//{ relaxing
            plays: [0.0; THRESHOLD.len()],
//}
//{ plane
            turns: [Turn::none(); TURNS],
//}
//{ real_poles
            real: [Compensated::zero(); REAL.len()],
//}
//{ pairs
            pairs: [Compensated::zero(); PAIRS.len()],
//}
            delay: [0.0; $N_DELAY],
//{ inverse
            ring: [0.0; LAW_REFERENCE.len()],
//}
        })
    }

//{ inverse
    /// The inverse, at rest and virgin at the voltage within its limits that is next to 0 $INPUT_UNIT: `step`
    /// takes a reference \[$OUTPUT_UNIT\], [`PREVIEW`] samples ahead, and gives the voltage \[$INPUT_UNIT\].
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn compensator(&mut self) -> Result<Compensator<'_, Real>, ModelError<Real>> {
//}
//{ law
    /// The feedback law, at rest: `step` takes an error \[$OUTPUT_UNIT\] and gives a correction.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn feedback(&mut self) -> Result<Feedback<'_, Real>, ModelError<Real>> {
//}
//{ root|observed
    /// The model, at rest and virgin at 0 $INPUT_UNIT: `step` takes a voltage \[$INPUT_UNIT\] and gives the
    /// displacement \[$OUTPUT_UNIT\].
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn model(&mut self) -> Result<Model<'_, Real>, ModelError<Real>> {
//}
//{ states
        let operator = Operator::States { laws: &self.laws, memory: &mut self.z };
//}
//{ memoryless
//{ !law
        let operator = Operator::None;
//}
//}
//{ plays
        let bank = PlayBank::new(&THRESHOLD, &WEIGHT).map_err(|_| ModelError::Coefficient)?;
        let operator = Operator::Plays { bank, states: &mut self.plays };
//}
//{ branch
        let operator = Operator::Branch { law: LAW, weights: &WEIGHT, memory: &mut self.states };
//}
//{ sided
//{ even
        let sides = Sides::Even { widening: 0.0 };
//}
//{ rate
        let sides = Sides::Even { widening: WIDENING };
//}
//{ below
        let sides = Sides::Below;
//}
//{ envelopes
        let sides = Sides::Envelopes { right: RIGHT, left: LEFT };
//}
//{ ramps
        let sides = Sides::Ramps { steepness: STEEPNESS };
//}
        let plays = SidedPlays::new(sides, &THRESHOLD, &WEIGHT).map_err(|_| ModelError::Coefficient)?;
//{ line
        let line = BrokenLine::new(&SHARE, &CORNER, &SLOPE).map_err(|_| ModelError::Coefficient)?;
        let plays = plays.with_line(line).map_err(|_| ModelError::Coefficient)?;
//}
        let operator = Operator::SidedPlays { plays, states: &mut self.plays };
//}
//{ relaxing
        let plays = RelaxingPlays::new((SIGMA, INTERVAL), RANGE, &THRESHOLD, &SLOPE)
            .map_err(|_| ModelError::Coefficient)?;
        let operator = Operator::RelaxingPlays { plays, states: &mut self.plays };
//}
//{ plane
        let plane = Plane::new([LOWEST, HIGHEST], $N_INTERVALS, &EVERETT)
            .map_err(|_| ModelError::Coefficient)?;
        let operator = Operator::Plane { plane, turns: Turns::new(&mut self.turns) };
//}
//{ !law
        let hysteresis = Hysteresis::new(&POLYNOMIAL, operator)?;
//}
//{ real_poles
        let (real, real_memory) = (&REAL[..], &mut self.real[..]);
//}
//{ !real_poles
        let (real, real_memory) = (&[][..], &mut [][..]);
//}
//{ pairs
        let (pairs, pair_memory) = (&PAIRS[..], &mut self.pairs[..]);
//}
//{ !pairs
        let (pairs, pair_memory) = (&[][..], &mut [][..]);
//}
        let sections = Sections { taps: &TAP, real, pairs, rest_gain: REST_GAIN };
        let memory = SectionsMemory { real: real_memory, pairs: pair_memory, delay: &mut self.delay };
//{ inverse
        let law = Law { recent: &LAW_RECENT, real: &LAW_REAL, pairs: &LAW_PAIRS, reference: &LAW_REFERENCE };
        let limits = Limits { low: LIMITS[0], high: LIMITS[1], step: LIMITS[2] };
        Compensator::new(hysteresis, Linear::new(sections, memory)?, law, &mut self.ring, limits, OFFSET)
//}
//{ law
        Feedback::new(PROPORTIONAL, INTEGRAL, Linear::new(sections, memory)?)
//}
//{ root|observed
//{ means
        Model::new(hysteresis, Linear::new(sections, memory)?, OFFSET)?.with_means()
//}
//{ !means
        Model::new(hysteresis, Linear::new(sections, memory)?, OFFSET)
//}
//}
    }
}

//{ root|inverse
/// The state, as bytes that outlast a reset. Nothing changes.
///
/// # Errors
/// [`SavedError::Length`] where this is not the one of [`Memory`].
pub fn save($one: &mut $Streams<'_, Real>) -> Result<[u8; SAVED_BYTES], SavedError> {
    let mut bytes = [0; SAVED_BYTES];
    $one.save(MARK, &mut bytes)?;
    Ok(bytes)
}

/// Takes the state that was saved, and goes on with the same bits.
///
/// # Errors
/// [`SavedError`] for bytes of another export, or damaged ones; the state is then as it was.
pub fn restore($one: &mut $Streams<'_, Real>, bytes: &[u8]) -> Result<(), SavedError> {
    $one.restore(MARK, bytes)
}
//}
//{ states

fn laws() -> Option<[StateLaw<Real>; STATES.len()]> {
    let mut all = [StateLaw::of(STATES[0]).ok()?; STATES.len()];
    for (law, parameters) in all.iter_mut().zip(STATES) {
        *law = StateLaw::of(parameters).ok()?;
    }
    Some(all)
}
//}
