//! Flags that assign the columns of a record, shared by all commands that read records.

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_io::{IoError, ReadOptions, read_drive, read_input_output, read_record, read_reference};
use hysteron_model::record::{
    ChannelChoice, DeadBand, Driven, InputOutput, Record, RecordError, Scale, Signal, inspect,
};
use hysteron_model::{Advice, Finding};
use rayon::prelude::*;

use crate::cut::CutFlags;
use crate::failure::Failure;
use crate::numbers::{positive, whole};
use crate::{advice, console};

/// Time and size of a file.
#[derive(Args, Clone, Debug)]
pub struct TimeFlags {
    /// Time column: its name, with or without unit, or its number from 1
    #[arg(long, value_name = "COL", help_heading = "Columns")]
    time: Option<String>,

    /// Sample rate in Hz, for a file without time column; with one it must agree, and replaces the time
    /// stamps
    #[arg(
        long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true,
        help_heading = "Columns",
    )]
    sample_rate: Option<f64>,

    /// Maximum file size, in bytes
    #[arg(
        long, value_name = "BYTES", value_parser = whole::<u64>, allow_hyphen_values = true,
        help_heading = "Columns",
    )]
    max_bytes: Option<u64>,
}

/// Input column.
#[derive(Args, Clone, Debug)]
pub struct InputFlags {
    /// Input (drive) column: its name, with or without unit, or its number from 1
    #[arg(long, value_name = "COL", help_heading = "Columns")]
    input: Option<String>,

    /// Scale factor of a column, e.g. y=2.5um/V for a sensor in volts or u=15V/V for a command before an
    /// amplifier; may be repeated (--input and --output then take names, not numbers)
    #[arg(
        long = "scale", value_name = "COL=FACTOR", value_parser = str::parse::<Scale>,
        help_heading = "Columns",
    )]
    scales: Vec<Scale>,

    /// Dead band of the drive, as of a valve or an amplifier with a threshold: smaller drives count as 0
    #[arg(
        long, value_name = "DRIVE", value_parser = positive, allow_hyphen_values = true,
        help_heading = "Columns",
    )]
    dead_band: Option<f64>,

    /// Dead zone of the drive, as of a valve with overlap: smaller drives count as 0, larger ones by what
    /// exceeds it
    #[arg(
        long, value_name = "DRIVE", value_parser = positive, allow_hyphen_values = true,
        conflicts_with = "dead_band", help_heading = "Columns",
    )]
    dead_zone: Option<f64>,

    #[command(flatten)]
    time: TimeFlags,

    #[command(flatten)]
    cut: CutFlags,
}

/// Input and output columns.
#[derive(Args, Clone, Debug)]
pub struct ColumnFlags {
    #[command(flatten)]
    drive: InputFlags,

    /// Output (response) column: its name, with or without unit, or its number from 1
    #[arg(long, value_name = "COL", help_heading = "Columns")]
    output: Option<String>,
}

impl TimeFlags {
    /// The [`ReadOptions`] that the flags describe.
    pub fn options(&self) -> ReadOptions {
        let defaults = ReadOptions::default();
        ReadOptions {
            time: self.time.clone(),
            sample_rate_hz: self.sample_rate,
            max_bytes: self.max_bytes.unwrap_or(defaults.max_bytes),
            ..defaults
        }
    }
}

impl InputFlags {
    /// The flags as they are typed, each with its value, but for the time column.
    fn typed(&self) -> Vec<(&'static str, String)> {
        let number = |flag, x: Option<f64>| Some((flag, x?.to_string()));
        let mut typed: Vec<(&'static str, String)> = [
            self.input.clone().map(|column| ("--input", column)),
            number("--dead-band", self.dead_band),
            number("--dead-zone", self.dead_zone),
            number("--sample-rate", self.time.sample_rate),
            self.time.max_bytes.map(|bytes| ("--max-bytes", bytes.to_string())),
        ]
        .into_iter()
        .flatten()
        .collect();
        typed.extend(self.scales.iter().map(|scale| ("--scale", scale.to_string())));
        typed.extend(self.cut.typed());
        typed
    }

    /// The input that was chosen.
    pub fn input(&self) -> Option<&str> {
        self.input.as_deref()
    }

