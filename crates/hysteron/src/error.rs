//! What can go wrong.

use hysteron_export::ExportError;
use hysteron_identify::FitError;
use hysteron_io::atomic_file::AtomicWriteError;
use hysteron_io::{IoError, ModelDiskError};
use hysteron_model::axes::AxesError;
use hysteron_model::compensator::CompensatorError;
use hysteron_model::hysteresis::UnknownFamily;
use hysteron_model::invert::InversionError;
use hysteron_model::model::{RunError, Unsupported};
use hysteron_model::model_file::ModelFileError;
use hysteron_model::realise::RealiseError;
use hysteron_model::record::RecordError;

/// Error of this crate, of whatever layer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file is no readable record.
    #[error(transparent)]
    Read(#[from] IoError),
    /// A model file cannot be read or written.
    #[error(transparent)]
    ModelFile(#[from] ModelDiskError),
    /// The data of a model are not sound.
    #[error(transparent)]
    Model(#[from] ModelFileError),
    /// A record cannot be used.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A record of several axes cannot be used.
    #[error(transparent)]
    Axes(#[from] AxesError),
    /// No family of this name.
    #[error(transparent)]
    Family(#[from] UnknownFamily),
    /// No model was identified.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The model cannot be run on a record, or not scored.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The kind of model does not support it yet.
    #[error(transparent)]
    Unsupported(#[from] Unsupported),
    /// The model does not run sample by sample.
    #[error(transparent)]
    Realise(#[from] RealiseError),
    /// No drive follows the reference.
    #[error(transparent)]
    Inversion(#[from] InversionError),
    /// There is no controller.
    #[error(transparent)]
    Controller(#[from] CompensatorError),
    /// The model cannot be exported.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] AtomicWriteError),
    /// A reference needs a uniform time base.
    #[error("the reference `{name}` has no uniform sample rate: a controller runs at one")]
    NoSampleRate {
        /// Name of the signal.
        name: String,
    },
}
