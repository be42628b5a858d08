//! Runs the searches of an identification one after another: progress, cancellation and resumption in one place.

use super::IdentifyError;
use hysteron_optimize::{
    Algorithm, Checkpoint, LeastSquaresOptions, LeastSquaresProblem, Outcome, Progress, Settings, StopReason,
    minimize,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// Told about the searches of an identification; may stop it, and the best so far is kept.
pub trait Watcher {
    /// A generation of the search `step` is done. `searches` holds everything needed to go on from here, and is worth
    /// saving now and then (it is built only when asked for).
    fn progress(
        &mut self,
        step: &str,
        progress: &Progress<'_>,
        searches: &dyn Fn() -> Searches,
    ) -> ControlFlow<()>;
}

/// The watcher that looks away.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl Watcher for Unwatched {
    fn progress(&mut self, _: &str, _: &Progress<'_>, _: &dyn Fn() -> Searches) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// State of an identification: the searches done and the one under way. Serialise it to interrupt an identification
/// and go on later to the same final bits.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Searches {
    /// `hysteron-searches`.
    pub format: SearchesFormat,
    /// Checkpoint of each search, by its name.
    pub searches: BTreeMap<String, Checkpoint>,
}

/// Format tag of [`Searches`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum SearchesFormat {
    /// The only one.
    #[default]
    #[serde(rename = "hysteron-searches-1")]
    Version1,
}

/// One search of an identification, for reports.
#[derive(Clone, Debug)]
pub struct Search {
    /// What was searched.
    pub step: String,
    /// Name of the algorithm.
    pub algorithm: &'static str,
    /// What came out.
    pub outcome: Outcome,
}

pub(super) struct Engine<'a> {
    algorithm: Option<&'a Algorithm>,
    settings: Settings,
    watcher: &'a mut dyn Watcher,
    resumed: BTreeMap<String, Checkpoint>,
    done: BTreeMap<String, Checkpoint>,
    /// A search was stopped: later ones stop as soon as they have a result.
    pub(super) cancelled: bool,
}

impl<'a> Engine<'a> {
    pub(super) fn new(
        algorithm: Option<&'a Algorithm>,
        settings: Settings,
        watcher: &'a mut dyn Watcher,
        resume: Option<Searches>,
    ) -> Self {
        let resumed = resume.map(|r| r.searches).unwrap_or_default();
        Self { algorithm, settings, watcher, resumed, done: BTreeMap::new(), cancelled: false }
    }

    /// Runs the algorithm that was asked for (least squares by default).
    pub(super) fn search<P: LeastSquaresProblem>(
        &mut self,
        step: &str,
        problem: &P,
        starts: Vec<Vec<f64>>,
    ) -> Result<Search, IdentifyError> {
        let least_squares = Algorithm::LeastSquares(LeastSquaresOptions { starts: 12, ..Default::default() });
        let algorithm = self.algorithm.cloned().unwrap_or(least_squares);
        self.run(step, problem, &algorithm, starts)
    }

    /// Least squares from the given starts only: the small fits that choose a structure.
    pub(super) fn quick_fit<P: LeastSquaresProblem>(
        &mut self,
        step: &str,
        problem: &P,
        starts: Vec<Vec<f64>>,
    ) -> Result<Search, IdentifyError> {
        // Structures are told apart by far larger differences.
        self.local_fits(
            step,
            problem,
            starts,
            LeastSquaresOptions { cost_tolerance: 1e-8, ..Default::default() },
        )
    }

    /// Least squares from the given starts only, to the end.
    pub(super) fn fit_from<P: LeastSquaresProblem>(
        &mut self,
        step: &str,
        problem: &P,
        starts: Vec<Vec<f64>>,
    ) -> Result<Search, IdentifyError> {
        self.local_fits(step, problem, starts, LeastSquaresOptions::default())
    }

    /// A few iterations of least squares from each start: where other fits begin.
    pub(super) fn rough_fit<P: LeastSquaresProblem>(
        &mut self,
        step: &str,
        problem: &P,
        starts: Vec<Vec<f64>>,
    ) -> Result<Search, IdentifyError> {
        let options = LeastSquaresOptions { iterations: 12, cost_tolerance: 1e-4, ..Default::default() };
        self.local_fits(step, problem, starts, options)
    }

    fn local_fits<P: LeastSquaresProblem>(
        &mut self,
        step: &str,
        problem: &P,
        starts: Vec<Vec<f64>>,
        options: LeastSquaresOptions,
    ) -> Result<Search, IdentifyError> {
        let options = LeastSquaresOptions { starts: starts.len().max(1), ..options };
        self.run(step, problem, &Algorithm::LeastSquares(options), starts)
    }

    fn run<P: LeastSquaresProblem>(
        &mut self,
        step: &str,
        problem: &P,
        algorithm: &Algorithm,
        starts: Vec<Vec<f64>>,
    ) -> Result<Search, IdentifyError> {
        let generations = self.settings.generations;
        self.run_for(step, problem, algorithm, starts, generations)
    }

    /// Runs `algorithm` for this many generations.
    pub(super) fn run_for<P: LeastSquaresProblem>(
        &mut self,
        step: &str,
        problem: &P,
        algorithm: &Algorithm,
        starts: Vec<Vec<f64>>,
        generations: usize,
    ) -> Result<Search, IdentifyError> {
        let settings = Settings { starts, generations, ..self.settings.clone() };
        let resume = self.resumed.remove(step);
        let (watcher, done, cancelled) = (&mut *self.watcher, &self.done, self.cancelled);
        let mut observer = |progress: &Progress<'_>| {
            let searches = || {
                let mut searches = done.clone();
                searches.insert(step.to_owned(), progress.checkpoint().clone());
                Searches { format: SearchesFormat::Version1, searches }
            };
            let asked = watcher.progress(step, progress, &searches);
            if cancelled && progress.best_cost.is_finite() { ControlFlow::Break(()) } else { asked }
        };
        let outcome = minimize(problem, algorithm, &settings, &mut observer, resume)?;
        // A search after an interrupted one started from unfinished results: it is not worth keeping.
        if !self.cancelled {
            self.done.insert(step.to_owned(), outcome.checkpoint.clone());
        }
        self.cancelled |= outcome.stopped == StopReason::Cancelled;
        Ok(Search { step: step.to_owned(), algorithm: algorithm.name(), outcome })
    }

    /// State after the searches so far.
    pub(super) fn searches(&self) -> Searches {
        Searches { format: SearchesFormat::Version1, searches: self.done.clone() }
    }
}
