//! The joint fit: all records, both blocks, delay, offsets and initial states at once.

mod band;
mod between;
mod campaign;
mod creep_gain;
mod degree;
mod drive;
mod family;
mod fit;
mod fitted;
mod intervals;
mod knowledge;
mod many_starts;
mod model;
mod normalised;
mod objective;
mod orders;
mod parameter_layout;
mod parameters;
mod problem;
mod profile;
mod record;
mod reduction;
mod resolution;
mod resonances;
mod search;
mod setup;
mod smoothing;
mod starts;
#[cfg(test)]
mod tests;
mod weighting;

pub use band::{OutputUncertainty, PredictionBand};
pub use between::InterSampleChoice;
pub(super) use between::excess_if_held;
pub(super) use campaign::{JointMember, Rate, UNKNOWN_PAST};
pub(super) use fit::{PLAN, POPULATION_PLAN, identify};
pub use intervals::{Interval, IntervalMethod};
pub use knowledge::Covariance;
pub(super) use knowledge::coloured_square;
pub(super) use model::assemble;
pub(super) use normalised::{fit_with_its_memory, local_fits, nearer_with_its_memory};
pub use objective::{JointObjective, JointScratch};
pub(super) use problem::JointProblem;
pub(super) use resolution::information;
pub(super) use setup::{JointSetup, RESONANCE_AND_LAG, form, memory_name, scheme};
pub use smoothing::Smoothing;
