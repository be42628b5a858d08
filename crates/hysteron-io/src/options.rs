//! What the user may say about a file.

use hysteron_model::record::Cut;
use serde::{Deserialize, Serialize};

use crate::Rename;

/// How to read a file; the default detects everything.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReadOptions {
    /// Time column: its name, with or without unit, or its number counted from 1.
    pub time: Option<String>,
    /// Input column, likewise. With `output` also given, all other channels are left unread.
    pub input: Option<String>,
    /// Output column, likewise.
    pub output: Option<String>,
    /// Reference column, likewise.
    pub reference: Option<String>,
    /// Sample rate \[Hz\]: needed where there is no time column; where there is one, it must agree with it and
    /// replaces its stamps.
    pub sample_rate_hz: Option<f64>,
    /// Columns that are not read, by name or number: they may hold anything.
    pub leave_out: Vec<String>,
    /// New names of columns; whatever else names a column names it by its new name.
    pub rename: Vec<Rename>,
    /// Part of the record that is kept. Outside of it, numbers may be missing or not finite. A condition may ask for a text in a
    /// column of texts of a text file; the record is without that column.
    pub cut: Cut,
    /// Delimiter; `None`: detected.
    pub delimiter: Option<u8>,
    /// Largest file read \[bytes\].
    pub max_bytes: u64,
    /// Most numbers kept (8 bytes of memory each).
    pub max_values: usize,
}

impl Default for ReadOptions {
    /// Detect everything; at most 4 GiB of file and 2²⁹ numbers (4 GiB of memory).
    fn default() -> Self {
        ReadOptions {
            time: None,
            input: None,
            output: None,
            reference: None,
            sample_rate_hz: None,
            leave_out: Vec::new(),
            rename: Vec::new(),
            cut: Cut::default(),
            delimiter: None,
            max_bytes: 4 << 30,
            max_values: 1 << 29,
        }
    }
}

/// Most columns of a file.
pub(crate) const MAX_COLUMNS: usize = 1024;
/// Longest line \[bytes\].
pub(crate) const MAX_LINE_BYTES: usize = 1 << 18;
/// Longest number \[bytes\]; no decimal text that means anything is longer.
pub(crate) const MAX_NUMBER_BYTES: usize = 400;
