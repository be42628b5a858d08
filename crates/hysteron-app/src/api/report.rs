//! Reports.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An HTML page in the workspace.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ReportEntry {
    /// Identifier: path relative to the workspace.
    pub id: String,
    /// Folder of it: the device.
    pub device: String,
    /// Size \[bytes\].
    pub bytes: u64,
    /// Last change (ISO 8601, UTC).
    pub modified: String,
}
