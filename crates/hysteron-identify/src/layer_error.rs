//! What can go wrong in this crate, of whatever part: a caller that only tells crates apart takes [`Error`].

use crate::baselines::BaselineError;
use crate::error::IdentifyError;
use crate::fit::FitError;
use crate::frequency_response::{FileError, FrequencyResponseError};
use crate::online::{CorrectionError, FollowError};
use crate::prediction::PredictionError;
use crate::structure::{StructureError, UnknownCandidate};

/// Error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// [`BaselineError`].
    #[error(transparent)]
    Baseline(#[from] BaselineError),
    /// [`UnknownCandidate`].
    #[error(transparent)]
    Candidate(#[from] UnknownCandidate),
    /// [`CorrectionError`].
    #[error(transparent)]
    Correction(#[from] CorrectionError),
    /// [`FileError`].
    #[error(transparent)]
    File(#[from] FileError),
    /// [`FitError`].
    #[error(transparent)]
    Fit(#[from] FitError),
    /// [`FollowError`].
    #[error(transparent)]
    Follow(#[from] FollowError),
    /// [`FrequencyResponseError`].
    #[error(transparent)]
    FrequencyResponse(#[from] FrequencyResponseError),
    /// [`IdentifyError`].
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// [`PredictionError`].
    #[error(transparent)]
    Prediction(#[from] PredictionError),
    /// [`StructureError`].
    #[error(transparent)]
    Structure(#[from] StructureError),
}
