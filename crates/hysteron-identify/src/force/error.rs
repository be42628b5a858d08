//! Errors of the identification of a force.

use hysteron_model::force::ForceModelError;
use hysteron_numeric::display::exact;

/// No force was identified.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ForceError {
    /// A number that cannot be held, or not at this value.
    #[error("'{name}' = {value}: {wanted}", value = exact(*.value))]
    Fixed {
        /// Name of the number.
        name: String,
        /// Value demanded.
        value: f64,
        /// Accepted names or values.
        wanted: String,
    },
    /// An option out of range.
    #[error("{option} is {value}: expected {expected}", value = exact(*.value))]
    Option {
        /// Its name.
        option: &'static str,
        /// Its value.
        value: f64,
        /// Allowed values.
        expected: &'static str,
    },
    /// The rate needs the time between samples.
    #[error(
        "record '{record}' has neither a time column nor a sample rate: the rate of its displacement is not \
         known"
    )]
    NoTimes {
        /// Record.
        record: String,
    },
    /// A record cannot be simulated.
    #[error("record '{record}': {problem}")]
    Record {
        /// Record.
        record: String,
        /// Why.
        problem: ForceModelError,
    },
    /// The structure does not describe the record.
    #[error(
        "hysteresis of the displacement with forces of its rate does not describe record '{record}': the \
         best fit explains {fit_percent:.1} % of it, {need} % are needed",
        need = exact(*.need)
    )]
    Class {
        /// Record.
        record: String,
        /// Fit \[%\], see [`hysteron_model::validate::Scores`].
        fit_percent: f64,
        /// Least fit accepted \[%\].
        need: f64,
    },
}
