//! What an estimator or a monitor can fail with.

use core::error::Error;
use core::fmt::{Debug, Display, Formatter, Result};

/// Numbers an estimator or a monitor cannot be built with.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum OnlineError<T> {
    /// A number of the whole estimator is out of its range.
    Number {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: T,
        /// What it must be.
        must: &'static str,
    },
    /// A number of one parameter is out of its range.
    Parameter {
        /// Its name.
        name: &'static str,
        /// Number of the parameter, from 0.
        index: usize,
        /// Its value.
        value: T,
        /// What it must be.
        must: &'static str,
    },
    /// A monitor that looks for nothing.
    NoChange,
}

/// A sample that has no finite result. The estimator or the monitor is as it was before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SampleError {
    /// A regressor, the output or the residual is infinite or not a number.
    NotFinite,
    /// The result leaves the range of the number type.
    Overflow,
}

impl<T: Display> Display for OnlineError<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Number { name, value, must } => write!(f, "{name} is {value}: it must be {must}"),
            Self::Parameter { name, index, value, must } => {
                write!(f, "{name} of parameter {index} (from 0) is {value}: it must be {must}")
            }
            Self::NoChange => {
                write!(f, "the monitor looks for nothing: give a shift, a spread or both")
            }
        }
    }
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

impl<T: Display + Debug> Error for OnlineError<T> {}
impl Error for SampleError {}
