//! The report of an identification: what was measured, what was found, how good it is, how to repeat it.
//!
//! [`IdentificationReportData`] is plain data that the command line fills; [`identification_report`] lays it out.

use crate::figure::ticks::fixed;
use crate::figure::{
    Axis, Colour, ConvergenceCurve, Dash, Figure, FrequencyResponseCurve, Panel, Series, Style, convergence,
    correlation_matrix, correlogram, frequency_response, measured_and_model, residual,
};
use crate::number::{significant, with_std_error};
use crate::page::{Block, Column, Highlight, Page, Section, Table};
use crate::starts::SearchStarts;
use hysteron::identify::Correlation;
use hysteron::validate::Correlogram;

/// Everything the report of an identification shows. Empty parts are left out of the page.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct IdentificationReportData {
    /// Name of the model, e.g. the stem of its file.
    pub model_name: String,
    /// One line under the title: model family, how identified.
    pub summary: String,
    /// Whether the records come from a simulated bench; said in every figure.
    pub simulated: bool,
    /// The few numbers that sum the result up (RMSE, % of stroke, loop opening …).
    pub highlights: Vec<Highlight>,
    /// Warnings in plain words, shown first.
    pub warnings: Vec<String>,
    /// What the records can not determine, in plain words.
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
    /// What was done to the data, in order.
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
    /// What it is, in words.
    pub meaning: String,
    /// Value.
    pub value: f64,
    /// Unit; empty for a pure number.
    pub unit: String,
    /// Standard error in the same unit, where it was estimated.
    pub std_error: Option<f64>,
    /// Ends of its 95 % interval; the column is left out where no parameter has one.
    pub interval: Option<(f64, f64)>,
    /// How it came about when it was not estimated (`fixed`, `at its bound` …); may be empty.
    pub note: String,
}

/// One polynomial degree that was tried.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DegreeRow {
    /// Degree.
    pub degree: usize,
    /// RMSE of its fit \[objective unit\].
    pub rmse: f64,
    /// Bayesian information criterion of its fit.
    pub bic: f64,
    /// Whether it was chosen.
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

/// One record with the model's simulation, all of the same length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RecordCurves {
    /// Name, e.g. the file.
    pub name: String,
    /// `fitted` or `held out`.
    pub role: String,
    /// Time \[s\].
    pub time_s: Vec<f64>,
    /// Name and unit of the input, e.g. `("voltage", "V")`.
    pub input: (String, String),
    /// Input values.
    pub u: Vec<f64>,
    /// Name and unit of the output, e.g. `("displacement", "µm")`.
    pub output: (String, String),
    /// Measured output.
    pub measured: Vec<f64>,
    /// Simulated output.
    pub model: Vec<f64>,
    /// Whether a sample was used; empty means all. Unused samples are not drawn.
    pub valid: Vec<bool>,
    /// Time up to which samples were skipped in the scores \[s\]; 0 for none.
    pub skipped_until_s: f64,
    /// Autocorrelation of the residual; `None` for a record too short for it.
    pub autocorrelation: Option<Correlogram>,
    /// Correlation of the residual with the input.
    pub input_correlation: Option<Correlogram>,
}

impl RecordCurves {
    /// The values of valid samples, NaN elsewhere.
    fn masked(&self, values: &[f64]) -> Vec<f64> {
        let used = |k: usize| self.valid.is_empty() || self.valid.get(k).copied().unwrap_or(false);
        values.iter().enumerate().map(|(k, v)| if used(k) { *v } else { f64::NAN }).collect()
    }

    fn x_axis(&self) -> Axis {
        Axis::linear(&self.input.0, &self.input.1)
    }

    fn y_axis(&self) -> Axis {
        Axis::linear(&self.output.0, &self.output.1)
    }

    /// The loop, measured and model.
    pub fn loop_figure(&self) -> Figure {
        let (measured, model) = (self.masked(&self.measured), self.masked(&self.model));
        Figure::new(format!("Hysteresis loop: {}", self.name))
            .panel(measured_and_model(self.x_axis(), self.y_axis(), &self.u, &measured, &model))
            .panel_height(310.0)
            .captioned(format!(
                "Measured and simulated {} over {} of record {}.",
                self.output.0, self.input.0, self.name
            ))
    }

