//! The joint fit: all records, both blocks, delay, offsets and initial states at once.

mod campaign;
mod fit;
mod knowledge;
mod problem;
mod record;
mod setup;
#[cfg(test)]
mod tests;

pub(super) use fit::identify;
pub use knowledge::Covariance;
