//! `hysteron simulate`: a model's output for a drive.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use hysteron_identify::PredictionError;
use hysteron_io::write_csv;
use hysteron_model::record::{Channel, Record, TimeBase};

use crate::axes::{AxesFlags, LoadedAxes};
use crate::columns::InputFlags;
use crate::console;
use crate::failure::Failure;
use crate::model::{LoadedModel, Signal};
use crate::oscillator::LoadedOscillator;
use crate::output::{self, OutFile};
use crate::start::{Drive, StartFlags};

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
        if let Some(model) = LoadedOscillator::recognise(&self.model)? {
            return self.run_oscillator(&model);
        }
        if let Some(model) = LoadedAxes::recognise(&self.model)? {
            return self.run_modes(&model);
        }
        if self.axes.are_given() {
            return Err(Failure::usage("--inputs and --outputs go with models of several axes")
                .hint("choose the column with --input"));
        }
        let model = LoadedModel::read(&self.model)?;
        let drive = self.columns.read_drive(&self.input_file)?;
        let u_unit = model.agreed_unit(&self.input_file, Signal::Input, &drive.unit)?;
        let timed = Drive { u: &drive.samples, time: &drive.time };
        let (start, y) = model.simulate(&self.input_file, &timed, &self.start)?;
        let half = match self.band {
            None => None,
            Some(of) => {
                let band = model.band(&self.input_file, timed.u, timed.sample_rate_hz(), &start)?;
                Some(match of {
                    BandArg::Model => band.of_output(),
                    BandArg::Measurement if band.noise > 0.0 => band.of_measurement(),
                    BandArg::Measurement => return Err(model.no_band(&PredictionError::NoScores)),
                })
            }
        };
        let unit = &model.file.units.output;
        let ends = half.map(|half| {
            let end = |name: &str, sign: f64| {
                Channel::new(name, unit, y.iter().zip(&half).map(|(y, h)| y + sign * h).collect())
            };
            [end("y_low", -1.0), end("y_high", 1.0)]
        });
        let mut channels =
            vec![Channel::new("u", u_unit.symbol(), drive.samples), Channel::new("y", unit, y)];
        channels.extend(ends.into_iter().flatten());
        self.write(drive.time, channels)
    }

    fn run_oscillator(&self, model: &LoadedOscillator) -> Result<(), Failure> {
        if self.band.is_some() {
            return Err(Failure::usage("--band does not go with an oscillator")
                .because("its file holds no correlation of its parameters"));
        }
        let drive = self.columns.read_drive(&self.input_file)?;
        let u_unit = model.agreed_unit(&self.input_file, Signal::Input, &drive.unit)?;
        let timed = Drive { u: &drive.samples, time: &drive.time };
        let y = model.simulate(&self.input_file, &timed, &self.start)?;
        let output = Channel::new("y", &model.file.units.output, y);
        self.write(drive.time, vec![Channel::new("u", u_unit.symbol(), drive.samples), output])
    }

    fn run_modes(&self, model: &LoadedAxes) -> Result<(), Failure> {
        if self.band.is_some() {
            return Err(Failure::usage("--band does not go with models of several axes")
                .because("their file holds no correlation of its parameters"));
        }
        // Outputs are made here, not read.
        let mut axes = self.axes.or(&model.inputs, &[]);
        let names = if self.axes.outputs.is_empty() { &model.outputs } else { &self.axes.outputs }.clone();
        if names.len() != model.outputs.len() {
            return Err(Failure::usage(format!(
                "the model has {} outputs, --outputs names {}",
                model.outputs.len(),
                names.len()
            )));
        }
        axes.outputs.clear();
        let record = axes.read(&self.input_file, &self.columns)?;
        let (simulated, _) =
            model.simulate(&self.input_file, &record, self.start.settled_s("models of several axes")?)?;
        let inputs =
            record.inputs.iter().zip(record.u).map(|(name, u)| Channel::new(name, record.u_unit.symbol(), u));
        let outputs = names.iter().zip(simulated).map(|(name, y)| Channel::new(name, &model.units.output, y));
        let channels = inputs.chain(outputs).collect();
        self.write(record.time, channels)
    }

    fn write(&self, time: TimeBase, channels: Vec<Channel>) -> Result<(), Failure> {
        let failure = || Failure::new(format!("cannot write the simulation to {}", self.out.display()));
        let record =
            Record::new(&self.out.display().to_string(), time, channels).map_err(|e| failure().because(e))?;
        write_csv(&self.out, &record).map_err(|e| failure().because(e))?;
        console::message(&format!("wrote {} samples to {}", record.len(), self.out.display()));
        Ok(())
    }
}
