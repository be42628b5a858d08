//! The comparison as a page: Bode figure, errors, table, words.

use crate::figure::{
    Axis, Colour, Dash, Figure, FrequencyResponseCurve, Marker, Panel, Series, Style, frequency_response,
};
use crate::number::with_std_error;
use crate::page::{Block, Column, Page, Section, Table};
use crate::results::response::{ABOUT_AIC, cells};
use hysteron_identify::frequency_response::empirical::{DetectionLines, EmpiricalResponse};
use hysteron_identify::frequency_response::{Explained, unwrapped_phase_deg};
use hysteron_model::model_file::Maker;

/// The page of the structures fitted to a frequency response; `maker`: who made it, and by which command.
pub fn page(found: &Explained, maker: &Maker) -> Page {
    let mut response = Section::new("Response and structures")
        .block(Block::paragraph(found.what()))
        .block(bode(found))
        .block(comparison(found))
        .block(Block::list(found.candidates.iter().map(|c| format!("{}: {}", c.name, c.explanation))));
    response = response.block(Block::info(ABOUT_AIC));
    let mut page = Page::new(format!("Frequency response of {}", found.response.name)).section(response);
    if let Some(measured) = &found.empirical {
        page = page.section(
            Section::new("Noise and distortion")
                .block(Block::paragraph(measured.in_words()))
                .block(levels(measured)),
        );
    }
    page = page.section(Section::new("Parameters").block(parameters(found)));
    if let Some(command) = &maker.command {
        page = page.section(Section::new("Provenance").block(Block::code(command)));
    }
    page.footer_line(&maker.program)
}

/// Measured points, a line a structure, and the errors below.
fn bode(found: &Explained) -> Figure {
    let response = &found.response;
    let frequency_hz = &response.frequency_hz;
    let curve =
        |label: &str, values: &[hysteron_numeric::Complex64], phase_deg, as_points| FrequencyResponseCurve {
            label: label.to_owned(),
            frequency_hz: frequency_hz.clone(),
            magnitude: values.iter().map(|g| g.norm()).collect(),
            phase_deg,
            as_points,
        };
    let phase = response.phase_deg();
    let mut curves = vec![curve("measured", &response.values, phase.clone(), true)];
    let mut errors = Panel::new(Axis::log("frequency", "Hz"), Axis::log("|model/measured − 1|", "%"));
    for (i, candidate) in found.candidates.iter().enumerate() {
        let fitted = candidate.fit.response_at(frequency_hz);
        let near = nearest_turn(&unwrapped_phase_deg(&fitted), &phase);
        curves.push(curve(&candidate.name, &fitted, near, false));
        let error = candidate.fit.relative_errors(response).iter().map(|e| 100.0 * e.norm()).collect();
        // The measured points have the first style of the figure.
        let style = Style::nth(i + 1);
        errors = errors.series(Series::line(candidate.name.as_str(), frequency_hz.clone(), error, style));
    }
    frequency_response(format!("Frequency response of {}", response.name), shown(&response.unit), &curves)
        .panel(errors)
        .captioned("Measured points, the structures fitted to them, and their relative errors.")
}

/// Phases moved by whole turns so that they start beside the measured ones.
pub fn nearest_turn(phase: &[f64], measured: &[f64]) -> Vec<f64> {
    let turns = match (phase.first(), measured.first()) {
        (Some(a), Some(b)) => ((b - a) / 360.0).round(),
        _ => 0.0,
    };
    phase.iter().map(|p| p + 360.0 * turns).collect()
}

/// `um_per_V` as µm/V.
pub fn shown(unit: &str) -> String {
    unit.replace("um", "µm").replace("_per_", "/")
}

fn comparison(found: &Explained) -> Table {
    let best = found.lowest_aic();
    let columns = [
        Column::text("structure"),
        Column::text("formula"),
        Column::number("parameters", ""),
        Column::number("rms error", "%"),
        Column::number("largest error", "%"),
        Column::number("AIC above the best", ""),
    ];
    found.candidates.iter().fold(Table::new(columns), |table, c| table.row(cells(c, best)))
}

fn parameters(found: &Explained) -> Table {
    let columns = [
        Column::text("structure"),
        Column::text("parameter"),
        Column::number("value", ""),
        Column::number("std. error", ""),
        Column::text("unit"),
    ];
    let mut table = Table::new(columns);
    for candidate in &found.candidates {
        for (place, p) in candidate.fit.parameters.iter().enumerate() {
            let structure = if place == 0 { candidate.name.clone() } else { String::new() };
            let (value, error) = with_std_error(p.value, p.std_error);
            let error = if p.on_edge { "on the edge".to_owned() } else { error };
            table = table.row([structure, p.name.clone(), value, error, shown(&p.unit)]);
        }
    }
    table
}

/// Response, its noise and its distortion over frequency; output amplitude at the lines that are not excited.
fn levels(found: &EmpiricalResponse) -> Figure {
    let response = &found.response;
    let frequency = || Axis::log("frequency", "Hz");
    let mut panel = Panel::new(frequency(), Axis::log("magnitude", shown(&response.unit)));
    let magnitude = response.values.iter().map(|g| g.norm()).collect();
    let lists = [
        ("response", Some(magnitude)),
        ("noise of the mean", found.noise_std.clone()),
        ("nonlinear distortion", found.distortion_std.clone()),
    ];
    for (i, (label, list)) in lists.into_iter().enumerate() {
        if let Some(list) = list {
            panel = panel.series(Series::line(label, response.frequency_hz.clone(), list, Style::nth(i)));
        }
    }
    let mut figure = Figure::new("Noise and distortion").panel(panel).panel_height(220.0);
    let mut lines = Panel::new(frequency(), Axis::log("output amplitude", ""));
    let detection: [(&str, &DetectionLines, Colour); 2] =
        [("odd", &found.odd_detection, Colour::Vermillion), ("even", &found.even_detection, Colour::Blue)];
    for (parity, list, colour) in detection {
        let style = Style::line(colour).with_dash(Dash::None).with_marker(Marker::Circle);
        let series = |label: String, y: &[f64], style| {
            Series::line(label, list.frequency_hz.clone(), y.to_vec(), style)
        };
        if !list.amplitude.is_empty() {
            lines = lines
                .series(series(format!("{parity} lines, not excited"), &list.amplitude, style))
                .series(series(format!("{parity} lines, noise"), &list.noise, Style::line(colour)));
        }
    }
    if !lines.series.is_empty() {
        figure = figure.panel(lines);
    }
    figure.captioned(
        "Noise from the scatter between periods, distortion from that between realisations; lines in the \
         band that are not excited show distortion of odd and of even order above the noise.",
    )
}
