//! Errors of simulating a single-input single-output model.

use crate::dynamics::DynamicsError;
use crate::force::ForceModelError;
use crate::hysteresis::HysteresisError;
use hysteron_numeric::display::exact;

/// A Hammerstein model, an oscillator or a force that cannot be simulated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// Dynamics or a delay need to know the time between samples.
    #[error("the model has dynamics or a delay, but the record has no uniform sample rate")]
    NoSampleRate,
    /// The model's parameters belong to one sample rate.
    #[error(
        "the model ({scheme}) belongs to the sample rate it was identified at, {model_hz} Hz, and the record \
         has {record_hz} Hz",
        model_hz = exact(*.model_hz),
        record_hz = exact(*.record_hz)
    )]
    SampleRate {
        /// Scheme that ties the model to its rate, or `ARX`.
        scheme: &'static str,
        /// Rate of the model \[Hz\].
        model_hz: f64,
        /// Rate of the record \[Hz\].
        record_hz: f64,
    },
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
    /// The dynamic block failed.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// The force against a displacement failed.
    #[error(transparent)]
    ForceModel(#[from] ForceModelError),
    /// A start with a hysteresis memory, which an oscillator at rest does not have.
    #[error(
        "an oscillator starts from rest without force, or settled on a period; a hysteresis memory does not \
         apply"
    )]
    Memory,
    /// A parameter of an oscillator is out of range.
    #[error("oscillator parameter {name} is {value}: expected {expected}", value = exact(*.value))]
    Parameter {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Allowed values.
        expected: &'static str,
    },
    /// A state to start from is infinite or not a number.
    #[error(
        "the state to start from (y = {y}, velocity {velocity}, z = {z}) is not finite",
        y = exact(*.y),
        velocity = exact(*.velocity),
        z = exact(*.z)
    )]
    State {
        /// Displacement.
        y: f64,
        /// Velocity.
        velocity: f64,
        /// Hysteretic force.
        z: f64,
    },
    /// Too few samples of the force.
    #[error("the force has {samples} samples: at least 2 are needed")]
    TooShort {
        /// Samples there are.
        samples: usize,
    },
    /// A sample of the force is infinite or not a number.
    #[error("sample {index} of the force is {value}: it must be finite", value = exact(*.value))]
    Force {
        /// Number of the sample, from 0.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The sample rate is invalid.
    #[error("the sample rate is {value} Hz: it must be finite and above 0", value = exact(*.value))]
    BadSampleRate {
        /// The rate given.
        value: f64,
    },
    /// No steps of an oscillator between samples.
    #[error("0 steps a sample: at least 1 is needed")]
    Steps,
    /// The output does not have the length of the drive.
    #[error("the output has {found} samples but the force has {expected}")]
    Lengths {
        /// Samples of the force.
        expected: usize,
        /// Samples of the output.
        found: usize,
    },
    /// A periodic steady state was requested under a force that does not repeat.
    #[error("a periodic start needs a force that repeats, but this one was made with open ends")]
    NotPeriodic,
    /// The motion overflows.
    #[error(
        "the motion runs away before sample {index}: the parameters let z grow without limit (for α > 0 keep \
         β + γ > 0 and β − γ ≥ 0) or the motion is not damped"
    )]
    RunsAway {
        /// Number of the sample, from 0.
        index: usize,
    },
    /// The motion overflows, though the parameters keep it bounded.
    #[error(
        "the motion leaves the range of numbers before sample {index}: under this force the hysteresis changes \
         faster than the steps between samples can follow; check the unit of the force, or sample it faster"
    )]
    TooFast {
        /// Number of the sample, from 0.
        index: usize,
    },
    /// No periodic steady state was found.
    #[error(
        "no steady state after {periods} periods: the state still changes by {change:e} of its size in a \
         period"
    )]
    NotSettled {
        /// Periods simulated.
        periods: usize,
        /// Change over the last one, as a share of the largest value.
        change: f64,
    },
    /// The steady state does not determine its own derivatives.
    #[error("the steady state has no derivatives: state differences do not decay over a period")]
    NotContracting,
    /// The force could not be interpolated.
    #[error("the force between its samples: {0}")]
    Interpolation(HysteresisError),
}
