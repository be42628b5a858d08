//! What `hysteron identify` prints.

use std::path::Path;

use hysteron_identify::{Finding, Identification, Interval, IntervalMethod, RecordFit};
use hysteron_model::model::Score;
use hysteron_model::model_file::ModelFile;
use hysteron_report::number::with_std_error;
use serde::Serialize;

use crate::console;
use crate::scores;

/// The object of `--json`.
#[derive(Serialize)]
pub struct Outcome<'a> {
    model: String,
    records: Vec<Score>,
    hysteresis: &'a hysteron_model::model_file::HysteresisBlock,
    dynamics: &'a hysteron_model::model_file::DynamicsBlock,
    delay: &'a hysteron_model::model_file::Quantity,
    parameters: Vec<ParameterEntry<'a>>,
    searches: Vec<SearchEntry>,
    reduction: Option<ReductionEntry>,
    findings: &'a [Finding],
    interrupted: bool,
}

#[derive(Serialize)]
struct ParameterEntry<'a> {
    block: &'a str,
    name: &'a str,
    value: f64,
    unit: String,
    std_error: Option<f64>,
    interval_95: Option<Interval>,
    held: bool,
}

#[derive(Serialize)]
struct SearchEntry {
    step: String,
    optimizer: &'static str,
    cost: f64,
    evaluations: usize,
    generations: usize,
}

/// The search on thinned records: what the fit of all samples then changed.
#[derive(Serialize)]
struct ReductionEntry {
    samples: usize,
    searched: usize,
    moved_std_errors: f64,
}

fn scored(found: &Identification) -> Vec<Score> {
    found.records.iter().map(RecordFit::score).collect()
}

impl<'a> Outcome<'a> {
    pub fn new(path: &Path, found: &'a Identification, file: &'a ModelFile) -> Self {
        Outcome {
            model: path.display().to_string(),
            records: scored(found),
            hysteresis: &file.hysteresis,
            dynamics: &file.dynamics,
            delay: &file.delay,
            parameters: found
                .parameters
                .iter()
                .map(|p| ParameterEntry {
                    block: p.block,
                    name: &p.name,
                    value: p.value,
                    unit: hysteron_report::identification::unit_of(p, file),
                    std_error: p.std_error,
                    interval_95: p.interval,
                    held: p.held,
                })
                .collect(),
            searches: found
                .searches
                .iter()
                .map(|s| SearchEntry {
                    step: s.step.clone(),
                    optimizer: s.algorithm,
                    cost: s.outcome.cost,
                    evaluations: s.outcome.evaluations,
                    generations: s.outcome.generations,
                })
                .collect(),
            reduction: found.reduction.map(|r| ReductionEntry {
                samples: r.samples,
                searched: r.searched,
                moved_std_errors: r.moved,
            }),
            findings: &found.findings,
            interrupted: found.cancelled,
        }
    }
}

/// Both ends to the digits of the standard error; `*` where they come from a profile.
fn interval(interval: &Interval, std_error: Option<f64>) -> String {
    let end = |x: f64| with_std_error(x, std_error).0;
    let mark = if interval.method == IntervalMethod::Profile { " *" } else { "" };
    format!("{} … {}{mark}", end(interval.low), end(interval.high))
}

/// The same for people.
pub fn text(found: &Identification, file: &ModelFile) -> String {
    let mut headings = vec!["block", "parameter", "value", "std. error", "unit"];
    let intervals = found.parameters.iter().any(|p| p.interval.is_some());
    if intervals {
        headings.push("95 % interval");
    }
    let mut parameters = console::table(&headings);
    for p in &found.parameters {
        let (value, error) = with_std_error(p.value, p.std_error);
        let error = if p.std_error.is_some() { error } else { "-".to_owned() };
        let unit = hysteron_report::identification::unit_of(p, file);
        let mut row = vec![p.block.to_owned(), p.name.clone(), value, error, unit];
        if intervals {
            row.push(p.interval.map_or("-".to_owned(), |i| interval(&i, p.std_error)));
        }
        parameters.add_row(row);
    }
    let mut text = format!("{parameters}\n\n{}\n\n", scores::table(&scored(found)));
    for finding in &found.findings {
        text += &format!("{finding}\n");
    }
    for line in &found.treatment {
        text += &format!("data: {line}\n");
    }
    text
}
