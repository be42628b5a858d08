//! Identification of a model of any kind, with its full results.

mod dead_band;
mod other_kinds;
mod summary;

pub use other_kinds::usual_kind;
pub use summary::*;

use hysteron_model::axes::AxesRecord;
use hysteron_model::model::{Capability, RunError, Score, Unsupported};
use hysteron_model::model_file::{Kind, Maker};
use hysteron_model::record::InputOutput;
use hysteron_model::validate::Scoring;
use hysteron_model::{Model, Start};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::coupled::{self, CoupledIdentification};
use crate::force;
use crate::misfit::Misfit;
use crate::modes::{self, ModesIdentification};
use crate::oscillator;
use crate::structure::{Neighbours, neighbours};
use crate::{
    CampaignRecord, FamilyChoice, Finding, Identification, IdentifyError, Interval, Options, RecordFit,
    Searches, Watch, identify,
};

/// A kind of model and what is asked of its identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", content = "options", rename_all = "kebab-case")]
pub enum Task {
    /// Hysteresis followed by linear dynamics.
    Hammerstein(Box<Options>),
    /// A mass on a hysteretic spring.
    Oscillator(oscillator::Options),
    /// Force against a displacement and its rate.
    Force(force::Options),
    /// Structural modes with hysteresis in feedback.
    Modes(modes::Options),
    /// A sum of Hammerstein branches.
    Branches(coupled::Options),
}

impl Task {
    /// A kind with the default options.
    pub fn of(kind: Kind) -> Self {
        match kind {
            Kind::Hammerstein => Self::Hammerstein(Box::default()),
            Kind::Oscillator => Self::Oscillator(oscillator::Options::default()),
            Kind::Force => Self::Force(force::Options::default()),
            Kind::Modes => Self::Modes(modes::Options::default()),
            Kind::Branches => Self::Branches(coupled::Options::default()),
        }
    }

    /// The kind of model that it makes.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Hammerstein(_) => Kind::Hammerstein,
            Self::Oscillator(_) => Kind::Oscillator,
            Self::Force(_) => Kind::Force,
            Self::Modes(_) => Kind::Modes,
            Self::Branches(_) => Kind::Branches,
        }
    }

    /// This task, starting from the parameters of a model.
    ///
    /// # Errors
    /// [`IdentifyError::Unsupported`] for a model of a kind that cannot be a start,
    /// [`IdentifyError::OtherStart`] for one of another kind than the task's.
    pub fn starting_from(mut self, model: &Model) -> Result<Self, IdentifyError> {
        Unsupported::check(model.kind(), Capability::StartOfFit)?;
        match (&mut self, model) {
            (Self::Hammerstein(options), Model::Hammerstein(body)) => {
                options.start = Some(body.law().clone());
            }
            (Self::Oscillator(options), Model::Oscillator(body)) => options.start = Some(*body.law()),
            _ => return Err(IdentifyError::OtherStart { wanted: self.kind(), found: model.kind() }),
        }
        Ok(self)
    }

    /// Names of the stages of the identification in their usual order, as far as they are known before: the
    /// name of an [`Event`](crate::Event)'s stage begins with one of them, and one may be left out. Empty for
    /// modes.
    pub fn stages(&self) -> Vec<&'static str> {
        match self {
            Self::Hammerstein(options) => {
                let families = (options.hysteresis == FamilyChoice::Auto).then_some(crate::FAMILIES);
                families.into_iter().chain(crate::plan(options).names()).collect()
            }
            Self::Oscillator(_) => oscillator::PLAN.names().collect(),
            Self::Force(_) => force::PLAN.names().collect(),
            Self::Modes(_) => Vec::new(),
            Self::Branches(_) => coupled::PLAN.names().collect(),
        }
    }

    /// Number of threads; `None`: all cores.
    pub fn threads(&self) -> Option<usize> {
        match self {
            Self::Hammerstein(options) => options.threads,
            Self::Oscillator(_) | Self::Force(_) | Self::Modes(_) | Self::Branches(_) => None,
        }
    }

    /// True if the task takes records with several inputs and outputs.
    pub fn takes_several_axes(&self) -> bool {
        matches!(self, Self::Modes(_) | Self::Branches(_))
    }
}

/// Records as a kind takes them.
#[derive(Clone, Debug, PartialEq)]
pub enum FitRecords {
    /// One input and one output: Hammerstein models, oscillators and forces.
    Single(Vec<CampaignRecord>),
    /// Several named inputs and outputs: modes and branches.
    Several(Vec<AxesRecord>),
}

/// An identified model with its scores, parameters and findings.
///
/// As JSON: scores, parameters, findings, and results specific to its kind.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The model, with its file's data.
    pub model: Model,
    /// Scores of every record that it was identified from.
    pub scores: Vec<Score>,
    /// Every parameter that was estimated or held; empty for modes, which have too many.
    pub parameters: Vec<FitParameter>,
    /// Verdicts, advice and warnings.
    pub findings: Vec<Finding>,
    /// Treatment of the data, in plain words.
    pub treatment: Vec<String>,
    /// The fit was stopped; the model is the best so far.
    pub interrupted: bool,
    /// State to resume from.
    pub resume: Searches,
    /// Results specific to the kind of model.
    pub found: FitDetails,
}

