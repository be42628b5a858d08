//! The report of an identification: data, model, accuracy and how to repeat it.
//!
//! [`report`] makes the page from the result. [`IdentificationReportData`] is what it shows, laid out by
//! [`identification_report`].

mod contents;
mod degrees;
mod parameters;
mod searches;

use crate::figure::{
    Axis, Colour, ConvergenceCurve, Dash, Figure, FrequencyResponseCurve, Series, Style, convergence,
    correlation_matrix, frequency_response,
};
use crate::number::{significant, with_std_error};
use crate::page::{Block, Column, Highlight, Page, Section, Table};
use crate::record_curves::RecordCurves;
use crate::starts::SearchStarts;
pub use degrees::DegreeRow;
use hysteron_identify::structure::Neighbours;
use hysteron_identify::{Correlation, Identification, IdentifyError};
use hysteron_model::model_file::ModelFile;
use hysteron_numeric::number::fixed;

/// The report of an identification, whose model's data are `file`: model, errors, scores, measured against
/// simulated, findings, how to repeat it. `others`: neighbours of the identified structure, where they were
/// compared.
pub fn report(
    model_name: &str,
    found: &Identification,
    file: &ModelFile,
    others: Option<&Result<Neighbours, IdentifyError>>,
) -> Page {
    identification_report(&contents::data(model_name, found, file, others))
}

/// Everything the report of an identification shows. Empty parts are left out of the page.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct IdentificationReportData {
    /// Title: device, records, structure.
    pub title: String,
    /// Name of the model, e.g. the stem of its file; stands before the summary.
    pub model_name: String,
    /// One line under the title: model family, how identified.
    pub summary: String,
    /// Whether the records come from a simulated bench; said in every figure.
    pub simulated: bool,
    /// Key figures of the result (RMSE, % of stroke, loop opening …).
    pub highlights: Vec<Highlight>,
    /// Warnings in plain words, shown first.
    pub warnings: Vec<String>,
    /// Properties that the records cannot determine, in plain words.
    pub limits: Vec<String>,
    /// Model equations, one line each, in plain text.
    pub equations: Vec<String>,
    /// Parameters in the order of the model.
    pub parameters: Vec<ParameterRow>,
    /// Verdicts about the model: loop sense, admissibility, stability; name and statement.
    pub verdicts: Vec<(String, String)>,
    /// Scores, one row a record.
    pub scores: Vec<ScoreRow>,
    /// Definition of every score, one sentence each.
    pub score_definitions: Vec<String>,
    /// Steps of data preparation, in order.
    pub preparation: Vec<String>,
    /// Records with their simulation.
    pub records: Vec<RecordCurves>,
    /// Convergence of the search, a curve for each step or optimiser; one run each is usual here.
    pub convergence: Vec<ConvergenceCurve>,
    /// Starts of the searches that have several.
    pub starts: Vec<SearchStarts>,
    /// Name of the objective, e.g. `RMSE`.
    pub objective: String,
    /// Unit of the objective, for the convergence plot.
    pub objective_unit: String,
    /// Name and unit of the convergence abscissa, e.g. `generation`.
    pub convergence_x_label: String,
    /// Frequency response of the dynamic block, if it has one.
    pub frequency_response: Vec<FrequencyResponseCurve>,
    /// Frequencies that the records excite, lowest and highest \[Hz\]; shaded in the response.
    pub excited_hz: Option<(f64, f64)>,
    /// Unit of the magnitude of the response.
    pub magnitude_unit: String,
    /// Correlation of the estimated parameters of each step.
    pub correlations: Vec<Correlation>,
    /// Polynomial degrees tried; empty where the degree was given.
    pub degrees: Vec<DegreeRow>,
    /// Why the degree used is the one; may be empty.
    pub degrees_note: String,
    /// Neighbours of the identified structure; empty where they were not compared.
    pub structures: Vec<StructureRow>,
    /// Method behind these numbers, or the reason why there are none; may be empty.
    pub structures_note: String,
    /// Why the convergence curves do not end at the scores; may be empty.
    pub convergence_note: String,
    /// Where the model comes from: records with hash, options, seed, program version; name and value.
    pub provenance: Vec<(String, String)>,
    /// Command lines that give the same result again.
    pub commands: Vec<String>,
    /// Small print at the end of the page.
    pub footer: Vec<String>,
}

