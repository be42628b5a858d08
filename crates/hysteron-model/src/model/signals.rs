//! Signals that a model is run on.

use crate::axes::AxesRecord;
use crate::record::{Driven, InputOutput, Signal, TimeBase, Unit};

/// Inputs, and outputs where measured, in the form a model takes.
#[derive(Clone, Debug, PartialEq)]
pub enum Signals {
    /// One input and one output; no samples of the output where it was not measured.
    Single(InputOutput),
    /// Several inputs and outputs; no outputs where they were not measured.
    Several(AxesRecord),
}

impl Signals {
    /// Name of the record.
    pub fn name(&self) -> &str {
        match self {
            Self::Single(record) => &record.name,
            Self::Several(record) => &record.name,
        }
    }

    /// When the samples were taken.
    pub fn time(&self) -> &TimeBase {
        match self {
            Self::Single(record) => &record.time,
            Self::Several(record) => &record.time,
        }
    }
}

impl From<InputOutput> for Signals {
    fn from(record: InputOutput) -> Self {
        Self::Single(record)
    }
}

impl From<AxesRecord> for Signals {
    fn from(record: AxesRecord) -> Self {
        Self::Several(record)
    }
}

impl From<Driven> for Signals {
    /// The drive, with the measured output where there is one.
    fn from(Driven { drive, measured }: Driven) -> Self {
        match measured {
            Some(record) => Self::Single(record),
            None => drive.into(),
        }
    }
}

impl From<Signal> for Signals {
    /// A drive alone.
    fn from(drive: Signal) -> Self {
        Self::Single(InputOutput {
            name: drive.name.clone(),
            time: drive.time,
            u: drive.samples,
            y: Vec::new(),
            rate: None,
            valid: None,
            input: drive.name,
            output: String::new(),
            u_unit: drive.unit,
            y_unit: Unit::new(""),
            source: None,
        })
    }
}
