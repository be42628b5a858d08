//! Why no oscillator was identified.

use crate::IdentifyError;
use hysteron_model::hysteresis::HysteresisError;
use hysteron_model::oscillator::SimulationError;
use hysteron_model::record::RecordError;
use hysteron_model::validate::ScoreError;
use hysteron_optimize::OptimizeError;

/// Why no oscillator was identified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OscillatorFitError {
    /// A record that no identification can use.
    #[error(transparent)]
    Unusable(#[from] IdentifyError),
    /// Motion needs a uniform time base.
    #[error("record '{record}' has no uniform sample rate: the motion of a mass cannot be followed")]
    NotUniform {
        /// Record.
        record: String,
    },
    /// A parameter cannot be held.
    #[error("parameter '{name}' = {value}: {wanted}")]
    Fixed {
        /// Parameter.
        name: String,
        /// Value demanded.
        value: f64,
        /// What would be accepted.
        wanted: &'static str,
    },
    /// The records do not look like a mass on a spring.
    #[error(
        "the records are not those of a mass on a spring: the best linear oscillator has m = {mass:.3e}, c = {damping:.3e}, \
         k = {stiffness:.3e} (force over acceleration, velocity and displacement); all of them should be positive"
    )]
    NoOscillator {
        /// Its mass.
        mass: f64,
        /// Its damping.
        damping: f64,
        /// Its stiffness.
        stiffness: f64,
    },
    /// No shape of the loop gives an oscillator that can be simulated.
    #[error("no loop was found with which the oscillator can be simulated under the force of these records")]
    NoStart,
    /// The oscillator does not describe the record.
    #[error(
        "a mass on a hysteretic spring does not describe record '{record}': the best fit explains {fit_percent:.1} % of it, \
         {need} % are needed"
    )]
    ModelClass {
        /// Record.
        record: String,
        /// Fit \[%\], see [`hysteron_model::validate::Scores`].
        fit_percent: f64,
        /// Least fit accepted \[%\].
        need: f64,
    },
    /// A record is not usable.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The drive between its samples.
    #[error(transparent)]
    Hysteresis(#[from] HysteresisError),
    /// The oscillator could not be simulated.
    #[error(transparent)]
    Oscillator(#[from] SimulationError),
    /// The search failed.
    #[error(transparent)]
    Optimize(#[from] OptimizeError),
    /// The fit could not be scored.
    #[error(transparent)]
    Score(#[from] ScoreError),
}
