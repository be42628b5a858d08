//! Several inputs and outputs: simulation, recovery of what is known, the public steering mirror.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test stops at the first surprise, and says when it is skipped"
)]

mod comparison;
mod coupled;
mod device;
mod recovery;
mod simulation;
mod steering_mirror;