    /// Reads the input channel, and the output if it was measured too. Prints the choices made automatically.
    ///
    /// # Errors
    /// If the file is not a readable record or the input cannot be decided.
    pub fn read_drive(&self, path: &Path) -> Result<Driven, Failure> {
        let options = ReadOptions { input: self.input.clone(), ..self.options() };
        let read = || -> Result<Driven, Unreadable> {
            if self.scales.is_empty() {
                return Ok(read_drive(path, &options)?);
            }
            let record = self.scaled(read_record(path, &options)?)?;
            Ok(record.driven(self.input.as_deref())?)
        };
        let Driven { mut drive, mut measured } = read().map_err(|e| e.at(path, "--input"))?;
        let mut told: Vec<String> = drive.notes.iter().map(advice::text).collect();
        self.apply_dead_band(&mut drive.samples, &mut told)?;
        if let Some(measured) = &mut measured {
            measured.u.clone_from(&drive.samples);
        }
        notes(path, &told);
        Ok(Driven { drive, measured })
    }

    /// Reads all channels, scaled.
    ///
    /// # Errors
    /// If the file is not a readable record.
    pub fn read_record(&self, path: &Path) -> Result<Record, Failure> {
        let read = || self.scaled(read_record(path, &self.options())?);
        read().map_err(|e: Unreadable| e.at(path, "--inputs and --outputs"))
    }

    /// The [`ReadOptions`] that the flags describe, for all columns.
    fn options(&self) -> ReadOptions {
        ReadOptions { cut: self.cut.cut(), ..self.time.options() }
    }

    fn apply_dead_band(&self, u: &mut [f64], told: &mut Vec<String>) -> Result<(), Failure> {
        let band = DeadBand::given(self.dead_band, self.dead_zone);
        let band = band.map_err(|e| Failure::new(e.to_string()))?;
        told.extend(band.map(|band| advice::text(&band.apply(u))));
        Ok(())
    }

    fn scaled(&self, record: Record) -> Result<Record, Unreadable> {
        Ok(self.scales.iter().try_fold(record, |record, scale| scale.apply(&record))?)
    }
}

/// Reference column.
#[derive(Args, Clone, Debug)]
pub struct ReferenceFlags {
    /// Reference column: its name, with or without unit, or its number from 1
    #[arg(long, value_name = "COL", help_heading = "Columns")]
    reference: Option<String>,

    #[command(flatten)]
    time: TimeFlags,
}

impl ReferenceFlags {
    /// The flags of the time base.
    pub fn time(&self) -> &TimeFlags {
        &self.time
    }

    /// Reads the reference alone. Prints the choices made automatically.
    ///
    /// # Errors
    /// If the file is not a readable record or the reference cannot be decided.
    pub fn read(&self, path: &Path) -> Result<Signal, Failure> {
        let options = ReadOptions { reference: self.reference.clone(), ..self.time.options() };
        let signal =
            read_reference(path, &options).map_err(|e| Unreadable::from(e).at(path, "--reference"))?;
        notes(path, &signal.notes.iter().map(advice::text).collect::<Vec<_>>());
        Ok(signal)
    }

    /// Reads drive and measured output of a run, by the rules of every record.
    ///
    /// # Errors
    /// If the file is not a readable record or its columns cannot be decided.
    pub fn read_run(&self, path: &Path) -> Result<InputOutput, Failure> {
        let outcome = read_input_output(path, &self.time.options())
            .map_err(|e| Unreadable::from(e).at(path, "other names in its header"))?;
        notes(path, &outcome.notes.iter().map(advice::text).collect::<Vec<_>>());
        Ok(outcome.data)
    }
}

impl ColumnFlags {
    /// The flags as they are typed for `hysteron design`, each with its value.
    pub fn typed_for_design(&self) -> Vec<(&'static str, String)> {
        let mut typed = self.drive.typed();
        // Its --time is the length of the drive.
        typed.extend(self.drive.time.time.clone().map(|column| ("--time-column", column)));
        typed.extend(self.output.clone().map(|column| ("--output", column)));
        typed
    }

