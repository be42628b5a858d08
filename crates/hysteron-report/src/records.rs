//! Records as they were measured: loop, time curves and findings.

use crate::figure::{Axis, Figure, Panel, Series, Style};
use crate::page::{Block, Page, Section};
use crate::titles;
use hysteron_model::record::{InputOutput, Inspection};

/// The page of inspected records; `maker`: the program.
pub fn page<'a>(records: impl IntoIterator<Item = (&'a InputOutput, &'a Inspection)>, maker: &str) -> Page {
    let records: Vec<_> = records.into_iter().collect();
    let title = titles::title(None, records.iter().map(|(data, _)| data.name.as_str()), "what was measured");
    records
        .into_iter()
        .fold(Page::new(title).footer_line(maker), |page, (data, found)| page.section(section(data, found)))
}

fn section(data: &InputOutput, found: &Inspection) -> Section {
    let findings = found.findings.iter().map(|f| {
        if f.is_warning() { Block::warning(f.text.as_str()) } else { Block::paragraph(f.text.as_str()) }
    });
    Section::new(data.name.as_str()).block(figure(data)).blocks(findings)
}

/// Output over input, and both over time (over the sample's number where there is no time).
pub fn figure(data: &InputOutput) -> Figure {
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
