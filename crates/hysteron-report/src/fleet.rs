//! Page of a fleet of devices: distributions of parameters, devices outside the fleet's region, drift over
//! time, worst fits with small pictures, failures, and every device with a link to its own report.

use hysteron_model::model_file::typographic;
use hysteron_numeric::number::significant;
use serde::Deserialize;

use crate::figure::{Axis, Figure, Marker, Panel, Series, Style, histogram};
use crate::page::{Block, Cell, Column, Highlight, Page, Section, Table};

/// Classes of a distribution at most.
const MOST_CLASSES: f64 = 40.0;

/// What is known of a fleet, as its registry gives it. Texts are plain text; the page escapes them.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fleet {
    /// Title of the page.
    pub title: String,
    /// Where the results are from: registry, dates, program.
    pub sources: Vec<String>,
    /// Devices by their latest calibration.
    pub devices: Vec<FleetDevice>,
    /// Calibrations in the registry, earlier ones of a device included.
    pub calibrations: usize,
    /// Values of each parameter over the fleet.
    pub distributions: Vec<Distribution>,
    /// How the region of the fleet was drawn, or why there is none.
    pub region: String,
    /// Devices outside the region, furthest first.
    pub outside: Vec<Outside>,
    /// How drift was judged.
    pub drift: String,
    /// Parameters that have drifted, by their significance.
    pub drifts: Vec<Drift>,
    /// Worst fits, worst first.
    pub worst: Vec<WorstFit>,
}

/// A device by its latest calibration.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FleetDevice {
    /// Name of the device.
    pub device: String,
    /// Serial number; may be empty.
    pub serial: String,
    /// Date of the record.
    pub date: String,
    /// Why there is no model; empty where there is one.
    pub reason: String,
    /// Root mean square of the residual, in `unit`.
    pub rmse: Option<f64>,
    /// Fit \[%\].
    pub fit_percent: Option<f64>,
    /// Unit of the output.
    pub unit: String,
    /// Path of its report, relative to the page; empty where there is none.
    pub report: String,
}

/// Values of one parameter over the fleet.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Distribution {
    /// Name.
    pub name: String,
    /// Unit of the values.
    pub unit: String,
    /// Value of each device.
    pub values: Vec<f64>,
    /// Median of the standard errors, if known.
    pub std_error: Option<f64>,
}

/// A device outside the region of the fleet.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outside {
    /// Name of the device.
    pub device: String,
    /// Robust distance from the centre of the fleet.
    pub distance: f64,
    /// Probability that a device of the fleet is as far away.
    pub p: f64,
    /// Parameters that differ most, in words.
    pub parameters: String,
    /// Path of its report, relative to the page.
    pub report: String,
}

/// A parameter of a device over its calibrations.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drift {
    /// Name of the device.
    pub device: String,
    /// Name of the parameter.
    pub parameter: String,
    /// Its unit.
    pub unit: String,
    /// Dates of the calibrations, in days since the first one.
    pub days: Vec<f64>,
    /// Value at each.
    pub values: Vec<f64>,
    /// Change of the latest value against the mean of those before, in per cent of that mean.
    pub change_percent: Option<f64>,
    /// Probability of a larger change of an unchanged device.
    pub p: f64,
}

/// A fit with its loop.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorstFit {
    /// Name of the device.
    pub device: String,
    /// Root mean square of the residual.
    pub rmse: f64,
    /// Fit \[%\].
    pub fit_percent: Option<f64>,
    /// Unit of the input.
    pub input_unit: String,
    /// Unit of the output.
    pub unit: String,
    /// Samples of the input, reduced.
    pub u: Vec<f64>,
    /// Measured output at these.
    pub measured: Vec<f64>,
    /// Output of the model at these.
    pub model: Vec<f64>,
    /// Path of its report, relative to the page.
    pub report: String,
}

/// Page of a fleet.
pub fn page(fleet: &Fleet, program: &str) -> Page {
    let (failed, fitted): (Vec<_>, Vec<_>) =
        fleet.devices.iter().partition(|device| !device.reason.is_empty());
    let mut subtitle = format!("{} devices, {} calibrations", fleet.devices.len(), fleet.calibrations);
    if !failed.is_empty() {
        subtitle += &format!(", {} devices without a model", failed.len());
    }
    let mut page = Page::new(&fleet.title)
        .subtitled(subtitle)
        .section(summary(fleet, failed.len(), &fitted))
        .section(outside(fleet))
        .section(drift(fleet))
        .section(distributions(fleet))
        .section(worst(fleet))
        .section(failures(&failed))
        .section(all(&fitted));
    for line in &fleet.sources {
        page = page.footer_line(line);
    }
    page.footer_line(program)
}

