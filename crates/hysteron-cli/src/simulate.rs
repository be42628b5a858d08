//! `hysteron simulate`: a model's output for a drive.

use std::path::PathBuf;

use clap::Args;
use hysteron::record::{Channel, Record};
use hysteron_io::write_csv;

use crate::columns::InputFlags;
use crate::console;
use crate::failure::Failure;
use crate::model::{LoadedModel, Signal};
use crate::output;
use crate::start::{Drive, StartFlags};

/// Simulate a model's output for the drive in a file.
#[derive(Args)]
#[command(
    after_help = "The file written holds the time (where the input has one), the drive and the model's output, \
    in the model's units, e.g. t_s,u_V,y_um: a record that every other command reads.\n\n\
    Example: hysteron simulate model.json drive.csv -o simulated.csv"
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
    out: PathBuf,

    #[command(flatten)]
    start: StartFlags,

    #[command(flatten)]
    columns: InputFlags,
}

impl Simulate {
    pub fn run(&self) -> Result<(), Failure> {
        output::check_file("the simulation", &self.out)?;
        let model = LoadedModel::read(&self.model)?;
        let drive = self.columns.read_drive(&self.input_file)?;
        let u_unit = model.agreed_unit(&self.input_file, Signal::Input, &drive.unit)?;
        let timed = Drive { u: &drive.u, time: &drive.time };
        let y = model.simulate(&self.input_file, &timed, &self.start)?;
        let failure = || Failure::new(format!("cannot write the simulation to {}", self.out.display()));
        let channels =
            vec![Channel::new("u", u_unit.symbol(), drive.u), Channel::new("y", &model.file.units.output, y)];
        let record = Record::new(&self.out.display().to_string(), drive.time, channels)
            .map_err(|e| failure().because(e))?;
        write_csv(&self.out, &record).map_err(|e| failure().because(e))?;
        console::message(&format!("wrote {} samples to {}", record.len(), self.out.display()));
        Ok(())
    }
}
