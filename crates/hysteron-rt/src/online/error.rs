//! Errors of a step of an estimator or a monitor.

use core::error::Error;
use core::fmt::{Display, Formatter, Result};

/// A sample that has no finite result. The estimator or the monitor is as it was before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SampleError {
    /// A regressor, the output or the residual is infinite or not a number.
    NotFinite,
    /// The result leaves the range of the number type.
    Overflow,
}

impl Display for SampleError {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::NotFinite => {
                write!(f, "a regressor, the output or the residual is not finite: leave such samples out")
            }
            Self::Overflow => write!(f, "the result leaves the range of the number type: scale the signals"),
        }
    }
}

impl Error for SampleError {}
