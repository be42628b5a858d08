//! Options of reading a file.

use hysteron_model::record::Cut;
use serde::{Deserialize, Serialize};

use crate::Rename;

/// Options for reading a file; the default detects everything.
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
    /// Sample rate \[Hz\]: needed where there is no time column; where there is one, it must agree with it
    /// and replaces its stamps.
    pub sample_rate_hz: Option<f64>,
    /// Columns that are not read, by name or number: they may hold anything.
    pub leave_out: Vec<String>,
    /// New names of columns, by which all other options refer to them.
    pub rename: Vec<Rename>,
    /// Part of the record that is kept. Outside of it, numbers may be missing or not finite. A condition may
    /// match a text column of a text file, which the record then leaves out.
    pub cut: Cut,
    /// Delimiter; `None`: detected.
    pub delimiter: Option<u8>,
    /// Largest file read \[bytes\]. Where it is not the default, a small file may also unpack to as much.
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

impl ReadOptions {
    /// Most bytes that a file of this size may unpack to: far more than measured data do. A size limit chosen
    /// by the user applies unchanged.
    pub(crate) fn most_unpacked_bytes(&self, file_bytes: u64) -> u64 {
        if self.max_bytes != ReadOptions::default().max_bytes {
            return self.max_bytes;
        }
        self.max_bytes.min(LEAST_UNPACKED_BYTES.max(file_bytes.saturating_mul(UNPACKED_PER_BYTE)))
    }

    /// Most numbers of a file of this size that are kept, likewise.
    pub(crate) fn most_values(&self, file_bytes: u64) -> usize {
        let defaults = ReadOptions::default();
        if self.max_bytes != defaults.max_bytes || self.max_values != defaults.max_values {
            return self.max_values;
        }
        let most = (LEAST_UNPACKED_BYTES / 8).max(file_bytes.saturating_mul(VALUES_PER_BYTE));
        self.max_values.min(usize::try_from(most).unwrap_or(usize::MAX))
    }
}

/// Unpacked size allowed for any file \[bytes\]: reading it then takes less than 1 GiB of memory.
const LEAST_UNPACKED_BYTES: u64 = 256 << 20;
/// Unpacked bytes allowed per byte of a larger file: doubles of a noisy 8-bit converter unpack to fewer.
const UNPACKED_PER_BYTE: u64 = 16;
/// Numbers a byte of a larger file.
const VALUES_PER_BYTE: u64 = 8;

/// Most columns of a file.
pub(crate) const MAX_COLUMNS: usize = 1024;
/// Longest line \[bytes\].
pub(crate) const MAX_LINE_BYTES: usize = 1 << 18;
/// Longest number \[bytes\]; no decimal text that means anything is longer.
pub(crate) const MAX_NUMBER_BYTES: usize = 400;
