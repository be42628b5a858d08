//! From records to a model.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use hysteron_identify::{
    CampaignRecord, DynamicsChoice, Event, Finding, Identification, Options, Told, coupled, identify, modes,
    oscillator,
};
use hysteron_model::Model as Core;
use hysteron_model::axes::AxesRecord;
use hysteron_model::dynamics::Creep;
use hysteron_model::hysteresis::HysteresisForm;
use hysteron_model::model_file::{Kind, Maker, ModelFile, timestamp};
use hysteron_model::record::{ChannelChoice, Record};
use hysteron_report::{identification, model};

use crate::{Error, Model, Report};

type Watching<'a> = Box<dyn FnMut(&Event<'_>) -> ControlFlow<()> + 'a>;

/// An identification to be run: records and what is asked of it. What is not asked is chosen from the records.
pub struct Identify<'a> {
    records: &'a [Record],
    kind: Option<Kind>,
    inputs: Vec<String>,
    outputs: Vec<String>,
    options: Options,
    watching: Option<Watching<'a>>,
}

impl<'a> Identify<'a> {
    /// Of these records, all of one device.
    pub fn new(records: &'a [Record]) -> Self {
        Self {
            records,
            kind: None,
            inputs: Vec::new(),
            outputs: Vec::new(),
            options: Options::default(),
            watching: None,
        }
    }

    /// Kind of model; else a Hammerstein model, or modes where several inputs are named.
    #[must_use]
    pub fn kind(mut self, kind: Kind) -> Self {
        self.kind = Some(kind);
        self
    }

    /// Names of the input and output columns; else the channels that look like them.
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

    /// Family of the hysteresis block of a Hammerstein model.
    #[must_use]
    pub fn hysteresis(mut self, family: HysteresisForm) -> Self {
        self.options.hysteresis = family;
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

    /// Told about the progress; may stop the fit, whose best so far is then the result.
    #[must_use]
    pub fn watch(mut self, watching: impl FnMut(&Event<'_>) -> ControlFlow<()> + 'a) -> Self {
        self.watching = Some(Box::new(watching));
        self
    }

    /// Runs the identification.
    ///
    /// # Errors
    /// [`Error::Record`], [`Error::Axes`] for records that cannot be used; [`Error::Identify`], [`Error::Oscillator`],
    /// [`Error::Modes`], [`Error::Branches`] where no model describes them.
    pub fn run(mut self) -> Result<Fit, Error> {
        let mut silent = |_: &Event<'_>| ControlFlow::Continue(());
        let mut watching = self.watching.take();
        let mut told = match &mut watching {
            Some(watching) => Told(watching),
            None => Told(&mut silent),
        };
        let several = self.inputs.len() > 1;
        match self.kind.unwrap_or(if several { Kind::Modes } else { Kind::Hammerstein }) {
            Kind::Hammerstein => {
                let campaign = self.single()?.into_iter().map(|data| CampaignRecord { data, role: None });
                let campaign: Vec<_> = campaign.collect();
                let found = identify(&campaign, &self.options, &mut told, None)?;
                let data = found.model_file(&self.options, &maker());
                let (findings, interrupted) = (found.findings.clone(), found.cancelled);
                let shown = Some(Box::new((found, data.clone())));
                Ok(Fit { model: Core::try_from(data)?.into(), findings, interrupted, shown })
            }
            Kind::Oscillator => {
                let options = oscillator::Options::default();
                let found = oscillator::identify(&self.single()?, &options)?;
                let model = Core::try_from(found.model_file(&options, &maker()))?.into();
                Ok(Fit { model, findings: found.findings, interrupted: false, shown: None })
            }
            Kind::Modes => {
                let (records, options) = (self.axes()?, modes::Options::default());
                let found = modes::identify(&records, &options, &mut |progress| told.modes(progress))?;
                let model = Core::try_from(found.model_file(&records, &options, &maker()))?.into();
                Ok(Fit { model, findings: found.findings, interrupted: found.interrupted, shown: None })
            }
            Kind::Branches => {
                let records = self.axes()?;
                let least_fit = self.options.least_fit_percent;
                let mut stopped = false;
                let mut observer = |progress: &hysteron_optimize::Progress<'_>| {
                    let asked = told.search("branches", progress);
                    stopped |= asked.is_break();
                    asked
                };
                let found = coupled::identify(&records, least_fit, &mut observer)?;
                let model = Core::try_from(found.model_file(&records, &maker()))?.into();
                Ok(Fit { model, findings: found.findings, interrupted: stopped, shown: None })
            }
        }
    }

    fn single(&self) -> Result<Vec<hysteron_model::record::InputOutput>, Error> {
        let choice =
            ChannelChoice { input: self.inputs.first().cloned(), output: self.outputs.first().cloned() };
        self.records.iter().map(|record| Ok(record.input_output(&choice)?)).collect()
    }

    fn axes(&self) -> Result<Vec<AxesRecord>, Error> {
        self.records.iter().map(|record| Ok(AxesRecord::new(record, &self.inputs, &self.outputs)?)).collect()
    }
}

/// This library, now.
fn maker() -> Maker {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    Maker {
        program: concat!("hysteron ", env!("CARGO_PKG_VERSION")).to_owned(),
        created: Some(timestamp(seconds)),
        command: None,
    }
}

/// An identified model and what is to be known about it.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The model.
    pub model: Model,
    /// Verdicts, advice and warnings.
    pub findings: Vec<Finding>,
    /// The fit was stopped; the model is the best so far.
    pub interrupted: bool,
    shown: Option<Box<(Identification, ModelFile)>>,
}

impl Fit {
    /// Writes the model file.
    ///
    /// # Errors
    /// [`Error::ModelFile`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        self.model.save(path)
    }

    /// The identification in full, of a Hammerstein model.
    pub fn identification(&self) -> Option<&Identification> {
        self.shown.as_ref().map(|shown| &shown.0)
    }

    /// The report of the fit: for a Hammerstein model with curves, for the other kinds numbers, errors, scores and findings.
    ///
    /// # Errors
    /// [`Error::Model`] where the data of the model are not sound.
    pub fn report(&self) -> Result<Report, Error> {
        let name = self.model.core().name().unwrap_or("Identified model");
        Ok(Report(match self.shown.as_deref() {
            Some((found, data)) => identification::report(name, found, data, None),
            None => model::report(name, self.model.core(), &self.findings)?,
        }))
    }
}
