//! Structure selection: candidates compared by their held-out simulation error.
//!
//! [`compare`] holds out one fold after the other ([`Fold`]: a record, or a part of one or of a run), fits
//! every [`Candidate`] to the rest, simulates the held-out data (free run, with the sensor's offset
//! estimated), and ranks by the mean error over the folds with the uncertainty of its differences ([`rank`]).
//! Where the records repeat one experiment, it returns [`IdentifyError::CannotRank`] with the measurement
//! needed. [`prospects`] predicts before any fit what a campaign can determine.

mod candidate;
mod checkpoint;
mod content;
mod errors;
mod family;
mod fit;
mod folds;
mod loose;
mod neighbours;
mod prospect;
mod racing;
mod ranking;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

pub use candidate::{Block, Candidate, StructurePart, UnknownCandidate};
pub use checkpoint::ComparisonCheckpoint;
pub use content::Content;
pub use family::FamilySelection;
pub(crate) use family::choose as choose_family;
pub use folds::Fold;
pub use neighbours::{Neighbour, Neighbours, neighbours};
pub use prospect::{Prospect, Prospects, prospects};
pub use ranking::{Ranking, Standing, rank};

use super::campaign::{of_runs, runs, usable};
use super::compared::CandidateSummary;
use super::engine::Engine;
use super::joint::JointMember;
use super::options::{CampaignRecord, DynamicsChoice, Options};
use super::searches::Searches;
use super::watch::{Plan, State};
use super::{Event, IdentifyError, RecordFacts, Watch};
use checkpoint::FinishedCandidate;
use errors::Training;
use fit::{Campaign, Named, NoFit, WholeFit};
use hysteron_model::dynamics::Creep;
use hysteron_model::hammerstein::Model;
use hysteron_optimize::Settings;

/// Most passes of a search.
const PASSES: usize = 3;
/// Expected number of candidates in a second pass.
const SECOND_PASS: usize = 15;
/// Candidates fitted at the same time.
const ABREAST: usize = 3;
/// Number of other candidates' fits used as starts.
const LEND: usize = 2;

/// A comparison of structures.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The cross-validation folds.
    pub folds: Vec<Fold>,
    /// The candidates in the order they were fitted.
    pub entries: Vec<Entry>,
    /// Their order; `None` where none is finished.
    pub ranking: Option<Ranking>,
    /// Root of the mean squared noise floor of the records \[output unit\].
    pub noise_floor: f64,
    /// Effective number of independent samples of the best fit's residuals, used in AIC and BIC.
    pub independent_samples: f64,
    /// Samples of all records.
    pub samples: usize,
    /// Further limitations of the comparison, in plain words.
    pub notes: Vec<String>,
    /// The records were taken as parts of runs.
    pub continued: bool,
    /// It was stopped: candidates are missing.
    pub interrupted: bool,
    /// The time given was over: candidates are missing.
    pub out_of_time: bool,
}

/// The candidates of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Selection<'a> {
    /// These.
    Given(&'a [Candidate]),
    /// A search through families of hysteresis, dynamic blocks, kinds of creep, polynomial degrees and n, one
    /// [`StructurePart`] after the other from the preferred one so far, until it stays.
    Search,
    /// One pass of the search through the commonest of each part.
    QuickSearch,
}

/// One candidate.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The structure.
    pub candidate: Candidate,
    /// The model fitted to all records (to thinned ones where they are oversampled); `None` where the fit
    /// failed.
    pub model: Option<Model>,
    /// Number of parameters, without the records' offsets and initial memories.
    pub parameters: usize,
    /// RMSE over all records, each with its offset \[output unit\].
    pub training_rmse: Option<f64>,
    /// N ln(Σ(e/σ)²/N) + 2k over the independent samples N, with σ each record's noise floor (Akaike 1974,
    /// doi:10.1109/TAC.1974.1100705, for Gaussian residuals).
    pub aic: Option<f64>,
    /// N ln(Σ(e/σ)²/N) + k ln N (Schwarz 1978, doi:10.1214/aos/1176344136).
    pub bic: Option<f64>,
    /// Held-out RMSE of each fold, by the fit to the rest \[output unit\].
    pub fold_rmse: Vec<Option<f64>>,
    /// Why an error is missing.
    pub failures: Vec<String>,
    /// The search omitted its folds: already with all records in its fit, its error was more than 1.2 times
    /// the smallest held-out error.
    pub is_hopeless: bool,
}

