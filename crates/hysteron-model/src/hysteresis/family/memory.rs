//! Memory of an operator at the beginning of a record.

use super::Hysteresis;
use crate::hysteresis::HysteresisError;
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
        if self.form().description().remembers_output() {
            Memory::Displacement(value)
        } else {
            Memory::VirginAt(value)
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
    /// up to one span beyond either end where it is a voltage, between its ends of saturation where it is an
    /// output. `None` for an operator without memory.
    pub fn memory_range(&self, low: f64, high: f64) -> Option<(f64, f64)> {
        self.form().family().memory_range_of_model(self, low, high)
    }
}
