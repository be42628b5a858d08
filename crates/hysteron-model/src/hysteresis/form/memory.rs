//! What an operator remembers where a record begins.

use serde::{Deserialize, Serialize};

use super::super::{Admissibility, Family, Hysteresis, HysteresisError, PrandtlIshlinskii};

/// What a hysteresis operator remembers where a record begins, in one number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Memory {
    /// Hysteretic displacement z \[µm\], of Bouc–Wen.
    Displacement(f64),
    /// Voltage \[V\] at which the device was virgin before it moved, without turning, to where it rested; of every other family.
    VirginAt(f64),
}

impl Memory {
    /// The number.
    pub fn value(self) -> f64 {
        match self {
            Self::Displacement(value) | Self::VirginAt(value) => value,
        }
    }

    /// In words, the number as it is to read, with the units of input and output.
    pub fn in_words(self, number: &str, input: &str, output: &str) -> String {
        let words = match self {
            Self::Displacement(_) => format!("with the hysteresis memory z = {number} {output}"),
            Self::VirginAt(_) => format!("with the hysteresis memory of a device virgin at {number} {input}"),
        };
        words.trim_end().to_owned()
    }

    /// The same kind of memory with another number.
    #[must_use]
    pub fn with_value(self, value: f64) -> Self {
        match self {
            Self::Displacement(_) => Self::Displacement(value),
            Self::VirginAt(_) => Self::VirginAt(value),
        }
    }

    /// That of the operator whose output is `gain` times as large.
    #[must_use]
    pub fn scaled(self, gain: f64) -> Self {
        match self {
            Self::Displacement(z) => Self::Displacement(gain * z),
            virgin @ Self::VirginAt(_) => virgin,
        }
    }
}

impl Hysteresis {
    /// A memory of this operator with this number.
    pub fn memory(&self, value: f64) -> Memory {
        match self {
            Self::BoucWen(_) => Memory::Displacement(value),
            Self::PrandtlIshlinskii(_) | Self::Family(_) => Memory::VirginAt(value),
        }
    }

    /// The number of a memory.
    ///
    /// # Errors
    /// [`HysteresisError::Memory`] where it is another operator's.
    pub fn own_memory(&self, memory: Memory) -> Result<f64, HysteresisError> {
        if self.memory(memory.value()) == memory || memory.value().is_nan() {
            Ok(memory.value())
        } else {
            Err(HysteresisError::Memory)
        }
    }

    /// Numbers between which a memory of this operator can lie where the drive spans `low` to `high` \[V\]: between the
    /// saturations ±|α| (β' + γ')^(−1/n) of a Bouc–Wen operator, ±|α| times the span for one that does not saturate; up to
    /// the span beyond the span for other families. `None` where there is nothing to remember.
    pub fn memory_range(&self, low: f64, high: f64) -> Option<(f64, f64)> {
        match self {
            Self::BoucWen(model) => {
                let reach = match model.admissibility() {
                    Admissibility::Bounded { saturation_v }
                    | Admissibility::BoundedFromRest { saturation_v, .. } => saturation_v,
                    _ => high - low,
                };
                let limit = model.alpha.abs() * reach;
                (limit > 0.0 && limit.is_finite()).then_some((-limit, limit))
            }
            Self::PrandtlIshlinskii(PrandtlIshlinskii { weights, .. })
            | Self::Family(Family { weights, .. }) => {
                let reach = high - low;
                (low < high && weights.iter().any(|w| *w != 0.0)).then_some((low - reach, high + reach))
            }
        }
    }
}
