//! The joint fit: all records, both blocks, delay, offsets and initial states at once.

mod campaign;
mod fit;
mod intervals;
mod knowledge;
mod parameters;
mod problem;
mod profile;
mod record;
mod setup;
#[cfg(test)]
mod tests;

pub(super) use fit::identify;
pub use intervals::{Interval, IntervalMethod};
pub use knowledge::Covariance;
