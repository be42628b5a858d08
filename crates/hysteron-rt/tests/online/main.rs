//! Promises of what runs online: least squares are least squares, nothing winds up, gradients converge,
//! alarms are as rare as said.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // Helpers outside the test functions; a failure is a failed test.

mod gradient;
mod least_squares;
mod monitor;
mod noise;
