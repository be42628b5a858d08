//! Promise: what is exported does what the library does, builds without a warning, and takes any number.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test stops at the first surprise"
)]

mod arm;
mod axes;
mod c_agrees;
mod c_builds;
mod closed_loop;
mod fmu;
mod hostile_text;
mod inverse_agrees;
mod loop_starts;
mod matlab;
mod models;
mod platforms;
mod rust_crate;
mod saved;
mod simulink;
mod single_precision;
mod tools;
