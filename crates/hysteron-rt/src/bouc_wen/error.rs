//! Errors of a step.

use core::error::Error;
use core::fmt::{Display, Formatter, Result};

/// A step that has no finite result.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum StepError<T> {
    /// The voltage or z handed in is infinite or not a number.
    NotFinite,
    /// z becomes infinite within the move (n > 1, inadmissible parameters).
    BlowUp {
        /// Signed voltage change from the start of the move to the pole of z \[V\].
        after: T,
    },
    /// z (or a derivative) leaves the range of the number type within the move (inadmissible parameters).
    Overflow,
    /// The move needs more sub-steps than allowed (n other than 1 and 2; far beyond any sensible move).
    SubSteps {
        /// The number allowed.
        limit: u16,
    },
}

/// A simulation that stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SimulateError<T> {
    /// The output does not have the length the input asks for.
    Lengths {
        /// Samples the output must have.
        expected: usize,
        /// Samples it has.
        found: usize,
    },
    /// The move to a sample failed.
    Step {
        /// Number of the sample, from 0.
        index: usize,
        /// Why.
        cause: StepError<T>,
    },
}

impl<T: Display> Display for StepError<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::NotFinite => write!(f, "the voltage or the hysteresis state is not finite"),
            Self::BlowUp { after } => write!(
                f,
                "z becomes infinite after {after} V of the move: the parameters are outside the bounded \
                 class (α > 0: β + γ > 0 and β − γ ≥ 0)"
            ),
            Self::Overflow => write!(
                f,
                "z grows beyond the range of the number type: the parameters are outside the bounded class \
                 (α > 0: β + γ > 0 and β − γ ≥ 0)"
            ),
            Self::SubSteps { limit } => write!(
                f,
                "the move needs more than {limit} sub-steps: it is far longer than the voltage over which z \
                 saturates"
            ),
        }
    }
}

impl<T: Display> Display for SimulateError<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Lengths { expected, found } => {
                write!(f, "the output must have {expected} samples for this input but has {found}")
            }
            Self::Step { index, cause } => write!(f, "sample {index}: {cause}"),
        }
    }
}

impl<T: Display + core::fmt::Debug> Error for StepError<T> {}
impl<T: Display + core::fmt::Debug> Error for SimulateError<T> {}
