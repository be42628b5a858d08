//! What a user should know about a simulation.

use super::SignalRole;
use crate::record::Unit;
use crate::start::Start;

/// What was decided without being told, or deserves attention; each front end words it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Remark {
    /// A signal has no unit and is taken to be in the model's.
    UnitAssumed {
        /// Which signal.
        signal: SignalRole,
        /// The model's unit.
        unit: Unit,
    },
    /// The input leaves the range that the model was identified in.
    Extrapolates {
        /// Ends of the input.
        input: (f64, f64),
        /// Ends of the range identified.
        identified: (f64, f64),
        /// Their unit.
        unit: Unit,
    },
    /// The level of the inputs is beyond those identified.
    LevelExtrapolates {
        /// Level, rms of the inputs about their means.
        level: f64,
        /// Lowest and highest level identified.
        identified: (f64, f64),
        /// Their unit.
        unit: Unit,
    },
    /// The model was identified on settled periodic records, or takes one to be settled; this drive does not repeat, and the
    /// device is taken to start at rest.
    DoesNotRepeat,
    /// The record is explained better from another start than the one expected.
    StartChosen {
        /// The start taken.
        chosen: Start,
        /// The start expected.
        expected: Start,
    },
    /// The drive starts with a jump, which a model without dynamics cannot follow: so many samples are not scored.
    LeftOut {
        /// Number of samples.
        samples: usize,
    },
    /// A drive or a reference swings faster than what the model was identified with: beyond that it extrapolates, and an error
    /// predicted for it says nothing of that.
    Fast {
        /// Which signal.
        signal: SignalRole,
        /// Highest frequency of its swings \[Hz\].
        fastest_hz: f64,
        /// Highest frequency identified \[Hz\].
        identified_hz: f64,
    },
}
