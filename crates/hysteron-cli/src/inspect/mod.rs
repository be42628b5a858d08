//! `hysteron inspect`: what is in a record.

mod campaign;
mod plot;
mod text;

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_identify::structure::{Prospects, prospects};
use hysteron_io::{Content, contents, holds_named_arrays};
use hysteron_model::record::{InputOutput, Inspection, InspectionSummary, inspect};
use serde::Serialize;

use crate::columns::ColumnFlags;
use crate::console;
use crate::design::DesignFrom;
use crate::failure::Failure;
use crate::output::{self, OutFile};

/// Describe a record (rate, jitter, range, frequency, periods, noise floor, delay, loop, saturation,
/// warnings) and what the records together can determine.
#[derive(Args)]
#[command(
    after_help = "The last table says, before any fit, which parameters all records together determine, and \
    which record to measure next.\n\n\
    A file of named arrays (MAT, HDF5, TDMS, XLSX, NPZ, JPK) is listed with paths, shapes and units; where \
    it holds several candidates, choose with --time, --input and --output.\n\n\
    Example: hysteron inspect run.csv --plot run.html\n\
    Example: hysteron inspect loop.csv sweep.csv"
)]
pub struct Inspect {
    /// The records
    #[arg(value_name = "RECORD", required = true)]
    records: Vec<PathBuf>,

    /// Print one JSON object
    #[arg(long)]
    json: bool,

    /// Draw loop and time curves: an SVG (one record) or a self-contained HTML page, by the extension of the
    /// file
    #[arg(long, value_name = "FILE.svg|html", value_parser = plot::target)]
    plot: Option<OutFile>,

    #[command(flatten)]
    columns: ColumnFlags,
}

/// A record and the results of its inspection.
struct Inspected {
    data: InputOutput,
    found: Inspection,
}

#[derive(Serialize)]
struct Report<'a> {
    records: Vec<InspectionSummary>,
    campaign: &'a Prospects,
}

impl Inspect {
    pub fn run(&self) -> Result<(), Failure> {
        if self.records.len() > 1 && self.plot.as_deref().is_some_and(plot::is_figure) {
            return Err(Failure::usage("one SVG cannot hold several records")
                .hint("write an HTML page: --plot FILE.html"));
        }
        self.plot.as_deref().map_or(Ok(()), |path| output::check_file("the plot", path))?;
        let mut inspected = Vec::with_capacity(self.records.len());
        let mut held = Vec::new();
        for path in &self.records {
            let of_file = self.contents(path);
            match self.columns.read_silently(path) {
                Ok(data) => inspected.push(Inspected { found: inspect(&data), data }),
                // The user must choose the record among the arrays of the file.
                Err(failure) => {
                    if !of_file.is_empty() {
                        self.list(path, &of_file)?;
                    }
                    return Err(failure);
                }
            }
            held.push(of_file);
        }
        if let Some(target) = &self.plot {
            plot::write(target, &inspected)?;
        }
        let records: Vec<InputOutput> = inspected.iter().map(|i| i.data.clone()).collect();
        let prospects = prospects(&records);
        if self.json {
            return console::json(&Report {
                records: inspected.iter().map(|i| i.found.summary(&i.data)).collect(),
                campaign: &prospects,
            });
        }
        let listed = self.records.iter().zip(&held).filter(|(_, held)| !held.is_empty());
        let mut parts: Vec<String> = listed.map(|(path, held)| text::contents(path, held)).collect();
        parts.extend(inspected.iter().map(text::describe));
        parts.push(campaign::text(&prospects, &records, DesignFrom::Records(&self.records, &self.columns)));
        console::result(&parts.join("\n"))
    }

    /// Arrays of a file with their paths; empty for a text table, which is not read here, and for a file that
    /// cannot be listed.
    fn contents(&self, path: &Path) -> Vec<Content> {
        match holds_named_arrays(path) {
            Ok(true) => contents(path, &self.columns.options()).unwrap_or_default(),
            _ => Vec::new(),
        }
    }

    fn list(&self, path: &Path, held: &[Content]) -> Result<(), Failure> {
        if self.json {
            return console::json(&FileListing { file: path.display().to_string(), contents: held });
        }
        console::result(&text::contents(path, held))
    }
}

/// Listing of a file whose record is still to be chosen, as JSON.
#[derive(Serialize)]
struct FileListing<'a> {
    file: String,
    contents: &'a [Content],
}