    /// The flags of the drive alone.
    pub fn of_drive(&self) -> &InputFlags {
        &self.drive
    }

    /// The [`ReadOptions`] that the flags describe.
    pub fn options(&self) -> ReadOptions {
        ReadOptions { input: self.drive.input.clone(), output: self.output.clone(), ..self.drive.options() }
    }

    /// Reads input and output of a record. Prints the choices made automatically, and defects of the data: a
    /// saturated sensor, a constant drive, non-uniform time stamps.
    ///
    /// # Errors
    /// Those of [`ColumnFlags::read_silently`].
    pub fn read(&self, path: &Path) -> Result<InputOutput, Failure> {
        let mut told = Vec::new();
        let data = self.read_inspected(path, &mut told);
        notes(path, &told);
        data
    }

    /// [`ColumnFlags::read`] of several records at once. What is printed is in their order, up to the first
    /// that fails.
    ///
    /// # Errors
    /// Those of [`ColumnFlags::read`].
    pub fn read_all(&self, paths: &[PathBuf]) -> Result<Vec<InputOutput>, Failure> {
        let read = |path: &PathBuf| {
            let mut told = Vec::new();
            let data = self.read_inspected(path, &mut told);
            (told, data)
        };
        let records: Vec<_> = paths.par_iter().map(read).collect();
        let print = |(path, (told, data)): (&PathBuf, (Vec<String>, _))| {
            notes(path, &told);
            data
        };
        paths.iter().zip(records).map(print).collect()
    }

    fn read_inspected(&self, path: &Path, told: &mut Vec<String>) -> Result<InputOutput, Failure> {
        let data = self.read_told(path, told)?;
        told.extend(inspect(&data).findings.into_iter().filter(|f| f.is_warning()).map(|f| advice::text(&f)));
        Ok(data)
    }

    /// Reads input and output of a record. Prints the choices made automatically, and nothing about the data.
    ///
    /// # Errors
    /// If the file is not a readable record or its columns cannot be decided.
    pub fn read_silently(&self, path: &Path) -> Result<InputOutput, Failure> {
        let mut told = Vec::new();
        let data = self.read_told(path, &mut told);
        notes(path, &told);
        data
    }

    /// Input and output of a record; the choices made automatically are appended to `told`.
    fn read_told(&self, path: &Path, told: &mut Vec<String>) -> Result<InputOutput, Failure> {
        let (mut data, notes) = self.read_noted(path).map_err(|e| e.at(path, advice::INPUT_AND_OUTPUT))?;
        told.extend(notes.iter().map(advice::text));
        self.drive.apply_dead_band(&mut data.u, told)?;
        Ok(data)
    }

    fn read_noted(&self, path: &Path) -> Result<(InputOutput, Vec<Finding>), Unreadable> {
        if self.drive.scales.is_empty() {
            let outcome = read_input_output(path, &self.options())?;
            return Ok((outcome.data, outcome.notes));
        }
        let record = self.drive.scaled(read_record(path, &self.options())?)?;
        let choice = ChannelChoice { input: self.drive.input.clone(), output: self.output.clone() };
        let notes = record.select(&choice)?.notes;
        Ok((record.input_output(&choice)?, notes))
    }
}

/// Reason why a file is not a usable record.
pub struct Unreadable {
    because: String,
    advice: Option<Advice>,
}

impl Unreadable {
    /// The failure for the file at `path`, whose columns are chosen with these flags.
    pub fn at(self, path: &Path, choose_columns: &str) -> Failure {
        let failure =
            Failure::new(format!("cannot read the record {}", path.display())).because(self.because);
        match self.advice {
            Some(advice) => failure.hint(advice::in_flags_of_columns(&advice, choose_columns)),
            None => failure,
        }
    }
}

impl From<IoError> for Unreadable {
    fn from(e: IoError) -> Self {
        Unreadable { because: e.to_string(), advice: e.advice() }
    }
}

impl From<RecordError> for Unreadable {
    fn from(e: RecordError) -> Self {
        Unreadable { because: e.to_string(), advice: e.advice() }
    }
}

fn notes(path: &Path, notes: &[String]) {
    for note in notes {
        console::note(&format!("{}: {note}", path.display()));
    }
}
