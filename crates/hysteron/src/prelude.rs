//! What most programs need.

pub use std::ops::ControlFlow;

pub use crate::{
    Channel, Controller, Creep, Cut, DynamicsChoice, Error, Event, Export, Finding, Fit, HysteresisForm,
    Identify, InterSample, Kind, Limits, Model, Precision, Prepare, ReadOptions, Record, Report, Score,
    Scoring, Signal, Start, Stop, Target, TimeBase, Unit, Unsupported,
};
