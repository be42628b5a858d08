//! A model on records, as a page: scores, curves, residuals.

use hysteron_model::Model;
use hysteron_model::axes::AxesRecord;
use hysteron_model::model::{Score, Signals};
use hysteron_model::model_file::Maker;
use hysteron_model::record::InputOutput;
use hysteron_model::validate::Scores;

use crate::figure::Figure;
use crate::number::significant;
use crate::page::{Block, Column, Page, Section, Table};
use crate::record_curves::RecordCurves;

/// The page of a validation: every record with its score; `maker`: who made it, and by which command.
pub fn page(model: &Model, records: &[(Signals, Score)], maker: &Maker) -> Page {
    let name = model.name().map_or_else(|| format!("a model of the kind {}", model.kind()), str::to_owned);
    let scored = Section::new("Scores")
        .block(Block::paragraph(
            "The model was simulated in free run, from the start of each record: no measured output is used. Unless its own counts, the \
             offset of each sensor was estimated from the record.",
        ))
        .block(scores(records));
    let curves = records.iter().map(|(signals, score)| {
        let figures = match signals {
            Signals::Single(record) => single(record, score),
            Signals::Several(record) => several(record, score),
        };
        Section::new(score.record.as_str()).blocks(figures)
    });
    let page = Page::new(format!("Validation of {name}")).section(scored);
    let mut page = curves.fold(page, Page::section);
    if let Some(command) = &maker.command {
        page = page.section(Section::new("How it was made").block(Block::code(command)));
    }
    page.footer_line(&maker.program)
}

/// A row a record, or an output of it.
fn scores(records: &[(Signals, Score)]) -> Table {
    let columns = [
        Column::text("record"),
        Column::text("output"),
        Column::number("samples", ""),
        Column::number("offset", ""),
        Column::number("RMSE", ""),
        Column::number("largest error", ""),
        Column::text("unit"),
        Column::number("RMSE / stroke", "%"),
        Column::number("fit", "%"),
    ];
    let rows = records.iter().flat_map(|(signals, score)| {
        score.outputs.iter().enumerate().map(move |(m, scores)| row(signals, score, m, scores))
    });
    rows.fold(Table::new(columns), Table::row)
}

fn row(signals: &Signals, score: &Score, m: usize, scores: &Scores) -> [String; 9] {
    let output = match signals {
        Signals::Single(record) => record.output.clone(),
        Signals::Several(record) => record.outputs.get(m).cloned().unwrap_or_default(),
    };
    let percent = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| significant(x, 4));
    [
        score.record.clone(),
        output,
        scores.samples.to_string(),
        significant(scores.offset, 4),
        significant(scores.rmse, 4),
        significant(scores.max_abs_error, 4),
        score.unit.to_string(),
        percent(scores.rmse_percent_of_stroke),
        percent(scores.fit_percent),
    ]
}

fn single(record: &InputOutput, score: &Score) -> Vec<Figure> {
    let (Some(y), Some(scores)) = (score.simulation.outputs.first(), score.outputs.first()) else {
        return Vec::new();
    };
    RecordCurves::new(record, y, scores.offset, leading(record, scores)).figures()
}

/// Samples at the beginning that were not scored: those skipped beside the masked ones.
fn leading(record: &InputOutput, scores: &Scores) -> usize {
    let masked = record.valid.as_ref().map_or(0, |mask| mask.iter().filter(|valid| !**valid).count());
    scores.skipped_samples.saturating_sub(masked)
}

/// Time curves of each output, under the first input.
fn several(record: &AxesRecord, score: &Score) -> Vec<Figure> {
    let one = |(m, (y, scores)): (usize, (&Vec<f64>, &Scores))| {
        let (input, output) = (record.inputs.first()?, record.outputs.get(m)?);
        let data = InputOutput {
            name: format!("{}, {output}", record.name),
            input: input.clone(),
            output: output.clone(),
            u_unit: record.u_unit.clone(),
            y_unit: record.y_unit.clone(),
            valid: record.valid.clone(),
            ..InputOutput::new("", record.time.clone(), record.u.first()?.clone(), record.y.get(m)?.clone())
                .ok()?
        };
        let curves = RecordCurves::new(&data, y, scores.offset, 0);
        let figures = [Some(curves.time_figure()), curves.residual_figure()];
        Some(figures.map(|figure| figure.map(|figure| curves.marked(figure))))
    };
    let outputs = score.simulation.outputs.iter().zip(&score.outputs).enumerate();
    outputs.filter_map(one).flatten().flatten().collect()
}
