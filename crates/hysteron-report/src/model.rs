//! The page of a model of any kind: findings, numbers with their standard errors, scores, how it was made.
//!
//! It is built from the model's data alone, the same way for every kind.

use hysteron_identify::{Finding, FindingKind};
use hysteron_model::Model;
use hysteron_model::model_file::{Document, ModelFileError};
use serde_json::Value;

use crate::number::{significant, with_std_error};
use crate::page::{Block, Column, Page, Section, Table};
use crate::titles;
use hysteron_model::model_file::typographic;

/// Scores shown, by their keys in the model file, with heading and whether they are in the unit of the
/// output.
const SHOWN: [(&str, &str, bool); 4] = [
    ("samples", "samples", false),
    ("rmse", "RMSE", true),
    ("max_abs_error", "largest error", true),
    ("fit_percent", "fit [%]", false),
];

/// The report of a model that was just identified, with what the fit found.
///
/// # Errors
/// [`ModelFileError`] where the data of the model are not sound.
pub fn report(name: &str, model: &Model, findings: &[Finding]) -> Result<Page, ModelFileError> {
    let numbers = Section::new("Numbers").block(numbers(&data_of(model)?));
    report_with(name, model, findings, vec![numbers])
}

/// [`report`] with these sections in place of the numbers.
pub(crate) fn report_with(
    name: &str,
    model: &Model,
    findings: &[Finding],
    sections: Vec<Section>,
) -> Result<Page, ModelFileError> {
    let data = data_of(model)?;
    let records = model.provenance().map_or(&[][..], |provenance| &provenance.records);
    let kind = format!("model of the kind {}", model.kind());
    let title = titles::title(model.name(), records.iter().map(|r| r.path.as_str()), &kind);
    let mut page = Page::new(title).subtitled(name);
    let notes = findings.iter().map(|finding| match finding.kind {
        FindingKind::Warning => Block::warning(&finding.text),
        FindingKind::Advice | FindingKind::Verdict => Block::info(&finding.text),
    });
    if !findings.is_empty() {
        page = page.section(Section::new("Findings").blocks(notes));
    }
    page = sections.into_iter().fold(page, Page::section);
    if let Some(scores) = scores(&data, &model.units().output) {
        page = page.section(Section::new("Scores on the records").block(scores));
    }
    let Some(provenance) = model.provenance() else { return Ok(page) };
    let mut made = vec![("program".to_owned(), provenance.program.clone())];
    made.extend(provenance.created.iter().map(|time| ("created".to_owned(), time.clone())));
    made.extend(provenance.records.iter().map(|r| ("record".to_owned(), r.path.clone())));
    made.extend(provenance.options.iter().map(|(name, value)| (name.clone(), value.clone())));
    let section = Section::new("Provenance").block(Block::key_values(made));
    let command = provenance.command.iter().map(Block::code);
    Ok(page.section(section.blocks(command)).footer_line(&provenance.program))
}

/// A number of a model, by its place in the data.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// Its place: `hysteresis.parameters.alpha`.
    pub path: String,
    /// Its value.
    pub value: f64,
    /// Standard error, where it is known.
    pub std_error: Option<f64>,
    /// Unit as printed; empty for a pure number.
    pub unit: String,
}

/// Every number of a model that has a unit.
///
/// # Errors
/// [`ModelFileError`] where the data of the model are not sound.
pub fn numbers_of(model: &Model) -> Result<Vec<Number>, ModelFileError> {
    let mut found = Vec::new();
    quantities("", &data_of(model)?, &mut found);
    Ok(found)
}

fn data_of(model: &Model) -> Result<Value, ModelFileError> {
    serde_json::to_value(Document::from(model.clone()))
        .map_err(|e| ModelFileError::Syntax { path: String::new(), problem: e })
}

/// Every number that has a unit, by its place in the data.
fn numbers(data: &Value) -> Table {
    let mut found = Vec::new();
    quantities("", data, &mut found);
    let rows = found.into_iter().map(|Number { path, value, std_error, unit }| {
        let (value, error) = with_std_error(value, std_error);
        [path, value, error, unit]
    });
    let columns = [
        Column::text("number"),
        Column::number("value", ""),
        Column::number("std. error", ""),
        Column::text("unit"),
    ];
    rows.fold(Table::new(columns), |table, row| table.row(row))
}

fn quantities(path: &str, data: &Value, found: &mut Vec<Number>) {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match data {
        Value::Object(object) => match (object.get("value"), object.get("unit")) {
            (Some(Value::Number(value)), Some(Value::String(unit))) => {
                let text = |key: &str| object.get(key).and_then(Value::as_str);
                let named = text("of").zip(text("name")).map(|(of, name)| format!("{of}: {name}"));
                found.push(Number {
                    path: named.unwrap_or_else(|| path.to_owned()),
                    value: value.as_f64().unwrap_or(f64::NAN),
                    std_error: object.get("std_error").and_then(Value::as_f64),
                    unit: if unit == "1" { String::new() } else { typographic(unit) },
                });
            }
            _ => object.iter().for_each(|(key, value)| quantities(&below(key), value, found)),
        },
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(i, v)| quantities(&format!("{path}[{i}]"), v, found));
        }
        _ => {}
    }
}

/// A row a record; `None` where the data hold no scores.
fn scores(data: &Value, output: &str) -> Option<Table> {
    let scores = data.get("scores")?.as_array().filter(|scores| !scores.is_empty())?;
    let shown = || SHOWN.iter().filter(|(key, ..)| scores.iter().any(|score| score.get(key).is_some()));
    let columns = shown().map(|(_, heading, in_unit)| {
        Column::number(*heading, if *in_unit { typographic(output) } else { String::new() })
    });
    let table = Table::new(std::iter::once(Column::text("record")).chain(columns));
    Some(scores.iter().fold(table, |table, score| {
        let record = score.get("record").and_then(Value::as_str).unwrap_or_default().to_owned();
        let number = |key: &str| score.get(key).and_then(Value::as_f64);
        let cells =
            shown().map(|(key, ..)| number(key).map_or_else(|| "-".to_owned(), |x| significant(x, 4)));
        table.row(std::iter::once(record).chain(cells))
    }))
}
