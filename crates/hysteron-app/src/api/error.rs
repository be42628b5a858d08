//! A refused request.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Body of every answer with a status of 400 or above.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Refusal {
    /// What went wrong.
    pub error: Problem,
}

/// What could not be done, why, and what can be done about it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Problem {
    /// The failure in a sentence.
    pub what: String,
    /// Place in a file: `line 2, column 3`.
    #[serde(rename = "where", default, skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// The lines of a text file around that place.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub around: Vec<Line>,
    /// A remedy.
    #[serde(rename = "do", default, skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
}

/// A line of a text file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Line {
    /// Its number, counted from 1.
    pub number: u64,
    /// Its text, shortened where it is long.
    pub text: String,
    /// It is the line of the error.
    pub here: bool,
}
