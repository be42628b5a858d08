//! A model file read for use with records.

use hysteron_io::ModelDiskError;
use std::path::{Path, PathBuf};

use hysteron_identify::{PredictionBand, PredictionError};
use hysteron_model::dynamics::Dynamics;
use hysteron_model::hammerstein::{Model, SimulationError, Start};
use hysteron_model::model_file::{ModelFile, SignalUnits, ValidRange};
use hysteron_model::record::{InputOutput, Quantity, Unit};
use hysteron_model::validate::{Scoring, StartError, choose_start};
use hysteron_numeric::display::short;

use crate::console;
use crate::failure::Failure;
use crate::numbers::ends;
use crate::start::{Drive, StartFlags, in_words};

/// Excess over the valid range, as a fraction of it, that is not worth a remark.
const RANGE_SLACK: f64 = 0.01;

/// A model file and the model in it.
pub struct LoadedModel {
    path: PathBuf,
    pub file: ModelFile,
    model: Model,
}

impl LoadedModel {
    /// Reads a model file.
    ///
    /// # Errors
    /// If it cannot be read or is not sound.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let file =
            hysteron_io::read_model_file(path, ModelFile::from_slice).map_err(|e| cannot_read(path, e))?;
        let model = file.to_model().map_err(|e| cannot_read(path, e))?;
        Ok(LoadedModel { path: path.to_owned(), file, model })
    }

    /// The start, and the output simulated from it for the drive of the record at `path`.
    ///
    /// # Errors
    /// If the model cannot be run on this drive, e.g. dynamics without a sample rate.
    pub fn simulate(
        &self,
        path: &Path,
        drive: &Drive,
        start: &StartFlags,
    ) -> Result<(Start, Vec<f64>), Failure> {
        remark_extrapolation(self.file.valid_range.as_ref(), path, drive.u);
        let start = start.choose(&self.file, path, drive)?;
        let simulated = self.model.simulate(drive.u, drive.sample_rate_hz(), &start);
        Ok((start, simulated.map_err(|e| self.cannot_simulate(path, &e))?))
    }

    /// Simulates the record from the start the flags give, else from the one that explains it best (said in a note where
    /// it is not the model file's).
    ///
    /// # Errors
    /// As [`Self::simulate`], and if the record cannot be scored.
    pub fn simulate_record(
        &self,
        path: &Path,
        record: &InputOutput,
        start: &StartFlags,
        scoring: &Scoring,
    ) -> Result<(Start, Vec<f64>), Failure> {
        let drive = Drive { u: &record.u, time: &record.time };
        let preferred = start.choose(&self.file, path, &drive)?;
        if start.are_given() {
            return self.simulate(path, &drive, start);
        }
        remark_extrapolation(self.file.valid_range.as_ref(), path, drive.u);
        let (chosen, simulated) =
            choose_start(&self.model, record, preferred, scoring).map_err(|e| match e {
                StartError::Simulation(e) => self.cannot_simulate(path, &e),
                e => Failure::new(format!("cannot score {}", path.display())).because(e),
            })?;
        if chosen != preferred {
            console::note(&format!(
                "{}: simulated {}, which explains it better than {} (--rest-voltage or --settled say otherwise)",
                path.display(),
                in_words(&chosen, &self.file.units.input, &self.file.units.output),
                in_words(&preferred, &self.file.units.input, &self.file.units.output)
            ));
        }
        Ok((chosen, simulated))
    }

    /// Band of the output for the drive of the record at `path`, from the errors of the numbers in the file.
    ///
    /// # Errors
    /// If the file does not hold them.
    pub fn band(
        &self,
        path: &Path,
        u: &[f64],
        sample_rate_hz: Option<f64>,
        start: &Start,
    ) -> Result<PredictionBand, Failure> {
        PredictionBand::of_file(&self.file, u, sample_rate_hz, start).map_err(|e| match e {
            PredictionError::Simulation(e) => self.cannot_simulate(path, &e),
            e => self.no_band(&e),
        })
    }

    /// Why the file gives no band.
    pub fn no_band(&self, error: &PredictionError) -> Failure {
        Failure::new(format!("cannot draw a band around {}", self.path.display())).because(error).hint(
            "identify the model anew: a joint fit, or one of slow records alone, writes what a band needs; two steps and ARX do not",
        )
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Whether the model has no dynamic block.
    pub fn is_static(&self) -> bool {
        self.model.dynamics == Dynamics::None
    }

    fn cannot_simulate(&self, path: &Path, error: &SimulationError) -> Failure {
        let failure = Failure::new(format!("cannot simulate {} on {}", self.path.display(), path.display()));
        let failure = failure.because(error);
        match error {
            SimulationError::NoSampleRate => failure
                .hint("give the sample rate with --sample-rate HZ, or resample the record to a uniform time"),
            SimulationError::SampleRate { model_hz, .. } => failure.hint(format!(
                "resample the record to {model_hz} Hz, or identify the model again with --scheme tustin, which holds at \
                 other rates"
            )),
            _ => failure,
        }
    }

    /// As [`agreed_unit`].
    ///
    /// # Errors
    /// If they disagree.
    pub fn agreed_unit(&self, record: &Path, signal: Signal, found: &Unit) -> Result<Unit, Failure> {
        agreed_unit((&self.path, &self.file.units), record, signal, found)
    }
}

