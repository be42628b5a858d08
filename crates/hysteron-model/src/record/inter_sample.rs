//! Rules of a sampled signal between its samples.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

use crate::unknown_name::UnknownName;

/// Inter-sample behaviour of a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InterSample {
    /// Held until the next sample: a digital-to-analogue converter without a filter.
    Hold,
    /// A straight line to the next sample.
    #[default]
    Linear,
    /// The band-limited signal through the samples: no content above half the sample rate.
    BandLimited,
}

impl InterSample {
    /// Every rule.
    pub const ALL: [Self; 3] = [Self::Hold, Self::Linear, Self::BandLimited];

    /// Name as on the command line and in a model file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hold => "hold",
            Self::Linear => "linear",
            Self::BandLimited => "band-limited",
        }
    }

    /// One-line description.
    pub const fn summary(self) -> &'static str {
        match self {
            Self::Hold => "Each sample is held until the next: a converter without filter",
            Self::Linear => "A straight line to the next sample",
            Self::BandLimited => "No content above half the sample rate",
        }
    }
}

impl fmt::Display for InterSample {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for InterSample {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        UnknownName::find("rule between samples", name, Self::ALL, Self::name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back() {
        for rule in InterSample::ALL {
            assert_eq!(rule.to_string().parse(), Ok(rule));
        }
        assert!("cubic".parse::<InterSample>().is_err());
    }
}
