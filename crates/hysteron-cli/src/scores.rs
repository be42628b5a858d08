//! Scores of records as JSON that others rely on, and as a table.

use comfy_table::Table;
use hysteron::record::{InputOutput, Unit};
use hysteron::validate::{CorrelationTest, Definition, Scores, definitions};
use hysteron_report::number::significant;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::console;

/// The scores shown in the table, by key.
const SHOWN: [&str; 10] = [
    "samples",
    "skipped_samples",
    "offset",
    "rmse",
    "max_abs_error",
    "rmse_percent_of_stroke",
    "max_percent_of_stroke",
    "fit_percent",
    "relative_error",
    "loop_width_error_percent",
];

/// Scores of one record.
#[derive(Clone, Debug)]
pub struct Scored {
    record: String,
    unit: Unit,
    scores: Scores,
}

impl Scored {
    /// Scores of a record, in the unit of its output.
    pub fn new(data: &InputOutput, scores: Scores) -> Self {
        let record = data.source.as_ref().map_or(&data.name, |s| &s.path).clone();
        Scored { record, unit: data.y_unit.clone(), scores }
    }

    /// The same in the unit agreed on where the record names none.
    pub fn in_unit(self, unit: Unit) -> Self {
        Scored { unit, ..self }
    }

    /// What the residual tests found, in a sentence; `None` for a record too short for them.
    pub fn residual_tests(&self) -> Option<String> {
        let outside = |test: &CorrelationTest| {
            let CorrelationTest { outside, lags, largest, largest_lag, .. } = test;
            format!("{outside} of {lags} lags (largest {largest:.3} at lag {largest_lag})")
        };
        let own = self.scores.whiteness.as_ref()?;
        let input = self.scores.input_correlation.as_ref()?;
        Some(format!(
            "{}: the residual's autocorrelation leaves its 99 % bounds at {}, its correlation with the input at {}.",
            self.record,
            outside(own),
            outside(input)
        ))
    }
}

impl Serialize for Scored {
    /// Lengths in µm; the keys of another output end in its unit, and `unit` names it.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let s = &self.scores;
        let symbol = self.unit.symbol();
        let in_unit = |key: &str| if symbol.is_empty() { key.to_owned() } else { format!("{key}_{symbol}") };
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("record", &self.record)?;
        map.serialize_entry("samples", &s.samples)?;
        map.serialize_entry("skipped_samples", &s.skipped_samples)?;
        if symbol != "um" {
            map.serialize_entry("unit", symbol)?;
        }
        map.serialize_entry(&in_unit("offset"), &s.offset)?;
        map.serialize_entry(&in_unit("rmse"), &s.rmse)?;
        map.serialize_entry(&in_unit("max_abs_error"), &s.max_abs_error)?;
        map.serialize_entry("rmse_percent_of_stroke", &s.rmse_percent_of_stroke)?;
        map.serialize_entry("max_percent_of_stroke", &s.max_percent_of_stroke)?;
        map.serialize_entry("fit_percent", &s.fit_percent)?;
        map.end()
    }
}

/// The table for people, a row a record.
pub fn table(records: &[Scored]) -> Table {
    let header: Vec<String> = shown()
        .map(|d| match d.unit {
            "output" | "1" => d.name.to_owned(),
            unit => format!("{} [{unit}]", d.name),
        })
        .collect();
    let mut columns = vec!["record", "unit"];
    columns.extend(header.iter().map(String::as_str));
    let mut table = console::table(&columns);
    for r in records {
        let s = &r.scores;
        let ratio = |x: Option<f64>, digits: usize| x.map_or("-".to_owned(), |x| format!("{x:.digits$}"));
        table.add_row([
            r.record.clone(),
            r.unit.to_string(),
            s.samples.to_string(),
            s.skipped_samples.to_string(),
            significant(s.offset, 4),
            significant(s.rmse, 4),
            significant(s.max_abs_error, 4),
            ratio(s.rmse_percent_of_stroke, 3),
            ratio(s.max_percent_of_stroke, 3),
            ratio(s.fit_percent, 2),
            ratio(s.relative_error, 5),
            ratio(s.loop_width_error_percent, 3),
        ]);
    }
    table
}

/// What the columns of the table mean, a line each.
pub fn explanation() -> String {
    let line = |d: &Definition| {
        format!("{} [{}]: {}\n", d.name, if d.unit == "output" { "unit" } else { d.unit }, d.meaning)
    };
    shown().map(line).collect()
}

fn shown() -> impl Iterator<Item = &'static Definition> {
    SHOWN.iter().filter_map(|key| definitions().iter().find(|d| d.key == *key))
}
