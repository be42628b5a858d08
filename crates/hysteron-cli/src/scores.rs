//! Scores of records as JSON that others rely on, and as a table.

use std::collections::HashSet;
use std::path::Path;

use comfy_table::Table;
use hysteron_model::Start;
use hysteron_model::hysteresis::Memory;
use hysteron_model::model::{Score, Simulation};
use hysteron_model::record::{InputOutput, Unit};
use hysteron_model::validate::{CorrelationTest, Definition, Scores, definitions};
use hysteron_report::number::significant;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::console;
use crate::object::key_in;

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
    input_unit: Unit,
    unit: Unit,
    scores: Scores,
    /// The start simulated from, where it was estimated from the record.
    start: Option<Start>,
    within: Option<Within>,
}

/// How the 95 % band of a new measurement holds a record, in the unit of its output.
#[derive(Clone, Copy, Debug)]
pub struct Within {
    /// Share of the scored samples within the band \[%\].
    pub inside_percent: f64,
    /// Half of its width, at its widest.
    pub measurement: f64,
    /// The same of the band of the model's output.
    pub model: f64,
}

impl Scored {
    /// Scores of a record, in the unit of its output.
    pub fn new(data: &InputOutput, scores: Scores) -> Self {
        let record = data.source.as_ref().map_or(&data.name, |s| &s.path).clone();
        let (input_unit, unit) = (data.u_unit.clone(), data.y_unit.clone());
        Scored { record, input_unit, unit, scores, start: None, within: None }
    }

    /// Scores of a record of one output.
    pub fn of(score: Score) -> Option<Self> {
        let Score { record, unit, outputs, simulation, .. } = score;
        let Simulation { start, input_unit, .. } = simulation;
        let scores = outputs.into_iter().next()?;
        Some(Scored { record, input_unit, unit, scores, start: Some(start), within: None })
    }

    /// The same, with how a band holds it.
    pub fn within(self, within: Option<Within>) -> Self {
        Scored { within, ..self }
    }

    /// How the band holds the record, in a sentence; `None` where none was asked for.
    pub fn within_band(&self) -> Option<String> {
        let Within { inside_percent, measurement, model } = self.within?;
        let unit = self.unit.to_string();
        Some(format!(
            "{}: {} % of the samples lie within the 95 % band of a new measurement, ± {} {unit} at its widest (± {} {unit} of it from the \
             errors of the parameters).",
            self.record,
            significant(inside_percent, 3),
            significant(measurement, 3),
            significant(model, 2)
        ))
    }

    /// What was estimated of the record's start, in a sentence; `None` where nothing was.
    pub fn estimated_start(&self) -> Option<String> {
        let Some(Start::Remembering { voltage_v, memory }) = self.start else { return None };
        let memory = memory.in_words(
            &significant(memory.value(), 4),
            &self.input_unit.to_string(),
            &self.unit.to_string(),
        );
        Some(format!(
            "{}: simulated from rest at its first input, {}, {memory}, estimated from the record.",
            self.record,
            significant(voltage_v, 4)
        ))
    }

