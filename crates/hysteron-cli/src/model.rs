//! A loaded model file, applied to records.

use std::path::{Path, PathBuf};

use hysteron_identify::{IdentifyError, PredictionBand};
use hysteron_io::{IoError, load_model_and_source, read_record, save_model};
use hysteron_model::axes::{AxesError, AxesRecord, ScheduledModes};
use hysteron_model::decoupling::DecouplingError;
use hysteron_model::hammerstein::SimulationError;
use hysteron_model::model::{
    Capability, Hammerstein, RunError, RunScore, Score, SignalRole, Signals, Simulation, Unsupported,
};
use hysteron_model::record::{Driven, InputOutput, MeasurementRun, Quantity, Source, Timing, Unit};
use hysteron_model::validate::Scoring;
use hysteron_model::{Advice, Model, Start, hammerstein};
use hysteron_numeric::display::short_to;

use crate::axes::AxesFlags;
use crate::columns::{ColumnFlags, InputFlags, TimeFlags};
use crate::failure::Failure;
use crate::progress::during;
use crate::remarks;
use crate::start::StartFlags;

/// A model of any kind and the file it came from.
pub struct Loaded {
    path: PathBuf,
    model: Model,
    source: Source,
}

impl Loaded {
    /// Reads a model file.
    ///
    /// # Errors
    /// If it cannot be read or is not sound.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let (model, source) = load_model_and_source(path).map_err(|e| cannot_read(path, e))?;
        Ok(Loaded { path: path.to_owned(), model, source })
    }

    /// Its file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The file as it was read.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// Inputs and outputs of the record at `path`, in the order of the model.
    ///
    /// # Errors
    /// If it is not a readable record, or the flags are those of another kind of model.
    pub fn read_record(
        &self,
        path: &Path,
        columns: &ColumnFlags,
        axes: &AxesFlags,
    ) -> Result<Signals, Failure> {
        Ok(match self.axes(axes, "--output")? {
            Some(names) => names.read(path, columns.of_drive())?.into(),
            None => columns.read(path)?.into(),
        })
    }

    /// The inputs of the file at `path`, in the order of the model, with the measured output if it is in the
    /// model's unit.
    ///
    /// # Errors
    /// Those of [`Self::read_record`].
    pub fn read_drive(
        &self,
        path: &Path,
        columns: &InputFlags,
        axes: &AxesFlags,
    ) -> Result<Signals, Failure> {
        Ok(match self.axes(axes, "")? {
            Some(names) => AxesFlags { outputs: Vec::new(), ..names }.read(path, columns)?.into(),
            None => {
                let Driven { drive, measured } = columns.read_drive(path)?;
                let output = SignalRole::Output;
                let agrees =
                    |m: &InputOutput| self.model.agreed_unit(output, &m.y_unit, &mut Vec::new()).is_ok();
                Driven { drive, measured: measured.filter(agrees) }.into()
            }
        })
    }

    /// [`Self::read_record`] of a part of a run.
    ///
    /// # Errors
    /// As there; if the model is of several inputs and outputs.
    pub fn read_part(
        &self,
        path: &Path,
        columns: &ColumnFlags,
        axes: &AxesFlags,
    ) -> Result<InputOutput, Failure> {
        part_of_run(self.read_record(path, columns, axes)?)
    }

    /// [`Self::read_drive`] of a part of a run.
    ///
    /// # Errors
    /// Those of [`Self::read_part`].
    pub fn read_driven_part(
        &self,
        path: &Path,
        columns: &InputFlags,
        axes: &AxesFlags,
    ) -> Result<InputOutput, Failure> {
        part_of_run(self.read_drive(path, columns, axes)?)
    }

    /// Names of the outputs in written files: those given, else the model's.
    ///
    /// # Errors
    /// If their number is not that of the model's outputs.
    pub fn output_names(&self, axes: &AxesFlags) -> Result<Vec<String>, Failure> {
        let Some((_, own)) = self.model.channels() else { return Ok(vec!["y".to_owned()]) };
        let names = if axes.outputs.is_empty() { own } else { &axes.outputs };
        if names.len() != own.len() {
            return Err(Failure::usage(format!(
                "the model has {} outputs, --outputs names {}",
                own.len(),
                names.len()
            )));
        }
        Ok(names.to_vec())
    }

    /// The references in the file at `path`, one per output of the model, in its order.
    ///
    /// # Errors
    /// If it is not a readable record or does not have them.
    pub fn read_references(
        &self,
        path: &Path,
        time: &TimeFlags,
        axes: &AxesFlags,
    ) -> Result<AxesRecord, Failure> {
        let record = read_record(path, &time.options())
            .map_err(|e| Failure::new(format!("cannot read the references {}", path.display())).because(e))?;
        AxesRecord::new(&record, &self.output_names(axes)?, &[]).map_err(|e| {
            Failure::new(format!("cannot read the references {}", path.display())).because(e).hint(
                "name the columns of the references with --outputs, in the order of the model's outputs",
            )
        })
    }

    /// Names of several inputs and outputs; `None` for a model of one of each.
    fn axes(&self, given: &AxesFlags, also: &str) -> Result<Option<AxesFlags>, Failure> {
        match self.model.channels() {
            Some((inputs, outputs)) => Ok(Some(given.or(inputs, outputs))),
            None if given.are_given() => {
                let and = if also.is_empty() { String::new() } else { format!(" and {also}") };
                let columns = if also.is_empty() { "column" } else { "columns" };
                Err(Failure::usage("--inputs and --outputs go with models of several axes")
                    .hint(format!("choose the {columns} with --input{and}")))
            }
            None => Ok(None),
        }
    }

    /// The output for the drive in `signals`, from the start the flags give, else the model file's; corrected
    /// by the predicted misfit where that is asked for.
    ///
    /// # Errors
    /// If the model cannot be run on this drive, e.g. dynamics without a sample rate.
    pub fn simulate(
        &self,
        path: &Path,
        signals: &Signals,
        start: &StartFlags,
        correct: bool,
    ) -> Result<Simulation, Failure> {
        let start = start.start(path, signals.time())?;
        let simulated = || match correct {
            true => self.model.simulate_corrected(signals, start),
            false => self.model.simulate(signals, start),
        };
        let found = during("simulating", simulated).map_err(|e| self.cannot_run(path, e))?;
        remarks::tell(path, &self.model, &found.remarks);
        Ok(found)
    }

    /// Scores on a record, simulated from the start the flags give, else from the best-fitting one; corrected
    /// by the predicted misfit where that is asked for.
    ///
    /// # Errors
    /// Those of [`Self::simulate`], and one for a record that cannot be scored.
    pub fn score(
        &self,
        path: &Path,
        signals: &Signals,
        start: &StartFlags,
        scoring: &Scoring,
        correct: bool,
    ) -> Result<Score, Failure> {
        let start = start.start(path, signals.time())?;
        let scored = || match correct {
            true => self.model.score_corrected(signals, start, scoring),
            false => self.model.score(signals, start, scoring),
        };
        let score = during("scoring", scored).map_err(|e| self.cannot_run(path, e))?;
        remarks::tell(path, &self.model, &score.simulation.remarks);
        Ok(score)
    }

    /// Scores of the model on a run of several records, of which the one at `path` is the first.
    ///
    /// # Errors
    /// Those of [`Self::score`].
    pub fn score_run(
        &self,
        path: &Path,
        run: &MeasurementRun,
        start: Start,
        scoring: &Scoring,
    ) -> Result<RunScore, Failure> {
        let score = during("scoring", || self.model.score_run(run, start, scoring))
            .map_err(|e| self.cannot_run(path, e))?;
        remarks::tell(path, &self.model, &score.whole.simulation.remarks);
        Ok(score)
    }

    /// The unit that the model and the record at `record` agree on, for one of the signals.
    ///
    /// # Errors
    /// If they disagree.
    pub fn agreed_unit(&self, record: &Path, signal: SignalRole, found: &Unit) -> Result<Unit, Failure> {
        let mut told = Vec::new();
        let unit =
            self.model.agreed_unit(signal, found, &mut told).map_err(|e| self.cannot_run(record, e))?;
        remarks::tell(record, &self.model, &told);
        Ok(unit)
    }

    /// The start that the model file assumes for a record of one input and output.
    pub fn expected_start(&self, path: &Path, record: &InputOutput) -> Start {
        let mut told = Vec::new();
        let start = self.model.expected_start(record, &mut told);
        remarks::tell(path, &self.model, &told);
        start
    }

    /// The Hammerstein model, for a command that takes no other kind.
    ///
    /// # Errors
    /// If the model is of another kind, which does not support what is `wanted` yet.
    pub fn hammerstein(&self, wanted: Capability) -> Result<&Hammerstein, Failure> {
        self.model.hammerstein(wanted).map_err(|e| self.unsupported(&e))
    }

    /// The scheduled modes.
    ///
    /// # Errors
    /// If it is of another kind.
    pub fn scheduled_modes(&self, wanted: Capability) -> Result<&ScheduledModes, Failure> {
        self.model.scheduled_modes(wanted).map_err(|e| self.unsupported(&e))
    }

    fn unsupported(&self, error: &Unsupported) -> Failure {
        match error.wanted {
            Capability::Correction => {
                Failure::usage("--correct does not go with this kind of model").because(error)
            }
            Capability::Bands => Failure::usage("--band does not go with this kind of model").because(error),
            _ => Failure::new(format!("cannot use {}", self.path.display())).because(error),
        }
    }

    /// Prediction band of the output for the drive of the record at `path`, from the uncertainties in the
    /// file.
    ///
    /// # Errors
    /// If the file has none.
    pub fn band<'a>(
        &self,
        path: &Path,
        u: &[f64],
        timing: impl Into<Timing<'a>>,
        start: &Start,
    ) -> Result<PredictionBand, Failure> {
        let file = self.hammerstein(Capability::Bands)?.data();
        PredictionBand::of_file(file, u, timing, start).map_err(|e| match e {
            IdentifyError::Simulation(e) => self.cannot_run(path, e.into()),
            e => self.no_band(&e),
        })
    }

    /// Failure for a file that gives no prediction band.
    pub fn no_band(&self, error: &IdentifyError) -> Failure {
        Failure::new(format!("cannot draw a band around {}", self.path.display()))
            .because(error)
            .hint("identify the model again: only a joint fit writes the covariance that a band needs")
    }

    /// Failure to follow the references in the file at `path`.
    pub fn cannot_follow(&self, path: &Path, error: RunError) -> Failure {
        let failure =
            || Failure::new(format!("cannot follow {} with {}", path.display(), self.path.display()));
        match error {
            RunError::Unit { signal, model, record } => self.units_disagree(path, signal, &model, &record),
            RunError::Unsupported(e) => self.unsupported(&e),
            RunError::Decoupling(e @ DecouplingError::Begins { .. }) => failure()
                .because(e)
                .hint("widen --range, or let the references begin nearer to the device's rest"),
            RunError::Decoupling(e @ DecouplingError::NotConverging { .. }) => {
                let identified = self.model.valid_range().and_then(|range| range.frequency.as_ref());
                let within = identified.map_or(String::new(), |swings| {
                    format!(" (the records of the model hold up to {} Hz)", short_to(swings.high, 3))
                });
                failure().because(e).hint(format!(
                    "a lower --bandwidth{within}, or sample by sample as a controller does: --preview SAMPLES"
                ))
            }
            RunError::Decoupling(e @ DecouplingError::RangeUnknown) => {
                failure().because(e).hint("e.g. --range=-1:1")
            }
            RunError::Decoupling(e @ DecouplingError::Limits { .. }) => Failure::usage(e.to_string())
                .hint("give one for all actuators, or one per actuator, separated by commas"),
            RunError::Decoupling(e @ DecouplingError::Axes(AxesError::Rate { .. })) => failure()
                .because(e)
                .hint("sample the references faster: hysteron prepare REFERENCE.csv --rate HZ -o OUT.csv"),
            e => failure().because(e),
        }
    }

    /// Failure for a library error, with a remedy.
    fn cannot_run(&self, path: &Path, error: RunError) -> Failure {
        let record = path.display();
        let simulating = || Failure::new(format!("cannot simulate {} on {record}", self.path.display()));
        let scoring = || Failure::new(format!("cannot score {record}"));
        match error {
            RunError::Unit { signal, model, record } => self.units_disagree(path, signal, &model, &record),
            RunError::RestVoltage { .. } => {
                Failure::usage("--rest-voltage does not go with this kind of model").because(error)
            }
            RunError::Unsupported(e) => self.unsupported(&e),
            RunError::NotCorrected(e) => self.cannot_correct(e),
            RunError::Simulation(e) => {
                let failure = simulating().because(&e);
                match e {
                    SimulationError::NoSampleRate => failure.advised(Some(Advice::Resample)),
                    SimulationError::SampleRate { model_hz, .. } => failure.hint(format!(
                        "hysteron prepare {record} --rate {model_hz}Hz -o OUT.csv, or identify the model \
                         again with --scheme tustin, which is valid at other rates"
                    )),
                    SimulationError::NotSettled { .. } => {
                        failure.hint("leave --settled out: the record starts from rest")
                    }
                    _ => failure,
                }
            }
            RunError::NoSampleRate => simulating().because(error).advised(Some(Advice::Resample)),
            RunError::Score(e) => scoring().because(e),
            RunError::Axes(e @ (AxesError::Score(_) | AxesError::Outputs { .. })) => scoring().because(e),
            RunError::TooFewSamples { .. } => {
                scoring().because(error).hint("record at least one loop, with a hundred samples or more")
            }
            RunError::ConstantOutput { .. } => {
                scoring().because(error).hint("check that the sensor was on; choose the column with --output")
            }
            RunError::ConstantInput { .. } => scoring().because(error).hint(
                "choose the column with --input; for a step from another voltage say --rest-voltage VOLTS (a \
                 model with dynamics follows it)",
            ),
            error => simulating().because(error),
        }
    }

    fn units_disagree(&self, path: &Path, signal: SignalRole, own: &Unit, found: &Unit) -> Failure {
        let failure = Failure::new(format!("cannot run {} on {}", self.path.display(), path.display()));
        if self.model.channels().is_some() {
            let role = signal.name();
            return failure
                .because(format!("the model's {role}s are in {own}, the record's in {found}"))
                .hint(format!("choose the columns with --{role}s, or correct the units in their headers"));
        }
        let of_record = if signal == SignalRole::Reference { "reference" } else { "record's" };
        let of_model = if signal == SignalRole::Input { "input" } else { "output" };
        let converted = match own.base().0 {
            Quantity::Voltage => "V, mV or kV".to_owned(),
            Quantity::Length => "nm, µm, mm or m".to_owned(),
            Quantity::Angle => "nrad, µrad, mrad, rad, arcsec or deg".to_owned(),
            Quantity::Time | Quantity::Other => own.to_string(),
        };
        let failure = failure.because(format!(
            "the model's {of_model} is in {own}, the {of_record} in {found}: expected {converted}"
        ));
        let flag = signal.name();
        failure.hint(match signal {
            SignalRole::Reference => format!(
                "choose the column with --{flag}, or correct the unit in its header and convert its numbers"
            ),
            SignalRole::Input | SignalRole::Output => format!(
                "choose the column with --{flag}, correct the unit in its header, or convert it with \
                 --scale, e.g. --scale {letter}=2.5{symbol}/{per}",
                letter = if signal == SignalRole::Input { "u" } else { "y" },
                symbol = own.symbol(),
                per = found.symbol()
            ),
        })
    }
}

