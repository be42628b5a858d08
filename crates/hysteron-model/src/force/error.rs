//! Errors of a force against a displacement.

use crate::hysteresis::HysteresisError;
use hysteron_numeric::display::exact;

/// A force that cannot be simulated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ForceModelError {
    /// A parameter is out of range.
    #[error("parameter {name} of the force is {value}: expected {expected}", value = exact(*.value))]
    Parameter {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Allowed values.
        expected: &'static str,
    },
    /// A rate needs the time between samples.
    #[error(
        "the force depends on the rate of the displacement, but the record has neither a time column nor a \
         sample rate"
    )]
    NoTimes,
    /// The rate does not belong to the displacement.
    #[error("the rate has {found} samples but the displacement has {expected}")]
    RateLength {
        /// Samples of the displacement.
        expected: usize,
        /// Samples of the rate.
        found: usize,
    },
    /// There is no such channel for the rate.
    #[error("there is no column `{name}` for the rate: the record has {available}")]
    NoRateChannel {
        /// As asked for.
        name: String,
        /// The channels there are.
        available: String,
    },
    /// The unit of the rate is not that of the displacement per time.
    #[error(
        "the rate `{channel}` is in {found}, but the displacement in {displacement}: expected a unit like \
         {displacement}/s, in a header v_{displacement}_per_s"
    )]
    RateUnit {
        /// Name of the channel.
        channel: String,
        /// Its unit.
        found: String,
        /// Unit of the displacement.
        displacement: String,
    },
    /// A sample is infinite or not a number.
    #[error("sample {index} of the {signal} is {value}: it must be finite", value = exact(*.value))]
    Sample {
        /// `displacement` or `rate`.
        signal: &'static str,
        /// Number of the sample, from 0.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A start that needs a state which the force does not have.
    #[error(
        "a force starts from rest at the first sample, or settled on a period; another rest or a hysteresis \
         memory does not apply"
    )]
    Start,
    /// The period of a settled start is out of range.
    #[error("a settled start needs a period of 2 to {samples} samples, found {period_samples}")]
    Period {
        /// Samples of the record.
        samples: usize,
        /// Samples of the period requested.
        period_samples: usize,
    },
    /// The hysteresis block failed.
    #[error(transparent)]
    Hysteresis(#[from] HysteresisError),
}
