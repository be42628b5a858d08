//! Errors of the whole crate in one type, [`Error`].

use crate::Advice;
use crate::axes::AxesError;
use crate::control::ControlError;
use crate::decoupling::DecouplingError;
use crate::dynamics::DynamicsError;
use crate::hammerstein::SimulationError;
use crate::hysteresis::HysteresisError;
use crate::invert::InversionError;
use crate::model::{RunError, Unsupported};
use crate::model_file::ModelFileError;
use crate::realise::RealiseError;
use crate::record::RecordError;
use crate::unknown_name::UnknownName;
use crate::validate::ScoreError;

/// Error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// [`AxesError`].
    #[error(transparent)]
    Axes(#[from] AxesError),
    /// [`ControlError`].
    #[error(transparent)]
    Control(#[from] ControlError),
    /// [`DecouplingError`].
    #[error(transparent)]
    Decoupling(#[from] DecouplingError),
    /// [`DynamicsError`].
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// [`HysteresisError`].
    #[error(transparent)]
    Hysteresis(#[from] HysteresisError),
    /// [`InversionError`].
    #[error(transparent)]
    Inversion(#[from] InversionError),
    /// [`ModelFileError`].
    #[error(transparent)]
    ModelFile(#[from] ModelFileError),
    /// [`UnknownName`].
    #[error(transparent)]
    Name(#[from] UnknownName),
    /// [`RealiseError`].
    #[error(transparent)]
    Realise(#[from] RealiseError),
    /// [`RecordError`].
    #[error(transparent)]
    Record(#[from] RecordError),
    /// [`RunError`].
    #[error(transparent)]
    Run(#[from] RunError),
    /// [`ScoreError`].
    #[error(transparent)]
    Score(#[from] ScoreError),
    /// [`SimulationError`].
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// [`Unsupported`].
    #[error(transparent)]
    Unsupported(#[from] Unsupported),
}

impl Error {
    /// Remedy available to the user, if any.
    pub fn advice(&self) -> Option<Advice> {
        match self {
            Self::Record(e) => e.advice(),
            Self::Axes(e) => e.advice(),
            _ => None,
        }
    }
}
