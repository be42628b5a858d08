//! The result as a page.

use hysteron_report::figure::{Axis, Figure, Panel, Series, Style};
use hysteron_report::page::{Block, Column, Page, Section, Table};

use super::Found;
use super::text::{HEADER, MARGINS, cells, introduction, margins};
use crate::identify::command_line;

/// Curves of a figure at most.
const CURVES: usize = 6;

pub fn page(found: &Found) -> Page {
    let columns = HEADER.iter().enumerate().map(|(i, name)| match (i, *name) {
        (0, name) => Column::text(name),
        (_, "rms" | "largest") => Column::number(HEADER[i], found.output.to_string()),
        (_, "lowest drive" | "highest drive") => Column::number(HEADER[i], found.input.to_string()),
        (_, name) => Column::number(name, ""),
    });
    let table = found.runs.iter().fold(Table::new(columns), |table, run| table.row(cells(run)));
    let mut result = Section::new("What each controller leaves")
        .block(Block::paragraph(introduction(found)))
        .block(table)
        .block(motion(found))
        .block(errors(found));
    let rows: Vec<_> = found.runs.iter().filter_map(margins).collect();
    if !rows.is_empty() {
        let columns = MARGINS
            .iter()
            .enumerate()
            .map(|(i, name)| if i < 2 { Column::text(*name) } else { Column::number(*name, "") });
        result = result.block(Block::paragraph("Margins of the feedback on the identified model:"));
        result = result.block(rows.into_iter().fold(Table::new(columns), |table, row| table.row(row)));
    }
    let mut page = Page::new(format!("Following {} (simulated)", found.name)).section(result);
    if !found.reach.is_empty() {
        page = page.section(Section::new("What the amplifier leaves").block(reach(found)));
    }
    page.section(Section::new("How it was made").block(Block::code(command_line())))
        .footer_line(concat!("hysteron ", env!("CARGO_PKG_VERSION")))
}

fn time(found: &Found) -> Vec<f64> {
    (0..found.reference.len()).map(|k| k as f64 / found.sample_rate_hz).collect()
}

fn motion(found: &Found) -> Figure {
    let unit = found.output.to_string();
    let mut panel = Panel::new(Axis::linear("time", "s"), Axis::linear("displacement", unit))
        .series(Series::line("reference", time(found), found.reference.clone(), Style::nth(0)));
    for (i, run) in found.runs.iter().enumerate().filter(|(i, _)| *i == 0 || *i + 1 == found.runs.len()) {
        let style = Style::nth(usize::from(i > 0) + 1);
        let y = run.played.displacement.clone();
        panel = panel.series(Series::line(run.controller.words(), time(found), y, style));
    }
    Figure::new("Reference and displacement")
        .panel(panel)
        .captioned("The reference with the first and the last controller of the table, simulated.")
}

/// Error over time of the controllers that leave least, and of the first.
fn errors(found: &Found) -> Figure {
    let unit = found.output.to_string();
    let mut order: Vec<usize> = (0..found.runs.len()).collect();
    order.sort_by(|a, b| found.runs[*b].score.rms.total_cmp(&found.runs[*a].score.rms));
    let skipped = order.len().saturating_sub(CURVES - 1);
    let mut shown: Vec<usize> = vec![0];
    shown.extend(order.into_iter().skip(skipped).filter(|i| *i != 0));
    let mut figure = Figure::new("Error over time").panel_height(180.0);
    for (place, i) in shown.into_iter().enumerate() {
        let run = &found.runs[i];
        let from = found.scored_from;
        let error = found.reference.iter().zip(&run.played.displacement).skip(from);
        let error: Vec<f64> = error.map(|(r, y)| r - y - run.score.mean).collect();
        let time = time(found).split_off(from);
        let panel = Panel::new(Axis::linear("time", "s"), Axis::linear("error", unit.clone()))
            .series(Series::line(run.controller.words(), time, error, Style::nth(place)));
        figure = figure.panel(panel);
    }
    figure.captioned("Reference less displacement, mean taken off: the first controller and those that leave least. Each panel has its own scale.")
}

fn reach(found: &Found) -> Figure {
    let (x, y) = found.reach.iter().map(|r| (r.amplitude, r.highest_hz)).unzip();
    let axis = Axis::log("amplitude", found.output.to_string());
    let panel = Panel::new(axis, Axis::log("highest frequency", "Hz")).series(Series::line(
        "largest rate of the drive",
        x,
        y,
        Style::nth(0),
    ));
    Figure::new("Bandwidth against amplitude").panel(panel).captioned(
        "Highest frequency of a sine that the largest rate of the drive does not hold back, by formula from the model.",
    )
}
