//! The page of Hysteron, served from the person's own machine.
#![forbid(unsafe_code)]

pub mod api;
