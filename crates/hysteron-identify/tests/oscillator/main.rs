//! Promises about hysteresis in feedback: simulation, derivatives, the public benchmark, identification.
#![allow(clippy::unwrap_used)] // A failure is a failed test.
#![allow(clippy::print_stdout)] // What is skipped is said.

mod benchmark;
mod derivatives;
mod laws;
mod oracles;
mod recovery;
mod simulation;
