//! Loop and time curves of records.

use std::ffi::OsString;
use std::path::Path;

use hysteron_io::atomic_file::write_atomically;
use hysteron_report::figure::{Axis, Figure, Panel, Series, Style};
use hysteron_report::page::{Block, Page, Section};
use hysteron_report::write_page;

use super::Inspected;
use crate::console;
use crate::failure::Failure;
use crate::output::{self, OutFile};

/// A file name whose ending says what is drawn.
pub fn target(text: &str) -> Result<OutFile, String> {
    let known = ["svg", "html", "htm"].iter().any(|ending| ends_in(Path::new(text), ending));
    let wrong = || "expected a file name ending in .svg or .html".to_owned();
    known.then(|| OutFile::from(OsString::from(text))).ok_or_else(wrong)
}

/// Whether the file is to be one figure, not a page.
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
            write_atomically(path, figure(record).to_svg().as_bytes()).map_err(failed)?;
        }
        _ => {
            let mut page = Page::new("Records").footer_line(concat!("hysteron ", env!("CARGO_PKG_VERSION")));
            for record in records {
                page = page.section(section(record));
            }
            write_page(path, &page).map_err(failed)?;
        }
    }
    console::message(&format!("plot written to {}", path.display()));
    Ok(())
}

fn section(record: &Inspected) -> Section {
    let findings = record.found.findings.iter().map(|f| {
        if f.is_warning() { Block::warning(f.text.as_str()) } else { Block::paragraph(f.text.as_str()) }
    });
    Section::new(record.data.name.as_str()).block(figure(record)).blocks(findings)
}

/// Output over input, and both over time (over the sample's number where there is no time).
fn figure(record: &Inspected) -> Figure {
    let data = &record.data;
    let input = || Axis::linear(data.input.as_str(), data.u_unit.to_string());
    let output = || Axis::linear(data.output.as_str(), data.y_unit.to_string());
    let times: Option<Vec<f64>> = (0..data.len()).map(|k| data.time.time_s(k)).collect();
    let (abscissa, x) = match times {
        Some(times) => (Axis::linear("time", "s"), times),
        None => (Axis::linear("sample", ""), (0..data.len()).map(|k| k as f64).collect()),
    };
    let curve =
        |x: &[f64], y: &[f64]| Series::line("", x.to_vec(), y.to_vec(), Style::nth(0).with_width(1.0));
    Figure::new(data.name.as_str())
        .captioned("Output over input, output over time, input over time.")
        .panel(Panel::new(input(), output()).series(curve(&data.u, &data.y)))
        .panel(Panel::new(abscissa.clone(), output()).series(curve(&x, &data.y)))
        .panel(Panel::new(abscissa, input()).series(curve(&x, &data.u)))
}
