//! Hysteron: measured records of a piezo actuator go in, a checked model comes out.
//!
//! The modules in data-flow order: [`record`] and [`excitation`], the two blocks [`hysteresis`] and
//! [`dynamics`] (on [`fractional`] calculus and [`numeric`] kernels) joined by [`hammerstein`], then
//! [`optimize`], [`identify`], [`validate`], [`model_file`]; [`bench_rig`] is a simulated test bench.

pub mod atomic_file;
pub mod bench_rig;
pub mod dynamics;
pub mod excitation;
pub mod fractional;
pub mod hammerstein;
pub mod hysteresis;
pub mod identify;
pub mod model_file;
pub mod numeric;
pub mod optimize;
pub mod record;
pub mod validate;
