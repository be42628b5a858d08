//! State of a device before a record's first sample.

use hysteron_numeric::display::short;
use serde::{Deserialize, Serialize};

use crate::record::Unit;

/// State of a device before a record's first sample. `M` is the form of the memory at rest: [`Memory`] for a
/// model, the number in the operator's own scale for a hysteresis operator, the whole state for an
/// oscillator, nothing for a linear block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Start<M = Memory> {
    /// As the model file assumes ([`crate::Model`]); without one, at rest at the first sample.
    #[default]
    AsIdentified,
    /// The device rested at this voltage, demagnetised (z = 0), and moves to u(0) in one sample period.
    /// `voltage_v` = u(0) is the condition `rest` of `docs/theory/fractional.md`, 0 V (drive off) its `zero`.
    /// An oscillator rests without force, whatever the voltage.
    Rest {
        /// Voltage before the first sample \[V\].
        voltage_v: f64,
    },
    /// The device rested at this voltage with a hysteresis memory and moves to u(0) in one sample period.
    Remembering {
        /// Voltage before the first sample \[V\].
        voltage_v: f64,
        /// Hysteresis memory there.
        memory: M,
    },
    /// Periodic steady state: the first period repeated for long before the record.
    Settled {
        /// Samples of a period; `None`: the record's own, which for a block of a model is the whole record.
        period_samples: Option<usize>,
        /// Voltage at which the device was virgin before it moved monotonically to the start of the first
        /// period \[V\]; `None`: virgin at that start.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        virgin_at_v: Option<f64>,
    },
}

/// The start of a linear block, whose memory follows from its past input: [`Start::AsIdentified`]: at rest at
/// the first sample's input, so that v − v(0) is simulated and G(0) v(0) added; [`Start::Rest`]: at rest at
/// this input.
pub type LinearStart = Start<std::convert::Infallible>;

/// Memory of a hysteresis operator where a record begins, as one number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Memory {
    /// Hysteretic displacement z \[µm\], for families that remember an output.
    Displacement(f64),
    /// Voltage \[V\] at which the device was virgin before it moved monotonically to rest, for the
    /// others.
    VirginAt(f64),
}

impl<M> Start<M> {
    /// Periodic steady state with the record's own period.
    pub const PERIODIC: Self = Self::Settled { period_samples: None, virgin_at_v: None };

    /// At rest at 0, without memory: all signals zero before the first sample (the article).
    pub const ZERO: Self = Self::Rest { voltage_v: 0.0 };

    /// Periodic steady state with a period of `period_samples`.
    pub fn settled(period_samples: usize) -> Self {
        Self::Settled { period_samples: Some(period_samples), virgin_at_v: None }
    }
}

impl Start {
    /// A start in words, with the units of input and output (header symbols).
    pub fn in_words(&self, input: &str, output: &str) -> String {
        let quantity =
            |value: f64, unit: &str| format!("{} {}", short(value), Unit::new(unit)).trim_end().to_owned();
        match self {
            Self::AsIdentified => "as identified".to_owned(),
            Self::Rest { voltage_v } => format!("from rest at {}", quantity(*voltage_v, input)),
            Self::Remembering { voltage_v, memory } => format!(
                "from rest at {} {}",
                quantity(*voltage_v, input),
                memory.in_words(
                    &short(memory.value()),
                    &Unit::new(input).to_string(),
                    &Unit::new(output).to_string()
                )
            ),
            Self::Settled { period_samples: Some(samples), .. } => {
                format!("settled on its period of {samples} samples")
            }
            Self::Settled { period_samples: None, .. } => "settled on its period".to_owned(),
        }
    }

    /// Voltage before the first sample \[V\]; `None` where the record repeats or the model file determines
    /// it.
    pub fn voltage_v(&self) -> Option<f64> {
        match *self {
            Self::Rest { voltage_v } | Self::Remembering { voltage_v, .. } => Some(voltage_v),
            Self::Settled { .. } | Self::AsIdentified => None,
        }
    }
}

impl Memory {
    /// The number.
    pub fn value(self) -> f64 {
        match self {
            Self::Displacement(value) | Self::VirginAt(value) => value,
        }
    }

    /// In words, with the formatted `number` and the units of input and output.
    pub fn in_words(self, number: &str, input: &str, output: &str) -> String {
        let words = match self {
            Self::Displacement(_) => format!("with the hysteresis memory z = {number} {output}"),
            Self::VirginAt(_) => format!("with the hysteresis memory of a device virgin at {number} {input}"),
        };
        words.trim_end().to_owned()
    }

    /// This kind of memory with another number.
    #[must_use]
    pub fn with_value(self, value: f64) -> Self {
        match self {
            Self::Displacement(_) => Self::Displacement(value),
            Self::VirginAt(_) => Self::VirginAt(value),
        }
    }

    /// The memory of the operator with its output scaled by `gain`.
    #[must_use]
    pub fn scaled(self, gain: f64) -> Self {
        match self {
            Self::Displacement(z) => Self::Displacement(gain * z),
            virgin @ Self::VirginAt(_) => virgin,
        }
    }
}
