//! Model files on disk: bytes in, within bounds; JSON out, atomically.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use hysteron_model::Model;
use hysteron_model::model_file::MAX_BYTES;
use hysteron_model::record::Source;

use crate::atomic_file::write_atomically;
use crate::hash::sha256;
use crate::{IoError, JsonFileError};

/// The model in the file at `path`, of any kind.
///
/// # Errors
/// If it cannot be read, is too large for a model, or not sound.
pub fn load_model(path: &Path) -> Result<Model, IoError> {
    Ok(load_model_and_source(path)?.0)
}

/// [`load_model`], with path and hash of the file for provenance.
///
/// # Errors
/// Those of [`load_model`].
pub fn load_model_and_source(path: &Path) -> Result<(Model, Source), IoError> {
    let unreadable = |cause| JsonFileError::Unread { path: path.to_owned(), cause };
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    let source = Source { path: path.display().to_string(), sha256: sha256(&bytes) };
    Ok((Model::from_json(&bytes)?, source))
}

/// Writes a model; `path` holds its old content or all of the new.
///
/// # Errors
/// If the model is not sound, or the file cannot be written.
pub fn save_model(path: &Path, model: &Model) -> Result<(), IoError> {
    Ok(write_atomically(path, model.to_json()?.as_bytes())?)
}