/// The identification in full, by kind.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum FitDetails {
    /// Of a Hammerstein model.
    Hammerstein(Box<Identification>),
    /// Of an oscillator.
    Oscillator(Box<oscillator::Identification>),
    /// Of a force.
    Force(Box<force::Identification>),
    /// Of modes.
    Modes(Box<ModesIdentification>),
    /// Of branches.
    Branches(Box<CoupledIdentification>),
}

/// A parameter of an identified model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FitParameter {
    /// Block, actuator or path it belongs to, where there are several.
    #[serde(flatten)]
    pub place: Option<Place>,
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Unit, empty for a pure number.
    pub unit: String,
    /// Standard error; `None` where the parameter was held or the data do not determine it.
    pub std_error: Option<f64>,
    /// 95 % confidence interval; a joint fit only.
    pub interval_95: Option<Interval>,
    /// It was held at this value.
    pub held: bool,
    /// It ended at a bound of its range.
    pub at_limit: bool,
}

/// Part of a model that a parameter belongs to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Place {
    /// A block of the model.
    Block(String),
    /// An actuator or a path, by the names of its signals.
    Of(String),
}

impl Fit {
    /// The identified modes; `None` for a fit of another kind.
    pub fn modes(&self) -> Option<&ModesIdentification> {
        match &self.found {
            FitDetails::Modes(found) => Some(found),
            _ => None,
        }
    }

    /// Each run as a whole, where records continue one another.
    pub fn runs(&self) -> &[RecordFit] {
        match &self.found {
            FitDetails::Hammerstein(found) => &found.runs,
            _ => &[],
        }
    }

    /// The structures next to the identified one, fitted to the same records; `None` for a kind that has no
    /// others.
    pub fn neighbours(
        &self,
        records: &FitRecords,
        task: &Task,
        watch: &Watch<'_>,
    ) -> Option<Result<Neighbours, IdentifyError>> {
        match (&self.found, records, task) {
            (FitDetails::Hammerstein(found), FitRecords::Single(records), Task::Hammerstein(options)) => {
                Some(neighbours(records, options, found, watch))
            }
            _ => None,
        }
    }
}

/// Identifies a model of the kind that `task` asks for. `resume`: searches of an interrupted fit of the same
/// records.
///
/// # Errors
/// [`IdentifyError`].
pub fn fit(
    records: &FitRecords,
    task: &Task,
    watch: &Watch<'_>,
    resume: Option<Searches>,
    maker: &Maker,
) -> Result<Fit, IdentifyError> {
    let others = |kind: Kind, expected| IdentifyError::Records { kind, expected };
    match (task, records) {
        (Task::Hammerstein(options), FitRecords::Single(records)) => {
            let found = identify(records, options, watch, resume)
                .map_err(|error| other_kinds::instead(error, records, watch))?;
            let said = other_kinds::weigh(&found, records, options, watch)?;
            let mut fit = hammerstein(found, options, maker)?;
            fit.findings.extend(said);
            Ok(fit)
        }
        (Task::Oscillator(options), FitRecords::Single(records)) => {
            let records: Vec<InputOutput> = records.iter().map(|r| r.data.clone()).collect();
            let found = oscillator::identify(&records, options, watch, resume)?;
            oscillator_fit(found, options, maker)
        }
        (Task::Force(options), FitRecords::Single(records)) => {
            let records: Vec<InputOutput> = records.iter().map(|r| r.data.clone()).collect();
            let found = force::identify(&records, options, watch, resume)?;
            force_fit(found, options, maker)
        }
        (Task::Modes(options), FitRecords::Several(records)) => {
            let found = modes::identify(records, options, watch, resume)?;
            modes_fit(found, records, options, maker)
        }
        (Task::Branches(options), FitRecords::Several(records)) => {
            let found = coupled::identify(records, options, watch, resume)?;
            branches_fit(found, records, maker)
        }
        (Task::Hammerstein(_), _) => Err(others(Kind::Hammerstein, "one input and one output")),
        (Task::Oscillator(_), _) => Err(others(Kind::Oscillator, "one input and one output")),
        (Task::Force(_), _) => Err(others(Kind::Force, "one input and one output")),
        (Task::Modes(_), _) => Err(others(Kind::Modes, "several named inputs and outputs")),
        (Task::Branches(_), _) => Err(others(Kind::Branches, "several named inputs and outputs")),
    }
}

/// [`fit`] on `threads` threads; the result does not depend on their number.
///
/// # Errors
/// Those of [`fit`]; [`IdentifyError::Threads`].
pub fn fit_on(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<Fit, IdentifyError> + Send,
) -> Result<Fit, IdentifyError> {
    let Some(threads) = threads else { return work() };
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        Err(e) => Err(IdentifyError::Threads { threads, reason: e.to_string() }),
    }
}

