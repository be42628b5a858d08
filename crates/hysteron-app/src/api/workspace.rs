//! The workspace, its history and its trash.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Job;

/// The folder that is served.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Workspace {
    /// Path of the folder.
    pub folder: String,
    /// Name and version of the program.
    pub program: String,
    /// Subfolders with records or models, each a device; the folder itself is the empty name.
    pub devices: Vec<String>,
    /// Number of the last change: records, models and reports of a page that has seen it are current.
    pub change: u64,
    /// Largest upload \[bytes\].
    pub max_upload_bytes: u64,
    /// Examples that can be opened.
    pub examples: Vec<Example>,
    /// Undo of the last deletions, newest first.
    pub trash: Vec<Trashed>,
}

/// A measured example with its licence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Example {
    /// Name, and folder that it is copied to.
    pub name: String,
    /// What it is, in a line.
    pub title: String,
    /// It is in the workspace.
    pub open: bool,
}

/// An example copied into the workspace.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ExampleOpened {
    /// Its records.
    pub records: Vec<String>,
}

/// Something in the trash folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Trashed {
    /// Token for its restoration.
    pub token: String,
    /// What it was: its identifier.
    pub id: String,
    /// When it was deleted (ISO 8601, UTC).
    pub deleted: String,
}

/// What was done in this workspace, newest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct History {
    /// Jobs, newest first.
    pub jobs: Vec<Job>,
    /// All commands that repeat what was done, oldest first, as a shell script.
    pub shell: String,
    /// The same as a Python script.
    pub python: String,
}

/// Event `records`, `models` or `reports`: the list has changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Changed {
    /// Number of the change.
    pub change: u64,
}
