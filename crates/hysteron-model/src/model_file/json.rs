//! Bytes of a model file: bounded parsing, and writing.

use serde::{Deserialize, Serialize};

use super::{FORMAT, Kind, MAX_BYTES, ModelFileError, VERSION};

/// Format, version and kind alone, to distinguish a file of another version from a broken one.
#[derive(Deserialize)]
#[serde(expecting = "a model file (a JSON object)")]
pub(super) struct Header {
    format: Option<serde_json::Value>,
    version: Option<serde_json::Value>,
    kind: Option<serde_json::Value>,
}

/// Kinds by the key `format` of version 1, which had one format per kind.
const VERSION_1: [(&str, Kind); 4] = [
    (FORMAT, Kind::Hammerstein),
    ("hysteron-oscillator", Kind::Oscillator),
    ("hysteron-modes", Kind::Modes),
    ("hysteron-coupled", Kind::Branches),
];

impl Header {
    /// Header of a file no larger than a model can be.
    pub(super) fn of(bytes: &[u8]) -> Result<Self, ModelFileError> {
        if bytes.len() as u64 > MAX_BYTES {
            return Err(ModelFileError::TooLarge { limit_bytes: MAX_BYTES });
        }
        parse(bytes)
    }

    /// The kind of model, of a file of a version that this program reads.
    pub(super) fn kind(&self) -> Result<Kind, ModelFileError> {
        let text = |value: &Option<serde_json::Value>| value.as_ref().map(ToString::to_string);
        let format = self.format.as_ref().and_then(|format| format.as_str()).unwrap_or_default();
        let old = VERSION_1.into_iter().find(|(name, _)| *name == format);
        let Some((_, old)) = old else {
            return Err(ModelFileError::NotAModel { found: text(&self.format) });
        };
        match self.version.as_ref().and_then(serde_json::Value::as_u64) {
            Some(1) => Ok(old),
            Some(VERSION) if format == FORMAT => {
                let kind = self.kind.as_ref().and_then(|kind| kind.as_str()).and_then(Kind::of_name);
                kind.ok_or_else(|| ModelFileError::UnknownKind { found: text(&self.kind) })
            }
            _ => Err(ModelFileError::UnknownVersion { found: text(&self.version) }),
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
