//! The arithmetic of one sample: `no_std`, no allocation, cannot panic.
#![no_std]
#![forbid(unsafe_code)]
