//! Identification of a model from records.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use hysteron_identify::design::{Design, DesignBasis, DesignOptions, design};
use hysteron_identify::{
    CampaignRecord, DynamicsChoice, Event, FamilyChoice, Finding, Fit as Found, FitParameter, FitRecords,
    Listener, Options, Searches, Stop, Task, Watch, fit_on, usual_kind,
};
use hysteron_model::axes::AxesRecord;
use hysteron_model::dynamics::Creep;
use hysteron_model::force::with_rate;
use hysteron_model::hammerstein::SimulationError;
use hysteron_model::model::Score;
use hysteron_model::model_file::{Kind, Maker, timestamp};
use hysteron_model::record::{ChannelChoice, InputOutput, Record};
use serde::{Serialize, Serializer};

use crate::{Error, Model, Report};

/// Builder of an identification: records and options. Options that are not set are chosen from the records.
pub struct Identify<'a> {
    records: &'a [Record],
    kind: Option<Kind>,
    inputs: Vec<String>,
    outputs: Vec<String>,
    rate: Option<String>,
    options: Options,
    task: Option<Task>,
    start: Option<hysteron_model::Model>,
    watch: Watch<'a>,
    stop: Stop,
    resume: Option<Searches>,
}

impl<'a> Identify<'a> {
    /// An identification from these records of one device.
    pub fn new(records: &'a [Record]) -> Self {
        Self {
            records,
            kind: None,
            inputs: Vec::new(),
            outputs: Vec::new(),
            rate: None,
            options: Options::default(),
            task: None,
            start: None,
            watch: Watch::silent(),
            stop: Stop::new(),
            resume: None,
        }
    }

    /// The records are consecutive parts of one run on one clock: hysteresis memory, creep and offset carry
    /// over.
    #[must_use]
    pub fn continued(mut self) -> Self {
        self.options.continued = true;
        self
    }

    /// Kind of model; default: a force where every record has a displacement as its input and a force as its
    /// output, else a Hammerstein model; modes where several inputs are named.
    #[must_use]
    pub fn kind(mut self, kind: Kind) -> Self {
        self.kind = Some(kind);
        self
    }

    /// Kind of model with all options of its identification, in place of the single options.
    #[must_use]
    pub fn task(mut self, task: Task) -> Self {
        self.task = Some(task);
        self
    }

    /// Model whose parameters are the first starting point of every search.
    #[must_use]
    pub fn start(mut self, model: &Model) -> Self {
        self.start = Some(model.core().clone());
        self
    }

    /// Names of the input and output columns; default: recognised among the channels.
    #[must_use]
    pub fn columns<S: Into<String>>(
        mut self,
        inputs: impl IntoIterator<Item = S>,
        outputs: impl IntoIterator<Item = S>,
    ) -> Self {
        self.inputs = inputs.into_iter().map(Into::into).collect();
        self.outputs = outputs.into_iter().map(Into::into).collect();
        self
    }

    /// Name of the column of the measured rate of the input, for a model of the kind force; default: the rate
    /// is that of the displacement.
    #[must_use]
    pub fn rate(mut self, column: impl Into<String>) -> Self {
        self.rate = Some(column.into());
        self
    }

    /// Family of the hysteresis block of a Hammerstein model, or [`FamilyChoice::Auto`], the one with the
    /// smallest held-out error; default: the usual one.
    #[must_use]
    pub fn hysteresis(mut self, family: impl Into<FamilyChoice>) -> Self {
        self.options.hysteresis = family.into();
        self
    }

    /// Dynamic block of a Hammerstein model.
    #[must_use]
    pub fn dynamics(mut self, dynamics: DynamicsChoice) -> Self {
        self.options.dynamics = dynamics;
        self
    }

    /// Creep of a Hammerstein model.
    #[must_use]
    pub fn creep(mut self, creep: Creep) -> Self {
        self.options.creep = creep;
        self
    }

