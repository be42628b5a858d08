//! JSON files of what is neither a record nor a model: settings of the bench, searches of an interrupted fit,
//! results.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::IoError;
use crate::atomic_file::write_atomically;

/// Reads a JSON file of at most `most_bytes`.
///
/// # Errors
/// [`IoError`].
pub fn load_json<T: DeserializeOwned>(path: &Path, most_bytes: u64) -> Result<T, IoError> {
    let unread = |cause| IoError::JsonUnread { path: path.to_owned(), cause };
    let mut bytes = Vec::new();
    File::open(path).map_err(unread)?.take(most_bytes + 1).read_to_end(&mut bytes).map_err(unread)?;
    if bytes.len() as u64 > most_bytes {
        return Err(IoError::JsonTooLarge { path: path.to_owned(), most_bytes });
    }
    serde_json::from_slice(&bytes).map_err(|cause| IoError::JsonContent { path: path.to_owned(), cause })
}

/// Writes a JSON file, at once or not at all; on many lines where `indented`.
///
/// # Errors
/// [`IoError`].
pub fn save_json(path: &Path, value: &impl Serialize, indented: bool) -> Result<(), IoError> {
    let text = if indented { serde_json::to_string_pretty(value) } else { serde_json::to_string(value) };
    let text = text.map_err(|cause| IoError::JsonContent { path: path.to_owned(), cause })?;
    Ok(write_atomically(path, (text + "\n").as_bytes())?)
}
