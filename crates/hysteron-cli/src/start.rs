//! Flags for the state of the device before a record's first sample.

use std::path::Path;

use clap::Args;
use hysteron_model::record::TimeBase;
use hysteron_model::{Advice, Start};

use crate::failure::Failure;
use crate::numbers::{number, positive};

/// Start of a simulation, where the model file's own assumption does not hold.
#[derive(Args, Clone, Debug)]
pub struct StartFlags {
    /// Voltage at rest before the record [default: as the model file assumes]
    #[arg(
        long, value_name = "VOLTS", value_parser = number, allow_hyphen_values = true,
        conflicts_with = "settled",
    )]
    rest_voltage: Option<f64>,

    /// Period of a record in periodic steady state, in s
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    settled: Option<f64>,
}

impl StartFlags {
    /// True if a flag gives the start.
    pub fn are_given(&self) -> bool {
        self.rest_voltage.is_some() || self.settled.is_some()
    }

    /// The start of the record at `path`: the flags', else as the model was identified.
    ///
    /// # Errors
    /// If a period is given and the record has no sample rate.
    pub fn start(&self, path: &Path, time: &TimeBase) -> Result<Start, Failure> {
        if let Some(period_s) = self.settled {
            let Some(samples) = time.samples_of(period_s) else {
                return Err(Failure::new(format!("cannot start {} settled", path.display()))
                    .because("the record has no times, so its period has no number of samples")
                    .advised(Some(Advice::GiveSampleRate)));
            };
            return Ok(Start::settled(samples));
        }
        Ok(self.rest_voltage.map_or(Start::AsIdentified, |voltage_v| Start::Rest { voltage_v }))
    }
}
