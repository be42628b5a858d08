//! Hysteresis families on the command line: the library's list.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use hysteron_model::hysteresis::{HysteresisForm, UnknownFamily};

use crate::failure::Failure;

/// Parses the name of a family.
pub fn parser() -> impl TypedValueParser<Value = HysteresisForm> {
    let value = |form: HysteresisForm| PossibleValue::new(form.name()).help(form.summary());
    PossibleValuesParser::new(HysteresisForm::usual().map(value))
        .try_map(|name| name.parse::<HysteresisForm>().map_err(|e: UnknownFamily| e.to_string()))
}

/// The family with the number of elements asked for.
///
/// # Errors
/// Wrong usage, for a number that it cannot have.
pub fn with_elements(form: HysteresisForm, elements: Option<usize>) -> Result<HysteresisForm, Failure> {
    elements.map_or(Ok(form), |count| {
        form.with_elements(count).map_err(|e| Failure::usage(format!("--elements {count}: {e}")))
    })
}