impl Entry {
    fn complete(&self) -> Option<Vec<f64>> {
        self.fold_rmse.iter().copied().collect()
    }
}

impl<'a> Selection<'a> {
    /// The candidates given, else a search.
    pub fn of(given: &'a [Candidate], quick: bool) -> Self {
        match (given, quick) {
            ([], false) => Self::Search,
            ([], true) => Self::QuickSearch,
            (given, _) => Self::Given(given),
        }
    }
}

/// Compares candidates on a campaign. Structure, algorithm and demands in `options` are ignored. Where
/// `watch` has a time limit ([`Watch::within`]), the comparison is of what is finished by then.
///
/// # Errors
/// [`IdentifyError`]. A candidate that cannot be fitted is no error: see [`Entry::failures`].
pub fn compare(
    campaign: &[CampaignRecord],
    selection: Selection<'_>,
    options: &Options,
    watch: &Watch<'_>,
) -> Result<Comparison, IdentifyError> {
    compare_from(campaign, selection, options, watch, None)
}

/// [`compare`], with the candidates of an interrupted comparison ([`Event::searches`]) as they are: the result
/// is that of a comparison that was not interrupted, to the bit.
///
/// # Errors
/// Those of [`compare`]; [`IdentifyError::Resume`] for a state of other records, options or candidates.
pub fn compare_from(
    campaign: &[CampaignRecord],
    selection: Selection<'_>,
    options: &Options,
    watch: &Watch<'_>,
    resume: Option<Searches>,
) -> Result<Comparison, IdentifyError> {
    options.validate()?;
    let problem = checkpoint::problem(campaign, selection, options);
    let resumed = ComparisonCheckpoint::of(resume, &problem)?;
    let runs = if options.continued { runs(campaign)? } else { Vec::new() };
    let joined = of_runs(campaign, &runs);
    let facts = usable(if options.continued { &joined } else { campaign })?;
    let contents: Vec<Content> = facts.iter().map(Content::of).collect();
    let folds = match folds::of_parts(&runs) {
        Some(folds) => folds,
        None => folds::plan(&facts, &contents)?,
    };
    let options = &Options { demands: Default::default(), algorithm: None, start: None, ..options.clone() };
    let settings = Settings { seed: options.seed, ..Settings::default() };
    let mut engine = Engine::new(None, settings, watch, Plan(&[]), None);
    let members =
        facts.iter().map(|f| JointMember::new(f, options, &mut engine)).collect::<Result<Vec<_>, _>>()?;
    let campaign = Campaign { facts: &facts, members: &members, options, stop: watch.stop() };

    let mut run = RunningComparison {
        campaign,
        folds,
        watch,
        done: AtomicUsize::new(0),
        planned: 0,
        finished: Vec::new(),
        cut_short: false,
        preferred: None,
        of_best: None,
        is_search: !matches!(selection, Selection::Given(_)),
        has_news: AtomicBool::new(false),
        problem,
        resumed,
    };
    match selection {
        Selection::Given(candidates) => run.add(candidates),
        Selection::Search => run.search(Candidate::alternatives, PASSES),
        Selection::QuickSearch => run.search(Candidate::common_alternatives, 1),
    }
    // Amplitudes and frequencies are those of the uniformly sampled segments.
    let parts = facts.iter().flat_map(|facts| facts.data.in_moving_segments());
    let seen: Vec<Content> = parts.map(|part| Content::of(&RecordFacts::new(part))).collect();
    let notes = folds::limits(&seen, &run.folds);
    Ok(run.comparison(notes))
}

