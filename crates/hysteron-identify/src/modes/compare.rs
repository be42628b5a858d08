//! Structures of scheduled modes compared by held-out error.
//!
//! Fold k holds out the k-th record of every level; each candidate is identified from the others and
//! simulated on those held out. Its error is the geometric mean over the levels of the rms error of the mean
//! period, so that every level counts by its relative error. Candidates are ranked by the one-standard-error
//! rule ([`rank`]).

use hysteron_model::axes::AxesRecord;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};

use super::candidate::ModesCandidate;
use super::normal::residual;
use super::records::Campaign;
use super::{ModesIdentification, Options, identify, summary};
use crate::structure::{Ranking, Standing, rank};
use crate::watch::Event;
use crate::{IdentifyError, ModesComparisonCheckpoint, ModesFitCheckpoint, Searches, Watch, fingerprint};
use hysteron_numeric::number::significant;

/// Most folds.
const MOST_FOLDS: usize = 5;

/// One candidate of a comparison.
#[derive(Clone, Debug)]
pub struct ModesEntry {
    /// The structure.
    pub candidate: ModesCandidate,
    /// Parameters and modes of its fit of all records; 0 where that failed.
    pub parameters: usize,
    /// Modes found.
    pub modes: usize,
    /// Its error on all records, all in its fit.
    pub training: Option<f64>,
    /// Held-out error of every fold.
    pub folds: Vec<Option<f64>>,
    /// Fits that failed, with the reason.
    pub failures: Vec<String>,
}

/// A comparison of structures of modes.
#[derive(Clone, Debug)]
pub struct ModesComparison {
    /// Names of the records.
    pub records: Vec<String>,
    /// Unit of the outputs, as printed.
    pub unit: String,
    /// Records held out in every fold.
    pub folds: Vec<Vec<String>>,
    /// The candidates, in the order given.
    pub entries: Vec<ModesEntry>,
    /// Their ranking; `None` where none is complete.
    pub ranking: Option<Ranking>,
    /// The comparison was stopped.
    pub interrupted: bool,
}

/// Compares `candidates` (empty: [`ModesCandidate::USUAL`]) on records of several axes; `options`: the rest
/// of their options. After a stop the finished candidates are compared. `resume`: the state of an interrupted
/// comparison of the same records, whose finished fits are taken and whose last one goes on; the result is
/// the same to the bit.
///
/// # Errors
/// [`IdentifyError`]: records that cannot be used; [`IdentifyError::CannotRank`] where a level has one record
/// only; [`IdentifyError::Resume`] for a state of other records or options.
pub fn compare_modes(
    records: &[AxesRecord],
    candidates: &[ModesCandidate],
    options: &Options,
    watch: &Watch<'_>,
    resume: Option<Searches>,
) -> Result<ModesComparison, IdentifyError> {
    let problem = identity(records, options);
    let (mut finished, mut running) = resumed(resume, problem)?;
    let campaign = Campaign::new(records, options)?;
    let folds = folds(&campaign)?;
    let candidates = if candidates.is_empty() { &ModesCandidate::USUAL[..] } else { candidates };
    let fits = (candidates.len() * (folds.len() + 1)) as f64;
    let mut entries = Vec::new();
    let mut done = 0.0;
    'candidates: for candidate in candidates {
        let own = candidate.options(options);
        let mut entry = ModesEntry {
            candidate: *candidate,
            parameters: 0,
            modes: 0,
            training: None,
            folds: Vec::new(),
            failures: Vec::new(),
        };
        for (fold, held_out) in std::iter::once(&Vec::new()).chain(&folds).enumerate() {
            let stage = if held_out.is_empty() {
                format!("{candidate}, all records")
            } else {
                format!("{candidate}, fold {}", entry.folds.len() + 1)
            };
            // A stop is seen below.
            let _ = watch.tell(Event::new(&stage, done / fits, None));
            let name = candidate.to_string();
            let before = finished.fits.iter().find(|fit| fit.candidate == name && fit.fold == fold);
            let fit = match before {
                Some(fit) => fit.clone(),
                None => {
                    let kept = |k: &usize| !held_out.contains(k);
                    let training: Vec<AxesRecord> =
                        (0..records.len()).filter(kept).map(|k| records[k].clone()).collect();
                    let state = running.take().filter(|state| is_of(state, &training, &own));
                    let part = watch.part(done / fits, (done + 1.0) / fits);
                    let found = identify(&training, &own, &part.with_fits(&finished), state);
                    drop(part);
                    if watch.is_stopped() {
                        break 'candidates;
                    }
                    let scored: Vec<usize> =
                        if held_out.is_empty() { (0..records.len()).collect() } else { held_out.clone() };
                    let fit = of_fit(name, fold, &found, &campaign, &scored);
                    finished.fits.push(fit.clone());
                    fit
                }
            };
            done += 1.0;
            entry.failures.extend(fit.failure.map(|why| format!("{stage}: {why}")));
            if fold > 0 {
                entry.folds.push(fit.error);
            } else {
                (entry.parameters, entry.modes, entry.training) = (fit.parameters, fit.modes, fit.error);
            }
        }
        entries.push(entry);
    }
    let errors: Vec<Option<Vec<f64>>> = entries.iter().map(|e| e.folds.iter().copied().collect()).collect();
    let parameters: Vec<usize> = entries.iter().map(|entry| entry.parameters).collect();
    let label = |held: &Vec<usize>| held.iter().map(|&k| records[k].label()).collect();
    Ok(ModesComparison {
        records: records.iter().map(AxesRecord::label).collect(),
        unit: records.first().map_or_else(String::new, |r| r.y_unit.to_string()),
        folds: folds.iter().map(label).collect(),
        ranking: rank(&errors, &parameters),
        entries,
        interrupted: watch.is_stopped(),
    })
}

