//! Inspections as text.

use hysteron_model::record::{NoiseMethod, TimeBase, Unit};
use hysteron_report::number::significant;

use super::Inspected;
use std::path::Path;

use crate::advice;
use crate::console;
use hysteron_io::Content;

/// Jitter attributed to the rounding of time stamps, in samples.
const NO_JITTER: f64 = 1e-6;

/// A table of numbers, then warnings and remarks in plain words.
pub fn describe(inspected: &Inspected) -> String {
    let Inspected { data, found } = inspected;
    let mut table = console::table(&["", data.source.as_ref().map_or(&data.name, |s| &s.path)]);
    let mut row = |what: &str, value: String| {
        table.add_row([what.to_owned(), value]);
    };
    row("samples", found.samples.to_string());
    let duration = found.duration_s.map_or(String::new(), |d| format!(" for {} s", rounded(d)));
    let time = match (&data.time, found.sample_rate_hz) {
        (TimeBase::Uniform { jitter_samples, .. }, Some(rate)) => {
            let jitter = match *jitter_samples {
                j if j < NO_JITTER => "no jitter".to_owned(),
                j => format!("jitter {} of a sample", significant(j, 2)),
            };
            format!("{} Hz{duration}, {jitter}", rounded(rate))
        }
        (TimeBase::NonUniform { .. }, _) => match found.segments.len() {
            0 => format!("irregular{duration}"),
            segments => format!("{segments} segments of different rates{duration}"),
        },
        _ => "no time".into(),
    };
    row("sampling", time);
    row("input", signal(&data.input, &data.u_unit, found.input_range));
    row("output", signal(&data.output, &data.y_unit, found.output_range));
    if found.segments.is_empty() {
        row("drive", drive(found.kind.name(), found.frequency_span_hz));
    }
    if let Some(shape) = &found.loop_shape {
        let unit = data.y_unit.spaced();
        let settled = found.periods.is_some_and(|p| p.steady_start() > 0);
        row(if settled { "stroke, settled" } else { "stroke" }, significant(shape.stroke, 4) + &unit);
        let opening = significant(shape.opening.abs(), 3) + &unit;
        row("loop opening", format!("{opening}, {} % of stroke", significant(shape.opening_percent, 3)));
    }
    if let Some(noise) = &found.noise_floor {
        let at_most = if noise.method == NoiseMethod::FourthDifferences { ", at most" } else { "" };
        row(
            &format!("noise floor{at_most}"),
            format!("{}{} rms", significant(noise.rms, 3), data.y_unit.spaced()),
        );
    }
    let mut text = format!("{table}\n");
    if !found.segments.is_empty() {
        text += &format!("{}\n", segments(inspected));
    }
    for finding in &found.findings {
        text +=
            &format!("{}{}\n", if finding.is_warning() { "WARNING: " } else { "- " }, advice::text(finding));
    }
    text
}

/// One row per segment: time, sample rate, drive and response.
fn segments(Inspected { data, found }: &Inspected) -> String {
    let (input, output) = (data.u_unit.spaced(), data.y_unit.spaced());
    let mut table = console::table(&[
        "from [s]",
        "for [s]",
        "samples",
        "rate [Hz]",
        "drive",
        "level",
        "amplitude",
        "answer",
    ]);
    for segment in &found.segments {
        let drive = drive(&segment.drive.kind, segment.drive.low_hz.zip(segment.drive.high_hz));
        let answer = match (segment.gain, segment.phase_deg, segment.creep) {
            (Some(gain), Some(phase), _) => {
                let per = ratio(&data.y_unit, &data.u_unit);
                format!("{}{per}, {}°", significant(gain, 4), significant(phase, 3))
            }
            (_, _, Some(creep)) => format!("creeps by {}{output}", significant(creep, 3)),
            _ => String::new(),
        };
        table.add_row([
            rounded(segment.start_s),
            significant(segment.duration_s, 4),
            segment.samples.len().to_string(),
            significant(segment.sample_rate_hz, 5),
            drive,
            significant(segment.level, 4) + &input,
            significant(segment.amplitude, 3) + &input,
            answer,
        ]);
    }
    table.to_string()
}

/// Kind and frequencies of a drive.
fn drive(kind: &str, span_hz: Option<(f64, f64)>) -> String {
    let hz = |f: f64| significant(f, 4);
    match span_hz {
        Some((low, high)) if low == high => format!("{kind}, {} Hz", hz(low)),
        Some((low, high)) => format!("{kind}, {} to {} Hz", hz(low), hz(high)),
        None => kind.to_owned(),
    }
}

/// The unit of a gain, with a space before it.
fn ratio(output: &Unit, input: &Unit) -> String {
    if output.symbol().is_empty() || input.symbol().is_empty() {
        String::new()
    } else {
        format!(" {output}/{input}")
    }
}

fn signal(name: &str, unit: &Unit, (low, high): (f64, f64)) -> String {
    format!("{name}: {} to {}{}", significant(low, 5), significant(high, 5), unit.spaced())
}

/// A number to nine significant digits, without trailing zeros.
fn rounded(x: f64) -> String {
    format!("{x:.8e}").parse::<f64>().map_or_else(|_| x.to_string(), |x| x.to_string())
}

/// Table of the arrays of a file.
pub fn contents(path: &Path, held: &[Content]) -> String {
    let mut table = console::table(&["path", "shape", "unit", "holds"]);
    for content in held {
        let shape: Vec<String> = content.shape.iter().map(usize::to_string).collect();
        let unit = content.unit.clone().unwrap_or_default();
        table.add_row([content.path.clone(), shape.join(" × "), unit, content.kind.clone()]);
    }
    format!("{} holds\n{table}\n", path.display())
}