fn summary(fleet: &Fleet, failed: usize, fitted: &[&FleetDevice]) -> Section {
    let mut fits: Vec<f64> = fitted.iter().filter_map(|device| device.fit_percent).collect();
    fits.sort_by(f64::total_cmp);
    let mut highlights = vec![
        Highlight::new("devices with a model", fitted.len().to_string(), ""),
        Highlight::new("failed", failed.to_string(), ""),
        Highlight::new("outside the region", fleet.outside.len().to_string(), ""),
        Highlight::new("parameters that drifted", fleet.drifts.len().to_string(), ""),
    ];
    if let Some(median) = fits.get(fits.len() / 2) {
        highlights.push(Highlight::new("median fit", significant(*median, 4), "%"));
    }
    Section::new("Summary").block(Block::Highlights(highlights))
}

fn outside(fleet: &Fleet) -> Section {
    let section = Section::new("Devices outside the fleet's region").block(Block::paragraph(&fleet.region));
    if fleet.outside.is_empty() {
        return section;
    }
    let columns = [
        Column::text("device"),
        Column::number("distance", ""),
        Column::number("p", ""),
        Column::text("parameters that differ most"),
    ];
    let table = fleet.outside.iter().fold(Table::new(columns), |table, out| {
        table.row([
            linked(&out.device, &out.report),
            significant(out.distance, 3).into(),
            significant(out.p, 2).into(),
            out.parameters.as_str().into(),
        ])
    });
    section.block(table)
}

fn drift(fleet: &Fleet) -> Section {
    let section = Section::new("Drift over time").block(Block::paragraph(&fleet.drift));
    if fleet.drifts.is_empty() {
        return section;
    }
    let columns = [
        Column::text("device"),
        Column::text("parameter"),
        Column::number("latest", ""),
        Column::text("unit"),
        Column::number("change", "%"),
        Column::number("p", ""),
    ];
    let mut table = Table::new(columns);
    let mut figure = Figure::new("Parameters that drifted")
        .captioned("Each parameter over its calibrations, the latest at the right.")
        .in_columns(3)
        .panel_height(110.0);
    for drift in &fleet.drifts {
        let latest = drift.values.last().map_or_else(String::new, |value| significant(*value, 5));
        table = table.row([
            drift.device.clone(),
            drift.parameter.clone(),
            latest,
            drift.unit.clone(),
            drift.change_percent.map_or_else(String::new, |change| significant(change, 3)),
            significant(drift.p, 2),
        ]);
    }
    for drift in fleet.drifts.iter().take(9) {
        let style = Style::measured().with_marker(Marker::Circle);
        let series = Series::line("", drift.days.clone(), drift.values.clone(), style);
        let axes = (Axis::linear("time", "days"), Axis::linear(&drift.parameter, &drift.unit));
        figure = figure.panel(Panel::new(axes.0, axes.1).titled(&drift.device).series(series));
    }
    section.block(figure).block(table)
}

fn distributions(fleet: &Fleet) -> Section {
    let mut figure = Figure::new("Distributions of the parameters")
        .captioned("Latest calibration of each device.")
        .in_columns(3)
        .panel_height(110.0);
    let columns = [
        Column::text("parameter"),
        Column::text("unit"),
        Column::number("5 %", ""),
        Column::number("median", ""),
        Column::number("95 %", ""),
        Column::number("median standard error", ""),
    ];
    let mut table = Table::new(columns);
    for distribution in &fleet.distributions {
        let mut sorted = distribution.values.clone();
        sorted.sort_by(f64::total_cmp);
        let at = |p: f64| sorted.get(((sorted.len() - 1) as f64 * p).round() as usize).copied();
        if sorted.is_empty() {
            continue;
        }
        let shown = |value: Option<f64>| value.map_or_else(String::new, |value| significant(value, 4));
        table = table.row([
            distribution.name.clone(),
            distribution.unit.clone(),
            shown(at(0.05)),
            shown(at(0.5)),
            shown(at(0.95)),
            shown(distribution.std_error),
        ]);
        let classes = (sorted.len() as f64).sqrt().ceil().clamp(1.0, MOST_CLASSES) as usize;
        let axis = Axis::linear(&distribution.name, &distribution.unit);
        for mut panel in histogram("", axis, &sorted, classes).panels {
            panel.y = Axis::linear("devices", "");
            figure = figure.panel(panel);
        }
    }
    if table.rows.is_empty() {
        return Section::new("Parameters");
    }
    Section::new("Parameters").block(figure).block(table)
}

