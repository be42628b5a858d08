//! Dynamic block: linear time-invariant dynamics behind the hysteresis block.
//!
//! A [`TransferFunction`] with real orders (article Eqs. 2–6; whole orders make it the integer one) is
//! simulated over a record through a [`SimulationPlan`], made once per record: a candidate then costs one
//! complex exponential per term and frequency and one inverse FFT, and allocates nothing. A [`DynamicForm`]
//! gives transfer functions by physical parameters, with exact derivatives, and a [`Response`] applies them
//! to any number of inputs. [`stability`] is exact; [`delay`] shifts signals by fractions of a sample;
//! [`Arx`] is the sampled-data alternative.
//!
//! ```
//! use hysteron_model::Start;
//! use hysteron_model::dynamics::{Scheme, SimulationPlan, TransferFunction};
//!
//! let stage = TransferFunction::article_eq13();
//! assert_eq!(stage.to_string(), "5.2589e6 / (s^2.0384 + 3081 s^1.0523 + 5.4955e6)");
//! let drive: Vec<f64> = (0..1000).map(|k| (k as f64 * 0.01).sin()).collect();
//! let plan = SimulationPlan::new(drive.len(), 10_000.0, Scheme::Tustin, Start::AsIdentified)?;
//! let mut workspace = plan.workspace();
//! let mut displacement = vec![0.0; drive.len()];
//! plan.simulate(&stage, &drive, &mut workspace, &mut displacement)?;
//! # Ok::<(), hysteron_model::dynamics::DynamicsError>(())
//! ```

pub mod arx;
mod blocks;
mod causal;
mod creep;
pub mod delay;
mod form;
mod form_parameter;
mod frequencies;
mod images;
mod inverse;
mod inverse_matrix;
mod linearised;
mod mode_order;
mod plan;
mod poles;
mod record_plan;
mod response;
mod second_order;
mod shift;
mod stability;
mod stamped;
mod sums;
mod tangent;
mod transfer_function;
mod transient;

pub use crate::dynamics_error::DynamicsError;
pub use crate::fractional::{Scheme, Term};
pub use crate::record::InterSample;
pub use arx::Arx;
pub use creep::{Creep, MOST_CREEP_ELEMENTS};
pub use form::{DynamicForm, MOST_INTEGER_POLES, MOST_RESONANCES, Modes};
pub use form_parameter::{FormParameter, ParameterKind};
pub use inverse::{Inverse, InverseAim};
pub use inverse_matrix::{MatrixInverse, ResponseMatrix};
pub use linearised::{Linearised, TermTangent};
pub use plan::{InputSpectrum, SimulationPlan, Workspace};
pub use record_plan::{PlanInput, PlanResponse, PlanWorkspace, RecordPlan};
pub use response::{Response, Sampling};
pub use second_order::SecondOrder;
pub use stability::{Stability, stability};
pub use stamped::{KnotTimes, Knots, Readings, StampedPlan, StampedResponse, StampedWorkspace};
pub use transfer_function::TransferFunction;

/// The dynamic block of a Hammerstein model. The pure delay is not here: it belongs to the model.
#[derive(Clone, Debug, PartialEq)]
pub enum Dynamics {
    /// Static model: output = hysteresis output.
    None,
    /// Integer-order transfer function (every order a whole number), in s.
    Integer(TransferFunction),
    /// Linear autoregressive model with exogenous input, in z at the model's sample rate.
    Arx(Arx),
    /// Fractional-order transfer function (article Eq. 6), in s.
    Fractional(TransferFunction),
}