fn hammerstein(mut found: Identification, options: &Options, maker: &Maker) -> Result<Fit, IdentifyError> {
    let (file, misfit) = found.written(options, maker);
    found.findings.extend(misfit.iter().flat_map(Misfit::findings));
    let parameters = found.parameters.iter().map(|p| FitParameter {
        place: Some(Place::Block(p.block().to_owned())),
        name: p.name.clone(),
        value: p.value,
        unit: p.unit(&file),
        std_error: p.std_error,
        interval_95: p.interval,
        held: p.held,
        at_limit: false,
    });
    Ok(Fit {
        parameters: parameters.collect(),
        model: Model::try_from(file)?,
        scores: found.records.iter().map(RecordFit::score).collect(),
        findings: found.findings.clone(),
        treatment: found.treatment.clone(),
        interrupted: found.cancelled,
        resume: found.resume.clone(),
        found: FitDetails::Hammerstein(Box::new(found)),
    })
}

fn oscillator_fit(
    found: oscillator::Identification,
    options: &oscillator::Options,
    maker: &Maker,
) -> Result<Fit, IdentifyError> {
    let file = found.model_file(options, maker);
    let parameters = found.estimates.iter().map(|e| FitParameter {
        place: None,
        name: e.name.to_owned(),
        value: e.value,
        unit: e.unit(&file),
        std_error: e.std_error,
        interval_95: None,
        held: e.held,
        at_limit: e.at_limit,
    });
    Ok(Fit {
        parameters: parameters.collect(),
        model: Model::try_from(file)?,
        scores: found.records.iter().map(oscillator::RecordFit::score).collect(),
        findings: found.findings.clone(),
        treatment: found.treatment.clone(),
        interrupted: found.interrupted,
        resume: found.resume.clone(),
        found: FitDetails::Oscillator(Box::new(found)),
    })
}

fn force_fit(
    found: force::Identification,
    options: &force::Options,
    maker: &Maker,
) -> Result<Fit, IdentifyError> {
    let mut file = found.model_file(options, maker);
    let parameters = found.estimates.iter().map(|e| FitParameter {
        place: None,
        name: e.name.clone(),
        value: e.value,
        unit: file.quantity_mut(&e.name).map_or_else(String::new, |quantity| quantity.unit.clone()),
        std_error: e.std_error,
        interval_95: None,
        held: e.held,
        at_limit: e.at_limit,
    });
    Ok(Fit {
        parameters: parameters.collect(),
        model: Model::try_from(file)?,
        scores: found.records.iter().map(force::RecordFit::score).collect(),
        findings: found.findings.clone(),
        treatment: found.treatment.clone(),
        interrupted: found.interrupted,
        resume: found.resume.clone(),
        found: FitDetails::Force(Box::new(found)),
    })
}

fn modes_fit(
    found: ModesIdentification,
    records: &[AxesRecord],
    options: &modes::Options,
    maker: &Maker,
) -> Result<Fit, IdentifyError> {
    let file = found.model_file(records, options, maker);
    let parameters = file.quantities.iter().map(|q| FitParameter {
        place: Some(Place::Of(q.of.clone())),
        name: q.name.clone(),
        value: q.value,
        unit: q.unit.clone(),
        std_error: q.std_error,
        interval_95: None,
        held: false,
        at_limit: false,
    });
    let parameters = parameters.collect();
    let model = Model::try_from(file)?;
    // A record fitted as a single period is scored as one.
    let start = |record: &AxesRecord| {
        let whole =
            |fit: &&modes::ModesRecordFit| fit.record == record.label() && fit.period_samples == record.len();
        match found.records.iter().find(whole) {
            Some(fit) => Start::settled(fit.period_samples),
            None => Start::AsIdentified,
        }
    };
    Ok(Fit {
        scores: scores(&model, records, start)?,
        model,
        parameters,
        findings: found.findings.clone(),
        treatment: found.treatment.clone(),
        interrupted: found.interrupted,
        resume: found.resume.clone(),
        found: FitDetails::Modes(Box::new(found)),
    })
}

fn branches_fit(
    found: CoupledIdentification,
    records: &[AxesRecord],
    maker: &Maker,
) -> Result<Fit, IdentifyError> {
    let file = found.model_file(records, maker);
    let parameters = file.parameters().into_iter().map(|(of, name, q)| FitParameter {
        place: Some(Place::Of(of)),
        name: name.to_owned(),
        value: q.value,
        unit: q.unit.clone(),
        std_error: q.std_error,
        interval_95: None,
        held: false,
        at_limit: false,
    });
    let parameters = parameters.collect();
    let model = Model::try_from(file)?;
    Ok(Fit {
        scores: scores(&model, records, |_| Start::AsIdentified)?,
        model,
        parameters,
        findings: found.findings.clone(),
        treatment: Vec::new(),
        interrupted: found.interrupted,
        resume: found.resume.clone(),
        found: FitDetails::Branches(Box::new(found)),
    })
}

fn scores(
    model: &Model,
    records: &[AxesRecord],
    start: impl Fn(&AxesRecord) -> Start,
) -> Result<Vec<Score>, RunError> {
    let score = |r: &AxesRecord| model.score(&r.clone().into(), start(r), &Scoring::default());
    records.iter().map(score).collect()
}