fn worst(fleet: &Fleet) -> Section {
    if fleet.worst.is_empty() {
        return Section::new("Worst fits");
    }
    let mut figure = Figure::new("Worst fits: loops, measured and model")
        .captioned("Free run of the model over the record of its fit, samples reduced.")
        .in_columns(3)
        .panel_height(120.0);
    let columns = [
        Column::text("device"),
        Column::number("RMSE", ""),
        Column::text("unit"),
        Column::number("fit", "%"),
    ];
    let mut table = Table::new(columns);
    for (k, fit) in fleet.worst.iter().enumerate() {
        table = table.row([
            linked(&fit.device, &fit.report),
            significant(fit.rmse, 4).into(),
            typographic(&fit.unit).into(),
            fit.fit_percent.map_or_else(String::new, |percent| significant(percent, 4)).into(),
        ]);
        let label = |text: &str| if k == 0 { text.to_owned() } else { String::new() };
        let measured =
            Series::line(label("measured"), fit.u.clone(), fit.measured.clone(), Style::measured());
        let model = Series::line(label("model"), fit.u.clone(), fit.model.clone(), Style::model());
        let panel = Panel::new(
            Axis::linear("input", typographic(&fit.input_unit)),
            Axis::linear("output", typographic(&fit.unit)),
        )
        .titled(&fit.device)
        .series(measured)
        .series(model);
        figure = figure.panel(panel);
    }
    Section::new("Worst fits").block(figure).block(table)
}

fn failures(failed: &[&FleetDevice]) -> Section {
    let section = Section::new("Devices without a model");
    if failed.is_empty() {
        return section;
    }
    let columns = [Column::text("device"), Column::text("date"), Column::text("reason")];
    let table = failed.iter().fold(Table::new(columns), |table, device| {
        table.row([device.device.clone(), device.date.clone(), device.reason.clone()])
    });
    section.block(table)
}

fn all(fitted: &[&FleetDevice]) -> Section {
    let section = Section::new("All devices");
    if fitted.is_empty() {
        return section;
    }
    let columns = [
        Column::text("device"),
        Column::text("serial number"),
        Column::text("date"),
        Column::number("RMSE", ""),
        Column::text("unit"),
        Column::number("fit", "%"),
    ];
    let table = fitted.iter().fold(Table::new(columns), |table, device| {
        let shown = |value: Option<f64>| value.map_or_else(String::new, |value| significant(value, 4));
        table.row([
            linked(&device.device, &device.report),
            device.serial.as_str().into(),
            device.date.as_str().into(),
            shown(device.rmse).into(),
            typographic(&device.unit).into(),
            shown(device.fit_percent).into(),
        ])
    });
    let summary = format!("{} devices, with links to their reports", fitted.len());
    section.block(Block::details(summary, vec![table.into()]))
}

fn linked(device: &str, report: &str) -> Cell {
    if report.is_empty() { Cell::new(device) } else { Cell::linked(device, report) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fleet() -> Fleet {
        let device = |name: &str, reason: &str| FleetDevice {
            device: name.into(),
            reason: reason.into(),
            rmse: Some(0.25),
            fit_percent: Some(97.0),
            unit: "um".into(),
            report: format!("reports/{name}.html"),
            ..FleetDevice::default()
        };
        Fleet {
            title: "Fleet".into(),
            devices: vec![device("<b>A</b>", ""), device("B", "the file is empty")],
            calibrations: 3,
            distributions: vec![Distribution {
                name: "alpha".into(),
                unit: "um/V".into(),
                values: vec![1.0, 2.0, 4.0],
                std_error: Some(0.1),
            }],
            region: "99 % region".into(),
            outside: vec![Outside { device: "C".into(), distance: 7.0, p: 1e-9, ..Outside::default() }],
            drifts: vec![Drift {
                device: "D".into(),
                values: vec![1.0],
                days: vec![0.0],
                ..Drift::default()
            }],
            worst: vec![WorstFit {
                device: "E".into(),
                report: "javascript:alert(1)".into(),
                ..WorstFit::default()
            }],
            ..Fleet::default()
        }
    }

    #[test]
    fn every_part_of_the_page_is_there_and_names_stay_text() {
        let html = page(&fleet(), "hysteron").to_html();
        for text in ["outside the fleet", "alpha", "the file is empty", "2 devices, 3 calibrations"] {
            assert!(html.contains(text), "{text}");
        }
        assert!(html.contains("&lt;b&gt;A&lt;/b&gt;") && !html.contains("<b>A</b>"));
    }

    #[test]
    fn a_link_leads_to_a_file_and_runs_nothing() {
        let html = page(&fleet(), "hysteron").to_html();
        assert!(html.contains("href=\"reports/%3Cb%3EA%3C/b%3E.html\""));
        assert!(html.contains("href=\"javascript%3Aalert%281%29\""));
    }
}
