//! A weighted plane of relays: its Everett function, and the turning points it remembers.

mod everett;
mod memory;

pub use everett::Plane;
pub use memory::{LEAST_TURNS, Turn, Turns, wipe_out};
