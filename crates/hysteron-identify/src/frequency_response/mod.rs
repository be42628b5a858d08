//! Identification from a measured frequency response.
//!
//! 1. [`FrequencyResponse`]: measured complex values at frequencies, with or without uncertainty.
//!    [`empirical`] estimates one, with its noise and distortion, from records of periodic multisines.
//! 2. [`Structure`]: a power law, a fractional lag or oscillator, poles and zeros, with delay, with a
//!    hysteresis loss angle.
//! 3. [`fit_structure`] fits one: linear starts ([`levy`], relocation of poles), then bounded least squares
//!    with the linear coefficients projected out and an analytic Jacobian, with standard errors. [`compare`]
//!    fits the structures usual for this kind of response and explains each.
//!
//! ```
//! use hysteron_model::dynamics::TransferFunction;
//! use hysteron_identify::frequency_response::{Core, FrequencyResponse, Structure, Weighting, fit_structure};
//!
//! let frequency_hz: Vec<f64> = (1..200).map(|k| 5.0 * f64::from(k)).collect();
//! let values = TransferFunction::article_eq13().frequency_response(&frequency_hz, 0.0);
//! let response = FrequencyResponse::new("Eq. 13", frequency_hz, values)?;
//! let fit = fit_structure(&response, &Structure::of(Core::FractionalOscillator), Weighting::Relative)?;
//! assert!((fit.value("order2") - 2.0384).abs() < 1e-6 && (fit.value("order1") - 1.0523).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod compare;
pub mod empirical;
mod explain;
mod explained;
mod fit;
mod levy;
mod problem;
mod relocation;
mod start;
mod structure;
mod transfer;

pub use compare::{Candidate, Family, compare, has_dynamics, has_resonance};
pub use explained::{
    DetectionSummary, EmpiricalSummary, Explained, ExplainedSummary, POOR, ResponseParameter,
    StructureSummary, WrittenStructure,
};
pub use fit::{FittedParameter, ResponseFit, Weighting, fit_structure};
pub use hysteron_model::record::{FrequencyResponse, unwrapped_phase_deg};
pub use levy::levy;
pub use structure::{Core, MOST_POLES, Structure};
