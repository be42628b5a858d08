//! `hysteron inspect`: what is in a record.

mod json;
mod plot;
mod text;

use std::path::PathBuf;

use clap::Args;
use hysteron::record::{InputOutput, Inspection, inspect};
use serde::Serialize;

use crate::columns::ColumnFlags;
use crate::console;
use crate::failure::Failure;

/// Show what is in a record: rate, jitter, range, frequency, periods, noise floor, delay, loop, saturation, warnings.
#[derive(Args)]
#[command(after_help = "Example: hysteron inspect run.csv --plot run.html")]
pub struct Inspect {
    /// The records
    #[arg(value_name = "RECORD", required = true)]
    records: Vec<PathBuf>,

    /// Print one JSON object
    #[arg(long)]
    json: bool,

    /// Draw loop and time curves: an SVG (one record) or a self-contained HTML page, by the file's ending
    #[arg(long, value_name = "FILE.svg|html", value_parser = plot::target)]
    plot: Option<plot::Target>,

    #[command(flatten)]
    columns: ColumnFlags,
}

/// A record and what was found in it.
struct Inspected {
    data: InputOutput,
    found: Inspection,
}

#[derive(Serialize)]
struct Report<'a> {
    records: Vec<json::Entry<'a>>,
}

impl Inspect {
    pub fn run(&self) -> Result<(), Failure> {
        if let (Some(plot::Target::Svg(_)), 2..) = (&self.plot, self.records.len()) {
            return Err(Failure::usage("one SVG cannot hold several records")
                .hint("write an HTML page: --plot FILE.html"));
        }
        self.plot.as_ref().map_or(Ok(()), plot::Target::check)?;
        let mut inspected = Vec::with_capacity(self.records.len());
        for path in &self.records {
            let data = self.columns.read_silently(path)?;
            inspected.push(Inspected { found: inspect(&data), data });
        }
        if let Some(target) = &self.plot {
            plot::write(target, &inspected)?;
        }
        if self.json {
            return console::json(&Report { records: inspected.iter().map(json::Entry::new).collect() });
        }
        console::result(&inspected.iter().map(text::describe).collect::<Vec<_>>().join("\n"))
    }
}