    /// The scores shown, in their order.
    fn values(&self) -> Vec<String> {
        let s = &self.scores;
        let ratio = |x: Option<f64>, digits: usize| {
            x.map_or("-".to_owned(), |x| format!("{x:.digits$}").replace('-', "−"))
        };
        // What is left of the model's own offset after rounding is no offset.
        let offset = if s.offset.abs() < 1e-9 * s.stroke { 0.0 } else { s.offset };
        vec![
            s.samples.to_string(),
            s.skipped_samples.to_string(),
            significant(offset, 4),
            significant(s.rmse, 4),
            significant(s.max_abs_error, 4),
            ratio(s.rmse_percent_of_stroke, 3),
            ratio(s.max_percent_of_stroke, 3),
            ratio(s.fit_percent, 2),
            ratio(s.relative_error, 5),
            ratio(s.loop_width_error_percent, 3),
        ]
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

/// A start with an estimated memory, in the model's units.
#[derive(Serialize)]
struct RememberingStart {
    kind: &'static str,
    voltage: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    z: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    virgin_at: Option<f64>,
}

impl Serialize for Scored {
    /// Lengths in µm; the keys of another output end in its unit, and `unit` names it. `start` is there where a hysteresis
    /// memory was estimated.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let s = &self.scores;
        let symbol = self.unit.symbol();
        let in_unit = |key: &str| key_in(key, symbol);
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
        if let Some(within) = self.within {
            map.serialize_entry("within_band_percent", &within.inside_percent)?;
            map.serialize_entry(&in_unit("band_of_measurement"), &within.measurement)?;
            map.serialize_entry(&in_unit("band_of_model"), &within.model)?;
        }
        if let Some(Start::Remembering { voltage_v, memory }) = self.start {
            let (z, virgin_at) = match memory {
                Memory::Displacement(z) => (Some(z), None),
                Memory::VirginAt(voltage) => (None, Some(voltage)),
            };
            let start = RememberingStart { kind: "remembering", voltage: voltage_v, z, virgin_at };
            map.serialize_entry("start", &start)?;
        }
        map.end()
    }
}

/// Records up to which the table has a column a record: it then fits a narrow terminal.
const SIDE_BY_SIDE: usize = 3;

/// The table for people: a column a record for a few records, a row a record for more.
pub fn table(records: &[Scored]) -> Table {
    let one_unit = records.windows(2).all(|pair| pair[0].unit == pair[1].unit);
    let unit = records.first().map(|r| r.unit.to_string()).filter(|unit| one_unit && !unit.is_empty());
    let mut metrics: Vec<String> = shown()
        .map(|d| match (d.unit, &unit) {
            ("output", unit) => console::in_unit(d.name, unit.as_deref().unwrap_or("")),
            ("1", _) => d.name.to_owned(),
            (unit, _) => console::in_unit(d.name, unit),
        })
        .collect();
    let mut values: Vec<Vec<String>> = records.iter().map(Scored::values).collect();
    if !one_unit {
        metrics.push("unit".to_owned());
        values.iter_mut().zip(records).for_each(|(values, r)| values.push(r.unit.to_string()));
    }
    let names = names(records);
    if records.len() > SIDE_BY_SIDE {
        let header: Vec<&str> = std::iter::once("record").chain(metrics.iter().map(String::as_str)).collect();
        let mut table = console::table(&header);
        for (name, values) in names.into_iter().zip(values) {
            table.add_row(std::iter::once(name.to_owned()).chain(values));
        }
        return table;
    }
    let header: Vec<&str> = std::iter::once("score").chain(names).collect();
    let mut table = console::table(&header);
    for (row, metric) in metrics.into_iter().enumerate() {
        let cells = values.iter().map(|values| values[row].clone());
        table.add_row(std::iter::once(metric).chain(cells));
    }
    table
}

/// File names where they tell the records apart, else the paths as given.
fn names(records: &[Scored]) -> Vec<&str> {
    let short: Vec<&str> = records
        .iter()
        .map(|r| Path::new(&r.record).file_name().and_then(|name| name.to_str()).unwrap_or(&r.record))
        .collect();
    let distinct: HashSet<&str> = short.iter().copied().collect();
    if distinct.len() == records.len() { short } else { records.iter().map(|r| r.record.as_str()).collect() }
}

/// What the scores of the table mean, a line each.
pub fn explanation() -> String {
    let line = |d: &Definition| {
        format!("{} [{}]: {}\n", d.name, if d.unit == "output" { "unit" } else { d.unit }, d.meaning)
    };
    shown().map(line).collect()
}

fn shown() -> impl Iterator<Item = &'static Definition> {
    SHOWN.iter().filter_map(|key| definitions().iter().find(|d| d.key == *key))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use hysteron_model::record::{Source, TimeBase};
    use hysteron_model::validate::{Scoring, score};

    fn scored(path: &str) -> Scored {
        let (u, y) = (vec![0.0, 1.0, 2.0, 1.0, 0.0], vec![0.0, 2.0, 5.0, 3.0, 0.5]);
        let mut data = InputOutput::new("r", TimeBase::uniform(10.0), u, y).unwrap();
        let scores = score(&data, &[0.0, 2.1, 4.8, 3.0, 0.5], &Scoring::default()).unwrap();
        data.source = Some(Source { path: path.into(), sha256: String::new() });
        Scored::new(&data, scores)
    }

    #[test]
    fn a_few_records_stand_side_by_side_and_many_in_rows() {
        let text = table(&[scored("a/x.csv"), scored("b/y.csv")]).to_string();
        assert!(text.starts_with("| score "), "{text}");
        assert!(text.contains("RMSE [µm]") && text.contains("x.csv") && !text.contains("a/x.csv"), "{text}");
        let many: Vec<Scored> = ["p.csv", "q.csv", "r.csv", "s.csv"].iter().map(|p| scored(p)).collect();
        let text = table(&many).to_string();
        assert!(text.starts_with("| record "), "{text}");
        assert_eq!(text.lines().count(), 6, "{text}");
    }

    #[test]
    fn records_of_one_name_are_told_apart_by_their_folders() {
        let text = table(&[scored("a/x.csv"), scored("b/x.csv")]).to_string();
        assert!(text.contains("a/x.csv") && text.contains("b/x.csv"), "{text}");
    }

    #[test]
    fn records_of_different_units_name_them_in_a_row() {
        let text =
            table(&[scored("x.csv"), Scored { unit: Unit::new("urad"), ..scored("y.csv") }]).to_string();
        assert!(!text.contains("RMSE [µm]") && text.contains("| unit ") && text.contains("µrad"), "{text}");
    }
}
