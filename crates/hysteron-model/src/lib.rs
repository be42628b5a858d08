//! Models of piezo actuators: structure, simulation, inversion, control.
//!
//! In the order of data flow: [`record`] holds measured channels with units on a time base. A Hammerstein
//! model has two blocks, [`hysteresis`] (article Eq. 1) and [`dynamics`], a transfer function with real
//! orders (Eqs. 2–6) on [`fractional`] calculus; [`hammerstein`] joins them. [`oscillator`] has its
//! hysteresis in feedback, [`force`] is that of a damper against a displacement and its rate, [`axes`]
//! couples several inputs and outputs. [`validate`] scores a simulation, [`misfit`] predicts how far a device
//! is from its model. [`realise`] turns a model into poles
//! that run sample by sample, [`invert`] and [`compensator`] compute the drive that tracks a reference,
//! [`decoupling`] those of several actuators, [`control`] closes the loop. [`model_file`] stores a model as
//! JSON.
//!
//! Units at every interface: V, µm, s, Hz. "Eq. 1" and the like are equations of L. Yang, Z. Zhao, Y. Zhang
//! and D. Li, *Micromachines* 13 (2022) 42, doi:10.3390/mi13010042.

pub mod advice;
pub mod axes;
pub mod compensator;
pub mod control;
pub mod decoupling;
pub mod dynamics;
mod dynamics_error;
mod error;
mod finding;
pub mod force;
pub mod fractional;
pub mod hammerstein;
pub mod hysteresis;
pub mod invert;
pub mod misfit;
pub mod model;
pub mod model_file;
pub mod oscillator;
pub mod realise;
pub mod record;
mod simulation_error;
mod start;
pub mod tracking;
mod unknown_name;
mod unlimited;
pub mod validate;

pub use advice::Advice;
pub use error::Error;
pub use finding::{Finding, FindingKind};
pub use model::Model;
pub use start::{LinearStart, Memory, Start};
pub use unknown_name::UnknownName;
