//! Drives of several actuators: what each does, and how well every axis follows.

use hysteron_model::model::DecoupledSummary;
use hysteron_model::record::Unit;

use super::{Listing, in_unit};
use crate::number::significant;

fn units(found: &DecoupledSummary) -> (String, String) {
    (Unit::new(&found.input_unit).to_string(), Unit::new(&found.output_unit).to_string())
}

/// Every actuator: its drive at rest, its range, the samples at a limit.
pub fn actuators(found: &DecoupledSummary) -> Listing {
    let (input, _) = units(found);
    let mut table = Listing::new([
        "actuator".to_owned(),
        in_unit("at rest", &input),
        in_unit("from", &input),
        in_unit("to", &input),
        "samples limited by the range".to_owned(),
        "by the slew rate".to_owned(),
    ]);
    for one in &found.actuators {
        table.push([
            one.name.clone(),
            one.rest.map_or_else(|| "–".to_owned(), |rest| significant(rest, 4)),
            significant(one.low, 4),
            significant(one.high, 4),
            one.samples_at_range.to_string(),
            one.samples_at_slew.to_string(),
        ]);
    }
    table
}

/// Every axis: its stroke and its predicted error.
pub fn axes(found: &DecoupledSummary) -> Listing {
    let (_, output) = units(found);
    let mut table = Listing::new([
        "axis".to_owned(),
        in_unit("stroke", &output),
        in_unit("predicted error, rms", &output),
        in_unit("largest", &output),
    ]);
    for one in &found.axes {
        table.push([
            one.name.clone(),
            significant(one.stroke, 4),
            significant(one.rms, 3),
            significant(one.max, 3),
        ]);
    }
    table
}

/// What the figures assume, and the worst axis.
pub fn sentences(found: &DecoupledSummary) -> Vec<String> {
    let (input, output) = units(found);
    let mut lines = vec![format!(
        "Errors assume an exact model. Bandwidth {} Hz; each voltage is held for {} s.",
        significant(found.bandwidth_hz, 3),
        significant(1.0 / found.sample_rate_hz, 4)
    )];
    if let Some(preview) = found.preview {
        lines.push(preview.in_words());
    }
    if found.level > 0.0 {
        lines.push(format!("Modes as at a drive of {} {input} rms.", significant(found.level, 3)));
    }
    if found.rate_error > 0.0 {
        lines.push(format!(
            "At this rate the model's linear response is matched to {} % rms.",
            significant(100.0 * found.rate_error, 2)
        ));
    }
    let worst = found.axes.iter().fold(0.0_f64, |most, one| most.max(one.rms));
    lines.push(format!("Worst axis: {} {output} rms.", significant(worst, 3)));
    lines.extend(found.findings.iter().map(ToString::to_string));
    lines
}
