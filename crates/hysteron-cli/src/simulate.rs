//! `hysteron simulate`: a model's output for a drive.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use hysteron_identify::IdentifyError;
use hysteron_io::write_record;
use hysteron_model::model::{Capability, Signals};
use hysteron_model::record::MeasurementRun;

use crate::advice;
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
    after_help = "The file written holds the time (where the input has one), the drive and the model's \
    output, in the model's units, e.g. t_s,u_V,y_um: a record that every other command reads. An output \
    measured in the input file is kept beside it as y_measured_um.\n\n\
    --band adds the limits of a 95 % band, e.g. y_low_um,y_high_um, from the standard errors in the model \
    file: of the model's output about its mean (a sensor has its own zero), or of a new measurement. The first \
    assumes that the model class is true. The second does where the class explains the training records; \
    else it includes a model of the difference, and a note says where it rests on other devices rather than \
    on those records.\n\n\
    Example: hysteron simulate model.json drive.csv -o simulated.csv --band measurement\n\
    Example: hysteron simulate model.json part1.csv part2.csv --continued -o run.csv"
)]
pub struct Simulate {
    /// The model file
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,

    /// File with the drive; several with --continued
    #[arg(value_name = "INPUT.csv", required = true)]
    input_files: Vec<PathBuf>,

    /// The files are consecutive parts of one run on one clock: simulated without interruption from the start
    /// of the first
    #[arg(long)]
    continued: bool,

    /// File to write
    #[arg(short, long = "out", value_name = "OUT.csv|npz|mat")]
    out: OutFile,

    /// Add the limits of a 95 % prediction band
    #[arg(long, value_enum)]
    band: Option<BandArg>,

    /// Add the predicted misfit of a device outside the model class, where that pays: refused where it gains
    /// nothing on left-out parts of the training records
    #[arg(long)]
    correct: bool,

    /// Column of the rate of the input, for a model of the kind force: its name, with or without unit
    /// [default: the rate is that of the displacement]
    #[arg(long, value_name = "COL", conflicts_with = "continued")]
    rate: Option<String>,

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
        if self.correct {
            loaded.check_correction()?;
        }
        if self.rate.is_some() {
            loaded.check_rate()?;
        }
        let names = loaded.output_names(&self.axes)?;
        let (path, signals) = self.signals(&loaded)?;
        let found = loaded.simulate(path, &signals, &self.start, self.correct)?;
        let unit = &loaded.model().units().output;
        let failure = || Failure::new(format!("cannot write the simulation to {}", self.out.display()));
        let mut ends = None;
        if let (Some(of), Signals::Single(drive), Some(y)) = (self.band, &signals, found.outputs.first()) {
            let band = loaded.band(path, &drive.u, &drive.time, &found.start)?;
            let band = if self.correct { band.corrected() } else { band };
            let half = match of {
                BandArg::Model => band.of_output(),
                BandArg::Measurement if band.noise > 0.0 => {
                    band.findings.iter().for_each(|finding| console::note(&advice::text(finding)));
                    band.of_measurement()
                }
                BandArg::Measurement => return Err(loaded.no_band(&IdentifyError::NoScores)),
            };
            ends = Some([-1.0, 1.0].map(|sign| y.iter().zip(&half).map(|(y, h)| y + sign * h).collect()));
        }
        let record = found.to_record(&self.out.display().to_string(), &signals, &names, unit, ends);
        let record = record.map_err(|e| failure().because(e))?;
        write_record(&self.out, &record).map_err(|e| failure().because(e))?;
        console::message(&format!("wrote {} samples to {}", record.len(), self.out.display()));
        Ok(())
    }

    /// The drive of the file or of the run that the files form, and the path of the first.
    fn signals(&self, loaded: &Loaded) -> Result<(&Path, Signals), Failure> {
        let (Some(path), several) = (self.input_files.first(), self.input_files.len() > 1) else {
            return Err(Failure::usage("no file with a drive is given"));
        };
        if !several {
            let signals = match (loaded.read_drive(path, &self.columns, &self.axes)?, &self.rate) {
                (Signals::Single(drive), Some(column)) => self.columns.with_rate(path, drive, column)?.into(),
                (signals, _) => signals,
            };
            return Ok((path, signals));
        }
        if !self.continued {
            return Err(Failure::usage("several files are simulated only as parts of one run")
                .hint("add --continued, or simulate one file at a time"));
        }
        let part = |path: &PathBuf| loaded.read_driven_part(path, &self.columns, &self.axes);
        let parts = self.input_files.iter().map(part).collect::<Result<Vec<_>, Failure>>()?;
        let runs =
            MeasurementRun::of(&parts).map_err(|e| Failure::new("the files form no run").because(e))?;
        match <[MeasurementRun; 1]>::try_from(runs) {
            Ok([run]) => Ok((path, Signals::Single(run.data))),
            Err(runs) => Err(Failure::new(format!("the files are {} runs", runs.len()))
                .because("a file begins before the one before it ends")
                .hint("simulate each run by itself, its files in the order of their time")),
        }
    }
}
