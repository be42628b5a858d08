//! Memory of an operator at the beginning of a record.

use super::super::{Admissibility, Hysteresis, HysteresisError};
use crate::start::{Memory, Start};

impl Hysteresis {
    /// At rest at a voltage \[V\] with a memory in this operator's own scale, virgin where there is none.
    pub fn start_at_rest(&self, voltage_v: f64, memory: Option<f64>) -> Start {
        match memory {
            None => Start::Rest { voltage_v },
            Some(memory) => Start::Remembering { voltage_v, memory: self.memory(memory) },
        }
    }

    /// A memory of this operator with this number.
    pub fn memory(&self, value: f64) -> Memory {
        match self {
            Self::BoucWen(_) => Memory::Displacement(value),
            Self::Family(_) => Memory::VirginAt(value),
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

    /// Numbers between which a memory of this operator can lie where the drive spans `low` to `high` \[V\]:
    /// between the saturations ±|α| (β' + γ')^(−1/n) of a Bouc–Wen operator, ±|α| times the span for one that
    /// does not saturate; up to one span beyond either end for other families. `None` for an operator without
    /// memory.
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
            Self::Family(model) => {
                let reach = high - low;
                (low < high && model.weights.iter().any(|w| *w != 0.0)).then_some((low - reach, high + reach))
            }
        }
    }
}
