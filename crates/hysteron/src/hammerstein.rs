//! The Hammerstein model: hysteresis block followed by the dynamic block.

use crate::dynamics::{Dynamics, Scheme};
use crate::hysteresis::Hysteresis;

/// y(t) = offset + (G ∗ v)(t − delay), v = hysteresis\[u\] (SPEC §4).
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Static block.
    pub hysteresis: Hysteresis,
    /// Dynamic block.
    pub dynamics: Dynamics,
    /// Output offset \[µm\].
    pub offset: f64,
    /// Pure delay \[s\].
    pub delay_s: f64,
    /// Simulation scheme the dynamic block was identified with.
    pub scheme: Scheme,
    /// Sample rate the model was identified at \[Hz\]; `None` for a static model of a record without one.
    pub sample_rate_hz: Option<f64>,
}