    /// Seed of every random number.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        self.options.seed = seed;
        self
    }

    /// Callback for progress; it may stop the fit, and the best model so far is then the result.
    #[must_use]
    pub fn watch(mut self, told: impl FnMut(&Event<'_>) -> ControlFlow<()> + Send + 'a) -> Self {
        self.watch = Watch::new(told);
        self
    }

    /// Handle that stops the fit from another thread; the best model so far is then the result.
    #[must_use]
    pub fn stop(mut self, stop: &Stop) -> Self {
        self.stop = stop.clone();
        self
    }

    /// Resumes an interrupted fit of the same records with the same options; the final result is
    /// bit-identical.
    #[must_use]
    pub fn resume(mut self, searches: Searches) -> Self {
        self.resume = Some(searches);
        self
    }

    /// Runs the identification.
    ///
    /// # Errors
    /// [`Error::Model`] for records that cannot be used; [`Error::Identify`] where no model describes them;
    /// [`Error::OptionsOfTask`], [`Error::OptionsOfKind`] for options that would have no effect.
    pub fn run(self) -> Result<Fit, Error> {
        let kind = match (self.kind, self.inputs.len()) {
            (Some(kind), _) => kind,
            (None, 0 | 1) if self.options != Options::default() => Kind::Hammerstein,
            (None, 0 | 1) => usual_kind(&self.single()?),
            (None, _) => Kind::Modes,
        };
        let task = match (&self.task, kind) {
            (Some(_), _) if self.options != Options::default() => return Err(Error::OptionsOfTask),
            (Some(task), _) => task.clone(),
            (None, Kind::Hammerstein) => Task::Hammerstein(Box::new(self.options.clone())),
            (None, kind) if self.options != Options::default() => return Err(Error::OptionsOfKind { kind }),
            (None, kind) => Task::of(kind),
        };
        let task = match &self.start {
            Some(model) => task.starting_from(model)?,
            None => task,
        };
        let records = if task.takes_several_axes() {
            FitRecords::Several(self.several()?)
        } else {
            let record = |data| CampaignRecord { data, role: None };
            FitRecords::Single(self.single()?.into_iter().map(record).collect())
        };
        let Self { watch, stop, resume, .. } = self;
        let watch = watch.stopped_by(&stop);
        let fit = || hysteron_identify::fit(&records, &task, &watch, resume, &maker());
        Ok(Fit::from(fit_on(task.threads(), fit)?))
    }

    fn single(&self) -> Result<Vec<InputOutput>, Error> {
        let choice =
            ChannelChoice { input: self.inputs.first().cloned(), output: self.outputs.first().cloned() };
        let read = |record: &Record| rated(record, &choice, self.rate.as_deref());
        self.records.iter().map(read).collect()
    }

    fn several(&self) -> Result<Vec<AxesRecord>, Error> {
        self.records.iter().map(|record| Ok(AxesRecord::new(record, &self.inputs, &self.outputs)?)).collect()
    }
}

/// Input and output of a record, with the measured rate of the input from a column of this name.
pub(crate) fn rated(
    record: &Record,
    choice: &ChannelChoice,
    rate: Option<&str>,
) -> Result<InputOutput, Error> {
    let data = record.input_output(choice)?;
    match rate {
        Some(column) => Ok(with_rate(data, record, column).map_err(SimulationError::from)?),
        None => Ok(data),
    }
}

/// Name and version of this library, and the current time.
pub(crate) fn maker() -> Maker {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    Maker {
        program: concat!("hysteron ", env!("CARGO_PKG_VERSION")).to_owned(),
        created: Some(timestamp(seconds)),
        command: None,
    }
}

/// An identified model with its scores, parameters and findings; its JSON is the output of
/// `hysteron identify --json`.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The model.
    pub model: Model,
    found: Found,
}

impl From<Found> for Fit {
    fn from(found: Found) -> Self {
        Self { model: found.model.clone().into(), found }
    }
}

impl Serialize for Fit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.found.serialize(serializer)
    }
}

impl Fit {
    /// Writes the model file.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        self.model.save(path)
    }

    /// Scores of the records that it was identified from.
    pub fn scores(&self) -> &[Score] {
        &self.found.scores
    }

    /// The parameters with their standard errors.
    pub fn parameters(&self) -> &[FitParameter] {
        &self.found.parameters
    }

    /// Verdicts, advice and warnings.
    pub fn findings(&self) -> &[Finding] {
        &self.found.findings
    }

    /// The fit was stopped; the model is the best so far.
    pub fn is_interrupted(&self) -> bool {
        self.found.interrupted
    }

    /// State of the searches, for [`Identify::resume`].
    pub fn searches(&self) -> &Searches {
        &self.found.resume
    }

    /// The identification in full.
    pub fn core(&self) -> &Found {
        &self.found
    }

    /// The next drive: the one after whose record the model is known best for a purpose, by this fit's
    /// covariance and residual.
    ///
    /// # Errors
    /// [`Error::Identify`].
    pub fn design(&self, options: &DesignOptions) -> Result<Design, Error> {
        Ok(design(&DesignBasis::of_fit(&self.found)?, options, Listener::silent())?)
    }

    /// The report of the fit: curves for a Hammerstein model; parameters, errors, scores and findings for the
    /// other kinds.
    ///
    /// # Errors
    /// [`Error::Model`] where the data of the model are not sound.
    pub fn report(&self) -> Result<Report, Error> {
        let name = self.model.core().name().unwrap_or("Identified model");
        Ok(Report(hysteron_report::fit::report(name, &self.found, None)?))
    }
}
