//! The arithmetic of one sample: `no_std`, no allocation, cannot panic; `f32` or `f64`.
//!
//! * [`BoucWen`]: parameters of the Bouc–Wen operator; [`BoucWen::step`] moves a [`BoucWenState`] to the next
//!   voltage exactly, whatever the distance, because the operator is rate independent.
//! * [`PlayBank`]: a weighted sum of play operators, its step and the exact inverse of
//!   the step.
//! * [`SidedPlays`]: plays between other sides ([`Sides`]), with a [`BrokenLine`] behind them; [`Plane`]: a
//!   plane of relays by its Everett function and its turning points ([`Turns`]).
//! * [`Branch`]: states that follow a differential equation along each branch, updated by increments, one
//!   file of [`branch`] a law; [`c_source`]: the operators in C99; [`rust_source`]: these files.
//! * [`Model`]: hysteresis ([`Operator`]) followed by linear dynamics ([`Sections`]: real poles, pole pairs,
//!   taps, delay), voltage in, displacement out, in a bounded number of operations a sample.
//! * [`Compensator`]: the inverse, reference in, voltage out, within the amplifier's range and slew ([`Law`],
//!   [`Hysteresis::reach`]); [`Observer`]: the disturbance between model and stage; [`Feedback`]: PI, PI^λ
//!   and integral with notch; [`Controller`]: all three together; [`FilteredLms`]: adaptive feedforward.
//! * [`Rls`], [`Nlms`]: recursive least squares with forgetting and normalised LMS, sample by sample;
//!   [`FitMonitor`] detects misfit.
//! * [`Dual`]: a number with its derivatives. Where a step is fed duals it returns the exact derivatives of
//!   its own result with respect to β, γ and n ([`BoucWen::advance_with_sensitivities`]).
//! * [`SavedError`]: states saved as bytes and restored after a reset ([`Model::save`]).
//! * [`Real`], [`Scalar`]: the two sealed traits of the number types.
//!
//! ```
//! use hysteron_rt::{BoucWen, BoucWenState};
//!
//! let operator = BoucWen::new(0.5_f64, 0.11, 0.02, 1.0)?;
//! let mut state = BoucWenState { u: 0.0, z: 0.0 };
//! for u in [2.0, 10.0, 4.0] {
//!     operator.step(&mut state, u)?;
//! }
//! // Rate independence: the samples in between change nothing.
//! let mut coarse = BoucWenState { u: 0.0, z: 0.0 };
//! operator.step(&mut coarse, 10.0)?;
//! operator.step(&mut coarse, 4.0)?;
//! assert!((state.z - coarse.z).abs() < 1e-14);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! `proof/run.sh` proves at link time that it neither needs `std` nor can panic.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]

mod bouc_wen;
use bouc_wen as state_law;
pub mod branch;
pub mod c_source;
mod dual;
mod increment;
mod model;
mod online;
mod parameter_error;
mod plane;
mod play;
mod real;
pub mod rust_source;
mod saved;
mod series;

/// dz/du = α − β s z|z|ⁿ⁻¹ − γ |z|ⁿ as the law of one state; several may act in parallel
/// ([`Operator::States`]).
pub use bouc_wen::BoucWen as StateLaw;
pub use bouc_wen::{BoucWen, BoucWenState, SimulateError, StepError};
pub use branch::Branch;
pub use dual::Dual;
pub use model::{
    Compensated, Compensator, Controller, Drive, Feedback, FilteredLms, HeldBack, Hysteresis,
    IncrementMemory, LANES, Law, Limited, Limits, Line, Linear, LmsFilter, LmsMemory, LmsSettings,
    MOST_LOOKS, MOST_TAPS, Means, Model, ModelError, Observed, Observer, Operator, PolePair, Reached,
    RealPoles, Sections, SectionsMemory,
};
pub use online::{
    FitMonitor, Misfit, MonitorSettings, Nlms, NlmsSettings, Residual, Rls, RlsSettings, SampleError,
    Unexcited,
};
pub use parameter_error::ParameterError;
pub use plane::{LEAST_TURNS, Plane, Turn, Turns, wipe_out};
pub use play::{
    BrokenLine, LinearPiece, PlayBank, PlayError, RelaxingMove, RelaxingPlays, SLOPES, SidedPlays, Sides,
    bernstein_integrals, between, between_ramps, each_band, play, ramp,
};
pub use real::{Real, Scalar};
pub use saved::SavedError;
