//! What a device did before a record's first sample.

use hysteron_numeric::display::short;
use serde::{Deserialize, Serialize};

use crate::hysteresis::{Hysteresis, Memory};
use crate::record::Unit;

/// What happened before a record's first sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Start {
    /// As the model file assumes ([`crate::Model`]); without one, at rest at the first sample.
    #[default]
    AsIdentified,
    /// The device rested at this voltage, free of hysteresis memory (z = 0), and moves to u(0) in one sample period.
    /// With `voltage_v` = u(0) this is SPEC §3 `rest`, with 0 V (drive off) it is `zero`. An oscillator rests without force,
    /// whatever the voltage.
    Rest {
        /// Voltage before the first sample \[V\].
        voltage_v: f64,
    },
    /// The device rested at this voltage with a hysteresis memory and moves to u(0) in one sample period.
    Remembering {
        /// Voltage before the first sample \[V\].
        voltage_v: f64,
        /// What the hysteresis block remembers there.
        memory: Memory,
    },
    /// The record repeats: its first period has been running for long.
    Settled {
        /// Samples of a period.
        period_samples: usize,
    },
}

impl Start {
    /// At rest at a voltage \[V\] with a memory in the operator's own scale, virgin where there is none.
    pub fn at_rest(hysteresis: &Hysteresis, voltage_v: f64, memory: Option<f64>) -> Self {
        match memory {
            None => Self::Rest { voltage_v },
            Some(memory) => Self::Remembering { voltage_v, memory: hysteresis.memory(memory) },
        }
    }

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
            Self::Settled { period_samples } => format!("settled on its period of {period_samples} samples"),
        }
    }

    /// Voltage before the first sample \[V\]; `None` where the record repeats, or the model file says.
    pub fn voltage_v(&self) -> Option<f64> {
        match *self {
            Self::Rest { voltage_v } | Self::Remembering { voltage_v, .. } => Some(voltage_v),
            Self::Settled { .. } | Self::AsIdentified => None,
        }
    }
}