/// One parameter of the model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ParameterRow {
    /// Block it belongs to, e.g. `hysteresis`.
    pub block: String,
    /// Symbol, e.g. `β`.
    pub symbol: String,
    /// Meaning, in words.
    pub meaning: String,
    /// Value.
    pub value: f64,
    /// Unit; empty for a pure number.
    pub unit: String,
    /// Standard error in the same unit, where it was estimated.
    pub std_error: Option<f64>,
    /// Ends of its 95 % interval; the column is left out where no parameter has one.
    pub interval: Option<(f64, f64)>,
    /// The interval comes from a profile of the fit instead of the standard error.
    pub is_profiled: bool,
    /// Origin of a value that was not estimated (`fixed`, `at its bound` …), behind the meaning; may be
    /// empty.
    pub note: String,
}

/// One structure fitted to the same records.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StructureRow {
    /// Its name, e.g. `integer2+creep`.
    pub name: String,
    /// Number of its parameters.
    pub parameters: usize,
    /// RMSE of its fit \[objective unit\].
    pub rmse: f64,
    /// Bayesian information criterion above the lowest of all.
    pub bic_above: f64,
    /// Whether it is the one identified.
    pub chosen: bool,
}

/// Scores of one record.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScoreRow {
    /// Record.
    pub record: String,
    /// `fitted` or `held out`.
    pub role: String,
    /// Samples scored.
    pub samples: usize,
    /// Samples skipped at the start.
    pub skipped: usize,
    /// Unit of the output.
    pub unit: String,
    /// Root mean square error \[unit\].
    pub rmse: f64,
    /// Largest absolute error \[unit\].
    pub max_abs_error: f64,
    /// RMSE over stroke \[%\].
    pub rmse_percent_of_stroke: f64,
    /// Largest error over stroke \[%\].
    pub max_percent_of_stroke: f64,
    /// 100 (1 − ‖y−ŷ‖/‖y−ȳ‖) \[%\].
    pub fit_percent: f64,
}

/// Lays out the report of an identification.
pub fn identification_report(data: &IdentificationReportData) -> Page {
    let mut overview = Section::new("");
    if !data.highlights.is_empty() {
        overview = overview.block(Block::Highlights(data.highlights.clone()));
    }
    if data.simulated {
        overview = overview.block(Block::info("The records of this report come from a simulated bench."));
    }
    overview = overview.blocks(data.warnings.iter().map(Block::warning));

    let named: Vec<&str> =
        [&data.model_name, &data.summary].into_iter().map(String::as_str).filter(|s| !s.is_empty()).collect();
    let mut page = Page::new(&data.title).subtitled(named.join(": ")).section(overview);
    page = page.section(scores(data)).section(loops(data)).section(model(data)).section(dynamics(data));
    page = page.section(search(data)).section(data_section(data)).section(repeat(data));
    page.footer = data.footer.clone();
    page
}

