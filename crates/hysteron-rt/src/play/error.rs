//! Errors of a bank of plays.

use core::error::Error;
use core::fmt::{Debug, Display, Formatter, Result};

/// A move, or the inverse of one, without a result.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PlayError<T> {
    /// Plays and states differ in number.
    Lengths {
        /// Number of plays.
        expected: usize,
        /// States handed in.
        found: usize,
    },
    /// The voltage, the output or a state handed in is infinite or not a number.
    NotFinite,
    /// The result leaves the range of the number type.
    Overflow,
    /// States that no common voltage history produces: those of play `index` and the one before it differ by
    /// more than their thresholds.
    History {
        /// Number of the play, from 0.
        index: usize,
    },
    /// The sum does not increase with the voltage: no inverse.
    Slope {
        /// The least partial slope.
        least: T,
    },
}

impl<T: Display> Display for PlayError<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Lengths { expected, found } => {
                write!(f, "{found} states for {expected} plays: give one a play")
            }
            Self::NotFinite => write!(f, "the voltage, the output or a state is not finite"),
            Self::Overflow => write!(f, "the result leaves the range of the number type"),
            Self::History { index } => write!(
                f,
                "the states have no common history: play {index} (from 0) is further from the one before it \
                 than their thresholds differ"
            ),
            Self::Slope { least } => write!(
                f,
                "the sum of plays has no inverse: its least partial slope is {least} and must be positive"
            ),
        }
    }
}

impl<T: Display + Debug> Error for PlayError<T> {}
