//! Input and output columns of a record of several axes.

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_model::axes::AxesRecord;
use rayon::prelude::*;

use crate::columns::InputFlags;
use crate::failure::Failure;

/// Columns of several inputs and outputs.
#[derive(Args, Clone, Debug, Default)]
pub struct AxesFlags {
    /// Input columns of a record of several axes, e.g. u1_V,u2_V,u3_V [default: those in the model file]
    #[arg(
        long,
        value_name = "COL,COL…",
        value_delimiter = ',',
        conflicts_with = "input",
        help_heading = "Columns"
    )]
    pub inputs: Vec<String>,

    /// Output columns of a record of several axes, e.g. y1_nm,y2_nm,y3_nm
    #[arg(long, value_name = "COL,COL…", value_delimiter = ',', help_heading = "Columns")]
    pub outputs: Vec<String>,
}

/// Columns of the references of several axes.
#[derive(Args, Clone, Debug, Default)]
pub struct AxesReferenceFlags {
    /// Columns of the references of several axes, in the order of the model's outputs [default: those in the
    /// model file]
    #[arg(long, value_name = "COL,COL…", value_delimiter = ',', help_heading = "Columns")]
    outputs: Vec<String>,
}

impl AxesReferenceFlags {
    /// Whether a flag is given.
    pub fn are_given(&self) -> bool {
        !self.outputs.is_empty()
    }

    /// The same for a record.
    pub fn of_record(&self) -> AxesFlags {
        AxesFlags { inputs: Vec::new(), outputs: self.outputs.clone() }
    }
}

impl AxesFlags {
    /// Whether a flag is given.
    pub fn are_given(&self) -> bool {
        !self.inputs.is_empty() || !self.outputs.is_empty()
    }

    /// The names given, else these.
    pub fn or(&self, inputs: &[String], outputs: &[String]) -> Self {
        let choose = |given: &[String], own: &[String]| if given.is_empty() { own } else { given }.to_vec();
        Self { inputs: choose(&self.inputs, inputs), outputs: choose(&self.outputs, outputs) }
    }

    /// The channels of the record at `path`.
    ///
    /// # Errors
    /// If the file is not a readable record or does not have them.
    pub fn read(&self, path: &Path, columns: &InputFlags) -> Result<AxesRecord, Failure> {
        let record = columns.read_record(path)?;
        AxesRecord::new(&record, &self.inputs, &self.outputs).map_err(|e| {
            Failure::new(format!("cannot read the record {}", path.display())).because(e).hint(
                "name the columns with --inputs and --outputs; hysteron inspect shows what a record holds",
            )
        })
    }

    /// [`Self::read`] of several records.
    ///
    /// # Errors
    /// Those of [`Self::read`], the first that fails.
    pub fn read_all(&self, paths: &[PathBuf], columns: &InputFlags) -> Result<Vec<AxesRecord>, Failure> {
        let records: Vec<_> = paths.par_iter().map(|path| self.read(path, columns)).collect();
        records.into_iter().collect()
    }
}
