//! The model's parameters with symbol, meaning and unit.

use super::ParameterRow;
use hysteron_identify::{Identification, IntervalMethod, Parameter};
use hysteron_model::dynamics::DynamicForm;
use hysteron_model::hysteresis::DriveSpan;
use hysteron_model::model_file::ModelFile;
use hysteron_model::{Memory, Start};

/// Name of the record whose hysteresis memory this parameter is.
fn record_of_memory<'a>(name: &str, found: &'a Identification) -> Option<&'a str> {
    let number: usize = name.strip_prefix("memory_")?.parse().ok()?;
    Some(found.records.get(number.checked_sub(1)?)?.data.name.as_str())
}

fn parameter_row(p: &Parameter, found: &Identification, file: &ModelFile) -> ParameterRow {
    let memory = record_of_memory(&p.name, found).map(|record| match found.model.hysteresis.memory(0.0) {
        Memory::Displacement(_) => format!("hysteretic part z at the first sample of {record}"),
        Memory::VirginAt(_) => format!("input of the demagnetised state before the first sample of {record}"),
    });
    let (symbol, meaning) = symbol_and_meaning(p, found);
    ParameterRow {
        block: p.block.to_owned(),
        symbol,
        meaning: memory.unwrap_or(meaning),
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

/// Symbol and meaning of a parameter: of the hysteresis and of the modes by their own descriptions.
fn symbol_and_meaning(p: &Parameter, found: &Identification) -> (String, String) {
    let name = p.name.as_str();
    let form = found.model.hysteresis.form();
    let shape = form.shape_numbers(&DriveSpan::UNIT);
    let of_hysteresis = p.block == "hysteresis";
    if let Some(number) = shape.iter().find(|number| of_hysteresis && number.name == name) {
        return (greek(name).to_owned(), number.meaning.to_owned());
    }
    if of_hysteresis && form.weight_names().iter().any(|weight| weight == name) {
        let meaning = if form.columns() == 1 { "size of the loop" } else { "weight of a column" };
        return (greek(name).to_owned(), meaning.to_owned());
    }
    if let Some(parameter) = DynamicForm::parameter_named(name).filter(|_| !of_hysteresis) {
        return (parameter.symbol.to_owned(), parameter.meaning.to_owned());
    }
    let (symbol, meaning) = match name {
        "linear" => ("l₁", "coefficient of u"),
        "quadratic" => ("l₂", "coefficient of u²"),
        "cubic" => ("l₃", "coefficient of u³"),
        "gain" => ("K", "gain at zero frequency"),
        "delay" => ("τ", "delay"),
        "b" => ("b", "numerator, K·c₀"),
        "c0" => ("c₀", "coefficient of s⁰"),
        "c1" => ("c₁", "coefficient of s^α₁"),
        other if other.starts_with("noise_") => (other, "coefficient of the noise model C/D"),
        other if is_coefficient(other, "b") => (other, "coefficient of the numerator"),
        other if is_coefficient(other, "f") || is_coefficient(other, "a") => {
            (other, "coefficient of the denominator")
        }
        other if other.starts_with("degree_") || other.starts_with("qu") => (other, "polynomial coefficient"),
        other => (other, "parameter of the dynamics"),
    };
    (symbol.to_owned(), meaning.to_owned())
}

/// The letter that a name spells.
fn greek(name: &str) -> &str {
    match name {
        "alpha" => "α",
        "beta" => "β",
        "gamma" => "γ",
        "delta" => "δ",
        other => other,
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

/// `b0`, `b1`, …
fn is_coefficient(name: &str, of: &str) -> bool {
    name.strip_prefix(of).is_some_and(|place| place.parse::<usize>().is_ok())
}
