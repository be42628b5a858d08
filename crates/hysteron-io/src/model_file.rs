//! Model files on disk: bytes in, within bounds; JSON out, atomically.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use hysteron_model::model_file::{MAX_BYTES, ModelFileError};

use crate::atomic_file::{AtomicWriteError, write_atomically};

/// Why a model file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelDiskError {
    /// The file cannot be opened or read.
    #[error("cannot read {}: {problem}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Answer of the operating system.
        problem: std::io::Error,
    },
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] AtomicWriteError),
    /// It holds no sound model.
    #[error(transparent)]
    Content(#[from] ModelFileError),
}

/// The model file at `path`, parsed by `parse`.
///
/// # Errors
/// If it cannot be read, is too large for a model, or not sound.
pub fn read_model_file<T>(
    path: &Path,
    parse: fn(&[u8]) -> Result<T, ModelFileError>,
) -> Result<T, ModelDiskError> {
    let unreadable = |problem| ModelDiskError::Unreadable { path: path.to_owned(), problem };
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    Ok(parse(&bytes)?)
}

/// Writes the text of a model file; `path` holds its old content or all of the new.
///
/// # Errors
/// If there is no text, the model not being sound, or it cannot be written.
pub fn write_model_file(path: &Path, text: Result<String, ModelFileError>) -> Result<(), ModelDiskError> {
    Ok(write_atomically(path, text?.as_bytes())?)
}