fn scores(data: &IdentificationReportData) -> Section {
    let mut section = Section::new("Accuracy");
    if !data.scores.is_empty() {
        let unit = data.scores.first().map(|s| s.unit.clone()).unwrap_or_default();
        let one_unit = data.scores.iter().all(|s| s.unit == unit);
        let header_unit = if one_unit { unit } else { String::new() };
        let mut columns = vec![
            Column::text("record"),
            Column::text("used as"),
            Column::number("samples", ""),
            Column::number("skipped", ""),
            Column::number("RMSE", &header_unit),
            Column::number("max |error|", &header_unit),
            Column::number("RMSE", "% of stroke"),
            Column::number("max", "% of stroke"),
            Column::number("fit", "%"),
        ];
        if !one_unit {
            columns.push(Column::text("unit"));
        }
        let mut table = Table::new(columns);
        for s in &data.scores {
            let mut cells = vec![
                s.record.clone(),
                s.role.clone(),
                fixed(s.samples as f64, 0),
                fixed(s.skipped as f64, 0),
                significant(s.rmse, 3),
                significant(s.max_abs_error, 3),
                significant(s.rmse_percent_of_stroke, 3),
                significant(s.max_percent_of_stroke, 3),
                significant(s.fit_percent, 4),
            ];
            if !one_unit {
                cells.push(s.unit.clone());
            }
            table = table.row(cells);
        }
        table.notes = data.score_definitions.clone();
        section = section.block(table);
    }
    if !data.limits.is_empty() {
        section = section.block(Block::Heading("Not determined by these records".into()));
        section = section.block(Block::List(data.limits.clone()));
    }
    section
}

fn loops(data: &IdentificationReportData) -> Section {
    let mut section = Section::new("Measured and model");
    for record in &data.records {
        section = section.blocks(record.figures());
    }
    section
}

fn model(data: &IdentificationReportData) -> Section {
    let mut section = Section::new("The model");
    section = section.blocks(data.equations.iter().cloned().map(Block::Formula));
    if !data.parameters.is_empty() {
        let mut columns = vec![
            Column::text("block"),
            Column::text("symbol"),
            Column::text("meaning"),
            Column::number("value", ""),
            Column::number("std. error", ""),
            Column::text("unit"),
        ];
        let intervals = data.parameters.iter().any(|p| p.interval.is_some());
        if intervals {
            columns.insert(5, Column::text("95 % interval"));
        }
        let mut table = Table::new(columns);
        let mut block = "";
        for p in &data.parameters {
            let (value, error) = with_std_error(p.value, p.std_error);
            let shown = if p.block == block { String::new() } else { p.block.clone() };
            block = &p.block;
            let meaning = match p.note.as_str() {
                "" => p.meaning.clone(),
                note => format!("{} ({note})", p.meaning),
            };
            // A file's name may break after an underscore, or it would push the units off the page.
            let meaning = meaning.replace('_', "_\u{200b}");
            let mut cells = vec![shown, p.symbol.clone(), meaning, value, error, p.unit.clone()];
            if intervals {
                let end = |x: f64| with_std_error(x, p.std_error).0;
                let mark = if p.is_profiled { " *" } else { "" };
                let both = |(low, high): (f64, f64)| format!("{} … {}{mark}", end(low), end(high));
                // On one line.
                cells.insert(5, p.interval.map(both).unwrap_or_default().replace(' ', "\u{a0}"));
            }
            table = table.row(cells);
        }
        if data.parameters.iter().any(|p| p.is_profiled) {
            table = table.note(
                "* by profile likelihood: the fit is not linear enough in this parameter for its standard \
                error.",
            );
        }
        section = section.block(table);
    }
    if !data.verdicts.is_empty() {
        section = section.block(Block::KeyValues(data.verdicts.clone()));
    }
    if !data.degrees.is_empty() {
        section = section.block(degrees::table(data));
    }
    section = section.blocks(data.correlations.iter().filter(|c| c.names.len() > 1).map(correlation));
    if data.structures.is_empty() && data.structures_note.is_empty() {
        return section;
    }
    section = section.block(Block::Heading("Other structures on the same records".into()));
    if data.structures.is_empty() {
        return section.block(Block::paragraph(&data.structures_note));
    }
    section.block(structures(data))
}

/// The identified structure, shaded, and its neighbours.
fn structures(data: &IdentificationReportData) -> Table {
    let mut table = Table::new([
        Column::text("structure"),
        Column::number("parameters", ""),
        Column::number("RMSE", &data.objective_unit),
        Column::number("BIC above the lowest", ""),
    ]);
    for s in &data.structures {
        let cells = [s.name.clone(), s.parameters.to_string(), significant(s.rmse, 4), fixed(s.bic_above, 1)];
        table = if s.chosen { table.highlighted_row(cells) } else { table.row(cells) };
    }
    table.note(&data.structures_note)
}

