//! Scores of a record of several outputs, as JSON and as a table.

use comfy_table::Table;
use hysteron_model::axes::AxesScores;
use hysteron_model::model::Score;
use hysteron_model::record::Unit;
use hysteron_report::number::significant;
use serde_json::{Map, Value, json};

use crate::console;

/// Scores of one record.
#[derive(Clone, Debug)]
pub struct AxesScored {
    record: String,
    outputs: Vec<String>,
    unit: Unit,
    level: Option<f64>,
    scores: AxesScores,
}

impl AxesScored {
    /// Scores of a record of several outputs.
    pub fn of(score: Score) -> Self {
        let Score { record, unit, rmse, max_abs_error, fit_percent, outputs, axes, .. } = score;
        let axes = axes.unwrap_or_default();
        let mean_period_rmse = axes.mean_period_rmse;
        Self {
            record,
            outputs: axes.outputs,
            unit,
            level: axes.level,
            scores: AxesScores { outputs, rmse, max_abs_error, fit_percent, mean_period_rmse },
        }
    }

    /// The object of `--json`: pooled over the outputs, then each of them in `outputs`.
    pub fn json(&self) -> Value {
        let symbol = self.unit.symbol();
        let in_unit = |key: &str| if symbol.is_empty() { key.to_owned() } else { format!("{key}_{symbol}") };
        let first = self.scores.outputs.first();
        let mut object = Map::new();
        object.insert("record".into(), json!(self.record));
        object.insert("samples".into(), json!(first.map(|s| s.samples)));
        object.insert("skipped_samples".into(), json!(first.map(|s| s.skipped_samples)));
        if symbol != "um" {
            object.insert("unit".into(), json!(symbol));
        }
        object.insert("level".into(), json!(self.level));
        object.insert(in_unit("rmse"), json!(self.scores.rmse));
        object.insert(in_unit("rmse_mean_period"), json!(self.scores.mean_period_rmse));
        object.insert(in_unit("max_abs_error"), json!(self.scores.max_abs_error));
        object.insert("fit_percent".into(), json!(self.scores.fit_percent));
        let output = |(name, s): (&String, &hysteron_model::validate::Scores)| {
            let mut object = Map::new();
            object.insert("output".into(), json!(name));
            object.insert(in_unit("offset"), json!(s.offset));
            object.insert(in_unit("rmse"), json!(s.rmse));
            object.insert(in_unit("max_abs_error"), json!(s.max_abs_error));
            object.insert("rmse_percent_of_stroke".into(), json!(s.rmse_percent_of_stroke));
            object.insert("max_percent_of_stroke".into(), json!(s.max_percent_of_stroke));
            object.insert("fit_percent".into(), json!(s.fit_percent));
            Value::Object(object)
        };
        let outputs: Vec<Value> = self.outputs.iter().zip(&self.scores.outputs).map(output).collect();
        object.insert("outputs".into(), Value::Array(outputs));
        Value::Object(object)
    }
}

/// The table for people, a row a record.
pub fn table(records: &[AxesScored]) -> Table {
    let unit = records.first().map_or_else(String::new, |r| r.unit.to_string());
    let in_unit = |name: &str| console::in_unit(name, &unit);
    let mut header = vec![
        "record".to_owned(),
        "level".to_owned(),
        in_unit("RMSE"),
        in_unit("of mean period"),
        in_unit("max error"),
        "fit [%]".to_owned(),
    ];
    if let Some(first) = records.first() {
        header.extend(first.outputs.iter().map(|name| in_unit(&format!("RMSE {name}"))));
    }
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let mut table = console::table(&header);
    let number = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| significant(x, 4));
    for r in records {
        let name = std::path::Path::new(&r.record).file_name().and_then(|name| name.to_str());
        let mut row = vec![
            name.unwrap_or(&r.record).to_owned(),
            number(r.level),
            number(Some(r.scores.rmse)),
            number(r.scores.mean_period_rmse),
            number(Some(r.scores.max_abs_error)),
            number(r.scores.fit_percent),
        ];
        row.extend(r.scores.outputs.iter().map(|s| number(Some(s.rmse))));
        table.add_row(row);
    }
    table
}
