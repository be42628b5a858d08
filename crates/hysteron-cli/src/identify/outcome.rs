//! What `hysteron identify` prints.

use std::path::Path;

use hysteron::identify::{FindingKind, Identification};
use hysteron::model_file::ModelFile;
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
        let error = p.std_error.map_or("held".to_owned(), |e| format!("{e:.2e}"));
        let unit = super::report::unit_of(p, file);
        parameters.add_row([
            p.block.to_owned(),
            p.name.clone(),
            format!("{:.6}", Shortest(p.value)),
            error,
            unit,
        ]);
    }
    let mut text = format!("{parameters}\n\n{}\n", scores::table(&scored(found)));
    for finding in &found.findings {
        text += &format!("{}: {}\n", kind_name(finding.kind), finding.text);
    }
    for line in &found.treatment {
        text += &format!("data: {line}\n");
    }
    text
}

/// A number in plain or scientific form, whichever reads better.
struct Shortest(f64);

impl std::fmt::Display for Shortest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = f.precision().unwrap_or(6);
        let size = self.0.abs();
        if size == 0.0 || (1e-3..1e6).contains(&size) {
            let decimals = (digits as i32 - 1 - size.max(1e-3).log10().floor() as i32).max(0) as usize;
            write!(f, "{:.decimals$}", self.0)
        } else {
            write!(f, "{:.*e}", digits.saturating_sub(1), self.0)
        }
    }
}
