//! Errors of the inverse of several axes.

use crate::axes::AxesError;
use crate::dynamics::DynamicsError;
use crate::hammerstein::SimulationError;
use crate::hysteresis::HysteresisError;
use hysteron_numeric::display::{exact, short};

/// The references of several axes cannot be followed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DecouplingError {
    /// Another number of references than the model has outputs.
    #[error("the model has {outputs} outputs, but there are {references} references")]
    References {
        /// Outputs of the model.
        outputs: usize,
        /// References given.
        references: usize,
    },
    /// Another number of limits than the model has inputs.
    #[error("the model has {inputs} inputs, but there are limits for {limits}")]
    Limits {
        /// Inputs of the model.
        inputs: usize,
        /// Limits given.
        limits: usize,
    },
    /// No limits were given, and the model was identified in none.
    #[error("the model does not say which drives it was identified with: give their limits")]
    RangeUnknown,
    /// Periodic references were to be followed one sample at a time.
    #[error("references that repeat are followed as a whole: one sample at a time they have no steady state")]
    Repeats,
    /// A reference that is too short, or references of different lengths.
    #[error("reference {axis} has {samples} samples: all must have the same number, 2 or more")]
    Samples {
        /// Number of the reference, from 1.
        axis: usize,
        /// Its samples.
        samples: usize,
    },
    /// A sample that is not finite.
    #[error("sample {index} (from 0) of reference {axis} is not finite")]
    NotFinite {
        /// Number of the reference, from 1.
        axis: usize,
        /// Number of the sample.
        index: usize,
    },
    /// Fewer actuators than axes.
    #[error(
        "{inputs} actuators cannot move {outputs} axes independently: at least as many actuators are needed"
    )]
    TooFewActuators {
        /// Inputs of the model.
        inputs: usize,
        /// Outputs of the model.
        outputs: usize,
    },
    /// Axes that the actuators do not move independently at rest.
    #[error(
        "the actuators do not move the axes independently at rest: the condition number of the gains is {}",
        short(*condition)
    )]
    Singular {
        /// Condition number of the gains at rest.
        condition: f64,
    },
    /// No drive within the limits holds the first values.
    #[error(
        "input {actuator} would have to rest at {}, outside of its limits {} to {}, for the first values of \
         the references",
        short(*rest),
        short(*low),
        short(*high)
    )]
    Begins {
        /// Number of the input, from 1.
        actuator: usize,
        /// Voltage needed \[V\].
        rest: f64,
        /// Its least voltage \[V\].
        low: f64,
        /// Its largest voltage \[V\].
        high: f64,
    },
    /// The drive changes from round to round.
    #[error(
        "no drive with a bandwidth of {bandwidth_hz} Hz was found in {rounds} rounds: it still changes by {change} \
         of its size; the hysteresis in feedback is too strong at this bandwidth",
        bandwidth_hz = short(*.bandwidth_hz),
        change = short(*.change)
    )]
    NotConverging {
        /// Rounds computed.
        rounds: usize,
        /// Relative change in the last one.
        change: f64,
        /// Bandwidth \[Hz\].
        bandwidth_hz: f64,
    },
    /// The voltages that hold outputs change from round to round.
    #[error(
        "no voltages that hold the first values of the references were found in {rounds} rounds: they still \
         change by {} of their range",
        short(*change)
    )]
    NoRest {
        /// Rounds computed.
        rounds: usize,
        /// Change in the last one, relative to the range.
        change: f64,
    },
    /// The drives depend on the last digits of the references.
    #[error(
        "with a bandwidth of {bandwidth_hz} Hz the drives depend on the last digits of the references: the loop \
         through the hysteresis does not settle; ask for a lower bandwidth",
        bandwidth_hz = short(*.bandwidth_hz)
    )]
    Unsteady {
        /// Bandwidth \[Hz\].
        bandwidth_hz: f64,
    },
    /// The equations of the regulator have no solution in double precision.
    #[error("no stable regulator of the axes was found; ask for another bandwidth")]
    NoRegulator,
    /// An option out of its range.
    #[error("{name} must be {allowed}, but it is {value}", value = exact(*.value))]
    Option {
        /// Its name, with its unit where it has one.
        name: &'static str,
        /// The value given.
        value: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    /// The stage cannot be driven.
    #[error("{problem}")]
    Stage {
        /// Description of the problem.
        problem: String,
    },
    /// The model cannot be run.
    #[error(transparent)]
    Axes(#[from] AxesError),
    /// The dynamics have no inverse.
    #[error("the dynamics cannot be inverted: {0}")]
    Dynamics(#[from] DynamicsError),
    /// A hysteresis has no inverse.
    #[error("the hysteresis cannot be inverted: {0}")]
    Hysteresis(#[from] HysteresisError),
    /// A branch that cannot be simulated.
    #[error(transparent)]
    Branch(#[from] SimulationError),
}
