//! JSON files of what is neither a record nor a model: settings of the bench, searches of an interrupted fit, results.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::atomic_file::{AtomicWriteError, write_atomically};

/// Why a JSON file was not read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JsonFileError {
    /// The file cannot be opened or read.
    #[error("{path}: {cause}")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// It is too large to be what it should be.
    #[error("{path}: it has more than {most_bytes} bytes")]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Largest size read \[bytes\].
        most_bytes: u64,
    },
    /// It is not JSON, or not of what was expected.
    #[error("{path}: {cause}")]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong, with line and column.
        cause: serde_json::Error,
    },
    /// It cannot be written.
    #[error(transparent)]
    Write(#[from] AtomicWriteError),
}

/// Reads a JSON file of at most `most_bytes`.
///
/// # Errors
/// [`JsonFileError`].
pub fn load_json<T: DeserializeOwned>(path: &Path, most_bytes: u64) -> Result<T, JsonFileError> {
    let unread = |cause| JsonFileError::Read { path: path.to_owned(), cause };
    let mut bytes = Vec::new();
    File::open(path).map_err(unread)?.take(most_bytes + 1).read_to_end(&mut bytes).map_err(unread)?;
    if bytes.len() as u64 > most_bytes {
        return Err(JsonFileError::TooLarge { path: path.to_owned(), most_bytes });
    }
    serde_json::from_slice(&bytes).map_err(|cause| JsonFileError::Content { path: path.to_owned(), cause })
}

/// Writes a JSON file, at once or not at all; on many lines where `indented`.
///
/// # Errors
/// [`JsonFileError`].
pub fn save_json(path: &Path, value: &impl Serialize, indented: bool) -> Result<(), JsonFileError> {
    let text = if indented { serde_json::to_string_pretty(value) } else { serde_json::to_string(value) };
    let text = text.map_err(|cause| JsonFileError::Content { path: path.to_owned(), cause })?;
    Ok(write_atomically(path, (text + "\n").as_bytes())?)
}
