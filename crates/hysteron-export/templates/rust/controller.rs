$DESCRIPTION
//!
//! ```
//! use $crate::controller::{Memory, PREVIEW};
//!
//! let mut memory = Memory::new()?;
//! let mut controller = memory.controller()?;
//! // At rest at 0 $INPUT_UNIT, where the sensor reads 0 $OUTPUT_UNIT.
//! let displacement = controller.rest_after(0.0, 0.0, 0.0)?;
//! for _ in 0..PREVIEW {
//!     controller.know(displacement);
//! }
//! // Each period: the voltage goes out, and the displacement is read.
//! let drive = controller.step(displacement);
//! controller.measured(0.0);
//! assert!(drive.voltage >= controller.limits().low);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

//{ feedback
mod law;
//}
//{ observer
mod observed;
//}

//{ observer
use hysteron_rt::Observer;
//}
use hysteron_rt::{Controller, ModelError, SavedError};

pub use crate::inverse::PREVIEW;
use crate::{Real, inverse};

//{ observer
/// Share of the difference to the reading that the disturbance moves by.
const OBSERVER_GAIN: Real = $OBSERVER_GAIN;
//}
/// Marks the saved states of this export: those of another model, rate, number type or version have another.
const MARK: u64 = $MARK;
/// Bytes of a saved state.
pub const SAVED_BYTES: usize = $SAVED_BYTES;

/// What is remembered: the caller's, one for each device.
#[derive(Clone, Debug)]
pub struct Memory {
    inverse: inverse::Memory,
//{ feedback
    law: law::Memory,
//}
//{ observer
    observed: observed::Memory,
//}
    due: [Real; PREVIEW + 1],
}

impl Memory {
    /// Memory for [`Self::controller`].
    ///
    /// # Errors
    /// As [`inverse::Memory::new`].
    pub fn new() -> Result<Self, ModelError<Real>> {
        Ok(Self {
            inverse: inverse::Memory::new()?,
//{ feedback
            law: law::Memory::new()?,
//}
//{ observer
            observed: observed::Memory::new()?,
//}
            due: [0.0; PREVIEW + 1],
        })
    }

    /// The controller, its stage at rest and virgin at the voltage within its limits that is next to 0
    /// $INPUT_UNIT: `step` takes a reference \[$OUTPUT_UNIT\], [`PREVIEW`] samples ahead, and gives the
    /// voltage \[$INPUT_UNIT\]; `measured` takes the displacement \[$OUTPUT_UNIT\] read when it has gone out.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn controller(&mut self) -> Result<Controller<'_, Real>, ModelError<Real>> {
//{ feedback
        let feedback = Some(self.law.feedback()?);
//}
//{ !feedback
        let feedback = None;
//}
//{ observer
        let observer = Some(Observer::new(self.observed.model()?, OBSERVER_GAIN)?);
//}
//{ !observer
        let observer = None;
//}
        Controller::new(self.inverse.compensator()?, feedback, observer, &mut self.due)
    }
}

/// The state, as bytes that outlast a reset. Nothing changes.
///
/// # Errors
/// [`SavedError::Length`] where this is not the one of [`Memory`].
pub fn save(controller: &mut Controller<'_, Real>) -> Result<[u8; SAVED_BYTES], SavedError> {
    let mut bytes = [0; SAVED_BYTES];
    controller.save(MARK, &mut bytes)?;
    Ok(bytes)
}

/// Takes the state that was saved, and goes on with the same bits.
///
/// # Errors
/// [`SavedError`] for bytes of another export, or damaged ones; the state is then as it was.
pub fn restore(controller: &mut Controller<'_, Real>, bytes: &[u8]) -> Result<(), SavedError> {
    controller.restore(MARK, bytes)
}
