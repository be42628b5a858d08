//! Facade of a model of any kind: file, simulation, scores, inverse and controller.

use std::path::Path;

use hysteron_identify::Listener;
use hysteron_identify::design::{Design, DesignBasis, DesignOptions, design};
use hysteron_io::{load_model, save_model};
use hysteron_model::axes::AxesRecord;
use hysteron_model::compensator::{Controller, Limits};
use hysteron_model::control::{Plant, Stage};
use hysteron_model::decoupling::{DecouplingController, DecouplingLaw, DecouplingOptions, LawOptions};
use hysteron_model::model::{Capability, InverseRequest, RunScore, Score, Signals, Simulation};
use hysteron_model::model_file::Kind;
use hysteron_model::realise::RealiseOptions;
use hysteron_model::record::{ChannelChoice, MeasurementRun, Record, Signal, TimeBase, Unit};
use hysteron_model::tracking::{PlantDescription, TrackOptions, Tracking, track};
use hysteron_model::validate::Scoring;
use hysteron_model::{Model as Core, Start};

use crate::Error;
use crate::identify::rated;

/// An identified model.
#[derive(Clone, Debug, PartialEq)]
pub struct Model(Core);

impl From<Core> for Model {
    fn from(core: Core) -> Self {
        Self(core)
    }
}

