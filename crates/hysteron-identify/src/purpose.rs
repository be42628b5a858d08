//! Purposes of an experiment.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the next drive is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Purpose {
    /// The dead time.
    Delay,
    /// Frequency and gain of the resonance.
    Resonance,
    /// Creep.
    Creep,
    /// The output along slow minor loops.
    MinorLoops,
    /// The output along random motion up to the highest frequency.
    #[default]
    Prediction,
}

impl Purpose {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Delay, Self::Resonance, Self::Creep, Self::MinorLoops, Self::Prediction];

    /// `delay`, `resonance`, `creep`, `minor-loops` or `prediction`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Delay => "delay",
            Self::Resonance => "resonance",
            Self::Creep => "creep",
            Self::MinorLoops => "minor-loops",
            Self::Prediction => "prediction",
        }
    }
}
