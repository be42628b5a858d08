//! Errors of the facade.

use hysteron_export::ExportError;
use hysteron_io::IoError;
use hysteron_model::model_file::Kind;

/// Error of this crate, from the layer where it arose.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be read or written; it names file, line and column, and what was expected.
    #[error(transparent)]
    File(#[from] IoError),
    /// A record or a model cannot be used as asked.
    #[error(transparent)]
    Model(#[from] hysteron_model::Error),
    /// No model was identified.
    #[error(transparent)]
    Identify(#[from] hysteron_identify::IdentifyError),
    /// The model cannot be exported.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// Single options given together with a task, which contains all of them.
    #[error("a task contains all options: set hysteresis, dynamics, creep and seed in the task")]
    OptionsOfTask,
    /// Options of a Hammerstein model given for another kind.
    #[error(
        "hysteresis, dynamics, creep and seed belong to a Hammerstein model, not to {kind}: give a task for \
         it"
    )]
    OptionsOfKind {
        /// The kind asked for.
        kind: Kind,
    },
    /// A reference needs a uniform time base.
    #[error("the reference `{name}` has no uniform sample rate: a controller runs at one")]
    NoSampleRate {
        /// Name of the signal.
        name: String,
    },
}

macro_rules! of_layer {
    ($($layer:ident: $($below:ty),+;)+) => {
        $($(impl From<$below> for Error {
            fn from(error: $below) -> Self {
                Self::$layer(error.into())
            }
        })+)+
    };
}

of_layer! {
    File: hysteron_io::atomic_file::AtomicWriteError;
    Model: hysteron_model::UnknownName, hysteron_model::axes::AxesError,
        hysteron_model::control::ControlError, hysteron_model::decoupling::DecouplingError,
        hysteron_model::hammerstein::SimulationError,
        hysteron_model::invert::InversionError, hysteron_model::model::RunError,
        hysteron_model::model::Unsupported, hysteron_model::model_file::ModelFileError,
        hysteron_model::realise::RealiseError, hysteron_model::record::RecordError;
}