impl Model {
    /// The model in a file, of any kind.
    ///
    /// # Errors
    /// [`Error::File`], with the position in the file.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        Ok(Self(load_model(path.as_ref())?))
    }

    /// Writes the model file; an existing file is replaced in one step.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        Ok(save_model(path.as_ref(), &self.0)?)
    }

    /// The kind of model.
    pub fn kind(&self) -> Kind {
        self.0.kind()
    }

    /// The model of `hysteron-model`, with its numbers, units and standard errors.
    pub fn core(&self) -> &Core {
        &self.0
    }

    /// The output for a drive in free run, of a model of one input and one output.
    ///
    /// # Errors
    /// [`Error::Model`].
    pub fn simulate(&self, drive: &Signal, start: Start) -> Result<Signal, Error> {
        let simulation = self.0.simulate(&drive.clone().into(), start)?;
        Ok(self.output(simulation, &drive.time))
    }

    fn output(&self, simulation: Simulation, time: &TimeBase) -> Signal {
        Signal {
            samples: simulation.outputs.into_iter().next().unwrap_or_default(),
            unit: Unit::new(&self.0.units().output),
            name: "y".to_owned(),
            time: time.clone(),
            notes: Vec::new(),
        }
    }

    /// [`Self::simulate`] with the predicted misfit of a device outside the model class, where that pays.
    ///
    /// # Errors
    /// [`Error::Model`].
    pub fn simulate_corrected(&self, drive: &Signal, start: Start) -> Result<Signal, Error> {
        let simulation = self.0.simulate_corrected(&drive.clone().into(), start)?;
        Ok(self.output(simulation, &drive.time))
    }

    /// [`Self::score`] with the predicted misfit of a device outside the model class, where that pays; the
    /// score of the model alone is in [`Score::correction`].
    ///
    /// # Errors
    /// [`Error::Model`].
    pub fn score_corrected(&self, record: &Record, scoring: Scoring) -> Result<Score, Error> {
        Ok(self.0.score_corrected(&self.signals(record)?, Start::AsIdentified, &scoring)?)
    }

    /// Score of the model on a record, simulated from the best-fitting start. Columns are the model's own,
    /// else chosen by name and unit.
    ///
    /// # Errors
    /// [`Error::Model`].
    pub fn score(&self, record: &Record, scoring: Scoring) -> Result<Score, Error> {
        Ok(self.0.score(&self.signals(record)?, Start::AsIdentified, &scoring)?)
    }

    /// The force over a record with a measured rate of the displacement in this column, for a model of the
    /// kind force.
    ///
    /// # Errors
    /// [`Error::Model`].
    pub fn simulate_with_rate(&self, record: &Record, column: &str, start: Start) -> Result<Signal, Error> {
        let data = rated(record, &ChannelChoice::default(), Some(column))?;
        let time = data.time.clone();
        Ok(self.output(self.0.simulate(&data.into(), start)?, &time))
    }

    /// [`Self::score`] with a measured rate of the displacement in this column, for a model of the kind
    /// force.
    ///
    /// # Errors
    /// [`Error::Model`].
    pub fn score_with_rate(&self, record: &Record, column: &str, scoring: Scoring) -> Result<Score, Error> {
        let data = rated(record, &ChannelChoice::default(), Some(column))?;
        Ok(self.0.score(&data.into(), Start::AsIdentified, &scoring)?)
    }

    /// Scores of the model on consecutive records of one run, simulated without interruption from the start
    /// that fits the first best. A record that begins before the one before it ends starts another run.
    ///
    /// # Errors
    /// [`Error::Model`].
    pub fn score_continued(&self, records: &[Record], scoring: Scoring) -> Result<Vec<RunScore>, Error> {
        self.0.hammerstein(Capability::Runs)?;
        let single = |record: &Record| Ok(record.input_output(&ChannelChoice::default())?);
        let runs = MeasurementRun::of(&records.iter().map(single).collect::<Result<Vec<_>, Error>>()?)?;
        let score = |run: &MeasurementRun| Ok(self.0.score_run(run, Start::AsIdentified, &scoring)?);
        runs.iter().map(score).collect()
    }

    /// The drive (zero-order hold) that makes the output follow a reference.
    ///
    /// # Errors
    /// [`Error::Model`], [`Error::NoSampleRate`].
    pub fn invert(&self, reference: &Signal, limits: Limits) -> Result<Signal, Error> {
        let body = self.0.hammerstein(Capability::Inversion)?;
        let TimeBase::Uniform { sample_rate_hz, .. } = reference.time else {
            return Err(Error::NoSampleRate { name: reference.name.clone() });
        };
        let request = InverseRequest::within(limits);
        let (found, _) =
            body.drive_for(&reference.samples, sample_rate_hz, &request, None, Listener::silent())?;
        Ok(Signal {
            samples: found.drive,
            unit: Unit::new(&self.0.units().input),
            name: "u".to_owned(),
            time: reference.time.clone(),
            notes: Vec::new(),
        })
    }

    /// A controller at this sample rate \[Hz\] without preview: reference in, voltage out. It starts at rest
    /// at the voltage of the range closest to 0 V.
    ///
    /// # Errors
    /// [`Error::Model`].
    pub fn controller(&self, sample_rate_hz: f64, limits: Limits) -> Result<Controller, Error> {
        let body = self.0.hammerstein(Capability::Inversion)?;
        let request = InverseRequest::within(limits);
        let law = request.law(body, sample_rate_hz, RealiseOptions::default(), Some(0))?;
        Ok(Controller::of_law(law, request.limits(body)?)?)
    }

    /// The drives (zero-order hold) of all actuators of a model of several axes, decoupled: with them its
    /// outputs follow the references in a record, whose channels have the names of the outputs. `limits`: one
    /// per actuator.
    ///
    /// # Errors
    /// [`Error::Model`].
    pub fn decouple(&self, references: &Record, limits: &[Limits]) -> Result<Vec<Signal>, Error> {
        let (inputs, outputs) = self.0.channels().unwrap_or((&[], &[]));
        let references = AxesRecord::new(references, outputs, &[])?;
        let found = self.0.decouple(&references, &DecouplingOptions::within(limits.to_vec()))?;
        let unit = Unit::new(&self.0.units().input);
        let named = inputs.iter().zip(found.drive);
        Ok(named
            .map(|(name, samples)| Signal {
                samples,
                unit: unit.clone(),
                name: name.clone(),
                time: references.time.clone(),
                notes: Vec::new(),
            })
            .collect())
    }

    /// The inverse of a model of several axes sample by sample at this rate \[Hz\], with a preview of the
    /// references in samples: references in, voltages out. `limits`: one per actuator.
    ///
    /// # Errors
    /// [`Error::Model`].
    pub fn decoupling_controller(
        &self,
        sample_rate_hz: f64,
        preview: usize,
        limits: &[Limits],
    ) -> Result<DecouplingController, Error> {
        let model = self.0.scheduled_modes(Capability::Inversion)?;
        let options = LawOptions { preview: Some(preview), ..LawOptions::default() };
        Ok(DecouplingLaw::new(model, sample_rate_hz, &options)?.controller(limits)?)
    }

    /// Simulated tracking of a reference by several controllers, with the error of each; on the model itself
    /// without noise, or on a `stage`.
    ///
    /// # Errors
    /// [`Error::Model`]: a reference or options that leave nothing to simulate, a requested controller that
    /// cannot be made.
    pub fn track(
        &self,
        reference: &Signal,
        options: &TrackOptions,
        stage: Option<&dyn Stage>,
    ) -> Result<Tracking, Error> {
        let (plant, name, words) = match stage {
            Some(stage) => (Plant::Stage(stage), "stage", "a stage"),
            None => (Plant::Model, "model", "the model itself, simulated without noise"),
        };
        let description = PlantDescription { name, words: words.to_owned() };
        Ok(track(self.0.hammerstein(Capability::Tracking)?, reference, options, (plant, description))?)
    }

    /// The next drive: the one after whose record the model is known best for a purpose, by the covariance in
    /// its file.
    ///
    /// # Errors
    /// [`Error::Identify`], [`Error::Model`].
    pub fn design(&self, options: &DesignOptions) -> Result<Design, Error> {
        let basis = DesignBasis::from(self.0.hammerstein(Capability::Design)?.data());
        Ok(design(&basis, options, Listener::silent())?)
    }

    /// The channels of a record that are the model's inputs and outputs.
    fn signals(&self, record: &Record) -> Result<Signals, Error> {
        Ok(match self.0.channels() {
            Some((inputs, outputs)) => AxesRecord::new(record, inputs, outputs)?.into(),
            None => record.input_output(&ChannelChoice::default())?.into(),
        })
    }
}
