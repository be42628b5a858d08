//! What was found, for people.

use hysteron_model::record::{TimeBase, Unit};
use hysteron_report::number::significant;

use super::Inspected;
use crate::advice;
use crate::console;

/// Jitter that is the rounding of written times, in samples.
const NO_JITTER: f64 = 1e-6;

/// A table of numbers, then warnings and remarks in plain words.
pub fn describe(inspected: &Inspected) -> String {
    let Inspected { data, found } = inspected;
    let mut table = console::table(&["", data.source.as_ref().map_or(&data.name, |s| &s.path)]);
    let mut row = |what: &str, value: String| {
        table.add_row([what.to_owned(), value]);
    };
    row("samples", found.samples.to_string());
    let time = match (&data.time, found.sample_rate_hz) {
        (TimeBase::Uniform { jitter_samples, .. }, Some(rate)) => {
            let duration = found.duration_s.map_or(String::new(), |d| format!(" for {} s", rounded(d)));
            let jitter = match *jitter_samples {
                j if j < NO_JITTER => "no jitter".to_owned(),
                j => format!("jitter {} of a sample", significant(j, 2)),
            };
            format!("{} Hz{duration}, {jitter}", rounded(rate))
        }
        (TimeBase::NonUniform { .. }, _) => "not uniform".into(),
        _ => "no time".into(),
    };
    row("sampling", time);
    row("input", signal(&data.input, &data.u_unit, found.input_range));
    row("output", signal(&data.output, &data.y_unit, found.output_range));
    let hz = |f: f64| significant(f, 4);
    let drive = match found.frequency_span_hz {
        Some((low, high)) if low == high => format!("{}, {} Hz", found.kind.name(), hz(low)),
        Some((low, high)) => format!("{}, {} to {} Hz", found.kind.name(), hz(low), hz(high)),
        None => found.kind.name().into(),
    };
    row("drive", drive);
    if let Some(shape) = &found.loop_shape {
        let unit = spaced(&data.y_unit);
        row("stroke", significant(shape.stroke, 4) + &unit);
        let opening = significant(shape.opening.abs(), 3) + &unit;
        row("loop opening", format!("{opening}, {} % of stroke", significant(shape.opening_percent, 3)));
    }
    if let Some(noise) = &found.noise_floor {
        row("noise floor", format!("{}{} rms", significant(noise.rms, 3), spaced(&data.y_unit)));
    }
    let mut text = format!("{table}\n");
    for finding in &found.findings {
        text +=
            &format!("{}{}\n", if finding.is_warning() { "WARNING: " } else { "- " }, advice::text(finding));
    }
    text
}

fn signal(name: &str, unit: &Unit, (low, high): (f64, f64)) -> String {
    format!("{name}: {} to {}{}", significant(low, 5), significant(high, 5), spaced(unit))
}

fn spaced(unit: &Unit) -> String {
    if unit.symbol().is_empty() { String::new() } else { format!(" {unit}") }
}

/// A number to nine significant digits, without trailing zeros.
fn rounded(x: f64) -> String {
    format!("{x:.8e}").parse::<f64>().map_or_else(|_| x.to_string(), |x| x.to_string())
}
