//! `hysteron simulate`: a model's output for a drive.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use hysteron_identify::IdentifyError;
use hysteron_io::write_csv;
use hysteron_model::model::{Capability, Signals};
use hysteron_model::record::{Channel, Record};

use crate::axes::AxesFlags;
use crate::columns::InputFlags;
use crate::console;
use crate::failure::Failure;
use crate::model::Loaded;
use crate::output::{self, OutFile};
use crate::start::StartFlags;

/// Simulate a model's output for the drive in a file.
#[derive(Args)]
#[command(
    after_help = "The file written holds the time (where the input has one), the drive and the model's output, \
    in the model's units, e.g. t_s,u_V,y_um: a record that every other command reads.\n\n\
    --band adds the ends of a 95 % band, e.g. y_low_um,y_high_um, from the errors in the model file: of the model's output about \
    its mean (a sensor has its own zero), or of a new measurement, which scatters about it as the records identified from did. \
    Both take the model class for true.\n\n\
    Example: hysteron simulate model.json drive.csv -o simulated.csv --band measurement"
)]
pub struct Simulate {
    /// The model file
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,

    /// File with the drive; other columns are not used
    #[arg(value_name = "INPUT.csv")]
    input_file: PathBuf,

    /// File to write
    #[arg(short, long = "out", value_name = "OUT.csv")]
    out: OutFile,

    /// Add the ends of a 95 % band around the output
    #[arg(long, value_enum)]
    band: Option<BandArg>,

    #[command(flatten)]
    start: StartFlags,

    #[command(flatten)]
    columns: InputFlags,

    #[command(flatten)]
    axes: AxesFlags,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum BandArg {
    /// Of the output of the model with the true parameters
    Model,
    /// Of a new measurement
    Measurement,
}

impl Simulate {
    pub fn run(&self) -> Result<(), Failure> {
        output::check_file("the simulation", &self.out)?;
        let loaded = Loaded::read(&self.model)?;
        if self.band.is_some() {
            loaded.hammerstein(Capability::Bands)?;
        }
        let names = loaded.output_names(&self.axes)?;
        let signals = loaded.read_drive(&self.input_file, &self.columns, &self.axes)?;
        let found = loaded.simulate(&self.input_file, &signals, &self.start)?;
        let unit = &loaded.model().units().output;
        let mut channels = inputs(&signals, found.input_unit.symbol());
        let outputs = names.iter().zip(&found.outputs);
        channels.extend(outputs.map(|(name, y)| Channel::new(name, unit, y.clone())));
        if let (Some(of), Signals::Single(drive), Some(y)) = (self.band, &signals, found.outputs.first()) {
            let band = loaded.band(&self.input_file, &drive.u, &drive.time, &found.start)?;
            let half = match of {
                BandArg::Model => band.of_output(),
                BandArg::Measurement if band.noise > 0.0 => band.of_measurement(),
                BandArg::Measurement => return Err(loaded.no_band(&IdentifyError::NoScores)),
            };
            for (name, sign) in [("y_low", -1.0), ("y_high", 1.0)] {
                let end = y.iter().zip(&half).map(|(y, h)| y + sign * h).collect();
                channels.push(Channel::new(name, unit, end));
            }
        }
        let failure = || Failure::new(format!("cannot write the simulation to {}", self.out.display()));
        let record = Record::new(&self.out.display().to_string(), signals.time().clone(), channels)
            .map_err(|e| failure().because(e))?;
        write_csv(&self.out, &record).map_err(|e| failure().because(e))?;
        console::message(&format!("wrote {} samples to {}", record.len(), self.out.display()));
        Ok(())
    }
}

/// The drive as it is written beside the outputs.
fn inputs(signals: &Signals, unit: &str) -> Vec<Channel> {
    match signals {
        Signals::Single(drive) => vec![Channel::new("u", unit, drive.u.clone())],
        Signals::Several(record) => {
            record.inputs.iter().zip(&record.u).map(|(name, u)| Channel::new(name, unit, u.clone())).collect()
        }
    }
}
