//! What `hysteron identify` prints.

use std::path::Path;

use hysteron::identify::{FindingKind, Identification};
use hysteron::model_file::ModelFile;
use hysteron_report::number::with_std_error;
use serde::Serialize;

use crate::console;
use crate::scores::{self, Scored};

/// The object of `--json`.
#[derive(Serialize)]
pub struct Outcome<'a> {
    model: String,
    records: Vec<Scored>,
    hysteresis: &'a hysteron::model_file::HysteresisBlock,
    dynamics: &'a hysteron::model_file::DynamicsBlock,
    delay: &'a hysteron::model_file::Quantity,
    searches: Vec<SearchEntry>,
    findings: Vec<FindingEntry<'a>>,
    interrupted: bool,
}

#[derive(Serialize)]
struct SearchEntry {
    step: String,
    optimizer: &'static str,
    cost: f64,
    evaluations: usize,
    generations: usize,
}

#[derive(Serialize)]
struct FindingEntry<'a> {
    kind: &'static str,
    text: &'a str,
}

fn scored(found: &Identification) -> Vec<Scored> {
    found.records.iter().map(|r| Scored::new(&r.data, r.scores.clone())).collect()
}

impl<'a> Outcome<'a> {
    pub fn new(path: &Path, found: &'a Identification, file: &'a ModelFile) -> Self {
        Outcome {
            model: path.display().to_string(),
            records: scored(found),
            hysteresis: &file.hysteresis,
            dynamics: &file.dynamics,
            delay: &file.delay,
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
            findings: found
                .findings
                .iter()
                .map(|f| FindingEntry { kind: kind_name(f.kind), text: &f.text })
                .collect(),
            interrupted: found.cancelled,
        }
    }
}

fn kind_name(kind: FindingKind) -> &'static str {
    match kind {
        FindingKind::Verdict => "verdict",
        FindingKind::Advice => "advice",
        FindingKind::Warning => "warning",
    }
}

/// The same for people.
pub fn text(found: &Identification, file: &ModelFile) -> String {
    let mut parameters = console::table(&["block", "parameter", "value", "std. error", "unit"]);
    for p in &found.parameters {
        let (value, error) = with_std_error(p.value, p.std_error);
        let error = if p.std_error.is_some() { error } else { "-".to_owned() };
        let unit = super::report::unit_of(p, file);
        parameters.add_row([p.block.to_owned(), p.name.clone(), value, error, unit]);
    }
    let mut text = format!("{parameters}\n\n{}\n\n", scores::table(&scored(found)));
    for finding in &found.findings {
        text += &format!("{}: {}\n", kind_name(finding.kind), finding.text);
    }
    for line in &found.treatment {
        text += &format!("data: {line}\n");
    }
    text
}