    /// Input, output and residual over time, on one time axis.
    pub fn time_figure(&self) -> Figure {
        self.curves_over_time(self.time_s.len()).titled(format!("Time curves: {}", self.name)).captioned(
            format!(
                "Input, measured and simulated output, and residual (measured − model) of record {}.",
                self.name
            ),
        )
    }

    /// The first periods of a record that has more than [`CROWDED`], over time; `None` for other records.
    pub fn start_figure(&self) -> Option<Figure> {
        let starts = self.period_starts();
        if starts.len() <= CROWDED {
            return None;
        }
        // The record may begin within a period, so its end is counted from the record's first sample.
        let end = starts.get(PERIODS_SHOWN)?.checked_sub(*starts.first()?)?;
        let figure = self.curves_over_time(end.min(self.time_s.len()));
        Some(figure.titled(format!("Start of the record: {}", self.name)).captioned(format!(
            "The first {PERIODS_SHOWN} of {} periods of record {}.",
            starts.len(),
            self.name
        )))
    }

    /// Samples at which the input rises through the middle of its range, after having been below a tenth
    /// of the range under it.
    fn period_starts(&self) -> Vec<usize> {
        let values = || self.u.iter().copied().filter(|u| u.is_finite());
        let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), u| (a.min(u), b.max(u)));
        let (middle, armed_below) = (0.5 * (low + high), 0.4 * high + 0.6 * low);
        let (mut armed, mut starts) = (false, Vec::new());
        for (k, u) in self.u.iter().enumerate() {
            armed |= *u < armed_below;
            if armed && *u >= middle {
                armed = false;
                starts.push(k);
            }
        }
        starts
    }

    /// Correlation of the residual with itself and with the input; `None` for a record too short for it.
    pub fn residual_figure(&self) -> Option<Figure> {
        let tests = [
            ("with itself", self.autocorrelation.as_ref()?),
            ("with the input", self.input_correlation.as_ref()?),
        ];
        let mut figure = Figure::new(format!("Residual: {}", self.name)).in_columns(2).panel_height(150.0);
        let mut outside = Vec::new();
        for (title, c) in tests {
            figure = figure.panel(correlogram(title, c.first_lag, &c.coefficients, c.bound));
            let test = c.test();
            outside.push(format!("{} of {} lags {title}", test.outside, test.lags));
        }
        Some(figure.captioned(format!(
            "Correlation of the residual of record {}. Noise alone would stay within the 99 % bounds (dashed) at all but about one \
             lag in a hundred; outside are {}. What is outside is structure that the model does not describe: creep, minor loops, \
             dynamics (positive lags of the input), or a delay that is too long (negative lags).",
            self.name,
            outside.join(" and ")
        )))
    }

    /// Input, output and residual of the first `samples` samples.
    fn curves_over_time(&self, samples: usize) -> Figure {
        let first = |values: &[f64]| values.iter().take(samples).copied().collect::<Vec<f64>>();
        let time_s = first(&self.time_s);
        let (measured, model) = (first(&self.masked(&self.measured)), first(&self.masked(&self.model)));
        let time = || Axis::linear("time", "s");
        let grey = Style::line(Colour::Grey).with_width(1.2);
        let input =
            Panel::new(time(), self.x_axis()).series(Series::line("", time_s.clone(), first(&self.u), grey));
        let mut output = measured_and_model(time(), self.y_axis(), &time_s, &measured, &model);
        let mut error = residual(time(), &self.output.1, &time_s, &measured, &model);
        if let (Some(start), true) = (time_s.first(), self.skipped_until_s > 0.0) {
            output = output.span(*start, self.skipped_until_s, "not scored");
            error = error.span(*start, self.skipped_until_s, "");
        }
        Figure::new("").panel(input).panel(output).panel(error).panel_height(112.0).link_x()
    }
}

/// A time curve with more periods than this shows little: its start is drawn as well.
pub const CROWDED: usize = 12;

