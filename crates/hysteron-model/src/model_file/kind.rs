//! Kinds of model.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Kind of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Hysteresis followed by linear dynamics: one input, one output.
    Hammerstein,
    /// A mass on a hysteretic spring: one input, one output.
    Oscillator,
    /// Force of a damper against a displacement and its rate: one input, one output.
    Force,
    /// Structural modes with hysteresis in feedback, scheduled by the level of the drive: several inputs and
    /// outputs.
    Modes,
    /// Sums of Hammerstein branches: several inputs and outputs.
    Branches,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 5] =
        [Self::Hammerstein, Self::Oscillator, Self::Force, Self::Modes, Self::Branches];

    /// Name in the model file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hammerstein => "hammerstein",
            Self::Oscillator => "oscillator",
            Self::Force => "force",
            Self::Modes => "modes",
            Self::Branches => "branches",
        }
    }

    /// The kind of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// All names, for messages.
    pub(super) fn names() -> String {
        let quoted: Vec<String> = Self::ALL.iter().map(|kind| format!("\"{kind}\"")).collect();
        quoted.join(", ")
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
