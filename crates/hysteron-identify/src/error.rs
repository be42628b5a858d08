//! Errors of an identification.

use crate::baselines::BaselineError;
use crate::structure::UnknownCandidate;
use hysteron_model::Advice;
use hysteron_model::axes::AxesError;
use hysteron_model::dynamics::DynamicsError;
use hysteron_model::hammerstein::SimulationError;
use hysteron_model::hysteresis::{HysteresisError, HysteresisForm};
use hysteron_model::model::{RunError, Unsupported};
use hysteron_model::model_file::{Kind, ModelFileError};
use hysteron_model::record::RecordError;
use hysteron_model::validate::ScoreError;
use hysteron_numeric::display::{exact, short};
use hysteron_optimize::OptimizeError;
use hysteron_rt::{ParameterError, SampleError};

/// Error of this crate: no model was identified, or a request to one cannot be met.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// No record was given.
    #[error("no record was given")]
    NoRecords,
    /// Creep is fitted with the rest of the dynamics.
    #[error(
        "creep belongs to the joint fit, and neither the two-step method nor ARX, OE, BJ or SRIVC blocks \
         have it"
    )]
    CreepTakesJointFit,
    /// The two-step method, and the blocks that need it, are for the default family only.
    #[error(
        "the two-step method, which ARX, OE, BJ and SRIVC blocks need, identifies hysteresis {} only",
        HysteresisForm::default().name()
    )]
    FamilyTakesJointFit,
    /// A demand names a parameter that this fit does not have.
    #[error("there is no parameter '{name}' in this fit; its parameters are {known}")]
    UnknownParameter {
        /// As demanded.
        name: String,
        /// The names there are.
        known: String,
    },
    /// A demand that cannot be met.
    #[error("parameter '{name}': needs {wanted}")]
    Demand {
        /// Parameter.
        name: String,
        /// Accepted values.
        wanted: &'static str,
    },
    /// An option out of range.
    #[error("option {option} = {value}: needs {wanted}", value = exact(*.value))]
    Option {
        /// Option.
        option: &'static str,
        /// As given.
        value: f64,
        /// Accepted values.
        wanted: &'static str,
    },
    /// A designed drive too short or too long.
    #[error(
        "a drive of {} s at {} Hz cannot be designed: from {} to {} s can, 400 to 4 000 000 samples",
        short(*.time_s),
        short(*.rate_hz),
        short(*.least_s),
        short(*.most_s)
    )]
    DesignTime {
        /// Length asked for \[s\].
        time_s: f64,
        /// Sample rate \[Hz\].
        rate_hz: f64,
        /// Shortest \[s\].
        least_s: f64,
        /// Longest \[s\].
        most_s: f64,
    },
    /// A record with a constant input or output.
    #[error(
        "record '{record}': the {signal} is constant ({}), so nothing can be identified from it",
        short(*.value)
    )]
    Constant {
        /// Record.
        record: String,
        /// `input` or `output`.
        signal: &'static str,
        /// Its value.
        value: f64,
    },
    /// Too few usable samples.
    #[error("record '{record}': need at least {need} valid samples but found {found}")]
    TooFewSamples {
        /// Record.
        record: String,
        /// Needed.
        need: usize,
        /// Found.
        found: usize,
    },
    /// The units of two records differ.
    #[error("record '{record}' is in {found}, the other records are in {expected}")]
    Units {
        /// Record.
        record: String,
        /// Its units, input and output.
        found: String,
        /// Those of the first record.
        expected: String,
    },
    /// Dynamics need a uniform time base.
    #[error(
        "record '{record}' has {found}: dynamics and a delay need uniformly sampled records (a static fit \
         does not)"
    )]
    NotUniform {
        /// Record.
        record: String,
        /// Time base found.
        found: &'static str,
    },
    /// Dynamics were asked for but no record carries them.
    #[error("no record determines {wanted} dynamics: {because}")]
    NoDynamicInformation {
        /// Dynamics asked for.
        wanted: &'static str,
        /// Why not.
        because: String,
    },
    /// A record declared periodic is not.
    #[error("record '{record}' is not a periodic steady state: {found}")]
    NotPeriodic {
        /// Record.
        record: String,
        /// Behaviour found.
        found: String,
    },
    /// The model class does not describe the record.
    #[error(
        "the model class (hysteresis followed by linear dynamics) does not describe record '{record}': the \
         best fit explains {fit_percent:.1} % of it, {need} % are needed. {because}",
        need = exact(*.need)
    )]
    ModelClass {
        /// Record.
        record: String,
        /// Fit [%], see [`hysteron_model::validate::Scores`].
        fit_percent: f64,
        /// Least fit accepted [%].
        need: f64,
        /// Evidence against the model class.
        because: String,
    },
    /// A model of another kind describes the record, where hysteresis followed by linear dynamics does not.
    #[error(
        "hysteresis followed by linear dynamics explains {fit_percent:.1} % of record '{record}', a model of the \
         kind {kind} {other_percent:.1} %"
    )]
    OtherKind {
        /// Record.
        record: String,
        /// Fit of hysteresis followed by linear dynamics [%], see [`hysteron_model::validate::Scores`].
        fit_percent: f64,
        /// The kind that describes it.
        kind: Kind,
        /// Fit of that kind to the record that it describes worst [%].
        other_percent: f64,
    },
    /// A drive with a dead band describes the record, where hysteresis followed by linear dynamics does not.
    #[error(
        "hysteresis followed by linear dynamics explains {fit_percent:.1} % of record '{record}'; a drive below \
         {threshold}{space}{unit} moves nothing there: where it {counts}, a linear regression explains \
         {other_percent:.1} %",
        space = if .unit.is_empty() { "" } else { " " }
    )]
    DeadBand {
        /// Record.
        record: String,
        /// Fit of hysteresis followed by linear dynamics [%], see [`hysteron_model::validate::Scores`].
        fit_percent: f64,
        /// Threshold, in the unit of the drive.
        threshold: String,
        /// That unit.
        unit: String,
        /// How the drive counts.
        counts: &'static str,
        /// A larger drive counts by what exceeds the threshold.
        excess: bool,
        /// Share of the record that a regression with the dead band explains [%].
        other_percent: f64,
    },
    /// A record that a model does not describe, even with the best gain, delay and offset.
    #[error(
        "record '{record}' contradicts the model: with the best gain, delay and offset it explains \
         {fit_percent:.1} % of it, {need} % are needed",
        need = exact(*.need)
    )]
    OtherDevice {
        /// Record.
        record: String,
        /// Fit [%], see [`hysteron_model::validate::Scores`].
        fit_percent: f64,
        /// Least fit accepted [%].
        need: f64,
    },
    /// An unsuitable model to start from.
    #[error("the model to start from: {wanted}")]
    StartModel {
        /// Requirement.
        wanted: &'static str,
    },
    /// A record is not usable.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The search failed.
    #[error(transparent)]
    Optimize(#[from] OptimizeError),
    /// The identified model could not be simulated.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The dynamic block could not be set up.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// The fit could not be scored.
    #[error(transparent)]
    Score(#[from] ScoreError),
    /// A model file without the covariance of its parameters.
    #[error(
        "the model file holds no correlation of its numbers, so their errors cannot be propagated to the \
         output"
    )]
    NoCorrelation,
    /// A model file without scores, so that the measurement scatter is unknown.
    #[error("the model file holds no scores, so the scatter of measurements about the model is unknown")]
    NoScores,
    /// A purpose of an experiment that the model gives no meaning, or that is known already.
    #[error(
        "there is nothing to design for the {what}: the model has none, or its file states no standard error \
         of the numbers concerned"
    )]
    NothingUncertain {
        /// Purpose.
        what: &'static str,
    },
    /// Dynamics cannot be assumed beside sampled ones.
    #[error("no dynamics can be assumed beside an ARX block: identify integer or fractional ones")]
    SampledDynamics,
    /// An invalid model file.
    #[error(transparent)]
    ModelFile(#[from] ModelFileError),
    /// The records cannot discriminate between structures.
    #[error("{because}")]
    CannotRank {
        /// Why not.
        because: String,
        /// Recommended measurement.
        measure: String,
    },
    /// Simulating an oscillator needs a uniform time base.
    #[error("record '{record}' has no uniform sample rate: the motion of a mass cannot be followed")]
    OscillatorNotUniform {
        /// Record.
        record: String,
    },
    /// A parameter of an oscillator cannot be held.
    #[error("parameter '{name}' = {value}: {wanted}", value = exact(*.value))]
    OscillatorFixed {
        /// Parameter.
        name: String,
        /// Value demanded.
        value: f64,
        /// Accepted values.
        wanted: &'static str,
    },
    /// The records do not look like a mass on a spring.
    #[error(
        "the records are not those of a mass on a spring: the best linear oscillator has m = {mass:.3e}, c = \
         {damping:.3e}, k = {stiffness:.3e} (force over acceleration, velocity and displacement); all of \
         them should be positive"
    )]
    NoOscillator {
        /// Its mass.
        mass: f64,
        /// Its damping.
        damping: f64,
        /// Its stiffness.
        stiffness: f64,
    },
    /// No shape of the loop gives an oscillator that can be simulated.
    #[error("no loop was found with which the oscillator can be simulated under the force of these records")]
    NoLoop,
    /// The oscillator does not describe the record.
    #[error(
        "a mass on a hysteretic spring does not describe record '{record}': the best fit explains \
         {fit_percent:.1} % of it, {need} % are needed",
        need = exact(*.need)
    )]
    OscillatorClass {
        /// Record.
        record: String,
        /// Fit \[%\], see [`hysteron_model::validate::Scores`].
        fit_percent: f64,
        /// Least fit accepted \[%\].
        need: f64,
    },
    /// Invalid drive between its samples.
    #[error(transparent)]
    Hysteresis(#[from] HysteresisError),
    /// The checkpoint of modes to resume from belongs to another problem.
    #[error("the interrupted search is of other records or options")]
    Resume,
    /// Stopped too early.
    #[error("the fit was stopped before there was a model")]
    Stopped,
    /// A record or model of several axes that cannot be used.
    #[error(transparent)]
    Axes(#[from] AxesError),
    /// Records of different rate, channels or units.
    #[error("records `{first}` and `{other}` differ in their {what}: {of_first} and {of_other}")]
    Different {
        /// One record.
        first: String,
        /// Another.
        other: String,
        /// In what they differ.
        what: &'static str,
        /// Value of the first.
        of_first: String,
        /// Value of the other.
        of_other: String,
    },
    /// An option of a fit of modes that cannot be met.
    #[error("{name} is {value}: expected {expected}", value = exact(*.value))]
    ModesOption {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Allowed values.
        expected: &'static str,
    },
    /// No mode was found.
    #[error(
        "no lightly damped mode was found in the frequency response up to {top_hz:.1} Hz: nothing resonates \
         there"
    )]
    NoModes {
        /// Highest excited frequency \[Hz\].
        top_hz: f64,
    },
    /// Actuators that the outputs cannot distinguish.
    #[error(
        "the influence matrix is singular (condition number {condition:.1e}): the outputs do not distinguish \
         the inputs at slow movement"
    )]
    Singular {
        /// Condition number.
        condition: f64,
    },
    /// The model of several axes does not describe a record.
    #[error(
        "the {what} do not describe record `{record}`: the best fit explains {fit_percent:.1} % of it, \
         {need} % are needed",
        need = exact(*.need)
    )]
    AxesClass {
        /// `modes` or `branches`.
        what: &'static str,
        /// Record.
        record: String,
        /// Fit \[%\].
        fit_percent: f64,
        /// Least fit accepted \[%\].
        need: f64,
    },
    /// No records to fit branches to, or none with outputs.
    #[error("no records with inputs and outputs were given")]
    NoOutputs,
    /// No branches could be simulated, or the inputs are not distinguishable.
    #[error(
        "no branches can be fitted: an input does not move, or moves together with another in all records"
    )]
    NoBranches,
    /// The kind of model takes other records.
    #[error("{kind} takes records of {expected}")]
    Records {
        /// Kind of model asked for.
        kind: Kind,
        /// Records it takes.
        expected: &'static str,
    },
    /// A model of this kind cannot be a start.
    #[error(transparent)]
    Unsupported(#[from] Unsupported),
    /// A start of another kind.
    #[error("a fit of the kind \"{wanted}\" begins with a model of that kind, not of \"{found}\"")]
    OtherStart {
        /// Kind that is fitted.
        wanted: Kind,
        /// Kind of the start.
        found: Kind,
    },
    /// The model found cannot be scored on its records.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The number of threads is not available.
    #[error("cannot work on {threads} threads: {reason}")]
    Threads {
        /// Threads asked for.
        threads: usize,
        /// Why not.
        reason: String,
    },
    /// A force against a displacement.
    #[error(transparent)]
    Force(#[from] crate::force::ForceError),
    /// A frequency response without a fitted structure.
    #[error("no structure was fitted to the frequency response")]
    NoStructure,
    /// Too few points of a frequency response for the parameters.
    #[error(
        "{found} points of `{name}` between {low_hz} and {high_hz} Hz; {structure} with {parameters} \
         parameters needs at least {need}: take a wider band or a simpler structure",
        low_hz = exact(*.low_hz),
        high_hz = exact(*.high_hz)
    )]
    TooFewPoints {
        /// The response.
        name: String,
        /// Lower end of the band \[Hz\].
        low_hz: f64,
        /// Upper end \[Hz\].
        high_hz: f64,
        /// The structure.
        structure: String,
        /// Its parameters.
        parameters: usize,
        /// Points needed.
        need: usize,
        /// Points there are.
        found: usize,
    },
    /// A structure outside the range that can be fitted to a frequency response.
    #[error("{what} is {found}; allowed is {allowed}")]
    ResponseStructure {
        /// Quantity out of range.
        what: &'static str,
        /// Found.
        found: usize,
        /// Allowed range.
        allowed: &'static str,
    },
    /// No start of a fit to a frequency response could be evaluated.
    #[error("no start for {structure} could be evaluated on `{name}`")]
    NoResponseStart {
        /// The structure.
        structure: String,
        /// The response.
        name: String,
    },
    /// A frequency response whose linear equations have no solution.
    #[error(
        "the response at {points} frequencies does not determine the {coefficients} coefficients of the \
         transfer function"
    )]
    Undetermined {
        /// Number of frequencies.
        points: usize,
        /// Coefficients wanted.
        coefficients: usize,
    },
    /// Records that do not allow an empirical frequency response.
    #[error("cannot take a frequency response from `{record}`: {problem}")]
    NoResponse {
        /// The record.
        record: String,
        /// Problem and remedy.
        problem: String,
        /// Remedy, typed.
        advice: Option<Advice>,
    },
    /// A structure that no model file can hold.
    #[error("{structure} is no transfer function: {problem}")]
    NoTransferFunction {
        /// The structure.
        structure: String,
        /// Why.
        problem: String,
    },
    /// Text that names no structure.
    #[error(transparent)]
    Candidate(#[from] UnknownCandidate),
    /// A baseline.
    #[error(transparent)]
    Baseline(#[from] BaselineError),
    /// A term of a correction with a number out of its range.
    #[error("term {index} (from 0): {name} is {value}, it must be {must}", value = exact(*.value))]
    CorrectionTerm {
        /// Number of the term, from 0.
        index: usize,
        /// Name of the number.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Requirement.
        must: &'static str,
    },
    /// A duplicate term of a correction.
    #[error("term {index} (from 0) is a duplicate: the coefficients cannot be distinguished")]
    CorrectionTwice {
        /// Index of the duplicate, from 0.
        index: usize,
    },
    /// A creep term over a record without a sample rate.
    #[error("a creep term needs the time between samples, but the record has no uniform sample rate")]
    CorrectionNoRate,
    /// The regressors of a correction do not have one row per sample.
    #[error("the record has {found} samples but the regressors {expected}: make them from this record")]
    CorrectionLengths {
        /// Rows of the regressors.
        expected: usize,
        /// Samples of the record.
        found: usize,
    },
    /// A creep coefficient that a Hammerstein model has no place for.
    #[error(
        "term {index} (from 0) creeps by {value}: a model file has no place for it; leave creep terms out",
        value = exact(*.value)
    )]
    CorrectionCreep {
        /// Number of the term, from 0.
        index: usize,
        /// Its coefficient.
        value: f64,
    },
    /// Invalid settings of an online estimator or monitor.
    #[error(transparent)]
    OnlineSettings(#[from] ParameterError<f64>),
    /// A sample that an online estimator cannot use.
    #[error("sample {index}: {cause}")]
    OnlineSample {
        /// Its number, from 0.
        index: usize,
        /// Why.
        cause: SampleError,
    },
    /// No terms to track, or too many.
    #[error("between one and six terms can be followed, not {0}")]
    FollowTerms(usize),
    /// A non-uniformly sampled record for tracking.
    #[error("it has no uniform sample rate, and a memory is a number of samples")]
    FollowNotUniform,
}

impl IdentifyError {
    /// Remedy, where there is one that the user can choose.
    pub fn advice(&self) -> Option<Advice> {
        match self {
            Self::CreepTakesJointFit | Self::FamilyTakesJointFit => Some(Advice::FitJointly),
            Self::NotUniform { .. } => Some(Advice::NoDynamics),
            Self::NoDynamicInformation { .. } => Some(Advice::NameDynamicRecord),
            Self::Constant { .. } | Self::Units { .. } | Self::OtherDevice { .. } => {
                Some(Advice::ChooseColumns)
            }
            Self::OtherKind { kind, .. } => Some(Advice::OtherKind { kind: *kind }),
            Self::DeadBand { threshold, excess, .. } => {
                Some(Advice::DeadBand { threshold: threshold.clone(), excess: *excess })
            }
            Self::OscillatorNotUniform { .. } => Some(Advice::Resample),
            Self::NoResponse { advice, .. } => advice.clone(),
            Self::Record(e) => e.advice(),
            Self::Axes(e) => e.advice(),
            _ => None,
        }
    }
}