/// State of a running comparison.
struct RunningComparison<'a, 'w> {
    campaign: Campaign<'a>,
    folds: Vec<Fold>,
    watch: &'a Watch<'w>,
    done: AtomicUsize,
    planned: usize,
    finished: Vec<Finished>,
    /// A stop came before the end.
    cut_short: bool,
    /// The preferred candidate so far, and its held-out error.
    preferred: Option<(Candidate, f64)>,
    /// Held-out errors of the best candidate so far.
    of_best: Option<Vec<f64>>,
    /// The candidates come from a search.
    is_search: bool,
    /// A candidate has finished since the last event.
    has_news: AtomicBool,
    /// Fingerprint of records, options and candidates.
    problem: String,
    /// Candidates that an interrupted comparison finished and this one has not come to yet.
    resumed: Vec<FinishedCandidate>,
}

struct Finished {
    entry: Entry,
    named: Named,
    training: Option<Training>,
}

impl RunningComparison<'_, '_> {
    /// Coordinate search over the parts of the structure from fractional dynamics with creep, each part from
    /// the preferred candidate so far, repeated until a pass changes nothing: the best dynamics depend on the
    /// hysteresis before them, and vice versa.
    fn search(&mut self, alternatives_of: fn(Candidate, StructurePart) -> Vec<Candidate>, passes: usize) {
        let fractional = Candidate::of(Block::of(DynamicsChoice::Fractional));
        let mut so_far = Candidate { creep: Creep::Fractional, ..fractional };
        for pass in 1..=passes {
            let before = so_far;
            for (parts_left, part) in (0..StructurePart::ALL.len()).rev().zip(StructurePart::ALL) {
                let mut alternatives = alternatives_of(so_far, part);
                alternatives.retain(|alternative| pass == 1 || !self.is_outclassed(*alternative, part));
                // Estimate: every remaining part has as many candidates as this one.
                let of_next_pass = if pass == 1 && passes > 1 { SECOND_PASS } else { 0 };
                let to_come = parts_left * alternatives.len() + of_next_pass;
                self.planned = self.done.load(Ordering::Relaxed)
                    + (alternatives.len() + to_come) * (self.folds.len() + 1);
                self.add(&alternatives);
                if self.watch.is_stopped() {
                    self.cut_short = true;
                    return;
                }
                if let Some(ranking) = self.ranking() {
                    so_far = self.finished[ranking.preferred].entry.candidate;
                }
            }
            if so_far == before {
                return;
            }
        }
    }

    fn add(&mut self, candidates: &[Candidate]) {
        let fits = self.folds.len() + 1;
        self.planned = self.planned.max(self.done.load(Ordering::Relaxed) + candidates.len() * fits);
        // The first fit of all lends its values to the others.
        let alone = usize::from(self.finished.is_empty()).min(candidates.len());
        let (alone, others) = candidates.split_at(alone);
        for abreast in [alone].into_iter().filter(|first| !first.is_empty()).chain(others.chunks(ABREAST)) {
            if self.watch.is_stopped() || !self.add_abreast(abreast) {
                self.cut_short = true;
                return;
            }
        }
    }

