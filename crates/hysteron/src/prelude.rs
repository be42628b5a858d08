//! What most programs need.

pub use std::ops::ControlFlow;

pub use crate::{
    Channel, Controller, Creep, DynamicsChoice, Error, Event, Export, Finding, Fit, HysteresisForm, Identify,
    InterSample, Kind, Limits, Model, Precision, Record, Report, Score, Scoring, Signal, Start, Stop, Target,
    TimeBase, Unit, Unsupported,
};
