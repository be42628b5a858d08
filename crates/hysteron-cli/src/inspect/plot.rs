//! Loop and time curves of records.

use std::path::PathBuf;

use hysteron::atomic_file::write_atomically;
use hysteron_report::figure::{Axis, Figure, Panel, Series, Style};
use hysteron_report::page::{Block, Page, Section};
use hysteron_report::write_page;

use super::Inspected;
use crate::console;
use crate::failure::Failure;
use crate::output;

/// File to draw into.
#[derive(Clone, Debug)]
pub enum Target {
    Svg(PathBuf),
    Html(PathBuf),
}

impl Target {
    /// Checks that the file can be written.
    ///
    /// # Errors
    /// If it cannot.
    pub fn check(&self) -> Result<(), Failure> {
        let (Target::Svg(path) | Target::Html(path)) = self;
        output::check_file("the plot", path)
    }
}

/// Parses a file name by its ending.
pub fn target(text: &str) -> Result<Target, String> {
    let path = PathBuf::from(text);
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("svg") => Ok(Target::Svg(path)),
        Some("html" | "htm") => Ok(Target::Html(path)),
        _ => Err("expected a file name ending in .svg or .html".into()),
    }
}

/// Draws the records.
///
/// # Errors
/// If the file cannot be written.
pub fn write(target: &Target, records: &[Inspected]) -> Result<(), Failure> {
    let (Target::Svg(path) | Target::Html(path)) = target;
    let failed = |e| output::cannot_write("the plot", path, e);
    match (target, records) {
        (Target::Svg(path), [record, ..]) => {
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
        if f.is_warning { Block::warning(f.text.as_str()) } else { Block::paragraph(f.text.as_str()) }
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