/// Correlation of the estimates of one step.
fn correlation(c: &Correlation) -> Figure {
    let title = format!("Correlation of the parameters: {}", c.step);
    correlation_matrix(title, &c.names, &c.matrix).captioned(format!(
        "Correlation of the estimates of the step '{}'; condition number {}. Parameters with a correlation \
         near ±1 are hardly distinguishable: these records determine only their combination.",
        c.step,
        significant(c.condition_number, 3)
    ))
}

fn dynamics(data: &IdentificationReportData) -> Section {
    let mut section = Section::new("Frequency response of the dynamics");
    if !data.frequency_response.is_empty() {
        let mut figure =
            frequency_response("Frequency response", &data.magnitude_unit, &data.frequency_response);
        if let Some((from, to)) = data.excited_hz.filter(|(from, to)| from < to) {
            for panel in &mut figure.panels {
                *panel = std::mem::take(panel).span(from, to, "excited by the records");
            }
        }
        if let Some((at, _)) = data.excited_hz.filter(|(from, to)| from == to) {
            mark_frequency(&mut figure, at);
        }
        section = section.block(figure.captioned(
            "Response of the linear block behind the hysteresis, delay included. It is not that of the whole \
             actuator.",
        ));
    }
    section
}

/// Marks the one frequency that the records excite on every curve.
fn mark_frequency(figure: &mut Figure, at_hz: f64) {
    let label = format!("excited by the records: {} Hz", significant(at_hz, 3));
    for panel in &mut figure.panels {
        let mark = |s: &Series| {
            let k = s.x.iter().position(|f| *f >= at_hz)?;
            let (x0, x1) = (s.x[k.saturating_sub(1)], s.x[k]);
            let share = if x1 > x0 { (at_hz - x0) / (x1 - x0) } else { 0.0 };
            let (y0, y1) = (s.y.get(k.saturating_sub(1))?, s.y.get(k)?);
            let style = Style::line(Colour::Vermillion).marked(0).with_dash(Dash::None);
            Some(Series::line(label.as_str(), vec![at_hz], vec![y0 + share * (y1 - y0)], style))
        };
        let marks: Vec<Series> = panel.series.iter().filter_map(mark).collect();
        panel.series.extend(marks);
    }
}

fn search(data: &IdentificationReportData) -> Section {
    let mut section = Section::new("Convergence of the search");
    if !data.convergence.is_empty() {
        let x_label = if data.convergence_x_label.is_empty() {
            "generation"
        } else {
            data.convergence_x_label.as_str()
        };
        let objective = if data.objective.is_empty() { "objective" } else { data.objective.as_str() };
        let figure = convergence(
            "Convergence",
            x_label,
            Axis::log(format!("best {objective} so far"), &data.objective_unit),
            &data.convergence,
        );
        let note = if data.convergence_note.is_empty() {
            String::new()
        } else {
            format!(" {}", data.convergence_note)
        };
        let spread = data.convergence.iter().any(|c| c.runs.len() > 1);
        section = section.block(figure.captioned(if spread {
            format!("Best {objective} so far: median over the runs, quartiles shaded.{note}")
        } else {
            format!("Best {objective} so far.{note}")
        }));
    }
    for starts in &data.starts {
        section = section.blocks(starts.blocks());
    }
    section
}

fn data_section(data: &IdentificationReportData) -> Section {
    let mut section = Section::new("Data treatment");
    if !data.preparation.is_empty() {
        section = section.block(Block::List(data.preparation.clone()));
    }
    section
}

fn repeat(data: &IdentificationReportData) -> Section {
    let mut section = Section::new("Reproduction");
    if !data.commands.is_empty() {
        section = section.block(Block::Code(data.commands.join("\n")));
    }
    if !data.provenance.is_empty() {
        section = section.block(Block::KeyValues(data.provenance.clone()));
    }
    section
}
