//! Draws the best model so far and keeps checkpoints, on a thread of its own, so that the fit does not wait.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::{Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

use hysteron_identify::Searches;
use hysteron_io::{save_json, save_model};
use hysteron_model::model::Signals;
use hysteron_model::record::{InputOutput, find_periods};
use hysteron_model::validate::{Scoring, score};
use hysteron_model::{Model, Start};

use super::Jobs;
use crate::api::{Axis, CostPoint, Curve, LiveLoop, LiveUpdate};
use crate::draw::{Along, over, over_time};
use crate::notice::Notice;

/// Samples that are simulated for a drawing: a millisecond or two, and more than three a pixel.
const MOST_SAMPLES: usize = 1_500;
/// Width of the drawings \[pixels\].
const PIXELS: usize = 400;
/// Time between two drawings, in times of the work for one: the fit has the processors for the rest.
const REST: u32 = 24;
/// Time after which the pages hear from a fit that reports nothing.
const SILENCE: Duration = Duration::from_millis(180);

/// What is drawn of a running fit.
#[derive(Default)]
pub(super) struct Drawn {
    pub costs: Vec<CostPoint>,
    pub measured: Option<Curve>,
    pub latest: Option<LiveLoop>,
}

/// Work of the thread.
enum Work {
    Draw { model: Box<Model>, stage: usize, update: Box<LiveUpdate> },
    Keep { searches: Box<Searches>, model: Option<Box<Model>> },
}

/// The thread.
pub(super) struct Drawing<'s> {
    work: SyncSender<Work>,
    busy: Arc<AtomicBool>,
    thread: ScopedJoinHandle<'s, ()>,
}

impl<'s> Drawing<'s> {
    /// Begins to draw for the job `id` on the record `drawn`, and to keep checkpoints at the paths `keep`:
    /// the model, and the searches.
    pub(super) fn begin<'e>(
        scope: &'s Scope<'s, 'e>,
        jobs: &'s Jobs,
        id: i64,
        drawn: Option<(String, InputOutput)>,
        keep: (PathBuf, PathBuf),
    ) -> Self {
        let (work, coming) = sync_channel(2);
        let busy = Arc::new(AtomicBool::new(false));
        let own = Arc::clone(&busy);
        let thread = scope.spawn(move || run(jobs, id, drawn, &keep, &coming, &own));
        Self { work, busy, thread }
    }

    /// True if a drawing would not wait.
    pub(super) fn is_free(&self) -> bool {
        !self.busy.load(Ordering::Acquire)
    }

    /// Draws a model; left out where the thread is busy.
    pub(super) fn draw(&self, model: Model, stage: usize, update: LiveUpdate) {
        let work = Work::Draw { model: Box::new(model), stage, update: Box::new(update) };
        self.busy.store(true, Ordering::Release);
        if self.work.try_send(work).is_err() {
            self.busy.store(false, Ordering::Release);
        }
    }

    /// Keeps a checkpoint; the next one follows where the thread is busy.
    pub(super) fn keep(&self, searches: Searches, model: Option<Model>) {
        let _ = self.work.try_send(Work::Keep { searches: Box::new(searches), model: model.map(Box::new) });
    }

    /// Ends the thread when its work is done.
    pub(super) fn end(self) {
        let Self { work, thread, .. } = self;
        drop(work);
        let _ = thread.join();
    }
}