/// Fingerprint of records and options.
fn identity(records: &[AxesRecord], options: &Options) -> String {
    let values = records.iter().flat_map(|r| r.u.iter().chain(&r.y)).flatten().map(|x| x.to_bits());
    format!("comparison of modes {options:?} {:x}", fingerprint(values))
}

/// The finished fits of an interrupted comparison of this problem, and the state of the fit that ran.
fn resumed(
    resume: Option<Searches>,
    problem: String,
) -> Result<(ModesComparisonCheckpoint, Option<Searches>), IdentifyError> {
    match resume {
        None => Ok((ModesComparisonCheckpoint { problem, fits: Vec::new() }, None)),
        Some(mut state) => match state.modes_comparison.take() {
            Some(finished) if finished.problem == problem => Ok((*finished, Some(state))),
            _ => Err(IdentifyError::Resume),
        },
    }
}

/// Whether a state is that of the fit of these records.
fn is_of(state: &Searches, records: &[AxesRecord], options: &Options) -> bool {
    state.modes.as_ref().is_some_and(|modes| modes.problem == summary::identity(records, options))
}

/// A finished fit, with its error on the records `scored`.
fn of_fit(
    candidate: String,
    fold: usize,
    found: &Result<ModesIdentification, IdentifyError>,
    campaign: &Campaign,
    scored: &[usize],
) -> ModesFitCheckpoint {
    let (parameters, modes) = found.as_ref().map_or((0, 0), |found| (found.parameters, found.model.modes));
    ModesFitCheckpoint {
        candidate,
        fold,
        parameters,
        modes,
        error: found.as_ref().ok().and_then(|found| error(found, campaign, scored)),
        failure: found.as_ref().err().map(ToString::to_string),
    }
}

/// Fold k: the k-th record of every level.
fn folds(campaign: &Campaign) -> Result<Vec<Vec<usize>>, IdentifyError> {
    let of_level = |level: usize| -> Vec<usize> {
        let pieces = campaign.pieces.iter().enumerate();
        pieces.filter(|(_, piece)| piece.level == level).map(|(k, _)| k).collect()
    };
    let levels: Vec<Vec<usize>> = (0..campaign.levels.len()).map(of_level).collect();
    let count = levels.iter().map(Vec::len).min().unwrap_or(0).min(MOST_FOLDS);
    if count < 2 {
        return Err(IdentifyError::CannotRank {
            because: "a level has one record only: nothing of it can be held out".to_owned(),
            measure: "two records or more at every level, with other phases".to_owned(),
        });
    }
    Ok((0..count).map(|k| levels.iter().map(|records| records[k]).collect()).collect())
}

/// Geometric mean over the levels of the rms error on these records; `None` where one cannot be simulated.
fn error(found: &ModesIdentification, campaign: &Campaign, records: &[usize]) -> Option<f64> {
    let mut logarithm = 0.0;
    for level in 0..campaign.levels.len() {
        let (mut squares, mut count) = (0.0, 0.0);
        for piece in records.iter().map(|&k| &campaign.pieces[k]).filter(|piece| piece.level == level) {
            let e = residual(&found.model, piece)?;
            squares += e.iter().map(|e| e * e).sum::<f64>();
            count += e.len() as f64;
        }
        logarithm += 0.5 * f64::ln(squares / count) / campaign.levels.len() as f64;
    }
    Some(logarithm.exp()).filter(|error| error.is_finite())
}

impl ModesComparison {
    /// Candidates in the order of the ranking, unranked ones last.
    pub fn order(&self) -> Vec<usize> {
        let mut order = self.ranking.as_ref().map_or(Vec::new(), |r| r.order.clone());
        order.extend((0..self.entries.len()).filter(|&i| self.standing(i).is_none()));
        order
    }

    /// Standing of a candidate, by its index.
    pub fn standing(&self, index: usize) -> Option<Standing> {
        self.ranking.as_ref().and_then(|r| r.standings[index])
    }

