//! Errors of running a model on a record.

use crate::axes::AxesError;
use crate::decoupling::DecouplingError;
use crate::hammerstein::SimulationError;
use crate::misfit::NotCorrected;
use crate::model::Unsupported;
use crate::model_file::Kind;
use crate::record::Unit;
use crate::validate::ScoreError;
use hysteron_numeric::display::short;

/// One of a model's signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignalRole {
    /// The drive.
    Input,
    /// The measured output.
    Output,
    /// The desired output.
    Reference,
}

impl SignalRole {
    /// `input`, `output` or `reference`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Input => "input",
            Self::Output => "output",
            Self::Reference => "reference",
        }
    }
}

/// Error of simulating or scoring a model on a record.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// Model and record are in units that do not convert.
    #[error("the model's {} is in {model}, the record's in {record}", signal.name())]
    Unit {
        /// Which signal.
        signal: SignalRole,
        /// Unit of the model.
        model: Unit,
        /// Unit of the record.
        record: Unit,
    },
    /// The signals are those of another kind of model.
    #[error("a model of the kind \"{kind}\" takes {expected}")]
    Signals {
        /// The kind of the model.
        kind: Kind,
        /// The signals it takes.
        expected: &'static str,
    },
    /// A rest voltage or a memory is given to a model that has none.
    #[error(
        "a model of the kind \"{kind}\" starts from rest at its first sample, or settled on a period: a rest \
         voltage or a hysteresis memory does not apply"
    )]
    RestVoltage {
        /// The kind of the model.
        kind: Kind,
    },
    /// A period is given with which the drive does not repeat.
    #[error("the drive does not repeat every {period_samples} samples, as a settled start says")]
    NotRepeating {
        /// Samples of the period.
        period_samples: usize,
    },
    /// The motion of a mass needs the time between samples.
    #[error("the record has no uniform sample rate: the motion of a mass cannot be followed")]
    NoSampleRate,
    /// The output leaves the range of numbers.
    #[error(
        "the simulated output is not finite at sample {index}: numbers of the model or the drive are too large"
    )]
    NotFinite {
        /// The first such sample.
        index: usize,
    },
    /// A Hammerstein model or an oscillator.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A model of several axes.
    #[error(transparent)]
    Axes(#[from] AxesError),
    /// The kind does not support it.
    #[error(transparent)]
    Unsupported(#[from] Unsupported),
    /// The references of several axes cannot be followed.
    #[error(transparent)]
    Decoupling(#[from] DecouplingError),
    /// The model was to be corrected by its misfit.
    #[error("the model is not corrected by its predicted misfit: {0}")]
    NotCorrected(#[from] NotCorrected),
    /// The record cannot be scored.
    #[error(transparent)]
    Score(#[from] ScoreError),
    /// Too few samples can be scored.
    #[error("only {samples} of its {total} samples can be scored; need at least {need}")]
    TooFewSamples {
        /// Samples that can be scored.
        samples: usize,
        /// Samples of the record.
        total: usize,
        /// Samples needed.
        need: usize,
    },
    /// The output is constant.
    #[error("the output `{name}` is constant ({}): no motion to compare with", short(*value))]
    ConstantOutput {
        /// Name of the channel.
        name: String,
        /// Its value.
        value: f64,
    },
    /// The input is constant.
    #[error("the input `{name}` is constant ({}): the model has nothing to follow", short(*value))]
    ConstantInput {
        /// Name of the channel.
        name: String,
        /// Its value.
        value: f64,
    },
}
