//! Candidates that a search leaves out, or does not fit to the end, because others are far better.

use rayon::prelude::*;

use super::RunningComparison;
use super::candidate::{Candidate, StructurePart};
use super::errors::Simulations;
use super::fit::NoFit;
use super::ranking::{Ranking, rank};

/// A search omits the folds of a candidate whose error with all records in its fit is more than this many
/// times the smallest held-out error, and greater by more than the standard error of the difference.
const HOPELESS: f64 = 1.2;
/// A search leaves out a family, block, kind of creep or degree in later passes where the held-out error of
/// everything with it was more than this many times the smallest.
const OUTCLASSED: f64 = 1.5;

impl RunningComparison<'_, '_> {
    /// True if the same structure of a higher degree was hopeless, which is fitted no worse than this one.
    pub(super) fn is_within_hopeless(&self, candidate: Candidate) -> bool {
        let hopeless = self.finished.iter().map(|finished| &finished.entry).filter(|entry| entry.is_hopeless);
        let mut degrees = hopeless.map(|entry| (entry.candidate.degree, entry.candidate));
        degrees.any(|(degree, of)| degree > candidate.degree && Candidate { degree, ..candidate } == of)
    }

    /// True if all that have this `part` in common with the candidate are far worse than the best.
    pub(super) fn is_outclassed(&self, candidate: Candidate, part: StructurePart) -> bool {
        let Some(ranking) = self.ranking() else { return false };
        let best = ranking.standings[ranking.best].map_or(0.0, |standing| standing.mean);
        let alike = self.finished.iter().zip(&ranking.standings);
        let mut alike = alike.filter(|(f, _)| f.entry.candidate.shares(candidate, part)).peekable();
        alike.peek().is_some()
            && alike.all(|(finished, standing)| match standing {
                Some(own) => own.mean > OUTCLASSED * best && !own.as_good_as_best,
                None => finished.entry.is_hopeless,
            })
    }

    /// True if the folds of a search are omitted for this fit.
    pub(super) fn is_hopeless(&self, simulations: &Simulations) -> bool {
        let Some(of_best) = self.of_best.as_ref().filter(|_| self.is_search) else { return false };
        let errors = self.folds.par_iter().map(|fold| self.campaign.error_within(simulations, fold));
        // In order, independently of the threads.
        let errors: Result<Vec<f64>, NoFit> = errors.collect::<Vec<_>>().into_iter().collect();
        let Ok(errors) = errors else { return false };
        let standing = |ranking: Ranking| ranking.standings.into_iter().flatten().next();
        rank(&[Some(errors), Some(of_best.clone())], &[0, 0])
            .and_then(standing)
            .is_some_and(|own| own.mean > HOPELESS * (own.mean - own.difference) && !own.as_good_as_best)
    }
}
