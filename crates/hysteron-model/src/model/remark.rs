//! Remarks on a simulation for its user.

use hysteron_numeric::display::short;

use super::{Model, SignalRole};
use crate::Advice;
use crate::record::Unit;
use crate::start::Start;

/// Assumption made by default, or a caution to the user.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Remark {
    /// A signal without unit is assumed to be in the model's.
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
    /// The model was identified on settled periodic records, or takes one to be settled; this drive does not
    /// repeat, and the device is assumed to start at rest.
    DoesNotRepeat,
    /// A drive that repeats is taken to be settled.
    TakenAsSettled {
        /// Samples of its period.
        period_samples: usize,
    },
    /// Another start than the expected one explains the record better.
    StartChosen {
        /// The start taken.
        chosen: Start,
        /// The start expected.
        expected: Start,
    },
    /// The drive starts with a jump, which a model without dynamics cannot follow: this many samples are not
    /// scored.
    LeftOut {
        /// Number of samples.
        samples: usize,
    },
    /// The model is in the steady state of the drive, the device was not yet: this many samples are not
    /// scored.
    Settling {
        /// Number of samples.
        samples: usize,
    },
    /// The bandwidth of an inverse exceeds the frequencies identified.
    BandwidthExtrapolates {
        /// Bandwidth \[Hz\].
        bandwidth_hz: f64,
        /// Highest frequency identified \[Hz\].
        identified_hz: f64,
    },
    /// A drive or a reference exceeds the frequencies identified: beyond them the model extrapolates, and a
    /// predicted error does not include this.
    Fast {
        /// Which signal.
        signal: SignalRole,
        /// Highest frequency of its swings \[Hz\].
        fastest_hz: f64,
        /// Highest frequency identified \[Hz\].
        identified_hz: f64,
    },
}

impl Remark {
    /// In words, for a record that `model` ran on, with the remedy.
    pub fn in_words(&self, model: &Model) -> (String, Option<Advice>) {
        let units = model.units();
        let start = Some(Advice::GiveStart { at_voltage: model.rests_at_a_voltage() });
        match self {
            Self::UnitAssumed { signal, unit } => {
                (format!("the {} has no unit; taken to be in {unit}, the model's", signal.name()), None)
            }
            Self::Extrapolates { input, identified, unit } => (
                format!(
                    "the input runs from {} to {} {unit}, the model was identified from {} to {} {unit}: it \
                     extrapolates",
                    short(input.0),
                    short(input.1),
                    short(identified.0),
                    short(identified.1),
                ),
                None,
            ),
            Self::LevelExtrapolates { level, identified, unit } => (
                format!(
                    "the level of the inputs is {} {unit} rms, the model was identified from {} to {} \
                     {unit}: it extrapolates, with the modes of the nearest level",
                    short(*level),
                    short(identified.0),
                    short(identified.1),
                ),
                None,
            ),
            Self::BandwidthExtrapolates { bandwidth_hz, identified_hz } => (
                format!(
                    "the bandwidth is {} Hz, the model was identified up to {} Hz: beyond that the inverse \
                     follows a response that was not measured, and the drives may go from limit to limit",
                    short(*bandwidth_hz),
                    short(*identified_hz),
                ),
                None,
            ),
            Self::DoesNotRepeat if model.channels().is_some() => (
                "this drive does not repeat and is taken to start at rest, its inputs held before".to_owned(),
                start,
            ),
            Self::DoesNotRepeat => (
                format!(
                    "the model was identified on settled periodic records; this drive does not repeat and is \
                     taken to start at rest{}",
                    if model.rests_at_a_voltage() { " at its first sample" } else { "" }
                ),
                start,
            ),
            Self::TakenAsSettled { period_samples } => (
                format!(
                    "the drive repeats every {period_samples} samples and is taken to have done so for ever: \
                     the output is that of its steady state"
                ),
                start,
            ),
            Self::StartChosen { chosen, expected } => {
                let words = |from: &Start| match from {
                    Start::Settled { .. } => from.in_words(&units.input, &units.output),
                    _ if model.rests_at_a_voltage() => from.in_words(&units.input, &units.output),
                    _ => "from rest".to_owned(),
                };
                let (chosen, expected) = (words(chosen), words(expected));
                (format!("simulated {chosen}, which explains it better than {expected}"), start)
            }
            Self::LeftOut { samples } => (
                format!(
                    "the drive starts with a jump, which a model without dynamics cannot follow: its first \
                     {samples} samples are not scored"
                ),
                Some(Advice::ScoreAll),
            ),
            Self::Settling { samples } => (
                format!(
                    "the output settles to repeating after its first {samples} samples, which are not scored"
                ),
                Some(Advice::ScoreAll),
            ),
            Self::Fast { signal, fastest_hz, identified_hz } => (
                format!(
                    "the {} swings at up to {} Hz, the model was identified up to {} Hz: beyond that it \
                     extrapolates{}",
                    signal.name(),
                    short(*fastest_hz),
                    short(*identified_hz),
                    if *signal == SignalRole::Reference {
                        ", and the predicted error says nothing of that"
                    } else {
                        ""
                    }
                ),
                None,
            ),
        }
    }
}