    /// Fits candidates at the same time, with what was known before them, so that the result does not depend on
    /// the threads; false after a stop.
    fn add_abreast(&mut self, candidates: &[Candidate]) -> bool {
        let fits = self.folds.len() + 1;
        let is_known = |candidate: &Candidate| {
            self.finished.iter().any(|f| f.entry.candidate == *candidate)
                || self.is_within_hopeless(*candidate)
        };
        let (known, new): (Vec<_>, Vec<_>) = candidates.iter().copied().partition(is_known);
        known.into_iter().for_each(|candidate| self.step(fits, candidate));
        let fitted = |&candidate: &Candidate| self.restored(candidate).or_else(|| self.fitted(candidate));
        let fitted: Vec<Option<Finished>> = new.par_iter().map(fitted).collect();
        let is_complete = fitted.iter().all(Option::is_some);
        self.resumed.retain(|finished| !new.iter().any(|candidate| finished.is(*candidate)));
        for finished in fitted.into_iter().flatten() {
            let candidate = finished.entry.candidate;
            self.finished.push(finished);
            let ranking = self.ranking();
            let best = ranking.as_ref().map(|ranking| &self.finished[ranking.best].entry);
            self.of_best = best.and_then(Entry::complete);
            self.preferred = ranking.map(|ranking| {
                let error = ranking.standings[ranking.preferred].map_or(f64::NAN, |standing| standing.mean);
                (self.finished[ranking.preferred].entry.candidate, error)
            });
            self.has_news.store(true, Ordering::Relaxed);
            self.step(0, candidate);
        }
        is_complete
    }

    fn step(&self, fits: usize, candidate: Candidate) {
        let done = self.done.fetch_add(fits, Ordering::Relaxed) + fits;
        let fraction = done as f64 / self.planned.max(1) as f64;
        // The next check handles a stop.
        let stage = match &self.preferred {
            Some((preferred, _)) => format!("{candidate}, so far {preferred}"),
            None => candidate.to_string(),
        };
        let error = self.preferred.as_ref().map(|(_, error)| *error);
        let so_far = || self.so_far();
        let candidates: Option<&dyn Fn() -> Vec<CandidateSummary>> = Some(&so_far);
        let has_news = self.has_news.swap(false, Ordering::Relaxed);
        let searches = || self.searches();
        let searches: Option<&dyn Fn() -> Searches> = Some(&searches);
        let state = State { candidates: candidates.filter(|_| has_news), searches, ..State::default() };
        let _ = self.watch.tell(Event::new(&stage, fraction, error).with(state));
    }

    /// The candidate as an interrupted comparison finished it; `None` where it did not.
    fn restored(&self, candidate: Candidate) -> Option<Finished> {
        let finished = self.resumed.iter().find(|finished| finished.is(candidate))?;
        let finished = finished.clone().restored(candidate, self.folds.len())?;
        self.step(self.folds.len() + 1, candidate);
        Some(finished)
    }

    /// State to resume from.
    fn searches(&self) -> Searches {
        let finished = self.finished.iter().map(FinishedCandidate::from).chain(self.resumed.iter().cloned());
        let comparison = ComparisonCheckpoint { problem: self.problem.clone(), finished: finished.collect() };
        Searches { comparison: Some(Box::new(comparison)), ..Searches::default() }
    }

    /// The candidates that are finished, in the order of their error.
    fn so_far(&self) -> Vec<CandidateSummary> {
        let ranking = self.ranking();
        let standing = |index: usize| ranking.as_ref().and_then(|ranking| ranking.standings[index]);
        let summary = |(index, finished): (usize, &Finished)| {
            CandidateSummary::new(&finished.entry, standing(index), None)
        };
        let mut candidates: Vec<CandidateSummary> = self.finished.iter().enumerate().map(summary).collect();
        let error = |c: &CandidateSummary| c.error.unwrap_or(f64::INFINITY);
        candidates.sort_by(|a, b| error(a).total_cmp(&error(b)));
        candidates
    }