/// Periods in the figure of the start of a record.
const PERIODS_SHOWN: usize = 4;

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

    let mut page = Page::new(&data.model_name).subtitled(&data.summary).section(overview);
    page = page.section(scores(data)).section(loops(data)).section(model(data)).section(dynamics(data));
    page = page.section(search(data)).section(data_section(data)).section(repeat(data));
    page.footer = data.footer.clone();
    page
}

fn scores(data: &IdentificationReportData) -> Section {
    let mut section = Section::new("How good it is");
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
        section = section.block(Block::Heading("What these records cannot tell".into()));
        section = section.block(Block::List(data.limits.clone()));
    }
    section
}

fn loops(data: &IdentificationReportData) -> Section {
    let mut section = Section::new("Measured and model");
    let mark = |figure: Figure| if data.simulated { figure.subtitled("simulated bench") } else { figure };
    for record in &data.records {
        section = section.block(mark(record.loop_figure())).block(mark(record.time_figure()));
        section = section.blocks(record.start_figure().map(mark));
        section = section.blocks(record.residual_figure().map(mark));
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
            Column::text("remark"),
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
            let mut cells = vec![
                shown,
                p.symbol.clone(),
                p.meaning.clone(),
                value,
                error,
                p.unit.clone(),
                p.note.clone(),
            ];
            if intervals {
                let end = |x: f64| with_std_error(x, p.std_error).0;
                let both = |(low, high): (f64, f64)| format!("{} … {}", end(low), end(high));
                cells.insert(5, p.interval.map(both).unwrap_or_default());
            }
            table = table.row(cells);
        }
        section = section.block(table);
    }
    if !data.verdicts.is_empty() {
        section = section.block(Block::KeyValues(data.verdicts.clone()));
    }
    if !data.degrees.is_empty() {
        section = section.block(degrees(data));
    }
    section.blocks(data.correlations.iter().filter(|c| c.names.len() > 1).map(correlation))
}

/// The degrees tried, the chosen one shaded.
fn degrees(data: &IdentificationReportData) -> Table {
    let columns = [
        Column::number("degree", ""),
        Column::number("RMSE", &data.objective_unit),
        Column::number("BIC", ""),
    ];
    let mut table = Table::new(columns).captioned("Polynomial degrees tried").note(
        "A higher degree is taken where it lowers BIC by more than 10 and keeps the hysteresis bounded; shaded: the one used. BIC \
         counts only as many samples as are independent.",
    );
    for d in &data.degrees {
        let cells = [d.degree.to_string(), significant(d.rmse, 4), fixed(d.bic, 1)];
        table = if d.chosen { table.highlighted_row(cells) } else { table.row(cells) };
    }
    table
}

/// Correlation of the estimates of one step.
fn correlation(c: &Correlation) -> Figure {
    correlation_matrix(format!("Correlation of the parameters: {}", c.step), &c.names, &c.matrix).captioned(format!(
        "Correlation of the estimates of the step '{}'; condition number {}. Parameters with a correlation near ±1 can hardly be \
         told apart by these records: only their combination is determined.",
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
            for (panel, label) in figure.panels.iter_mut().zip(["excited by the records", ""]) {
                *panel = std::mem::take(panel).span(from, to, label);
            }
        }
        if let Some((at, _)) = data.excited_hz.filter(|(from, to)| from == to) {
            mark_frequency(&mut figure, at);
        }
        section = section.block(figure.captioned(
            "Response of the linear block behind the hysteresis, delay included. It is not that of the whole actuator.",
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
    let mut section = Section::new("How the search went");
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
    let mut section = Section::new("What was done to the data");
    if !data.preparation.is_empty() {
        section = section.block(Block::List(data.preparation.clone()));
    }
    section
}

fn repeat(data: &IdentificationReportData) -> Section {
    let mut section = Section::new("How to repeat it");
    if !data.commands.is_empty() {
        section = section.block(Block::Code(data.commands.join("\n")));
    }
    if !data.provenance.is_empty() {
        section = section.block(Block::KeyValues(data.provenance.clone()));
    }
    section
}
