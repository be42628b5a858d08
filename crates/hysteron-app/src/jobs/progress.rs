//! The watch of a job: what the library reports becomes the state of the job, drawings and checkpoints.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

use hysteron_identify::{CandidateSummary, Event, Stop, Watch};
use hysteron_io::save_json;

use super::Jobs;
use super::drawing::Drawing;
use crate::api::{CostPoint, LiveUpdate, Stage};
use crate::notice::Notice;

/// Time between two updates: a picture that misses one comes with the next, still within a fifth of a second.
const BETWEEN: Duration = Duration::from_millis(90);
/// Part of the time of the fit that its own threads spend on models to be drawn, as a divisor, and the time
/// that the first one may take.
const SHARE: u32 = 60;
const FIRST: Duration = Duration::from_millis(50);
/// Time between two checkpoints.
const BETWEEN_CHECKPOINTS: Duration = Duration::from_secs(2);
/// Most points of the curve of costs: beyond it, every other one is left out.
const MOST_COSTS: usize = 2000;

/// A watch that keeps the job `id` current.
pub(super) fn watch<'a>(jobs: &'a Jobs, id: i64, stop: &Stop, drawing: &'a Drawing<'_>) -> Watch<'a> {
    let begun = Instant::now();
    let mut told: Option<Instant> = None;
    let mut kept = begun;
    // Stage and cost of the last model that was drawn, and the time that the fit has spent on such models.
    let mut shown: Option<(usize, Option<f64>)> = None;
    let mut spent = Duration::ZERO;
    let stopping = stop.clone();
    let told = move |event: &Event<'_>| {
        // Of stages that a stopped fit only passes through nothing is told.
        if stopping.is_requested() {
            return ControlFlow::Continue(());
        }
        let now = Instant::now();
        let is_new_stage = jobs.is_new_stage(id, event.stage);
        if is_new_stage || told.is_none_or(|told| now - told >= BETWEEN) {
            told = Some(now);
            let update = jobs.progressed(id, event, begun.elapsed(), is_new_stage);
            let stage = update.cost.as_ref().map_or(0, |cost| cost.stage);
            let state = (stage, event.cost);
            let is_new = shown != Some(state) && spent <= now.duration_since(begun) / SHARE + FIRST;
            let is_wanted = is_new && drawing.is_free() && jobs.workspace.notices.is_heard();
            let model = if is_wanted { event.model() } else { None };
            spent += now.elapsed();
            match model {
                Some(model) => {
                    shown = Some(state);
                    drawing.draw(model, stage, update);
                }
                None => jobs.workspace.notices.send(Notice::Live(Box::new(update))),
            }
        }
        if now - kept >= BETWEEN_CHECKPOINTS
            && let Some(searches) = event.searches()
        {
            kept = now;
            drawing.keep(searches, event.model());
        }
        ControlFlow::Continue(())
    };
    Watch::new(told).stopped_by(stop)
}

impl Jobs {
    fn is_new_stage(&self, id: i64, stage: &str) -> bool {
        let state = self.state();
        let last = state.jobs.get(&id).and_then(|job| job.stages.last());
        last.is_none_or(|last| last.name != stage)
    }

    /// Takes what an event reports into the job; returns the event for the pages.
    fn progressed(&self, id: i64, event: &Event<'_>, elapsed: Duration, is_new_stage: bool) -> LiveUpdate {
        let time_s = elapsed.as_secs_f64();
        let left_s = event.time_left(elapsed).map(|left| left.as_secs_f64());
        let mut update = LiveUpdate {
            job: id,
            fraction: event.fraction,
            left_s,
            stage: event.stage.to_owned(),
            cost: None,
            latest: None,
        };
        let mut state = self.state();
        let Some(job) = state.jobs.get_mut(&id) else { return update };
        job.revision += 1;
        if is_new_stage {
            job.stages.push(Stage { name: event.stage.to_owned(), from_s: time_s, cost: None });
        }
        job.fraction = event.fraction;
        job.left_s = left_s;
        let stage = job.stages.len().saturating_sub(1);
        if let Some(cost) = event.cost {
            job.cost = Some(cost);
            if let Some(last) = job.stages.last_mut() {
                last.cost = Some(last.cost.map_or(cost, |before| before.min(cost)));
            }
            update.cost = Some(CostPoint { time_s, cost, stage });
        }
        let job = is_new_stage.then(|| job.clone());
        if let (Some(running), Some(point)) = (&mut state.running, update.cost) {
            running.drawn.costs.push(point);
            if running.drawn.costs.len() > MOST_COSTS {
                let mut k = 0;
                running.drawn.costs.retain(|_| {
                    k += 1;
                    k % 2 == 0
                });
            }
        }
        drop(state);
        if let Some(job) = job {
            self.tell(&job);
        }
        update
    }

    /// Keeps the time that a job has run, so that it is known of one that is interrupted.
    pub(super) fn keep_time(&self, id: i64) {
        let state = self.state();
        let job = state.jobs.get(&id).map(|job| state.shown(job));
        drop(state);
        if let Some(job) = job {
            let _ = self.workspace.history.keep_job(&job);
        }
    }

    /// Tells the pages that the best so far can be kept, or why it cannot.
    pub(super) fn warned(&self, id: i64, warning: Option<String>) {
        let mut state = self.state();
        let Some(job) = state.jobs.get_mut(&id).filter(|job| job.warning != warning) else { return };
        job.warning = warning;
        job.revision += 1;
        let job = state.jobs.get(&id).map(|job| state.shown(job));
        drop(state);
        if let Some(job) = job {
            self.tell(&job);
        }
    }

    /// Tells the pages of a job from which nothing was heard for a moment.
    pub(super) fn still_running(&self, id: i64) {
        let state = self.state();
        let Some(job) = state.jobs.get(&id).map(|job| state.shown(job)) else { return };
        drop(state);
        let stage = job.stages.last().map_or_else(String::new, |stage| stage.name.clone());
        let (fraction, left_s) = (job.fraction, job.left_s);
        let update = LiveUpdate { job: id, fraction, left_s, stage, cost: None, latest: None };
        self.workspace.notices.send(Notice::Live(Box::new(update)));
    }

    /// Tells the pages which candidates are finished.
    fn raced(&self, id: i64, candidates: Vec<CandidateSummary>) {
        let mut state = self.state();
        let Some(job) = state.jobs.get_mut(&id) else { return };
        job.result.candidates = candidates;
        job.revision += 1;
        let job = job.clone();
        drop(state);
        self.tell(&job);
    }

    /// The watch of a comparison, which keeps its state at the end of each candidate in a file.
    pub(super) fn watch_of_race<'a>(&'a self, id: i64, stop: &Stop, kept: &'a Path) -> Watch<'a> {
        let begun = Instant::now();
        let mut told: Option<Instant> = None;
        let told = move |event: &Event<'_>| {
            if let Some(candidates) = event.candidates() {
                let saved = event.searches().map(|searches| save_json(kept, &searches, false));
                let failed = saved.and_then(Result::err);
                self.warned(id, failed.map(|e| format!("the finished candidates cannot be kept: {e}")));
                self.raced(id, candidates);
                self.keep_time(id);
            }
            let is_new_stage = self.is_new_stage(id, event.stage);
            if is_new_stage || told.is_none_or(|told| told.elapsed() >= BETWEEN) {
                told = Some(Instant::now());
                let update = self.progressed(id, event, begun.elapsed(), is_new_stage);
                self.workspace.notices.send(Notice::Live(Box::new(update)));
            }
            ControlFlow::Continue(())
        };
        Watch::new(told).stopped_by(stop)
    }
}
