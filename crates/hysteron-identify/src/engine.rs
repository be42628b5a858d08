//! Runs the searches of an identification one after another: progress, cancellation and resumption in one
//! place.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use hysteron_model::Model;
use hysteron_optimize::{
    Algorithm, Checkpoint, LeastSquaresOptions, LeastSquaresProblem, Observer, OptimizeError, Outcome,
    Progress, Settings, Stop, StopReason, minimize,
};

use crate::searches::Searches;
use crate::watch::{Event, Plan, State, Watch};

/// One search of an identification, for reports.
#[derive(Clone, Debug)]
pub struct Search {
    /// Name of the step.
    pub step: String,
    /// Name of the algorithm.
    pub algorithm: &'static str,
    /// Outcome of the search.
    pub outcome: Outcome,
}

impl Search {
    /// Takes the optimum of `other`, if there is one, where it is better, and adds its starts to these.
    pub(super) fn take_better(&mut self, other: Option<Self>) {
        let Some(Self { outcome: other, .. }) = other else { return };
        self.outcome.evaluations += other.evaluations;
        self.outcome.generations += other.generations;
        self.outcome.starts.extend(other.starts);
        if other.cost < self.outcome.cost {
            (self.outcome.best, self.outcome.cost) = (other.best, other.cost);
        }
    }
}

/// Model at a point of a search, for display; `None`: it is not shown.
pub(super) type Show<'s> = Option<&'s dyn Fn(&[f64]) -> Option<Model>>;

/// Options of the small fits that choose a structure, whose costs differ by far more than this tolerance.
pub(super) fn quick() -> LeastSquaresOptions {
    LeastSquaresOptions { cost_tolerance: 1e-8, ..Default::default() }
}

/// A few iterations, for fits that only provide starts.
pub(super) fn rough() -> LeastSquaresOptions {
    LeastSquaresOptions { iterations: 12, cost_tolerance: 1e-4, ..Default::default() }
}

pub(super) struct Engine<'a, 'w> {
    algorithm: Option<&'a Algorithm>,
    settings: Settings,
    watch: &'a Watch<'w>,
    plan: Plan,
    /// Share of the whole work done so far.
    fraction: f64,
    resumed: BTreeMap<String, Checkpoint>,
    done: BTreeMap<String, Checkpoint>,
    /// Searches begun, by step.
    begun: BTreeMap<String, usize>,
    /// A search was stopped: later ones stop as soon as they have a result.
    pub(super) cancelled: bool,
}

impl<'a, 'w> Engine<'a, 'w> {
    pub(super) fn new(
        algorithm: Option<&'a Algorithm>,
        settings: Settings,
        watch: &'a Watch<'w>,
        plan: Plan,
        resume: Option<Searches>,
    ) -> Self {
        let resumed = resume.map(|r| r.searches).unwrap_or_default();
        Self {
            algorithm,
            settings,
            watch,
            plan,
            fraction: 0.0,
            resumed,
            done: BTreeMap::new(),
            begun: BTreeMap::new(),
            cancelled: watch.is_stopped(),
        }
    }

    /// The stop signal.
    pub(super) fn stop(&self) -> &Stop {
        self.watch.stop()
    }

    /// True if the work is to end with the best result so far.
    pub(super) fn is_stopped(&mut self) -> bool {
        self.cancelled |= self.watch.is_stopped();
        self.cancelled
    }

    /// What was found, or `None` where it failed because of a stop.
    pub(super) fn unless_stopped<T, E>(&mut self, found: Result<T, E>) -> Result<Option<T>, E> {
        match found {
            Err(_) if self.is_stopped() => Ok(None),
            found => found.map(Some),
        }
    }

    /// [`Self::unless_stopped`] of a search beside others: `None` also where none of its starts can be
    /// simulated.
    pub(super) fn where_feasible(
        &mut self,
        search: Result<Search, OptimizeError>,
    ) -> Result<Option<Search>, OptimizeError> {
        match search {
            Err(OptimizeError::NoFeasiblePoint { .. }) => Ok(None),
            search => self.unless_stopped(search),
        }
    }

    /// Reports the beginning of a stage other than a search; false after a stop.
    pub(super) fn enter(&mut self, stage: &str) -> bool {
        self.fraction = self.plan.fraction(stage, 0.0).unwrap_or(self.fraction);
        self.cancelled |= self.watch.tell(Event::new(stage, self.fraction, None)).is_break();
        !self.cancelled
    }