fn run(
    jobs: &Jobs,
    id: i64,
    drawn: Option<(String, InputOutput)>,
    (partial, searches_file): &(PathBuf, PathBuf),
    coming: &Receiver<Work>,
    busy: &AtomicBool,
) {
    let mut easel = drawn.and_then(|(record, data)| Easel::new(record, data));
    if let Some(easel) = &easel
        && let Some(running) = &mut jobs.state().running
    {
        running.drawn.measured = Some(easel.measured());
    }
    // Until when the fit has the processors for itself.
    let mut rests_until = None;
    loop {
        let rest = rests_until.map(|until: Instant| until.saturating_duration_since(Instant::now()));
        let work = match coming.recv_timeout(rest.map_or(SILENCE, |rest| rest.min(SILENCE))) {
            Ok(work) => Some(work),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return,
        };
        match work {
            Some(Work::Draw { model, stage, mut update }) => {
                let begun = Instant::now();
                let is_heard = jobs.workspace.notices.is_heard();
                update.latest = easel.as_mut().filter(|_| is_heard).and_then(|e| e.draw(&model, stage));
                if let (Some(running), Some(latest)) = (&mut jobs.state().running, &update.latest)
                    && running.id == id
                {
                    running.drawn.latest = Some(latest.clone());
                }
                jobs.workspace.notices.send(Notice::Live(update));
                rests_until = Some(Instant::now() + begun.elapsed() * REST);
            }
            Some(Work::Keep { searches, model }) => {
                let kept = save_json(searches_file, &*searches, false)
                    .and_then(|()| model.map_or(Ok(()), |model| save_model(partial, &model)));
                // One that cannot be written is followed by another.
                jobs.keep_time(id);
                jobs.warned(id, kept.err().map(|e| format!("the best so far cannot be kept: {e}")));
            }
            None if rest.is_none() => jobs.still_running(id),
            None => {}
        }
        if rests_until.is_some_and(|until| until <= Instant::now()) {
            rests_until = None;
            busy.store(false, Ordering::Release);
        }
    }
}

/// The record that is drawn on.
struct Easel {
    record: String,
    data: InputOutput,
    signals: Signals,
    stage: Option<usize>,
    /// Start of the record, found once a stage.
    start: Start,
    residual_axis: Axis,
}

impl Easel {
    /// A record, or its first periods where it is long.
    fn new(record: String, data: InputOutput) -> Option<Self> {
        let data = if data.len() <= MOST_SAMPLES {
            data
        } else {
            let period = find_periods(&data).map_or(1, |periods| periods.period_samples.round() as usize);
            let whole = (MOST_SAMPLES / period.max(1)).max(1) * period.max(1);
            data.cropped(0..whole.min(MOST_SAMPLES)).ok()?
        };
        let signals = data.clone().into();
        let residual_axis = Axis::default();
        Some(Self { record, data, signals, stage: None, start: Start::AsIdentified, residual_axis })
    }

    fn measured(&self) -> Curve {
        let u = Along::new(&self.data.input, &self.data.u_unit, &self.data.u);
        let y = Along::new(&self.data.output, &self.data.y_unit, &self.data.y);
        over(&u, &y, 0..self.data.len(), PIXELS, None)
    }

    fn draw(&mut self, model: &Model, stage: usize) -> Option<LiveLoop> {
        let data = &self.data;
        let is_new_stage = self.stage != Some(stage);
        let start = if is_new_stage { Start::AsIdentified } else { self.start };
        let found = model.simulate(&self.signals, start).ok()?;
        self.start = found.start;
        let simulated = found.outputs.first()?;
        let scores = score(data, simulated, &Scoring::default()).ok()?;
        let shown: Vec<f64> = simulated.iter().map(|y| y + scores.offset).collect();
        let residual: Vec<f64> = data.y.iter().zip(&shown).map(|(y, model)| y - model).collect();
        let u = Along::new(&data.input, &data.u_unit, &data.u);
        let y = Along::new(&data.output, &data.y_unit, &shown);
        let e = Along::new("residual", &data.y_unit, &residual);
        let all = 0..data.len();
        let residual_curve = over_time(&data.time, &e, all.clone(), PIXELS);
        // Axes change only where a stage begins.
        if is_new_stage {
            self.stage = Some(stage);
            let reach = scores.max_abs_error;
            let up = residual_curve.up.clone();
            self.residual_axis = Axis { low: -reach, high: reach, ..up };
        }
        Some(LiveLoop {
            record: self.record.clone(),
            stage,
            model: over(&u, &y, all, PIXELS, None),
            residual: residual_curve,
            rmse: scores.rmse,
            residual_axis: self.residual_axis.clone(),
        })
    }
}
