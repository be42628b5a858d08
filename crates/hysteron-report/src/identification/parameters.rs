//! The model's parameters with symbol, meaning and unit.

use super::ParameterRow;
use hysteron_identify::{Identification, IntervalMethod, Parameter};
use hysteron_model::Start;
use hysteron_model::hysteresis::Hysteresis;
use hysteron_model::model_file::ModelFile;

/// Name of the record whose hysteresis memory this parameter is.
fn record_of_memory<'a>(name: &str, found: &'a Identification) -> Option<&'a str> {
    let number: usize = name.strip_prefix("memory_")?.parse().ok()?;
    Some(found.records.get(number.checked_sub(1)?)?.data.name.as_str())
}

fn parameter_row(p: &Parameter, found: &Identification, file: &ModelFile) -> ParameterRow {
    let memory = record_of_memory(&p.name, found).map(|record| match found.model.hysteresis {
        Hysteresis::BoucWen(_) => format!("hysteretic part z at the first sample of {record}"),
        _ => format!("where the device was virgin before it moved to the first sample of {record}"),
    });
    let (symbol, meaning) = match p.name.as_str() {
        "linear" => ("l₁", "coefficient of u"),
        "quadratic" => ("l₂", "coefficient of u²"),
        "cubic" => ("l₃", "coefficient of u³"),
        "alpha" => ("α", "size of the loop"),
        "beta" => ("β", "shape of the loop"),
        "gamma" => ("γ", "shape of the loop, going out against coming back"),
        "n" => ("n", "smoothness of the transition"),
        "gain" => ("K", "gain at zero frequency"),
        "natural_frequency" => ("ω_n/2π", "natural frequency"),
        "damping" => ("ζ", "damping"),
        "order2" => ("α₂", "highest order"),
        "order1" => ("α₁", "middle order"),
        "order0" => ("α₀", "lowest order"),
        name if name.starts_with("natural_frequency_") => ("ω_n/2π", "natural frequency of a further mode"),
        name if name.starts_with("damping_") => ("ζ", "damping of a further mode"),
        "order2_2" => ("α₂", "highest order of the second mode"),
        "order1_2" => ("α₁", "middle order of the second mode"),
        "share" => ("share", "share of the first mode in the gain at rest"),
        other if other.starts_with("share_") => {
            (other, "share of a further mode; the last has what is left of 1")
        }
        "creep" => ("k", "size of the creep, factor 1 + k s^−μ"),
        "creep_order" => ("μ", "order of the creep"),
        "creep_per_decade" => ("γ", "creep per decade of time, as a share of the step"),
        "creep_start" => ("t₀", "time from which creep is logarithmic"),
        other if other.starts_with("creep_time_") => (other, "time constant τ of a creep element"),
        other if other.starts_with("creep_") => (other, "share k of a creep element, k/(1 + τ s)"),
        "delay" => ("τ", "delay"),
        "lag" => ("T", "time constant of the lag"),
        "b" => ("b", "numerator, K·c₀"),
        "c0" => ("c₀", "coefficient of s⁰"),
        "c1" => ("c₁", "coefficient of s^α₁"),
        other if other.starts_with("noise_") => (other, "coefficient of the noise model C/D"),
        other if is_coefficient(other, "b") => (other, "coefficient of the numerator"),
        other if is_coefficient(other, "f") || is_coefficient(other, "a") => {
            (other, "coefficient of the denominator")
        }
        other if other.starts_with("degree_") || other.starts_with("qu") => (other, "polynomial coefficient"),
        other if p.block == "hysteresis" && shape_meaning(other).is_some() => {
            (other, shape_meaning(other).unwrap_or_default())
        }
        other if other.starts_with("threshold_") => (other, "half-width of a play"),
        other if other.starts_with("weight_") => (other, "weight of a column"),
        other if memory.is_some() => (other, ""),
        other => (other, "parameter of the dynamics"),
    };
    ParameterRow {
        block: p.block.to_owned(),
        symbol: symbol.to_owned(),
        meaning: memory.unwrap_or_else(|| meaning.to_owned()),
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
                ("u₀", "input at which the device had rested", voltage_v, fit.data.u_unit.to_string())
            }
            // The memory is among the fitted parameters.
            Start::Remembering { .. } | Start::AsIdentified => continue,
            Start::Settled { period_samples, .. } => {
                let samples = period_samples.unwrap_or(fit.data.len());
                ("N", "period on which the device had settled", samples as f64, "samples".into())
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

/// What a shape number of a family says.
fn shape_meaning(name: &str) -> Option<&'static str> {
    Some(match name {
        "delta" => "asymmetry of the loop",
        "rate" => "bend of the loop over the voltage",
        "reach" => "voltage at which the loop saturates",
        "exponent" => "smoothness of the transition",
        "scale" => "widest threshold of the grid",
        "low" | "high" => "end of the plane",
        "rise" => "length of a ramp",
        "rise_right" | "rise_left" => "steepness of an envelope",
        "centre_right" | "centre_left" => "centre of an envelope",
        "half_width" => "most frequent half-width of a relay",
        "half_width_spread" => "spread of the half-widths",
        "bias" => "most frequent bias of a relay",
        "bias_spread" => "spread of the biases",
        "anhysteretic" => "scale of the anhysteretic curve",
        "pinning" => "pinning, half the width of the loop",
        "reversibility" => "reversible share",
        "coupling" => "field of the magnetisation",
        name if name.starts_with("beta_") || name.starts_with("gamma_") => "shape of the loop",
        _ => return None,
    })
}
