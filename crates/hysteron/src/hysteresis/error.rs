//! What can be wrong with a hysteresis block or its simulation.

use hysteron_rt::{ParameterError, SimulateError, StepError};
use thiserror::Error;

/// A hysteresis block that cannot be built or simulated.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum HysteresisError {
    /// No polynomial coefficient.
    #[error("the polynomial of the hysteresis block is empty: give at least the linear coefficient")]
    EmptyPolynomial,
    /// A polynomial coefficient is infinite or not a number.
    #[error("the coefficient of u^{power} is {value}: polynomial coefficients must be finite")]
    Coefficient {
        /// Power of u it belongs to.
        power: usize,
        /// Its value.
        value: f64,
    },
    /// A shape parameter is infinite or not a number.
    #[error("Bouc–Wen parameter {name} is {value}: it must be finite")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// n < 1.
    #[error("Bouc–Wen exponent n is {n}: it must be at least 1")]
    Exponent {
        /// The exponent given.
        n: f64,
    },
    /// The output does not have the length the input asks for.
    #[error("the output has {found} samples but {expected} are needed for this input")]
    Lengths {
        /// Samples the output must have.
        expected: usize,
        /// Samples it has.
        found: usize,
    },
    /// A voltage, or the state before the first sample, is infinite or not a number.
    #[error("drive sample {index} (or the state before it) is not finite: remove or mask such samples first")]
    Drive {
        /// Number of the sample, from 0.
        index: usize,
    },
    /// The hysteresis state runs away: parameters outside the bounded class.
    #[error(
        "the hysteresis state runs away at drive sample {index} ({cause}); keep β + γ > 0 and β − γ ≥ 0 for α > 0, \
         β − γ > 0 and β + γ ≥ 0 for α < 0"
    )]
    RunsAway {
        /// Number of the sample, from 0.
        index: usize,
        /// What the step said.
        cause: StepError<f64>,
    },
    /// No periodic steady state was found.
    #[error(
        "no steady state after {periods} periods: z still changes by {change:e} a period; the record must be a whole \
         number of periods and the parameters in the bounded class"
    )]
    NotSettled {
        /// Periods simulated.
        periods: usize,
        /// Change of z over the last one \[µm\].
        change: f64,
    },
    /// The steady state of a period does not determine its own derivatives.
    #[error(
        "the steady state has no derivatives: what is left of a difference of states after a period is {slope} of it \
         and must be less than 1; give the loop a shape with β' > |γ'|, or another start than the periodic one"
    )]
    NotContracting {
        /// ∂ζ(end of the period)/∂ζ(its start).
        slope: f64,
    },
    /// Up-sampling by 0.
    #[error("the up-sampling factor is 0: it must be at least 1")]
    Factor,
    /// The Fourier transform of the drive failed.
    #[error("band-limited interpolation of {samples} samples failed: {message}")]
    Fourier {
        /// Length of the transform.
        samples: usize,
        /// What the transform said.
        message: String,
    },
}

impl From<ParameterError<f64>> for HysteresisError {
    fn from(error: ParameterError<f64>) -> Self {
        match error {
            ParameterError::Exponent { n } => Self::Exponent { n },
            ParameterError::NotFinite { name, value } => Self::Parameter { name, value },
            _ => Self::Parameter { name: "n", value: f64::NAN },
        }
    }
}

impl From<SimulateError<f64>> for HysteresisError {
    fn from(error: SimulateError<f64>) -> Self {
        match error {
            SimulateError::Lengths { expected, found } => Self::Lengths { expected, found },
            SimulateError::Step { index, cause: StepError::NotFinite } => Self::Drive { index },
            SimulateError::Step { index, cause } => Self::RunsAway { index, cause },
            _ => Self::Drive { index: 0 },
        }
    }
}
