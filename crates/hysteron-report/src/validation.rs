//! A model on records, as a page: scores, curves, residuals.

use std::path::Path;

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
use crate::titles;

/// A model with its file and the records that it was scored on.
pub struct Validated<'a> {
    /// Its file.
    pub path: &'a Path,
    /// The model.
    pub model: &'a Model,
    /// The records with their scores.
    pub records: &'a [(Signals, Score)],
}

/// The page of a validation: every record with its score, for each of the models with their files; `maker`:
/// who made it, and by which command.
pub fn page(models: &[Validated<'_>], maker: &Maker) -> Page {
    let what = match models {
        [Validated { model, .. }] => format!("validation of a model of the kind {}", model.kind()),
        _ => format!("validation of {} models", models.len()),
    };
    let (device, records) = match models {
        [first @ Validated { model, .. }, others @ ..] => {
            (model.name().filter(|_| others.is_empty()), first.records)
        }
        [] => (None, &[][..]),
    };
    let title = titles::title(device, records.iter().map(|(_, score)| score.record.as_str()), &what);
    let files: Vec<String> = models.iter().map(|model| model.path.display().to_string()).collect();
    let scored = Section::new("Scores")
        .block(Block::paragraph(
            "The model was simulated in free run, from the start of each record: no measured output is used. \
             The sensor offset was estimated from each record, unless that of the model applies.",
        ))
        .block(scores(models))
        .blocks(verdicts(models))
        .blocks(bands(models));
    let curves = models.iter().flat_map(|Validated { path, records, .. }| {
        records.iter().map(move |(signals, score)| {
            let figures = match signals {
                Signals::Single(record) => single(record, score),
                Signals::Several(record) => several(record, score),
            };
            let of = if models.len() > 1 { format!("{}: ", path.display()) } else { String::new() };
            Section::new(format!("{of}{}", score.record)).blocks(figures)
        })
    });
    let page = Page::new(title).subtitled(files.join(", ")).section(scored);
    let mut page = curves.fold(page, Page::section);
    if let Some(command) = &maker.command {
        page = page.section(Section::new("Provenance").block(Block::code(command)));
    }
    page.footer_line(&maker.program)
}

/// Table of the verdicts on device and range.
fn verdicts(models: &[Validated<'_>]) -> Option<Table> {
    let columns =
        [Column::text("model"), Column::text("record"), Column::text("verdict"), Column::text("why")];
    let rows = models.iter().flat_map(|Validated { path, records, .. }| {
        records.iter().filter_map(move |(_, score)| {
            let verdict = score.verdict.as_ref()?;
            let (model, record) = (path.display().to_string(), score.record.clone());
            Some([model, record, verdict.judgement.name().to_owned(), verdict.why.clone()])
        })
    });
    let mut rows = rows.peekable();
    rows.peek()?;
    Some(rows.fold(Table::new(columns), Table::row))
}

/// Table of the coverage by the 95 % bands of a new measurement, and what they rest on, where they were asked
/// for.
fn bands(models: &[Validated<'_>]) -> Option<Table> {
    let columns = [
        Column::text("model"),
        Column::text("record"),
        Column::number("within the 95 % band", "%"),
        Column::number("widest half", ""),
        Column::text("unit"),
        Column::text("rests on other devices"),
    ];
    let rows = models.iter().flat_map(|Validated { path, records, .. }| {
        records.iter().filter_map(move |(_, score)| {
            let band = score.band.as_ref()?;
            let rests_on: Vec<&str> = band.findings.iter().map(|finding| finding.text.as_str()).collect();
            Some([
                path.display().to_string(),
                score.record.clone(),
                significant(band.inside_percent, 3),
                significant(band.measurement, 3),
                score.unit.to_string(),
                if rests_on.is_empty() { "no".to_owned() } else { rests_on.join(" ") },
            ])
        })
    });
    let mut rows = rows.peekable();
    rows.peek()?;
    Some(rows.fold(Table::new(columns), Table::row))
}

/// A row a record, or an output of it.
fn scores(models: &[Validated<'_>]) -> Table {
    let columns = [
        Column::text("model"),
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
    let rows = models.iter().flat_map(|Validated { path, records, .. }| {
        records.iter().flat_map(move |(signals, score)| {
            let row = move |(m, scores)| row(path, signals, score, m, scores);
            score.outputs.iter().enumerate().map(row)
        })
    });
    rows.fold(Table::new(columns), Table::row)
}

fn row(path: &Path, signals: &Signals, score: &Score, m: usize, scores: &Scores) -> [String; 10] {
    let output = match signals {
        Signals::Single(record) => record.output.clone(),
        Signals::Several(record) => record.outputs.get(m).cloned().unwrap_or_default(),
    };
    let percent = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| significant(x, 4));
    [
        path.display().to_string(),
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
