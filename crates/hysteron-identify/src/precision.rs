//! Findings on the precision of a fit: standard errors, and searches that ended too early.

use super::engine::Search;
use super::result::Identification;
use super::{Finding, FindingKind};
use hysteron_model::Advice;
use hysteron_numeric::display::short;
use hysteron_optimize::StopReason;

/// A parameter whose standard error exceeds this share of its value is called undetermined.
const UNDETERMINED: f64 = 0.5;
/// A search whose best cost fell by more than this share was still converging.
const STILL_IMPROVING: f64 = 0.01;
/// Fewest last generations over which this is judged.
const LAST_GENERATIONS: usize = 5;

/// Parameters that the records do not determine, by their standard errors alone.
pub(super) fn precision(result: &Identification) -> Vec<Finding> {
    let mut findings = Vec::new();
    let undetermined: Vec<&str> = result
        .bounds
        .first()
        .into_iter()
        .flat_map(|bounds| &bounds.ranges)
        .map(|range| range.name.as_str())
        .filter(|name| result.parameters.iter().any(|p| p.name == *name && p.std_error.is_none()))
        .collect();
    if !undetermined.is_empty() {
        findings.push(
            Finding::new(FindingKind::Warning, "precision", format!(
                "No standard errors: the records do not determine {} separately from the other parameters. \
                 Lower the degree, add records, or hold one of them.",
                undetermined.join(", ")
            ))
            .with_advice(Advice::Hold { parameter: None }),
        );
    }
    let poor: Vec<String> = result
        .parameters
        .iter()
        .filter_map(|p| Some((p, p.std_error.filter(|e| *e > UNDETERMINED * p.value.abs())?)))
        .map(|(p, error)| format!("{} ({} ± {})", p.name, short(p.value), short(error)))
        .collect();
    if !poor.is_empty() {
        findings.push(Finding::new(
            FindingKind::Advice,
            "precision",
            format!(
                "Poorly determined by these records (value ± standard error): {}. Do not read them as \
                 properties of the device; the output is described by all parameters together.",
                poor.join(", ")
            ),
        ));
    }
    findings
}

/// Warning about a population search that ran out of generations while it was still improving: by more than
/// [`STILL_IMPROVING`] over the last tenth of them (at least the last [`LAST_GENERATIONS`], or all).
pub(super) fn still_improving(search: &Search) -> Option<String> {
    let outcome = &search.outcome;
    if !matches!(outcome.stopped, StopReason::Generations | StopReason::Budget) || !outcome.starts.is_empty()
    {
        return None;
    }
    let generations = outcome.generations;
    let last = generations.div_ceil(10).max(LAST_GENERATIONS).min(generations);
    let before = outcome.history.get(outcome.history.len().checked_sub(1 + last)?)?.best_cost;
    let gained = 1.0 - outcome.cost / before;
    (gained > STILL_IMPROVING || !before.is_finite()).then(|| {
        format!(
            "The search of the {} was too short to be trusted: the best RMSE was still falling, by {} % over \
             the last {last} of {generations} generations. Let it run longer, or leave the choice of the \
             optimiser to the program.",
            search.step,
            if before.is_finite() { short(100.0 * gained) } else { "100".into() }
        )
    })
}
