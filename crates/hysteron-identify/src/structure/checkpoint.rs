//! State of a comparison: the candidates that are finished, so that an interrupted one fits only the others.

use serde::{Deserialize, Serialize};

use super::super::options::{CampaignRecord, Options};
use super::super::{IdentifyError, Searches, fingerprint};
use super::candidate::Candidate;
use super::errors::Training;
use super::fit::Named;
use super::{Entry, Finished, Selection};
use hysteron_model::model_file::{ModelFile, SignalUnits};
use hysteron_model::record::TimeBase;

/// State of a comparison of structures. A comparison that resumes from it takes these candidates as they are
/// and ends with the same bits as one that was not interrupted; the candidate that was being fitted begins
/// anew.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComparisonCheckpoint {
    /// Fingerprint of the records, the options and the candidates.
    pub(super) problem: String,
    /// The candidates that are finished, in the order they were fitted.
    pub(super) finished: Vec<FinishedCandidate>,
}

impl ComparisonCheckpoint {
    /// Number of candidates that need not be fitted again.
    pub fn finished(&self) -> usize {
        self.finished.len()
    }

    /// The checkpoint within `resume`, if it has one, of this problem.
    ///
    /// # Errors
    /// [`IdentifyError::Resume`] for one of other records, options or candidates.
    pub(super) fn of(
        resume: Option<Searches>,
        problem: &str,
    ) -> Result<Vec<FinishedCandidate>, IdentifyError> {
        match resume.and_then(|searches| searches.comparison) {
            None => Ok(Vec::new()),
            Some(state) if state.problem == problem => Ok(state.finished),
            Some(_) => Err(IdentifyError::Resume),
        }
    }
}

/// A finished candidate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FinishedCandidate {
    candidate: String,
    model: Option<Box<ModelFile>>,
    parameters: usize,
    training: Option<Training>,
    fold_rmse: Vec<Option<f64>>,
    failures: Vec<String>,
    is_hopeless: bool,
    named: Named,
}

impl FinishedCandidate {
    pub(super) fn is(&self, candidate: Candidate) -> bool {
        self.candidate.parse() == Ok(candidate)
    }

    /// The candidate as it was when it finished; `None` for a file that does not fit these folds.
    pub(super) fn restored(&self, candidate: Candidate, folds: usize) -> Option<Finished> {
        let model = self.model.as_ref().map(|file| file.to_model()).transpose().ok()?;
        (self.fold_rmse.len() == folds).then(|| Finished {
            entry: Entry {
                candidate,
                model,
                parameters: self.parameters,
                training_rmse: self.training.map(|t| t.rmse),
                aic: None,
                bic: None,
                fold_rmse: self.fold_rmse.clone(),
                failures: self.failures.clone(),
                is_hopeless: self.is_hopeless,
            },
            named: self.named.clone(),
            training: self.training,
        })
    }
}

impl From<&Finished> for FinishedCandidate {
    fn from(Finished { entry, named, training }: &Finished) -> Self {
        // The file keeps every bit of a model; units are those of the records.
        let file = |model| Box::new(ModelFile::from_model(model, SignalUnits::default()));
        Self {
            candidate: entry.candidate.to_string(),
            model: entry.model.as_ref().map(file),
            parameters: entry.parameters,
            training: *training,
            fold_rmse: entry.fold_rmse.clone(),
            failures: entry.failures.clone(),
            is_hopeless: entry.is_hopeless,
            named: named.clone(),
        }
    }
}

/// Fingerprint of a comparison: samples, time bases, masks and roles of the records, options, candidates.
pub(super) fn problem(campaign: &[CampaignRecord], selection: Selection<'_>, options: &Options) -> String {
    let of_record = |record: &CampaignRecord| {
        let data = &record.data;
        let rates = data.rate.iter().flatten();
        let mut words: Vec<u64> = data.u.iter().chain(&data.y).chain(rates).map(|x| x.to_bits()).collect();
        words.extend(data.valid.iter().flatten().map(|valid| u64::from(*valid)));
        match &data.time {
            TimeBase::Uniform { start_s, sample_rate_hz, .. } => {
                words.extend([start_s.to_bits(), sample_rate_hz.to_bits()]);
            }
            TimeBase::NonUniform { times_s } => words.extend(times_s.iter().map(|t| t.to_bits())),
            TimeBase::Unknown => {}
        }
        words.extend(format!("{:?}", record.role).bytes().map(u64::from));
        words
    };
    let records = fingerprint(campaign.iter().flat_map(of_record));
    // The result does not depend on the number of threads.
    let options = Options { threads: None, ..options.clone() };
    let asked = fingerprint(format!("{selection:?} {options:?}").bytes().map(u64::from));
    format!("comparison {records:x} {asked:x}")
}
