//! What fractional calculus of samples can refuse.

use super::Scheme;

/// Error of [`crate::fractional`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FractionalError {
    /// The order is not a finite number.
    #[error("the order must be a finite real number (complex orders are not supported), but it is {order}")]
    Order {
        /// The order given.
        order: f64,
    },
    /// The sample rate is not a positive finite number.
    #[error("the sample rate must be a positive finite number of hertz, but it is {sample_rate_hz}")]
    SampleRate {
        /// The sample rate given \[Hz\].
        sample_rate_hz: f64,
    },
    /// The scheme has no power series.
    #[error("the {scheme} scheme has no weights in the time domain; use grunwald-letnikov, bdf2 or tustin")]
    NoWeights {
        /// The scheme given.
        scheme: Scheme,
    },
    /// Tustin was asked for an improper operator: its response at the Nyquist frequency is infinite.
    #[error(
        "tustin needs a proper operator (numerator order ≤ denominator order), but the orders are {numerator} over \
         {denominator} and it would diverge; use grunwald-letnikov or bdf2"
    )]
    Improper {
        /// Highest order of the numerator.
        numerator: f64,
        /// Highest order of the denominator.
        denominator: f64,
    },
    /// A polynomial has no terms, or no term that is not zero.
    #[error("the {part} has no non-zero term")]
    NoTerms {
        /// `numerator` or `denominator`.
        part: &'static str,
    },
    /// The result left the range of floating-point numbers.
    #[error(
        "sample {index} of the result is not finite: the system grows without bound or the input is not finite"
    )]
    NotFinite {
        /// First such sample.
        index: usize,
    },
}

pub(super) fn check_sample_rate(sample_rate_hz: f64) -> Result<(), FractionalError> {
    if sample_rate_hz.is_finite() && sample_rate_hz > 0.0 {
        Ok(())
    } else {
        Err(FractionalError::SampleRate { sample_rate_hz })
    }
}

pub(super) fn check_finite(samples: Vec<f64>) -> Result<Vec<f64>, FractionalError> {
    match samples.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(FractionalError::NotFinite { index }),
        None => Ok(samples),
    }
}
