//! Stages of several axes: records of several inputs and outputs, and models that couple them.
//!
//! [`AxesRecord`] takes several channels of a [`crate::record::Record`] at once. [`SteadyPeriod`] is the mean
//! period of one whose drive repeats; [`FrequencyMatrix`] its outputs over its inputs by the local polynomial
//! method, [`VectorFit`] the poles that all entries share, [`InfluenceMatrix`] the quasi-static gain of each
//! actuator at each sensor, with its conditioning. The model is [`ScheduledModes`]: structural modes with the
//! hysteresis of drive and stress in feedback; or, simpler, [`CoupledHammerstein`]: a sum of branches,
//! hysteresis of each actuator and dynamics of each path.

mod coupled;
mod error;
mod frequency_matrix;
mod influence;
mod modes;
mod record;
mod score;
mod steady;
mod vector_fit;

pub use coupled::{CoupledErrors, CoupledHammerstein, Path};
#[doc(hidden)]
pub use coupled::{branch, start};
pub use error::AxesError;
pub use frequency_matrix::{FrequencyMatrix, HALF_WINDOW, spectrum};
pub use influence::InfluenceMatrix;
#[doc(hidden)]
pub use modes::pole;
pub use modes::{
    AtLevel, FeedbackStrain, HeldModes, HeldSimulation, LevelLaw, LevelTracker, Mode, ScheduledModes,
    SquareWave, StrainLaw, Streaming, Trajectory, simulate_steady,
};
#[doc(hidden)]
pub use modes::{LARGEST_POLE, POWERS, frequency, linear_states};
pub use record::AxesRecord;
pub use score::AxesScores;
pub use steady::SteadyPeriod;
#[doc(hidden)]
pub use steady::remove_means;
pub(crate) use steady::{level, repeats};
pub use vector_fit::{CommonPoles, VectorFit, spread_poles};
