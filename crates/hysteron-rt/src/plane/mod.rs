//! Preisach plane of weighted relays: its Everett function and its memory of turning points.

mod everett;
mod memory;

pub use everett::Plane;
pub use memory::{LEAST_TURNS, Turn, Turns, wipe_out};
