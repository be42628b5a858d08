//! Output of `hysteron identify`.

use hysteron_identify::{Fit, FitParameter, Interval, IntervalMethod, Place, RecordFit};
use hysteron_model::Model;
use hysteron_model::axes::InfluenceMatrix;
use hysteron_model::model_file::typographic;
use hysteron_report::number::{significant, with_std_error};
use hysteron_report::results::modes::{ABOUT_GAINS, ABOUT_WEIGHTS, Names, gains, modes, weights};
use serde::Serialize;

use crate::advice;
use crate::console;
use crate::scores;

/// The object of `--json`.
#[derive(Serialize)]
pub struct Outcome<'a> {
    pub model: String,
    #[serde(flatten)]
    pub fit: &'a Fit,
}

/// Result as text, for people.
pub fn text(fit: &Fit) -> String {
    let mut text = String::new();
    if !fit.parameters.is_empty() && fit.modes().is_none() {
        text += &format!("{}\n\n", parameters(&fit.parameters));
    }
    if let Some(found) = fit.modes() {
        let names = Names::of(&fit.model);
        text += &format!("{}\n\n", console::listed(&modes(found)));
        text += &format!("{}\n{ABOUT_GAINS}\n\n", console::listed(&gains(found, &names)));
        if let Some(weights) = weights(found, &names) {
            text += &format!("{}\n{ABOUT_WEIGHTS}\n\n", console::listed(&weights));
        }
        for level in &found.influence {
            let (size, unit) = (significant(level.level, 4), &fit.model.units().input);
            text += &format!("influence at {size} {unit} rms\n{}\n\n", influence(&level.matrix, &fit.model));
        }
    }
    let whole = fit.runs().iter().map(RecordFit::score);
    text += &format!("{}\n\n", scores::table(&fit.scores.iter().cloned().chain(whole).collect::<Vec<_>>()));
    for finding in &fit.findings {
        text += &format!("{}: {}\n", finding.kind.name(), advice::text(finding));
    }
    if let Some(range) = fit.model.valid_range() {
        text += &format!("range: {}\n", range.in_words());
    }
    for line in &fit.treatment {
        text += &format!("data: {line}\n");
    }
    if let Some(found) = fit.modes() {
        text += &format!("data: {} parameters were fitted\n", found.parameters);
    }
    text
}

/// Interval rounded to the digits of the standard error; `*` marks a profile likelihood interval.
fn interval(interval: &Interval, std_error: Option<f64>) -> String {
    let end = |x: f64| with_std_error(x, std_error).0;
    let mark = if interval.method == IntervalMethod::Profile { " *" } else { "" };
    format!("{} … {}{mark}", end(interval.low), end(interval.high))
}

fn parameters(list: &[FitParameter]) -> comfy_table::Table {
    let place = list.first().and_then(|p| p.place.as_ref()).map(|place| match place {
        Place::Block(_) => "block",
        Place::Of(_) => "of",
    });
    let intervals = list.iter().any(|p| p.interval_95.is_some());
    let mut headings: Vec<&str> = place.into_iter().collect();
    headings.extend(["parameter", "value", "std. error", "unit"]);
    if intervals {
        headings.push("95 % interval");
    }
    let mut table = console::table(&headings);
    for p in list {
        let (value, error) = with_std_error(p.value, p.std_error);
        let error = match (p.held, p.std_error) {
            (true, _) => "held".to_owned(),
            (false, None) => "-".to_owned(),
            (false, Some(_)) => error,
        };
        let unit = if p.unit == "1" { String::new() } else { typographic(&p.unit) };
        let mut row: Vec<String> = match &p.place {
            Some(Place::Block(name) | Place::Of(name)) => vec![name.clone()],
            None => Vec::new(),
        };
        row.extend([p.name.clone(), value, error, unit]);
        if intervals {
            row.push(p.interval_95.map_or("-".to_owned(), |i| interval(&i, p.std_error)));
        }
        table.add_row(row);
    }
    table
}

fn influence(matrix: &InfluenceMatrix, model: &Model) -> comfy_table::Table {
    let (inputs, outputs) = model.channels().unwrap_or_default();
    let unit =
        format!("{}/{}", hysteron_model::record::Unit::new(&model.units().output), model.units().input);
    let mut header = vec![format!("[{unit}]")];
    header.extend(inputs.iter().cloned());
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let mut table = console::table(&header);
    for (name, row) in outputs.iter().zip(matrix.values.chunks(matrix.inputs.max(1))) {
        let numbers = row.iter().map(|g| significant(*g, 4));
        table.add_row(std::iter::once(name.clone()).chain(numbers));
    }
    table
}