    /// Fits the candidate to the whole campaign and on every fold; `None` after a stop.
    fn fitted(&self, candidate: Candidate) -> Option<Finished> {
        let mut entry = Entry {
            candidate,
            model: None,
            parameters: 0,
            training_rmse: None,
            aic: None,
            bic: None,
            fold_rmse: vec![None; self.folds.len()],
            failures: Vec::new(),
            is_hopeless: false,
        };
        let mut lenders: Vec<&Finished> = self.finished.iter().filter(|f| !f.named.is_empty()).collect();
        lenders.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        let lent: Vec<&Named> = lenders.iter().take(LEND).map(|f| &f.named).collect();
        let whole = match self.campaign.fit(candidate, &lent) {
            Ok(whole) => whole,
            Err(NoFit::Stopped) => return None,
            // A fit stopped before its first step returns an error unrelated to the candidate.
            Err(NoFit::Failed(_)) if self.watch.is_stopped() => return None,
            Err(NoFit::Failed(why)) => {
                entry.failures.push(format!("all records: {why}"));
                self.step(self.folds.len() + 1, candidate);
                return Some(Finished { entry, named: Vec::new(), training: None });
            }
        };
        self.step(1, candidate);
        let simulations = self.campaign.simulations(&whole);
        entry.is_hopeless = simulations.as_ref().is_ok_and(|simulations| self.is_hopeless(simulations));
        if entry.is_hopeless {
            self.step(self.folds.len(), candidate);
        } else {
            // Records are processed in parallel too, but rarely enough of them have equal size.
            let errors: Vec<Result<f64, NoFit>> =
                self.folds.par_iter().map(|fold| self.on_fold(candidate, &whole, fold)).collect();
            for (index, error) in errors.into_iter().enumerate() {
                match error {
                    Ok(error) => entry.fold_rmse[index] = Some(error),
                    Err(NoFit::Stopped) => return None,
                    Err(NoFit::Failed(_)) if self.watch.is_stopped() => return None,
                    Err(NoFit::Failed(why)) => {
                        entry.failures.push(format!("without {}: {why}", self.folds[index].label));
                    }
                }
            }
        }
        let training = simulations.and_then(|simulations| self.campaign.training(&simulations)).ok();
        entry.parameters = whole.parameters;
        entry.training_rmse = training.map(|t| t.rmse);
        entry.model = Some(whole.model);
        Some(Finished { entry, named: whole.named, training })
    }

    fn on_fold(&self, candidate: Candidate, whole: &WholeFit, fold: &Fold) -> Result<f64, NoFit> {
        let error = self.campaign.error_on(candidate, whole, fold);
        self.step(1, candidate);
        error
    }

    fn ranking(&self) -> Option<Ranking> {
        let errors: Vec<Option<Vec<f64>>> = self.finished.iter().map(|f| f.entry.complete()).collect();
        let parameters: Vec<usize> = self.finished.iter().map(|f| f.entry.parameters).collect();
        rank(&errors, &parameters)
    }

    fn comparison(self, notes: Vec<String>) -> Comparison {
        let ranking = self.ranking();
        // Residuals of the best fit are the least structured.
        let closest = self.finished.iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
        let information = closest.and_then(|f| f.training).map_or(2.0, |t| t.information.max(2.0));
        let interrupted = self.cut_short && self.watch.is_interrupted();
        let out_of_time = self.cut_short && !interrupted;
        let entries = self
            .finished
            .into_iter()
            .map(|Finished { mut entry, training, .. }| {
                let parameters = entry.parameters as f64;
                entry.aic = training.map(|t| t.fit(information) + 2.0 * parameters);
                entry.bic = training.map(|t| t.bic(information, entry.parameters));
                entry
            })
            .collect();
        let scored = |i: usize| self.campaign.facts[i].scored(0).len();
        let records = 0..self.campaign.facts.len();
        let samples: usize = records.clone().map(scored).sum();
        let noise = records.map(|i| scored(i) as f64 * self.campaign.members[i].noise.powi(2)).sum::<f64>();
        Comparison {
            continued: self.campaign.options.continued,
            folds: self.folds,
            entries,
            ranking,
            noise_floor: (noise / samples.max(1) as f64).sqrt(),
            independent_samples: information,
            samples,
            notes,
            interrupted,
            out_of_time,
        }
    }
}

/// Cost of the fit to the whole campaign.
fn cost(finished: &Finished) -> f64 {
    finished.training.map_or(f64::INFINITY, |t| t.mean_square)
}

#[cfg(test)]
mod tests;
