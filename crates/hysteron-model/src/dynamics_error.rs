//! Errors of sampled fractional calculus and of the dynamic block.

use crate::fractional::Scheme;
use hysteron_numeric::display::{exact, short};

/// Error of [`crate::fractional`] and [`crate::dynamics`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DynamicsError {
    /// A polynomial has no non-zero term.
    #[error("the {part} of the transfer function has no non-zero term")]
    NoTerms {
        /// `numerator` or `denominator`.
        part: &'static str,
    },
    /// A coefficient is not finite.
    #[error("coefficient {index} of the {part} must be finite, but it is {value}", value = exact(*.value))]
    Coefficient {
        /// `numerator` or `denominator`.
        part: &'static str,
        /// Position of the term, from 0.
        index: usize,
        /// The coefficient given.
        value: f64,
    },
    /// An order is not finite or negative.
    #[error(
        "order {index} of the {part} must be a real number ≥ 0 (complex orders are not supported), but it is \
         {order}",
        order = exact(*.order)
    )]
    Order {
        /// `numerator` or `denominator`.
        part: &'static str,
        /// Position of the term, from 0.
        index: usize,
        /// The order given.
        order: f64,
    },
    /// The terms are not in strictly ascending order.
    #[error(
        "the terms of the {part} must be in ascending order without repeats, but order {order} (term \
         {index}) follows {before}",
        order = exact(*.order),
        before = exact(*.before)
    )]
    NotAscending {
        /// `numerator` or `denominator`.
        part: &'static str,
        /// Position of the term, from 0.
        index: usize,
        /// Its order.
        order: f64,
        /// The order of the term before it.
        before: f64,
    },
    /// A parameter is outside its range.
    #[error("{name} must be {allowed}, but it is {value}", value = exact(*.value))]
    Parameter {
        /// Name of the parameter, with its unit where it has one.
        name: &'static str,
        /// The value given.
        value: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    /// The bandwidth of an inverse is out of range.
    #[error(
        "the bandwidth of the inverse is {bandwidth_hz} Hz: it must be above 0 and below {highest_hz} Hz, \
         half the sample rate, and the plant must pass something there",
        bandwidth_hz = exact(*.bandwidth_hz),
        highest_hz = exact(*.highest_hz)
    )]
    Bandwidth {
        /// The bandwidth given \[Hz\].
        bandwidth_hz: f64,
        /// Half the sample rate \[Hz\].
        highest_hz: f64,
    },
    /// The number of values differs from the number of parameters.
    #[error("the form of the dynamics has {expected} parameters, but {found} values are given")]
    ParameterCount {
        /// Parameters of the form.
        expected: usize,
        /// Values given.
        found: usize,
    },
    /// The response was allocated for another number of derivatives.
    #[error(
        "the response has room for {found} derivatives, but the form has {expected} with that of the delay: \
         make it with `empty_response` for as many parameters"
    )]
    Tangents {
        /// Parameters of the form, and the delay.
        expected: usize,
        /// Number of derivatives that the response has room for.
        found: usize,
    },
    /// The requested derivative was not computed.
    #[error(
        "derivative {which} of the response is not there; it has {found} (none unless last computed with \
         tangents)"
    )]
    NoTangent {
        /// The derivative requested, from 0.
        which: usize,
        /// Number of derivatives computed.
        found: usize,
    },
    /// The sample rate is not a positive finite number.
    #[error(
        "the sample rate must be a positive finite number of hertz, but it is {sample_rate_hz}",
        sample_rate_hz = exact(*.sample_rate_hz)
    )]
    SampleRate {
        /// The sample rate given \[Hz\].
        sample_rate_hz: f64,
    },
    /// Too few samples.
    #[error("need at least {need} samples but found {found}")]
    TooFewSamples {
        /// Smallest number of samples.
        need: usize,
        /// Samples given.
        found: usize,
    },
    /// A signal or buffer does not have the length it must have.
    #[error("the {what} must have {expected} samples, but it has {found}")]
    Length {
        /// Which signal or buffer.
        what: &'static str,
        /// Length it must have.
        expected: usize,
        /// Length it has.
        found: usize,
    },
    /// An input sample is not finite.
    #[error("sample {index} of the {what} is {value}; every sample must be finite", value = exact(*.value))]
    InputNotFinite {
        /// Which signal.
        what: &'static str,
        /// First such sample.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The simulated output left the range of floating-point numbers.
    #[error(
        "the simulated output is not finite: the coefficients are too large or too small for the sample rate"
    )]
    OutputNotFinite,
    /// The transfer function is improper under `Tustin`.
    #[error(
        "the tustin scheme needs a proper transfer function, but the highest orders are {numerator} over \
         {denominator}; use grunwald-letnikov or bdf2",
        numerator = exact(*.numerator),
        denominator = exact(*.denominator)
    )]
    Improper {
        /// Highest order of the numerator.
        numerator: f64,
        /// Highest order of the denominator.
        denominator: f64,
    },
    /// G(0) is infinite under an initial condition that needs it finite.
    #[error(
        "the gain at zero frequency is infinite (lowest orders {numerator} over {denominator}), so a state \
         of rest or a steady state does not exist; give the model a low-frequency corner, or start from zero",
        numerator = exact(*.numerator),
        denominator = exact(*.denominator)
    )]
    InfiniteDcGain {
        /// Lowest order of the numerator.
        numerator: f64,
        /// Lowest order of the denominator.
        denominator: f64,
    },
    /// The transfer function is unstable.
    #[error(
        "the transfer function is unstable: {poles} pole(s) in the right half-plane; its response grows \
         without bound"
    )]
    Unstable {
        /// Poles in the right half-plane, both of a pair counted; under a scheme, those of the sampled
        /// system.
        poles: usize,
    },
    /// A pole sits on the imaginary axis and the steady state does not exist.
    #[error(
        "the transfer function has an undamped pole at {} Hz, so a steady state does not exist",
        short(*.frequency_hz)
    )]
    Undamped {
        /// Frequency of the pole \[Hz\].
        frequency_hz: f64,
    },
    /// A periodic steady state was requested of the causal recursion.
    #[error("the causal recursion starts from rest or from zero; it has no periodic steady state")]
    PeriodicRecursion,
    /// An ARX model has a pole on or outside the unit circle where a steady state is needed.
    #[error("the ARX model has a pole on or outside the unit circle, so a steady state does not exist")]
    UnstableArx,
    /// The ARX model has no input coefficients.
    #[error("an ARX model needs at least one input coefficient (nb ≥ 1)")]
    NoInputCoefficients,
    /// The data do not determine a coefficient of a linear fit.
    #[error(
        "the data do not determine unknown {column} of {columns} (outputs first, then inputs, then offsets): \
         lower the orders, or use a record with more excitation"
    )]
    Dependent {
        /// Position of the unknown, from 0.
        column: usize,
        /// Number of unknowns.
        columns: usize,
    },
    /// The transfer function is not of the form of article Eq. 13.
    #[error(
        "gain, natural frequency and damping need the form b / (s^α₂ + c₁ s^α₁ + c₀ s^α₀) with b, c₀ > 0, \
         but this is {form}"
    )]
    NotSecondOrder {
        /// The transfer function, printed.
        form: String,
    },
    /// The order of an operator is not a finite number.
    #[error(
        "the order must be a finite real number (complex orders are not supported), but it is {order}",
        order = exact(*.order)
    )]
    OperatorOrder {
        /// The order given.
        order: f64,
    },
    /// The scheme has no power series.
    #[error("the {scheme} scheme has no weights in the time domain; use grunwald-letnikov, bdf2 or tustin")]
    NoWeights {
        /// The scheme given.
        scheme: Scheme,
    },
    /// The operator is improper under `Tustin`: its response at the Nyquist frequency is infinite.
    #[error(
        "tustin needs a proper operator (numerator order ≤ denominator order), but the orders are \
         {numerator} over {denominator} and it would diverge; use grunwald-letnikov or bdf2",
        numerator = exact(*.numerator),
        denominator = exact(*.denominator)
    )]
    ImproperOperator {
        /// Highest order of the numerator.
        numerator: f64,
        /// Highest order of the denominator.
        denominator: f64,
    },
    /// A polynomial of an operator has no terms, or no term that is not zero.
    #[error("the {part} has no non-zero term")]
    NoOperatorTerms {
        /// `numerator` or `denominator`.
        part: &'static str,
    },
    /// The result of an operator left the range of floating-point numbers.
    #[error(
        "sample {index} of the result is not finite: the system grows without bound or the input is not \
         finite"
    )]
    ResultNotFinite {
        /// First such sample.
        index: usize,
    },
}

pub(crate) fn check_sample_rate(sample_rate_hz: f64) -> Result<(), DynamicsError> {
    if sample_rate_hz.is_finite() && sample_rate_hz > 0.0 {
        Ok(())
    } else {
        Err(DynamicsError::SampleRate { sample_rate_hz })
    }
}

pub(crate) fn check_length(what: &'static str, found: usize, expected: usize) -> Result<(), DynamicsError> {
    if found == expected { Ok(()) } else { Err(DynamicsError::Length { what, expected, found }) }
}

pub(crate) fn check_finite(what: &'static str, samples: &[f64]) -> Result<(), DynamicsError> {
    match samples.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(DynamicsError::InputNotFinite { what, index, value: samples[index] }),
        None => Ok(()),
    }
}

pub(crate) fn check_result(samples: Vec<f64>) -> Result<Vec<f64>, DynamicsError> {
    match samples.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(DynamicsError::ResultNotFinite { index }),
        None => Ok(samples),
    }
}
