//! Promises of what runs online: least squares are least squares, nothing winds up, gradients converge,
//! alarms are as rare as said.

// Helpers outside the test functions; a failure is a failed test.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod gradient;
mod least_squares;
mod monitor;
mod noise;