/// Checks that a part of a run has one input and one output.
fn part_of_run(signals: Signals) -> Result<InputOutput, Failure> {
    match signals {
        Signals::Single(record) => Ok(record),
        Signals::Several(_) => Err(Failure::usage("--continued takes models of one input and one output")),
    }
}

/// Writes a model file.
///
/// # Errors
/// If it cannot be written.
pub fn save(path: &Path, model: &Model) -> Result<(), Failure> {
    let failure = || Failure::new(format!("cannot write the model to {}", path.display()));
    save_model(path, model).map_err(|e| failure().because(e))
}

/// Builds a model from its data, and writes it with [`save`].
///
/// # Errors
/// If the data are invalid, or the file cannot be written.
pub fn write(path: &Path, data: impl TryInto<Model, Error: Into<IoError>>) -> Result<Model, Failure> {
    let failure = || Failure::new(format!("cannot write the model to {}", path.display()));
    let model = data.try_into().map_err(|e| failure().because(e.into()))?;
    save(path, &model)?;
    Ok(model)
}

/// The failure to read the model file at `path`.
fn cannot_read(path: &Path, error: IoError) -> Failure {
    Failure::new(format!("cannot read the model {}", path.display()))
        .because(error)
        .hint("hysteron identify writes model files; hysteron schema prints their format")
}

/// A Hammerstein model and the file it came from, for commands that take no other kind.
pub struct LoadedModel {
    loaded: Loaded,
    body: Hammerstein,
}

impl LoadedModel {
    /// Reads a model file.
    ///
    /// # Errors
    /// If it cannot be read, is not sound, or of a kind that does not support what is `wanted` yet.
    pub fn read(path: &Path, wanted: Capability) -> Result<Self, Failure> {
        Self::of(Loaded::read(path)?, wanted)
    }

    /// A model that is loaded.
    ///
    /// # Errors
    /// If it is of a kind that does not support what is `wanted` yet.
    pub fn of(loaded: Loaded, wanted: Capability) -> Result<Self, Failure> {
        let body = loaded.hammerstein(wanted)?.clone();
        Ok(Self { loaded, body })
    }

    /// The file as it was read.
    pub fn source(&self) -> &Source {
        self.loaded.source()
    }

    /// The model with its data.
    pub fn body(&self) -> &Hammerstein {
        &self.body
    }

    /// The law.
    pub fn law(&self) -> &hammerstein::Model {
        self.body.law()
    }
}

impl std::ops::Deref for LoadedModel {
    type Target = Loaded;

    fn deref(&self) -> &Loaded {
        &self.loaded
    }
}
