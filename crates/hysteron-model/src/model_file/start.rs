//! The start that a file assumes: [`Start`], its voltage a quantity.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{ModelFile, OscillatorFile, Quantity};
use crate::start::Start;

/// Assumed history of the device before a record's first sample.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object with the keys `kind` and `voltage`")]
pub(super) struct StartEntry {
    /// At rest, or in a settled periodic motion.
    pub(super) kind: StartKind,
    /// For `rest`: the input at which the device rested, in the input's unit; null for each record's first
    /// sample.
    #[serde(default)]
    pub(super) voltage: Option<Quantity>,
}

/// Kinds of start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum StartKind {
    /// At rest at one voltage, without hysteresis memory.
    #[default]
    Rest,
    /// The record's first period has been running for some time.
    Settled,
}

impl ModelFile {
    /// Default start before a record. [`Start::AsIdentified`]: at rest at the record's own first sample;
    /// [`Start::PERIODIC`]: the periodic steady state of the drive's own period.
    pub fn start(&self) -> Start {
        match (&self.start.voltage, self.start.kind) {
            (Some(voltage), _) => Start::Rest { voltage_v: voltage.value },
            (None, StartKind::Rest) => Start::AsIdentified,
            (None, StartKind::Settled) => Start::PERIODIC,
        }
    }

    /// Sets it. The memory at rest and the samples of a period are a record's, not the model's.
    pub fn set_start(&mut self, start: Start) {
        let unit = if self.units.input.is_empty() { "1" } else { &self.units.input };
        self.start = match start {
            Start::AsIdentified => StartEntry::default(),
            Start::Rest { voltage_v } | Start::Remembering { voltage_v, .. } => {
                StartEntry { kind: StartKind::Rest, voltage: Some(Quantity::new(voltage_v, unit)) }
            }
            Start::Settled { .. } => StartEntry { kind: StartKind::Settled, voltage: None },
        };
    }
}

impl OscillatorFile {
    /// [`ModelFile::start`] for an oscillator, which rests without force.
    pub fn start(&self) -> Start {
        match self.start {
            StartKind::Rest => Start::AsIdentified,
            StartKind::Settled => Start::PERIODIC,
        }
    }

    /// Sets it.
    pub fn set_start(&mut self, start: Start) {
        self.start = match start {
            Start::Settled { .. } => StartKind::Settled,
            Start::AsIdentified | Start::Rest { .. } | Start::Remembering { .. } => StartKind::Rest,
        };
    }
}
