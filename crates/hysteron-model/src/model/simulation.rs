//! Result of a simulation.

use super::{Remark, RunError, Signals};
use crate::axes::SteadyPeriod;
use crate::record::{Channel, Record, RecordError, Unit};
use crate::start::Start;

/// Output of a model for a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    /// One list per output, in the model's output unit.
    pub outputs: Vec<Vec<f64>>,
    /// Start of the simulation.
    pub start: Start,
    /// Unit of the input, the record's or, where it has none, the model's.
    pub input_unit: Unit,
    /// Mean period of a record of several axes that repeats.
    pub period: Option<SteadyPeriod>,
    /// Remarks for the user.
    pub remarks: Vec<Remark>,
}

impl Simulation {
    /// This one, or an error where an output is not finite.
    pub(super) fn finite(self) -> Result<Self, RunError> {
        let mut beyond = self.outputs.iter().filter_map(|y| y.iter().position(|y| !y.is_finite()));
        match beyond.next() {
            Some(index) => Err(RunError::NotFinite { index }),
            None => Ok(self),
        }
    }

    /// Of one output, without remarks.
    pub fn of_single(y: Vec<f64>, start: Start, input_unit: Unit) -> Self {
        Self { outputs: vec![y], start, input_unit, period: None, remarks: Vec::new() }
    }

    /// The inputs, the model's `outputs` in `unit` under these names, the ends of a `band` around one output
    /// (`y_low`, `y_high`), and what was measured beside them (`y_measured`), with its mask.
    ///
    /// # Errors
    /// [`RecordError`] where the signals are not those of the simulation.
    pub fn to_record(
        &self,
        name: &str,
        signals: &Signals,
        outputs: &[String],
        unit: &str,
        band: Option<[Vec<f64>; 2]>,
    ) -> Result<Record, RecordError> {
        let input_unit = self.input_unit.symbol();
        let mut channels = match signals {
            Signals::Single(drive) => vec![Channel::new("u", input_unit, drive.u.clone())],
            Signals::Several(record) => {
                let inputs = record.inputs.iter().zip(&record.u);
                inputs.map(|(name, u)| Channel::new(name, input_unit, u.clone())).collect()
            }
        };
        channels
            .extend(outputs.iter().zip(&self.outputs).map(|(name, y)| Channel::new(name, unit, y.clone())));
        for (name, end) in ["y_low", "y_high"].into_iter().zip(band.into_iter().flatten()) {
            channels.push(Channel::new(name, unit, end));
        }
        let mut valid = None;
        if let Signals::Single(record) = signals
            && !record.y.is_empty()
        {
            channels.push(Channel::new("y_measured", unit, record.y.clone()));
            valid.clone_from(&record.valid);
        }
        Ok(Record { valid, ..Record::new(name, signals.time().clone(), channels)? })
    }
}