    /// The preferred structure and the reason, and what failed, in plain words.
    pub fn verdict(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(ranking) = &self.ranking {
            let name = |i: usize| self.entries[i].candidate.to_string();
            let error = |i: usize| self.standing(i).map_or(f64::NAN, |s| s.mean);
            let of = |i: usize| format!("{} {}", significant(error(i), 3), self.unit);
            let (best, preferred) = (ranking.best, ranking.preferred);
            lines.push(if best == preferred {
                format!(
                    "Preferred: {}. It has the smallest held-out error, {}, and no simpler structure is \
                     within one standard error of it.",
                    name(best),
                    of(best)
                )
            } else {
                format!(
                    "Preferred: {} ({} parameters, held-out error {}). {} is smallest ({}, {} parameters), \
                     but not by more than one standard error of the difference.",
                    name(preferred),
                    self.entries[preferred].parameters,
                    of(preferred),
                    name(best),
                    of(best),
                    self.entries[best].parameters
                )
            });
        }
        lines.extend(self.entries.iter().flat_map(|entry| &entry.failures).map(|why| format!("{why}.")));
        if self.interrupted {
            lines.push("Interrupted: the candidates that were not finished are missing.".to_owned());
        }
        lines
    }

    /// Explanation of the table.
    pub fn about(&self) -> String {
        format!(
            "Held-out error: mean over {} folds, ± standard error, of the rms error of the mean period on \
             the records held out, one of every level; over the levels the geometric mean, so that each \
             counts by its relative error. Above the best: mean ± standard error of the paired differences.",
            self.folds.len()
        )
    }

    /// The preferred structure and the options that identify it, else those of `options`; `None` without a
    /// ranking.
    pub fn preferred(&self, options: &Options) -> Option<(ModesCandidate, Options)> {
        let candidate = self.entries[self.ranking.as_ref()?.preferred].candidate;
        Some((candidate, candidate.options(options)))
    }

    /// The comparison in numbers.
    pub fn summary(&self) -> ModesComparisonSummary {
        let name = |i: usize| self.entries[i].candidate.to_string();
        let candidate = |i: usize| {
            let (entry, standing) = (&self.entries[i], self.standing(i));
            ModesCandidateSummary {
                name: name(i),
                parameters: entry.parameters,
                modes: entry.modes,
                error: standing.map(|s| s.mean),
                error_std_error: standing.map(|s| s.std_error),
                above_best: standing.map(|s| s.difference),
                above_best_std_error: standing.map(|s| s.difference_std_error),
                as_good_as_best: standing.map(|s| s.as_good_as_best),
                training_rmse: entry.training,
                fold_errors: entry.folds.clone(),
                failures: entry.failures.clone(),
            }
        };
        ModesComparisonSummary {
            records: self.records.clone(),
            output_unit: self.unit.clone(),
            preferred: self.ranking.as_ref().map(|r| name(r.preferred)),
            best: self.ranking.as_ref().map(|r| name(r.best)),
            folds: self.folds.clone(),
            candidates: self.order().into_iter().map(candidate).collect(),
            notes: self.verdict(),
            interrupted: self.interrupted,
        }
    }
}

/// A comparison of structures of modes in numbers, for JSON. Errors are in the unit of the outputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModesComparisonSummary {
    /// Names of the records.
    pub records: Vec<String>,
    /// Unit of the outputs.
    pub output_unit: String,
    /// Preferred candidate: the one with the fewest parameters that is as good as the best.
    pub preferred: Option<String>,
    /// Candidate with the smallest held-out error.
    pub best: Option<String>,
    /// Records held out in every fold.
    pub folds: Vec<Vec<String>>,
    /// Candidates in the order of the ranking.
    pub candidates: Vec<ModesCandidateSummary>,
    /// The verdict in sentences.
    pub notes: Vec<String>,
    /// The comparison was stopped.
    pub interrupted: bool,
}

/// A candidate of a comparison of modes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModesCandidateSummary {
    /// Its name.
    pub name: String,
    /// Number of estimated parameters.
    pub parameters: usize,
    /// Modes found.
    pub modes: usize,
    /// Held-out error.
    pub error: Option<f64>,
    /// Standard error of it.
    pub error_std_error: Option<f64>,
    /// Error above that of the best candidate.
    pub above_best: Option<f64>,
    /// Standard error of it.
    pub above_best_std_error: Option<f64>,
    /// Within one standard error of the best.
    pub as_good_as_best: Option<bool>,
    /// Error on all records, all in its fit.
    pub training_rmse: Option<f64>,
    /// Held-out error of each fold.
    pub fold_errors: Vec<Option<f64>>,
    /// Fits that failed, with the reason.
    pub failures: Vec<String>,
}

impl Serialize for ModesComparison {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.summary().serialize(serializer)
    }
}
