//! The registry of a fleet, read: which devices were calibrated, when, with which result.
//!
//! The Python package (`hysteron_models.fleet`) writes it; here a SQLite file of it is opened read-only, so that
//! a night that still runs is not disturbed. Tables: `python/hysteron_models/fleet/schema.py`.
//!
//! ```no_run
//! let registry = hysteron_registry::Registry::open("fleet.sqlite".as_ref())?;
//! for device in registry.devices()? {
//!     println!("{}: {} of {}", device.device, device.latest.status, device.latest.date);
//! }
//! # Ok::<(), hysteron_registry::RegistryError>(())
//! ```
#![forbid(unsafe_code)]

mod error;
mod open;
mod read;

pub use error::RegistryError;
pub use open::Registry;
pub use read::{Calibration, DeviceEntry, Parameter};
