//! What can go wrong between records and a model.

use hysteron_model::Advice;
use hysteron_model::dynamics::DynamicsError;
use hysteron_model::hammerstein::SimulationError;
use hysteron_model::record::RecordError;
use hysteron_model::validate::ScoreError;
use hysteron_numeric::display::short;
use hysteron_optimize::OptimizeError;

/// Why no model was identified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// No record was given.
    #[error("no record was given")]
    NoRecords,
    /// Creep is fitted with the rest of the dynamics.
    #[error(
        "creep belongs to the joint fit, and neither the two-step method nor ARX, OE, BJ or SRIVC blocks have it"
    )]
    CreepTakesJointFit,
    /// Two steps, and the blocks that need them, belong to Bouc–Wen.
    #[error(
        "the two-step method, which ARX, OE, BJ and SRIVC blocks need, identifies Bouc–Wen hysteresis only"
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
        /// What would be accepted.
        wanted: &'static str,
    },
    /// An option out of range.
    #[error("option {option} = {value}: needs {wanted}")]
    Option {
        /// Option.
        option: &'static str,
        /// As given.
        value: f64,
        /// What would be accepted.
        wanted: &'static str,
    },
    /// A record whose input or output never moves.
    #[error("record '{record}': the {signal} is constant ({}), so nothing can be identified from it", short(*.value))]
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
        "record '{record}' has {found}: dynamics and a delay need uniformly sampled records (a static fit does not)"
    )]
    NotUniform {
        /// Record.
        record: String,
        /// What it has instead.
        found: &'static str,
    },
    /// Dynamics were asked for but no record carries them.
    #[error("no record determines {wanted} dynamics: {because}")]
    NoDynamicInformation {
        /// What was asked for.
        wanted: &'static str,
        /// Why not.
        because: String,
    },
    /// A record that was said to repeat does not.
    #[error("record '{record}' is not a periodic steady state: {found}")]
    NotPeriodic {
        /// Record.
        record: String,
        /// What it is instead.
        found: String,
    },
    /// The model class does not describe the record.
    #[error(
        "the model class (Bouc–Wen hysteresis and linear dynamics) does not describe record '{record}': the best fit \
         explains {fit_percent:.1} % of it, {need} % are needed. {because}"
    )]
    ModelClass {
        /// Record.
        record: String,
        /// Fit [%], see [`hysteron_model::validate::Scores`].
        fit_percent: f64,
        /// Least fit accepted [%].
        need: f64,
        /// What the record looks like instead.
        because: String,
    },
    /// A record that a model does not describe, whatever its gain, delay and offset.
    #[error(
        "record '{record}' contradicts the model: with the best gain, delay and offset it explains {fit_percent:.1} % of it, \
         {need} % are needed"
    )]
    OtherDevice {
        /// Record.
        record: String,
        /// Fit [%], see [`hysteron_model::validate::Scores`].
        fit_percent: f64,
        /// Least fit accepted [%].
        need: f64,
    },
    /// A model to start from that does not suit.
    #[error("the model to start from: {wanted}")]
    StartModel {
        /// What is needed.
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
            Self::Record(e) => e.advice(),
            _ => None,
        }
    }
}
