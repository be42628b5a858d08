//! JSON files other than records and models: settings of the bench, searches of an interrupted fit, results.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use hysteron_numeric::display::json_problem;

use crate::IoError;
use crate::atomic_file::write_atomically;

/// Why a JSON file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JsonFileError {
    /// The file cannot be opened or read.
    #[error("cannot read {}: {cause}", path.display())]
    Unread {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        cause: std::io::Error,
    },
    /// The file exceeds the size limit.
    #[error("{}: it has more than {most_bytes} bytes", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Largest size read \[bytes\].
        most_bytes: u64,
    },
    /// It is not JSON, or not of the expected content.
    #[error("{}: {}", path.display(), json_problem(cause))]
    Content {
        /// The file.
        path: PathBuf,
        /// Error of the parser, with line and column.
        cause: serde_json::Error,
    },
}

/// Reads a JSON file of at most `most_bytes`.
///
/// # Errors
/// [`IoError`].
pub fn load_json<T: DeserializeOwned>(path: &Path, most_bytes: u64) -> Result<T, IoError> {
    let unread = |cause| JsonFileError::Unread { path: path.to_owned(), cause };
    let mut bytes = Vec::new();
    File::open(path).map_err(unread)?.take(most_bytes + 1).read_to_end(&mut bytes).map_err(unread)?;
    if bytes.len() as u64 > most_bytes {
        return Err(JsonFileError::TooLarge { path: path.to_owned(), most_bytes }.into());
    }
    let content = |cause| JsonFileError::Content { path: path.to_owned(), cause };
    Ok(serde_json::from_slice(&bytes).map_err(content)?)
}

/// Writes a JSON file, at once or not at all; on many lines where `indented`.
///
/// # Errors
/// [`IoError`].
pub fn save_json(path: &Path, value: &impl Serialize, indented: bool) -> Result<(), IoError> {
    let text = if indented { serde_json::to_string_pretty(value) } else { serde_json::to_string(value) };
    let text = text.map_err(|cause| JsonFileError::Content { path: path.to_owned(), cause })?;
    Ok(write_atomically(path, (text + "\n").as_bytes())?)
}
