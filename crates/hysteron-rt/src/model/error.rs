//! Errors of a streaming model.

use core::error::Error;
use core::fmt::{Debug, Display, Formatter, Result};

/// Invalid numbers of a streaming model, or a step without a result.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ModelError<T> {
    /// Memory of the wrong length: required is one number or group for each coefficient or group.
    Memory {
        /// Required number.
        expected: usize,
        /// Number given.
        found: usize,
    },
    /// No taps, or too many.
    Taps {
        /// Number given.
        found: usize,
    },
    /// A coefficient is infinite or not a number.
    Coefficient,
    /// The voltage is infinite or not a number.
    NotFinite,
    /// The hysteresis block's output exceeds the input range of the dynamics (inadmissible parameters, or an
    /// excessive voltage).
    Overflow,
    /// Invalid limits: required are low below high, both finite, and a step above 0.
    Limits,
    /// The initial displacement is infinite or not a number.
    Start {
        /// That displacement.
        displacement: T,
    },
}

impl<T: Display> Display for ModelError<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Memory { expected, found } => {
                write!(f, "memory for {found} where there are {expected}: give one each")
            }
            Self::Taps { found } => write!(f, "{found} taps: there must be 1 to {}", super::MOST_TAPS),
            Self::Coefficient => write!(f, "a coefficient of the model is not finite"),
            Self::NotFinite => write!(f, "the voltage is not finite"),
            Self::Overflow => write!(
                f,
                "the output of the hysteresis leaves the range of the number type: its parameters are \
                 outside the bounded class, or the voltage is out of all reason"
            ),
            Self::Limits => {
                write!(
                    f,
                    "limits that leave no room: give finite voltages, low below high, and a step above 0"
                )
            }
            Self::Start { displacement } => write!(f, "cannot start at a displacement of {displacement}"),
        }
    }
}

impl<T: Display + Debug> Error for ModelError<T> {}