    /// Runs the selected algorithm (least squares by default).
    pub(super) fn search<P: LeastSquaresProblem>(
        &mut self,
        step: &str,
        problem: &P,
        starts: Vec<Vec<f64>>,
        show: Show<'_>,
    ) -> Result<Search, OptimizeError> {
        let least_squares = Algorithm::LeastSquares(LeastSquaresOptions { starts: 12, ..Default::default() });
        let algorithm = self.algorithm.cloned().unwrap_or(least_squares);
        self.run(step, problem, &algorithm, starts, show)
    }

    /// Least squares from the given starts only: the small fits that choose a structure.
    pub(super) fn quick_fit<P: LeastSquaresProblem>(
        &mut self,
        step: &str,
        problem: &P,
        starts: Vec<Vec<f64>>,
    ) -> Result<Search, OptimizeError> {
        self.local_fits(step, problem, starts, quick(), None)
    }

    /// Least squares from the given starts only.
    pub(super) fn local_fits<P: LeastSquaresProblem>(
        &mut self,
        step: &str,
        problem: &P,
        starts: Vec<Vec<f64>>,
        options: LeastSquaresOptions,
        show: Show<'_>,
    ) -> Result<Search, OptimizeError> {
        let options = LeastSquaresOptions { starts: starts.len().max(1), ..options };
        self.run(step, problem, &Algorithm::LeastSquares(options), starts, show)
    }

    /// Runs `algorithm`.
    pub(super) fn run<P: LeastSquaresProblem>(
        &mut self,
        step: &str,
        problem: &P,
        algorithm: &Algorithm,
        starts: Vec<Vec<f64>>,
        show: Show<'_>,
    ) -> Result<Search, OptimizeError> {
        let generations = self.settings.generations;
        self.run_for(step, problem, algorithm, starts, generations, show)
    }

    /// Runs `algorithm` for this many generations.
    pub(super) fn run_for<P: LeastSquaresProblem>(
        &mut self,
        step: &str,
        problem: &P,
        algorithm: &Algorithm,
        starts: Vec<Vec<f64>>,
        generations: usize,
        show: Show<'_>,
    ) -> Result<Search, OptimizeError> {
        let settings = Settings { starts, generations, ..self.settings.clone() };
        // Its starts may come from interrupted work.
        self.is_stopped();
        let key = self.next_key(step);
        let resume = self.resumed.remove(&key);
        let mut observer = Observed { engine: self, step, key: &key, show };
        let outcome = minimize(problem, algorithm, &settings, &mut observer, resume)?;
        // A search after an interrupted one started from unfinished results and is not kept.
        if !self.cancelled && problem.bounds().dimension() > 0 {
            self.done.insert(key, outcome.checkpoint.clone());
        }
        self.cancelled |= outcome.stopped == StopReason::Cancelled;
        Ok(Search { step: step.to_owned(), algorithm: algorithm.name(), outcome })
    }

    /// Key of the next search of a step for resumption: a step may be searched more than once, on problems of
    /// different structure.
    fn next_key(&mut self, step: &str) -> String {
        let count = self.begun.entry(step.to_owned()).or_default();
        *count += 1;
        if *count == 1 { step.to_owned() } else { format!("{step} ({count})") }
    }

    /// State after the searches so far, with that of the current one.
    fn searches_with(&self, key: &str, checkpoint: &Checkpoint) -> Searches {
        let mut searches = self.done.clone();
        searches.insert(key.to_owned(), checkpoint.clone());
        Searches { searches, ..Searches::default() }
    }

    /// State after the searches so far.
    pub(super) fn searches(&self) -> Searches {
        Searches { searches: self.done.clone(), ..Searches::default() }
    }
}

/// Observer of the current search.
struct Observed<'e, 'a, 'w, 's> {
    engine: &'e mut Engine<'a, 'w>,
    step: &'s str,
    key: &'s str,
    show: Show<'s>,
}

impl Observer for Observed<'_, '_, '_, '_> {
    fn generation(&mut self, progress: &Progress<'_>) -> ControlFlow<()> {
        let engine = &mut *self.engine;
        let within = progress.generation as f64 / progress.generations.max(1) as f64;
        engine.fraction = engine.plan.fraction(self.step, within).unwrap_or(engine.fraction);
        let searches = || engine.searches_with(self.key, progress.checkpoint());
        let model = || self.show.and_then(|show| show(progress.best));
        let state = State { model: Some(&model), searches: Some(&searches), ..State::default() };
        engine.watch.tell(Event::new(self.step, engine.fraction, Some(progress.best_cost)).with(state))
    }

    fn stop(&self) -> Option<Stop> {
        Some(self.engine.stop().clone())
    }
}
