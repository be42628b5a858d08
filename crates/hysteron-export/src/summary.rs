//! Summary of an export, for programs.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::{NamedFile, Precision, Subject};

/// Summary of an export, machine-readable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExportSummary {
    /// Beginning of every name in the source.
    pub name: String,
    /// Number type.
    pub float: Precision,
    /// Rate that it runs at \[Hz\].
    pub sample_rate_hz: f64,
    /// States of the dynamic block.
    pub states: usize,
    /// Taps of the dynamic block.
    pub taps: usize,
    /// Whole samples of delay.
    pub delay_samples: usize,
    /// Largest error of its frequency response, as a share of its largest value.
    pub frequency_error: f64,
    /// Symbol of the unit of the input.
    pub input_unit: String,
    /// Symbol of the unit of the output.
    pub output_unit: String,
    /// Files written.
    pub files: Vec<FileSummary>,
}

/// One file of an export.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileSummary {
    /// Its path.
    pub path: String,
    /// Its size.
    pub bytes: usize,
}

impl ExportSummary {
    /// Summary of these files in a folder.
    pub fn new(folder: &Path, subject: &Subject, files: &[NamedFile]) -> Self {
        let linear = &subject.realisation.dynamics;
        Self {
            name: subject.name.clone(),
            float: subject.precision,
            sample_rate_hz: subject.realisation.sample_rate_hz,
            states: linear.states(),
            taps: linear.taps.len(),
            delay_samples: linear.delay_samples,
            frequency_error: linear.frequency_error,
            input_unit: subject.input_unit.clone(),
            output_unit: subject.output_unit.clone(),
            files: files
                .iter()
                .map(|f| FileSummary {
                    path: folder.join(&f.name).display().to_string(),
                    bytes: f.bytes.len(),
                })
                .collect(),
        }
    }
}
