//! The starts of the searches, for the report.

use crate::starts::{SearchStarts, StartRow};
use hysteron_identify::Identification;
use hysteron_optimize::{LocalStatus, StartResult};

/// Starts whose costs differ by less than this share of the best ended in the same optimum.
const SAME: f64 = 1e-6;

/// Every search that kept a record of its starts.
pub(super) fn starts(found: &Identification, unit: &str) -> Vec<SearchStarts> {
    let searches = found.searches.iter().filter(|search| !search.outcome.starts.is_empty());
    searches
        .map(|search| {
            let starts = &search.outcome.starts;
            let best = starts.iter().map(|start| start.cost).fold(f64::INFINITY, f64::min);
            SearchStarts {
                step: search.step.clone(),
                unit: unit.to_owned(),
                rows: starts.iter().map(|start| row(start, best)).collect(),
            }
        })
        .collect()
}

fn row(start: &StartResult, best: f64) -> StartRow {
    StartRow {
        initial: start.initial_cost,
        end: start.cost,
        iterations: start.iterations,
        how: in_words(start.status).to_owned(),
        best: start.cost.is_finite() && start.cost <= best * (1.0 + SAME),
    }
}

fn in_words(status: LocalStatus) -> &'static str {
    match status {
        LocalStatus::GradientTolerance => "converged: no slope left",
        LocalStatus::CostTolerance => "converged: RMSE no longer falls",
        LocalStatus::StepTolerance => "converged: parameters no longer move",
        LocalStatus::Iterations => "out of iterations",
        LocalStatus::Stalled => "stalled: the RMSE has jumps or an edge",
        LocalStatus::Abandoned => "given up: too slow to reach the best",
        LocalStatus::Budget => "out of evaluations",
        LocalStatus::Infeasible => "the model cannot be simulated there",
        LocalStatus::NotDifferentiable => "the model cannot be differentiated there",
        _ => "ended otherwise",
    }
}
