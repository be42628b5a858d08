//! A model file of any kind.

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::json::{self, Header, parse};
use super::{
    CoupledFile, FORMAT, ForceFile, Kind, ModelFile, ModelFileError, ModesFile, OscillatorFile, VERSION,
};

/// A model as data, of any kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Document {
    /// Hysteresis ahead of linear dynamics.
    Hammerstein(Box<ModelFile>),
    /// Hysteresis in feedback.
    Oscillator(Box<OscillatorFile>),
    /// Force against a displacement and its rate.
    Force(Box<ForceFile>),
    /// Scheduled modes of several inputs and outputs.
    Modes(Box<ModesFile>),
    /// Coupled Hammerstein branches of several inputs and outputs.
    Branches(Box<CoupledFile>),
}

/// Reads and checks the bytes of a model file of any kind, of version 2 or 1; the result is of version 2.
///
/// # Errors
/// [`ModelFileError`]: too large, not JSON, of another format or version, or a value that is missing, unknown
/// or not allowed.
pub fn read(bytes: &[u8]) -> Result<Document, ModelFileError> {
    fn body<T: DeserializeOwned>(
        bytes: &[u8],
        header: fn(&mut T) -> (&mut String, &mut u64),
        check: fn(&T) -> Result<(), ModelFileError>,
    ) -> Result<Box<T>, ModelFileError> {
        let mut file: Box<T> = parse(bytes)?;
        let (format, version) = header(&mut file);
        (*format, *version) = (FORMAT.to_owned(), VERSION);
        check(&file)?;
        Ok(file)
    }
    Ok(match Header::of(bytes)?.kind()? {
        Kind::Hammerstein => {
            Document::Hammerstein(body(bytes, |f| (&mut f.format, &mut f.version), ModelFile::check)?)
        }
        Kind::Oscillator => {
            Document::Oscillator(body(bytes, |f| (&mut f.format, &mut f.version), OscillatorFile::check)?)
        }
        Kind::Force => Document::Force(body(bytes, |f| (&mut f.format, &mut f.version), ForceFile::check)?),
        Kind::Modes => Document::Modes(body(bytes, |f| (&mut f.format, &mut f.version), ModesFile::check)?),
        Kind::Branches => {
            Document::Branches(body(bytes, |f| (&mut f.format, &mut f.version), CoupledFile::check)?)
        }
    })
}

impl Document {
    /// The kind of model.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Hammerstein(_) => Kind::Hammerstein,
            Self::Oscillator(_) => Kind::Oscillator,
            Self::Force(_) => Kind::Force,
            Self::Modes(_) => Kind::Modes,
            Self::Branches(_) => Kind::Branches,
        }
    }

    /// Checks everything that is not a matter of types.
    ///
    /// # Errors
    /// [`ModelFileError`] naming the first offending place.
    pub fn check(&self) -> Result<(), ModelFileError> {
        match self {
            Self::Hammerstein(file) => file.check(),
            Self::Oscillator(file) => file.check(),
            Self::Force(file) => file.check(),
            Self::Modes(file) => file.check(),
            Self::Branches(file) => file.check(),
        }
    }

    /// The file's text: indented JSON with a final newline.
    ///
    /// # Errors
    /// [`ModelFileError`] if [`read`] would not accept it.
    pub fn to_json(&self) -> Result<String, ModelFileError> {
        self.check()?;
        json::text(self)
    }
}
