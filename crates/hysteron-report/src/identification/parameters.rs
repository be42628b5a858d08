//! The model's parameters with symbol, meaning and unit.

use super::ParameterRow;
use hysteron_identify::{Identification, IntervalMethod, Parameter, ParameterRole};
use hysteron_model::Start;
use hysteron_model::model_file::ModelFile;

fn parameter_row(p: &Parameter, found: &Identification, file: &ModelFile) -> ParameterRow {
    let meaning = p.meaning(&found.model);
    let record = match p.role {
        ParameterRole::Memory(record) => found.records.get(record),
        _ => None,
    };
    ParameterRow {
        block: p.block().to_owned(),
        symbol: p.symbol().to_owned(),
        meaning: record.map_or(meaning.clone(), |record| format!("{meaning} of {}", record.data.name)),
        value: p.value,
        unit: p.unit(file),
        std_error: p.std_error,
        interval: p.interval.map(|i| (i.low, i.high)),
        is_profiled: p.interval.is_some_and(|i| i.method == IntervalMethod::Profile),
        note: match (p.held, p.std_error) {
            (true, _) => "held at this value".into(),
            (false, Some(_)) => String::new(),
            (false, None) => "not determined by these records".into(),
        },
    }
}

/// The model's parameters, then what belongs to the records: the sensor's offset and the start of each.
pub(super) fn rows(found: &Identification, file: &ModelFile) -> Vec<ParameterRow> {
    let mut rows: Vec<ParameterRow> =
        found.parameters.iter().map(|p| parameter_row(p, found, file)).collect();
    let Some(first) = found.records.first() else { return rows };
    let held = file.provenance.as_ref().is_some_and(|p| p.options.contains_key("fix offset"));
    rows.push(ParameterRow {
        block: "sensor".into(),
        symbol: "y₀".into(),
        meaning: "offset of the sensor".into(),
        value: found.model.offset,
        unit: first.data.y_unit.to_string(),
        std_error: None,
        interval: None,
        is_profiled: false,
        note: if held {
            "held at this value".into()
        } else {
            format!("mean residual of {}", first.data.name)
        },
    });
    for fit in &found.records {
        let (symbol, meaning, value, unit) = match fit.start {
            Start::Rest { voltage_v } => {
                ("u₀", "input at rest before the record", voltage_v, fit.data.u_unit.to_string())
            }
            // The memory is among the fitted parameters.
            Start::Remembering { .. } | Start::AsIdentified => continue,
            Start::Settled { period_samples, .. } => {
                let samples = period_samples.unwrap_or(fit.data.len());
                ("N", "period of the steady state", samples as f64, "samples".into())
            }
        };
        rows.push(ParameterRow {
            block: "start".into(),
            symbol: symbol.into(),
            meaning: meaning.into(),
            value,
            unit,
            std_error: None,
            interval: None,
            is_profiled: false,
            note: format!("of {}", fit.data.name),
        });
    }
    rows
}
