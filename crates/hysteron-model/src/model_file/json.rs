//! Bytes of a model file: parsed within bounds, and made.

use serde::{Deserialize, Serialize};

use super::{MAX_BYTES, ModelFileError, VERSION};

/// Format and version alone, so that a file of another version is told apart from a broken one.
#[derive(Deserialize)]
#[serde(expecting = "a model file (a JSON object)")]
pub(super) struct Header {
    format: Option<serde_json::Value>,
    version: Option<serde_json::Value>,
}

impl Header {
    /// Of the bytes of a file that is no larger than a model can be.
    pub(super) fn of(bytes: &[u8]) -> Result<Self, ModelFileError> {
        if bytes.len() as u64 > MAX_BYTES {
            return Err(ModelFileError::TooLarge { limit_bytes: MAX_BYTES });
        }
        parse(bytes)
    }

    /// Whether the format is `name`.
    pub(super) fn is(&self, name: &str) -> bool {
        self.format.as_ref().and_then(|format| format.as_str()) == Some(name)
    }

    /// The format as JSON, where there is one.
    pub(super) fn format(&self) -> Option<String> {
        self.format.as_ref().map(ToString::to_string)
    }

    /// Refuses every version but this program's.
    pub(super) fn check_version(&self) -> Result<(), ModelFileError> {
        match &self.version {
            Some(version) if version.as_u64() == Some(VERSION) => Ok(()),
            found => Err(ModelFileError::UnknownVersion { found: found.as_ref().map(ToString::to_string) }),
        }
    }
}

/// Parses JSON; errors name the place by its path as well as by line and column.
pub(super) fn parse<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<T, ModelFileError> {
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let value = serde_path_to_error::deserialize(&mut json)
        .map_err(|e| ModelFileError::syntax(&e.path().to_string(), e.into_inner()))?;
    json.end().map_err(|problem| ModelFileError::syntax(".", problem))?;
    Ok(value)
}

/// Indented JSON with a final newline.
pub(super) fn text(file: &impl Serialize) -> Result<String, ModelFileError> {
    let text = serde_json::to_string_pretty(file).map_err(|problem| ModelFileError::syntax(".", problem))?;
    Ok(text + "\n")
}
