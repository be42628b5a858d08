//! Errors of a model file.

use super::{FORMAT, Kind, VERSION};
use crate::axes::AxesError;
use crate::hysteresis::HysteresisError;
use hysteron_numeric::display::{exact, json_problem};

/// Error in a model file: the fault, its place, and the value expected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelFileError {
    /// The file is far larger than any model.
    #[error("more than {limit_bytes} bytes: this is not a model file")]
    TooLarge {
        /// Largest size read.
        limit_bytes: u64,
    },
    /// Not JSON, an unknown or missing key, or a value of the wrong type.
    #[error("{}{}", at(path), json_problem(problem))]
    Syntax {
        /// Place in the file, e.g. `dynamics.denominator[1].order.value`; empty for the file itself.
        path: String,
        /// The problem, with line and column.
        problem: serde_json::Error,
    },
    /// The key `format` is missing or something else.
    #[error("format: expected \"{FORMAT}\", found {}", found.as_deref().unwrap_or("no such key"))]
    NotAModel {
        /// The value found, as JSON.
        found: Option<String>,
    },
    /// The key `kind` is missing or something else.
    #[error("kind: expected {}, found {}", Kind::names(), found.as_deref().unwrap_or("no such key"))]
    UnknownKind {
        /// The value found, as JSON.
        found: Option<String>,
    },
    /// The keys are those of another kind.
    #[error("kind: expected \"{expected}\", found \"{found}\"")]
    OtherKind {
        /// Kind whose keys these are.
        expected: Kind,
        /// Kind named.
        found: Kind,
    },
    /// Columns without a name or with the same one.
    #[error("inputs, outputs: expected names that differ, found `{name}` twice or empty")]
    Channels {
        /// The name.
        name: String,
    },
    /// The numbers of scheduled modes do not make a model.
    #[error(transparent)]
    Modes(#[from] AxesError),
    /// The file is of a version this program does not know.
    #[error(
        "version: this program reads versions 1 and {VERSION}, found {}",
        found.as_deref().unwrap_or("no such key")
    )]
    UnknownVersion {
        /// The value found, as JSON.
        found: Option<String>,
    },
    /// A number is outside of what is allowed.
    #[error("{path}: expected {expected}, found {value}", value = exact(*.value))]
    NotAllowed {
        /// Place in the file.
        path: String,
        /// The number.
        value: f64,
        /// Allowed values.
        expected: &'static str,
    },
    /// A number is given in another unit than the format's.
    #[error("{path}: expected the unit \"{expected}\", found \"{found}\"")]
    WrongUnit {
        /// Place in the file.
        path: String,
        /// Unit found.
        found: String,
        /// Unit the format prescribes.
        expected: String,
    },
    /// A parameter of the hysteresis block is missing.
    #[error("hysteresis.parameters: `{name}` is missing")]
    MissingParameter {
        /// Its name.
        name: String,
    },
    /// A parameter the hysteresis block does not have.
    #[error("hysteresis.parameters: unknown parameter `{name}`; expected {expected}")]
    UnknownParameter {
        /// Its name.
        name: String,
        /// The names there are.
        expected: String,
    },
    /// The shape numbers are invalid for the hysteresis block.
    #[error("hysteresis.parameters: {problem}")]
    Shape {
        /// The problem.
        problem: HysteresisError,
    },
    /// A list of terms does not suit the kind of dynamics.
    #[error("{path}: expected {expected}, found {terms} terms")]
    Terms {
        /// Place in the file.
        path: &'static str,
        /// Terms found.
        terms: usize,
        /// The terms expected.
        expected: &'static str,
    },
    /// A settled start has no rest voltage.
    #[error("start.voltage: expected null for a start of the kind \"settled\"")]
    VoltageOfSettledStart,
    /// The correlation matrix is invalid.
    #[error("correlation: {problem}")]
    Correlation {
        /// The problem.
        problem: String,
    },
    /// An ARX model belongs to one sample rate, and the file names none.
    #[error("sample_rate_hz: an arx model needs its sample rate, found null")]
    ArxWithoutSampleRate,
}

impl ModelFileError {
    pub(super) fn syntax(path: &str, problem: serde_json::Error) -> Self {
        let path = if path == "." { String::new() } else { path.to_owned() };
        ModelFileError::Syntax { path, problem }
    }
}

fn at(path: &str) -> String {
    if path.is_empty() { String::new() } else { format!("{path}: ") }
}
