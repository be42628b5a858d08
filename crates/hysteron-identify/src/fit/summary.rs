//! An identification in numbers.

use std::collections::BTreeMap;

use hysteron_model::Model;
use hysteron_model::axes::Mode;
use hysteron_model::model::{Score, ScoreSummary};
use hysteron_model::model_file::{DynamicsBlock, HysteresisBlock, InfluenceEntry, Quantity};
use serde::{Deserialize, Serialize, Serializer};

use super::{Fit, FitDetails, FitParameter};
use crate::modes::ModeShift;
use crate::structure::FamilySelection;
use crate::{Finding, RecordFit, RecordSines};

/// An identification in numbers, for JSON. Empty and `None` fields are omitted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitSummary {
    /// Structure, of every kind but a Hammerstein model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub structure: Option<String>,
    /// Scores of the records, of parts of runs where they continue one another.
    pub records: Vec<ScoreSummary>,
    /// The whole of a run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub whole: Option<ScoreSummary>,
    /// The whole of each run, where there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub runs: Vec<ScoreSummary>,
    /// Estimated and held parameters; of modes, the physical quantities that follow from them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parameters: Option<Vec<FitParameter>>,
    /// Number of parameters of modes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parameter_count: Option<usize>,
    /// Static block of a Hammerstein model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hysteresis: Option<HysteresisBlock>,
    /// Its dynamic block.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dynamics: Option<DynamicsBlock>,
    /// Its delay.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delay: Option<Quantity>,
    /// Gain and phase at the sine segments of the records of a Hammerstein model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sines: Vec<RecordSines>,
    /// Choice of its hysteresis family, where it was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub family: Option<FamilySummary>,
    /// Searches that were run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub searches: Option<Vec<SearchSummary>>,
    /// Thinning of the records while searching.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reduction: Option<ReductionSummary>,
    /// Modes at the lowest and the highest level.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modes: Option<Vec<ModeSummary>>,
    /// Influence matrices of modes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub influence: Option<Vec<InfluenceEntry>>,
    /// Verdicts, advice and warnings.
    pub findings: Vec<Finding>,
    /// The fit was stopped.
    pub interrupted: bool,
}

/// Choice of a hysteresis family by held-out error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FamilySummary {
    /// The family chosen.
    pub chosen: String,
    /// Held-out error of each family, geometric mean over the folds \[output unit\]; `None` where a fit
    /// failed. Empty where families were not compared.
    pub errors: BTreeMap<String, Option<f64>>,
    /// Choice and reason, in plain words.
    pub verdict: String,
}

impl From<&FamilySelection> for FamilySummary {
    fn from(selection: &FamilySelection) -> Self {
        let errors = selection.errors.iter().map(|(family, error)| (family.name().to_owned(), *error));
        Self {
            chosen: selection.chosen.name().to_owned(),
            errors: errors.collect(),
            verdict: selection.verdict.clone(),
        }
    }
}

/// A search of an identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SearchSummary {
    /// Step of the identification that it belongs to.
    pub step: String,
    /// Optimiser.
    pub optimizer: String,
    /// Cost at the end.
    pub cost: f64,
    /// Evaluations of the cost.
    pub evaluations: usize,
    /// Generations, or iterations of least squares.
    pub generations: usize,
}

/// Thinning of the records while searching.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReductionSummary {
    /// Samples of the records.
    pub samples: usize,
    /// Samples used in the search.
    pub searched: usize,
    /// Samples of the last fit: fewer than all where a long record is far oversampled.
    #[serde(default)]
    pub fitted: usize,
    /// Largest change of a parameter in the fit of all samples, in standard errors.
    pub moved_std_errors: f64,
}

/// A mode at the lowest and at the highest level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModeSummary {
    /// At the lowest level.
    pub lowest_level: Mode,
    /// At the highest level.
    pub highest_level: Mode,
}

impl Serialize for Fit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.summary().serialize(serializer)
    }
}

impl Fit {
    /// The identification in numbers.
    pub fn summary(&self) -> FitSummary {
        let structure = match &self.found {
            FitDetails::Hammerstein(_) => None,
            FitDetails::Oscillator(_) => Some("oscillator"),
            FitDetails::Force(_) => Some("force"),
            FitDetails::Modes(_) => Some("modes"),
            FitDetails::Branches(_) => Some("hammerstein"),
        };
        let runs: Vec<ScoreSummary> = self.runs().iter().map(|run| run.score().summary()).collect();
        let mut summary = FitSummary {
            structure: structure.map(str::to_owned),
            records: self.scores.iter().map(Score::summary).collect(),
            parameters: Some(self.parameters.clone()),
            findings: self.findings.clone(),
            interrupted: self.interrupted,
            ..FitSummary::default()
        };
        match <[ScoreSummary; 1]>::try_from(runs) {
            Ok([run]) => summary.whole = Some(run),
            Err(runs) => summary.runs = runs,
        }
        match (&self.found, &self.model) {
            (FitDetails::Hammerstein(found), Model::Hammerstein(body)) => {
                let file = body.data();
                summary.hysteresis = Some(file.hysteresis.clone());
                summary.dynamics = Some(file.dynamics.clone());
                summary.delay = Some(file.delay.clone());
                let with_sines = found.records.iter().filter(|record| !record.sines.is_empty());
                let sines = |record: &RecordFit| RecordSines {
                    record: record.data.name.clone(),
                    sines: record.sines.clone(),
                };
                summary.sines = with_sines.map(sines).collect();
                summary.family = found.structure.family.as_ref().map(FamilySummary::from);
                let searches = found.searches.iter();
                let searches = searches.map(|s| SearchSummary::new(&s.step, s.algorithm, &s.outcome));
                summary.searches = Some(searches.collect());
                summary.reduction = found.reduction.map(|r| ReductionSummary {
                    samples: r.samples,
                    searched: r.searched,
                    fitted: r.fitted,
                    moved_std_errors: r.moved,
                });
            }
            (FitDetails::Oscillator(found), _) => {
                let shapes = found.shapes.iter().map(|s| ("shape", s));
                let all = shapes.chain([("output error", &found.search)]);
                let all = all.map(|(step, outcome)| SearchSummary::new(step, "least-squares", outcome));
                summary.searches = Some(all.collect());
            }
            (FitDetails::Force(found), _) => {
                summary.searches = Some(vec![SearchSummary::new("force", "least-squares", &found.search)]);
            }
            (FitDetails::Modes(found), Model::Modes(body)) => {
                let mode = |m: &ModeShift| ModeSummary { lowest_level: m.low, highest_level: m.high };
                summary.parameter_count = Some(found.parameters);
                summary.modes = Some(found.modes.iter().map(mode).collect());
                summary.influence = Some(body.data().influence.clone());
            }
            _ => {}
        }
        summary
    }
}

impl SearchSummary {
    fn new(step: &str, optimizer: &str, outcome: &hysteron_optimize::Outcome) -> Self {
        Self {
            step: step.to_owned(),
            optimizer: optimizer.to_owned(),
            cost: outcome.cost,
            evaluations: outcome.evaluations,
            generations: outcome.generations,
        }
    }
}
