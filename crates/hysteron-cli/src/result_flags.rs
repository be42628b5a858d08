//! Output flags of the commands with an HTML report and JSON output.

use std::borrow::Borrow;

use clap::Args;
use hysteron_report::page::Page;

use crate::failure::Failure;
use crate::output::{self, OutFile};
use crate::outputs::Outputs;

/// Output of the result as report or JSON.
#[derive(Args, Clone, Debug)]
pub struct ResultFlags {
    /// Report to write, one self-contained HTML file
    #[arg(long, value_name = "FILE.html")]
    report: Option<OutFile>,

    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

impl ResultFlags {
    /// Whether a report is wanted.
    pub fn has_report(&self) -> bool {
        self.report.is_some()
    }

    /// Checks that the report can be written.
    ///
    /// # Errors
    /// If it cannot.
    pub fn check(&self) -> Result<(), Failure> {
        self.report.as_deref().map_or(Ok(()), |path| output::check_file("the report", path))
    }

    /// Writes the report, if one is wanted, and says so.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write<P: Borrow<Page>>(&self, page: impl FnOnce() -> P) -> Result<(), Failure> {
        let mut outputs = Outputs::default();
        self.add(&mut outputs, page)?;
        outputs.finish()
    }

    /// Adds the report, if one is wanted, to files that are written together.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn add<P: Borrow<Page>>(
        &self,
        outputs: &mut Outputs,
        page: impl FnOnce() -> P,
    ) -> Result<(), Failure> {
        let Some(path) = &self.report else { return Ok(()) };
        outputs.add("the report", path, page().borrow().to_html().as_bytes())?;
        outputs.tell(format!("report written to {}", path.display()));
        Ok(())
    }
}
