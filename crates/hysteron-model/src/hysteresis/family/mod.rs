//! Families of hysteresis under one name each.
//!
//! A family has a description ([`FamilyDescription`]), operations ([`ColumnOperators`], for most those of a
//! kernel, [`ColumnFamily`]) and an entry in the list. [`HysteresisForm`] is a family with its number of
//! elements, [`Hysteresis`] a model of it, [`FamilyStream`] that model sample by sample.

mod description;
mod examples;
mod form;
mod json;
mod memory;
mod model;
mod number;
mod operators;
mod run;
mod runtime;
mod stream;

pub use description::{Elements, FamilyDescription};
pub(super) use description::{MOST_ELEMENTS, MOST_OF_A_PLANE, in_a_row, on_a_plane};
#[doc(hidden)]
pub use examples::examples;
pub use form::HysteresisForm;
pub use model::Hysteresis;
pub use number::{DriveSpan, ModelNumber, NumberUnit, Place, Search, ShapeNumber};
pub(super) use number::{SKEWS, ends};
pub(super) use operators::{ColumnFamily, ColumnOperators, GRID_ENDS, Mover, WHOLE_SHAPE};
pub use runtime::{MeanLine, RuntimeOperator};
pub use stream::FamilyStream;

#[cfg(test)]
mod tests;
