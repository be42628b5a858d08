//! Controllers of several axes compared: errors and cross-coupling of each.

use hysteron_model::model::AxesTrackingSummary;
use hysteron_model::record::Unit;

use super::{Listing, in_unit};
use crate::number::significant;

/// What the errors are.
pub const ABOUT_ERRORS: &str = "Errors are those of the true displacement, their mean removed; per cent of \
    the stroke of the axis, the worst axis. Cross-coupling: motion of an axis that is to stay while another \
    moves along its reference alone, in per cent of that stroke, the worst pair.";

/// Bandwidth and preview of the inverse, the integral, what to know of them.
pub fn sentences(found: &AxesTrackingSummary) -> Vec<String> {
    let mut lines = vec![format!(
        "Bandwidth {} Hz; preview {} samples. Integral: crossover {} Hz.",
        significant(found.bandwidth_hz, 3),
        found.preview_samples,
        significant(found.integral_crossover_hz, 3)
    )];
    lines.extend(found.findings.iter().map(ToString::to_string));
    lines
}

/// A row per controller.
pub fn errors(found: &AxesTrackingSummary) -> Listing {
    let unit = Unit::new(&found.output_unit).to_string();
    let mut columns = vec!["controller".to_owned()];
    columns.extend(found.axes.iter().map(|axis| in_unit(&format!("{axis}, rms"), &unit)));
    columns.extend(
        [
            "rms [% of stroke]",
            "largest [% of stroke]",
            "cross-coupling, rms [%]",
            "largest [%]",
            "samples at a limit",
        ]
        .map(str::to_owned),
    );
    let mut table = Listing::new(columns);
    for run in &found.controllers {
        let percent = |x: Option<f64>| x.map_or_else(|| "–".to_owned(), |x| significant(x, 3));
        let mut row = vec![run.controller.name().to_owned()];
        row.extend(run.rms.iter().map(|x| significant(*x, 3)));
        row.extend(
            [run.rms_percent, run.max_percent, run.cross_rms_percent, run.cross_max_percent].map(percent),
        );
        row.push(run.samples_at_limits.to_string());
        table.push(row);
    }
    table
}
