//! Number of elements of a hysteresis family on the command line.

use hysteron_model::hysteresis::HysteresisForm;

use crate::failure::Failure;

/// The family with the number of elements asked for.
///
/// # Errors
/// Wrong usage, for a number that the family does not allow.
pub fn with_elements(form: HysteresisForm, elements: Option<usize>) -> Result<HysteresisForm, Failure> {
    elements.map_or(Ok(form), |count| {
        form.with_elements(count).map_err(|e| Failure::usage(format!("--elements {count}: {e}")))
    })
}
