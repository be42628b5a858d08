//! Loop and time curves of records.

use std::ffi::OsString;
use std::path::Path;

use hysteron_io::atomic_file::write_atomically;
use hysteron_report::records::{figure, page};
use hysteron_report::write_page;

use super::Inspected;
use crate::console;
use crate::failure::Failure;
use crate::output::{self, OutFile};

/// Parses a file name whose extension selects the kind of plot.
pub fn target(text: &str) -> Result<OutFile, String> {
    let known = ["svg", "html", "htm"].iter().any(|ending| ends_in(Path::new(text), ending));
    let wrong = || "expected a file name ending in .svg or .html".to_owned();
    known.then(|| OutFile::from(OsString::from(text))).ok_or_else(wrong)
}

/// True for a single figure, false for a page.
pub fn is_figure(target: &Path) -> bool {
    ends_in(target, "svg")
}

fn ends_in(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}

/// Draws the records.
///
/// # Errors
/// If the file cannot be written.
pub fn write(path: &Path, records: &[Inspected]) -> Result<(), Failure> {
    let failed = |e| output::cannot_write("the plot", path, e);
    match records {
        [record, ..] if is_figure(path) => {
            write_atomically(path, figure(&record.data).to_svg().as_bytes()).map_err(failed)?;
        }
        _ => {
            let inspected = records.iter().map(|record| (&record.data, &record.found));
            let page = page(inspected, concat!("hysteron ", env!("CARGO_PKG_VERSION")));
            write_page(path, &page).map_err(failed)?;
        }
    }
    console::message(&format!("plot written to {}", path.display()));
    Ok(())
}
