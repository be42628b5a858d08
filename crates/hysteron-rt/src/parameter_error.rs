//! Error of invalid parameters.

use core::error::Error;
use core::fmt::{Debug, Display, Formatter, Result};

/// Invalid parameters of an operator, an estimator or a monitor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ParameterError<T> {
    /// A parameter of hysteresis is infinite or not a number.
    NotFinite {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: T,
    },
    /// n < 1.
    Exponent {
        /// The exponent given.
        n: T,
    },
    /// Weights and thresholds differ in number.
    Lengths {
        /// Number of thresholds.
        thresholds: usize,
        /// Number of weights.
        weights: usize,
    },
    /// A threshold is not finite or not above the one before it (0 before the first).
    Threshold {
        /// Its number, from 0.
        index: usize,
        /// Its value.
        value: T,
        /// Bound it must exceed.
        above: T,
    },
    /// A weight is infinite or not a number.
    Weight {
        /// Its number, from 0.
        index: usize,
        /// Its value.
        value: T,
    },
    /// A parameter of the sides of plays is infinite, not a number, or not positive where it must be.
    Sides,
    /// Ends of a plane of relays that are not finite, or not the low one below the high one.
    Range,
    /// Not n (n + 1)/2 sums over a plane of relays, n ≥ 1.
    Sums {
        /// Required number.
        expected: usize,
        /// Number given.
        found: usize,
    },
    /// A sum over a plane of relays is infinite or not a number.
    Sum,
    /// A setting of the whole estimator is out of its range.
    Number {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: T,
        /// Requirement.
        must: &'static str,
    },
    /// A number of one parameter of an estimator is out of its range.
    Parameter {
        /// Its name.
        name: &'static str,
        /// Number of the parameter, from 0.
        index: usize,
        /// Its value.
        value: T,
        /// Requirement.
        must: &'static str,
    },
    /// A monitor without a change to detect.
    NoChange,
}

impl<T: Display> Display for ParameterError<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::NotFinite { name, value } => {
                write!(f, "hysteresis parameter {name} = {value} is not finite")
            }
            Self::Exponent { n } => write!(f, "hysteresis exponent n = {n} is below 1, the smallest allowed"),
            Self::Lengths { thresholds, weights } => {
                write!(f, "{thresholds} thresholds but {weights} weights: give one weight a threshold")
            }
            Self::Threshold { index, value, above } => write!(
                f,
                "threshold {index} (from 0) is {value}: it must be finite and above {above}; thresholds are \
                 positive and increase"
            ),
            Self::Weight { index, value } => {
                write!(f, "weight {index} (from 0) is {value}: it must be finite")
            }
            Self::Sides => write!(
                f,
                "the numbers of the sides of the plays must be finite, rises and steepness positive, \
                 widening not negative"
            ),
            Self::Range => {
                write!(f, "the ends of a plane of relays must be finite, the low one below the high one")
            }
            Self::Sums { expected, found } => {
                write!(
                    f,
                    "{found} sums over a plane of relays where there must be {expected}, and at least 1"
                )
            }
            Self::Sum => write!(f, "a sum over a plane of relays is not finite"),
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

impl<T: Display + Debug> Error for ParameterError<T> {}
