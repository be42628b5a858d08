//! Promise: the drive of an inverse makes a plant in continuous time follow, of a class that the model shares
//! and by code that it does not.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // A failure is a failed test; figures are printed.

mod plant;
mod sample_by_sample;
mod whole_reference;
