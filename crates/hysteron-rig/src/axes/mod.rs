//! A simulated bench of several axes, of a class that the library does not identify.
//!
//! ```text
//! command u_i ─► DAC ─► amplifier i (lag) ─► hysteresis i (asymmetric plays, a bend) ─► stroke v_i
//! q_k'' + 2 ζ_k ω_k q_k' + ω_k² q_k = ω_k² Σ_i drive_ki v_i          modes k, driven by all actuators
//! y_m = Σ_k motion_km q_k ─► sensor m (noise, ADC)
//! ```
//!
//! Each actuator has plays and a bend of its own, in front of the modes; the model that is identified has
//! symmetric plays, shared by the actuators, in feedback with them. No code is shared with its simulation:
//! plays are exact on a grid of at least 20 steps a sample, amplifiers and modes exact for an input linear
//! over a step. No creep, no delay.

mod campaign;
mod run;
mod truth;

pub use campaign::{AxesPlan, AxesRole, AxesRun, run_axes_campaign};
pub use run::{AxesRig, AxesRigStage, measure_axes};
pub use truth::{AxesTruth, CoupledMode, HystereticActuator};
