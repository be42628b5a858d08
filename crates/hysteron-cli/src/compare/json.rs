//! The comparison for programs; errors in the output's unit.

use hysteron_model::hysteresis::Invertibility;
use serde::Serialize;

use super::baselines::BaselineEntry;
use super::{Found, text};

#[derive(Serialize)]
pub struct Summary<'a> {
    records: &'a [String],
    output_unit: &'a str,
    preferred: Option<String>,
    best: Option<String>,
    noise_floor: f64,
    samples: usize,
    independent_samples: f64,
    folds: Vec<FoldEntry<'a>>,
    candidates: Vec<CandidateEntry<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    baselines: Vec<BaselineEntry<'a>>,
    notes: Vec<String>,
    interrupted: bool,
}

#[derive(Serialize)]
struct FoldEntry<'a> {
    left_out: &'a str,
    content: &'a str,
    whole_records: bool,
}

#[derive(Serialize)]
struct CandidateEntry<'a> {
    name: String,
    parameters: usize,
    error: Option<f64>,
    error_std_error: Option<f64>,
    above_best: Option<f64>,
    above_best_std_error: Option<f64>,
    as_good_as_best: Option<bool>,
    training_rmse: Option<f64>,
    aic: Option<f64>,
    bic: Option<f64>,
    nanoseconds_per_sample: Option<f64>,
    states: Option<usize>,
    not_realised_because: Option<&'a str>,
    invertible: Option<&'static str>,
    fold_errors: &'a [Option<f64>],
    failures: &'a [String],
}

impl<'a> Summary<'a> {
    /// Candidates in the order of the ranking.
    pub fn new(found: &'a Found) -> Self {
        let comparison = &found.comparison;
        let name = |i: usize| comparison.entries[i].candidate.to_string();
        let candidate = |i: usize| {
            let (entry, standing) = (&comparison.entries[i], text::standing(comparison, i));
            let costs = found.costs.get(i);
            CandidateEntry {
                name: name(i),
                parameters: entry.parameters,
                error: standing.map(|s| s.mean),
                error_std_error: standing.map(|s| s.std_error),
                above_best: standing.map(|s| s.difference),
                above_best_std_error: standing.map(|s| s.difference_std_error),
                as_good_as_best: standing.map(|s| s.as_good_as_best),
                training_rmse: entry.training_rmse,
                aic: entry.aic,
                bic: entry.bic,
                nanoseconds_per_sample: costs.and_then(|c| c.cost).map(|c| c.nanoseconds),
                states: costs.and_then(|c| c.cost).map(|c| c.states),
                not_realised_because: costs.and_then(|c| c.why_not.as_deref()),
                invertible: costs.and_then(|c| c.inverse).map(Invertibility::word),
                fold_errors: &entry.fold_rmse,
                failures: &entry.failures,
            }
        };
        Summary {
            records: &found.records,
            output_unit: &found.unit,
            preferred: comparison.ranking.as_ref().map(|r| name(r.preferred)),
            best: comparison.ranking.as_ref().map(|r| name(r.best)),
            noise_floor: comparison.noise_floor,
            samples: comparison.samples,
            independent_samples: comparison.independent_samples,
            folds: comparison
                .folds
                .iter()
                .map(|f| FoldEntry { left_out: &f.label, content: &f.content, whole_records: f.whole })
                .collect(),
            candidates: text::order(comparison).into_iter().map(candidate).collect(),
            baselines: found.baselines.iter().map(BaselineEntry::new).collect(),
            notes: text::verdict(found),
            interrupted: comparison.interrupted,
        }
    }
}