/// A remark where the input leaves the range that a model was identified in.
pub fn remark_extrapolation(range: Option<&ValidRange>, record: &Path, u: &[f64]) {
    let Some(range) = range else { return };
    let (low, high) = ends(u);
    let slack = RANGE_SLACK * (range.input.high - range.input.low);
    if low < range.input.low - slack || high > range.input.high + slack {
        console::note(&format!(
            "{}: the input runs from {} to {} {unit}, the model was identified from {} to {} {unit}: it extrapolates",
            record.display(),
            short(low),
            short(high),
            short(range.input.low),
            short(range.input.high),
            unit = Unit::new(&range.input.unit),
        ));
    }
}

/// One of the model's signals.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    Input,
    Output,
    /// What the output is to be.
    Reference,
}

/// The unit that a model and a record agree on, for one of the signals: the record's, or the model's where the record
/// gives none.
///
/// # Errors
/// If they disagree.
pub fn agreed_unit(
    (model, units): (&Path, &SignalUnits),
    record: &Path,
    signal: Signal,
    found: &Unit,
) -> Result<Unit, Failure> {
    let (name, flag, own) = match signal {
        Signal::Input => ("input", "--input", &units.input),
        Signal::Output => ("output", "--output", &units.output),
        Signal::Reference => ("reference", "--reference", &units.output),
    };
    let own = Unit::new(own);
    if found.symbol().is_empty() {
        if !own.symbol().is_empty() {
            let record = record.display();
            console::note(&format!("{record}: the {name} has no unit; taken to be in {own}, the model's"));
        }
        return Ok(own);
    }
    if own.symbol().is_empty() || own == *found {
        return Ok(found.clone());
    }
    let (of_model, of_record) = match signal {
        Signal::Input => ("input", "record's"),
        Signal::Output => ("output", "record's"),
        Signal::Reference => ("output", "reference"),
    };
    let converted = match own.base().0 {
        Quantity::Voltage => "V, mV or kV".to_owned(),
        Quantity::Length => "nm, µm, mm or m".to_owned(),
        Quantity::Angle => "nrad, µrad, mrad, rad, arcsec or deg".to_owned(),
        Quantity::Time | Quantity::Other => own.to_string(),
    };
    let failure = Failure::new(format!("cannot run {} on {}", model.display(), record.display())).because(
        format!("the model's {of_model} is in {own}, the {of_record} in {found}: expected {converted}"),
    );
    Err(failure.hint(match signal {
        Signal::Reference => {
            format!("choose the column with {flag}, or correct the unit in its header and convert its numbers")
        }
        Signal::Input | Signal::Output => format!(
            "choose the column with {flag}, correct the unit in its header, or say what it means with --scale, e.g. --scale \
             {letter}=2.5{symbol}/{per}",
            letter = if signal == Signal::Input { "u" } else { "y" },
            symbol = own.symbol(),
            per = found.symbol()
        ),
    }))
}

/// The failure to read the model file at `path`.
pub fn cannot_read(path: &Path, error: impl Into<ModelDiskError>) -> Failure {
    Failure::new(format!("cannot read the model {}", path.display()))
        .because(error.into())
        .hint("hysteron identify writes model files; hysteron schema prints their format")
}
