//! The queue: one computation at a time, on a thread of its own. What a page sees of a job is what is kept of
//! it in the history, so that nothing is lost when the program ends.

mod compare;
mod drawing;
mod identify;
mod plan;
mod progress;

use std::collections::{BTreeMap, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use hysteron_identify::Stop;

use crate::api::{Command, Job, JobRequest, JobResult, JobState, Live, Problem};
use crate::clock::now;
use crate::notice::{Change, Notice};
use crate::refused::{Answer, Refused};
use crate::workspace::Workspace;
use drawing::Drawn;
pub(crate) use identify::FitFound;
use plan::Plan;

/// Jobs of a workspace.
pub(crate) struct Jobs {
    workspace: Arc<Workspace>,
    state: Mutex<State>,
    planning: Mutex<()>,
    wake: Condvar,
}

#[derive(Default)]
struct State {
    jobs: BTreeMap<i64, Job>,
    queue: VecDeque<i64>,
    running: Option<Running>,
    closing: bool,
}

/// The job that runs.
struct Running {
    id: i64,
    stop: Stop,
    begun: Instant,
    drawn: Drawn,
}

/// How a job ended.
struct Ended {
    result: JobResult,
    error: Option<Problem>,
    /// It was stopped before its end.
    stopped: bool,
    /// It can go on from where it was.
    resumable: bool,
}

impl Jobs {
    /// The jobs of the history. Those that ran when the program ended are interrupted; those that waited,
    /// wait.
    ///
    /// # Errors
    /// If the history cannot be read.
    pub(crate) fn open(workspace: Arc<Workspace>) -> rusqlite::Result<Arc<Self>> {
        let mut state = State::default();
        for mut job in workspace.history.jobs()? {
            match job.state {
                JobState::Running => {
                    job.state = JobState::Interrupted;
                    job.revision += 1;
                    job.ended = Some(now());
                    job.left_s = None;
                    job.resumable = plan::searches_of(&workspace, &job).is_some();
                    job.result.models = plan::partial_of(&workspace, &job).into_iter().collect();
                    workspace.history.keep_job(&job)?;
                }
                JobState::Waiting => state.queue.push_back(job.id),
                _ => {}
            }
            state.jobs.insert(job.id, job);
        }
        let jobs = Arc::new(Self {
            workspace,
            state: Mutex::new(state),
            planning: Mutex::default(),
            wake: Condvar::new(),
        });
        let worker = Arc::clone(&jobs);
        std::thread::spawn(move || worker.work());
        Ok(jobs)
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Queues a job.
    ///
    /// # Errors
    /// For records that are not there and options that contradict one another.
    pub(crate) fn add(&self, request: JobRequest) -> Answer<Job> {
        // One at a time, so that no two take the same name.
        let _planning = self.planning.lock().unwrap_or_else(PoisonError::into_inner);
        let Plan { request, name, command, unit } = self.plan(request)?;
        let mut job = Job {
            id: 0,
            name,
            state: JobState::Waiting,
            revision: 0,
            planned: planned_stages(&request),
            request,
            stages: Vec::new(),
            fraction: 0.0,
            cost: None,
            unit,
            elapsed_s: 0.0,
            left_s: None,
            ahead: 0,
            command,
            created: now(),
            started: None,
            ended: None,
            resumable: false,
            result: JobResult::default(),
            warning: None,
            error: None,
        };
        job.id = self.workspace.history.add_job(&job)?;
        self.workspace.history.add_action(&job.command)?;
        let mut state = self.state();
        state.queue.push_back(job.id);
        state.jobs.insert(job.id, job.clone());
        let job = state.shown(&job);
        drop(state);
        self.tell(&job);
        self.wake.notify_all();
        Ok(job)
    }

    /// The commands of a job, without queueing it.
    ///
    /// # Errors
    /// Those of [`Self::add`].
    pub(crate) fn command(&self, request: JobRequest) -> Answer<Command> {
        Ok(self.plan(request)?.command)
    }

    fn plan(&self, request: JobRequest) -> Answer<Plan> {
        let is_open = |job: &&Job| matches!(job.state, JobState::Waiting | JobState::Running);
        let taken: Vec<String> =
            self.state().jobs.values().filter(is_open).filter_map(plan::model_of).cloned().collect();
        plan::plan(&self.workspace, request, &taken)
    }

    /// All jobs, newest first.
    pub(crate) fn all(&self) -> Vec<Job> {
        let state = self.state();
        state.jobs.values().rev().map(|job| state.shown(job)).collect()
    }

    /// A job.
    ///
    /// # Errors
    /// If there is none of this number.
    pub(crate) fn one(&self, id: i64) -> Answer<Job> {
        let state = self.state();
        state.jobs.get(&id).map(|job| state.shown(job)).ok_or_else(|| unknown(id))
    }

    /// Stops a job: the best so far is kept. One that waits is taken out of the queue.
    ///
    /// # Errors
    /// If there is none of this number, or it has ended.
    pub(crate) fn stop(&self, id: i64) -> Answer<Job> {
        let mut state = self.state();
        let job = state.jobs.get(&id).cloned().ok_or_else(|| unknown(id))?;
        match job.state {
            JobState::Running => {
                if let Some(running) = state.running.as_ref().filter(|running| running.id == id) {
                    running.stop.request();
                }
                Ok(state.shown(&job))
            }
            JobState::Waiting => {
                state.queue.retain(|waiting| *waiting != id);
                let revision = job.revision + 1;
                let job = Job { state: JobState::Stopped, revision, ended: Some(now()), ..job };
                state.jobs.insert(id, job.clone());
                drop(state);
                self.keep(&job);
                Ok(job)
            }
            _ => Err(Refused::conflict("the job has ended")),
        }
    }

    /// Queues a job again that was stopped, interrupted or failed; a fit goes on from where it was.
    ///
    /// # Errors
    /// If there is none of this number, or it is not to be resumed.
    pub(crate) fn resume(&self, id: i64) -> Answer<Job> {
        let mut state = self.state();
        let job = state.jobs.get(&id).ok_or_else(|| unknown(id))?;
        if !matches!(job.state, JobState::Stopped | JobState::Interrupted | JobState::Failed) {
            return Err(Refused::conflict("only a job that was stopped or interrupted can go on"));
        }
        let job = Job {
            state: JobState::Waiting,
            revision: job.revision + 1,
            fraction: 0.0,
            ended: None,
            warning: None,
            error: None,
            left_s: None,
            stages: Vec::new(),
            ..job.clone()
        };
        state.jobs.insert(id, job.clone());
        state.queue.push_back(id);
        let job = state.shown(&job);
        drop(state);
        self.keep(&job);
        self.wake.notify_all();
        Ok(job)
    }

    /// Deletes a job that does not run; what it made stays.
    ///
    /// # Errors
    /// If there is none of this number, or it runs.
    pub(crate) fn delete(&self, id: i64) -> Answer<()> {
        let mut state = self.state();
        let job = state.jobs.get(&id).ok_or_else(|| unknown(id))?;
        if job.state == JobState::Running {
            return Err(Refused::conflict("the job runs").hint("Stop it first."));
        }
        let job = job.clone();
        state.queue.retain(|waiting| *waiting != id);
        state.jobs.remove(&id);
        drop(state);
        if plan::model_of(&job).is_none()
            && let Some(kept) = plan::searches_of(&self.workspace, &job)
        {
            let _ = std::fs::remove_file(kept);
        }
        self.workspace.history.delete_job(id)?;
        Ok(())
    }

    /// What is drawn of a running fit.
    ///
    /// # Errors
    /// If there is no job of this number.
    pub(crate) fn live(&self, id: i64) -> Answer<Live> {
        let state = self.state();
        let job = state.jobs.get(&id).map(|job| state.shown(job)).ok_or_else(|| unknown(id))?;
        let drawn = state.running.as_ref().filter(|running| running.id == id).map(|running| &running.drawn);
        Ok(match drawn {
            None => Live { job, costs: Vec::new(), measured: None, latest: None },
            Some(drawn) => Live {
                job,
                costs: drawn.costs.clone(),
                measured: drawn.measured.clone(),
                latest: drawn.latest.clone(),
            },
        })
    }

    /// Stops what runs and waits a little for its last state to be kept.
    pub(crate) fn close(&self, patience: Duration) {
        let until = Instant::now() + patience;
        let mut state = self.state();
        state.closing = true;
        if let Some(running) = &state.running {
            running.stop.request();
        }
        self.wake.notify_all();
        while state.running.is_some() {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return;
            }
            state = self.wake.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn tell(&self, job: &Job) {
        self.workspace.notices.send(Notice::Job(Box::new(job.clone())));
    }

    /// Keeps a job and tells the pages. A history that cannot be written does not stop a computation; it is
    /// written again at the next change.
    fn keep(&self, job: &Job) {
        let _ = self.workspace.history.keep_job(job);
        self.tell(job);
    }

    /// Runs the jobs, one after the other, until the program ends.
    fn work(&self) {
        while let Some((job, stop)) = self.next() {
            let ended = catch_unwind(AssertUnwindSafe(|| self.run(&job, &stop)));
            let ended = ended.unwrap_or_else(|_| {
                Ended::failed(Problem::new("the computation ended early by a defect of the program", None))
            });
            self.finish(job.id, ended);
        }
    }

    /// The next job, marked as running; `None` where the program ends.
    fn next(&self) -> Option<(Job, Stop)> {
        let mut state = self.state();
        let id = loop {
            if state.closing {
                return None;
            }
            if let Some(id) = state.queue.pop_front() {
                break id;
            }
            state = self.wake.wait(state).unwrap_or_else(PoisonError::into_inner);
        };
        let job = state.jobs.get_mut(&id)?;
        job.state = JobState::Running;
        job.revision += 1;
        job.started = Some(now());
        let job = job.clone();
        let stop = Stop::new();
        let drawn = Drawn::default();
        state.running = Some(Running { id, stop: stop.clone(), begun: Instant::now(), drawn });
        drop(state);
        self.keep(&job);
        Some((job, stop))
    }

    fn run(&self, job: &Job, stop: &Stop) -> Ended {
        let ended = match &job.request {
            JobRequest::Identify { .. } => identify::run(self, job, stop),
            JobRequest::Compare { .. } => compare::run(self, job, stop),
        };
        ended.unwrap_or_else(|refused| Ended::failed(refused.into_problem()))
    }

    fn finish(&self, id: i64, ended: Ended) {
        let mut state = self.state();
        let begun = state.running.as_ref().map(|running| running.begun);
        let closing = state.closing;
        let Some(job) = state.jobs.get_mut(&id) else { return };
        job.state = match (&ended.error, ended.stopped, closing) {
            (Some(_), false, _) => JobState::Failed,
            (_, true, true) => JobState::Interrupted,
            (_, true, false) => JobState::Stopped,
            (None, false, _) => JobState::Done,
        };
        job.revision += 1;
        job.ended = Some(now());
        job.left_s = None;
        job.elapsed_s += begun.map_or(0.0, |begun| begun.elapsed().as_secs_f64());
        if job.state == JobState::Done {
            job.fraction = 1.0;
        }
        (job.result, job.error, job.resumable) = (ended.result, ended.error, ended.resumable);
        let job = job.clone();
        // Kept before the program may end.
        self.keep(&job);
        state.running = None;
        drop(state);
        self.wake.notify_all();
        self.workspace.look();
        self.workspace.notices.changed(Change::Models);
    }
}

impl State {
    /// A job with what changes by the second.
    fn shown(&self, job: &Job) -> Job {
        let mut job = job.clone();
        if let Some(running) = self.running.as_ref().filter(|running| running.id == job.id) {
            job.elapsed_s += running.begun.elapsed().as_secs_f64();
        }
        if let Some(place) = self.queue.iter().position(|waiting| *waiting == job.id) {
            job.ahead = place + usize::from(self.running.is_some());
        }
        job
    }
}

impl Ended {
    fn failed(problem: Problem) -> Self {
        let error = Some(problem);
        Self { result: JobResult::default(), error, stopped: false, resumable: false }
    }
}

fn planned_stages(request: &JobRequest) -> Vec<String> {
    match request {
        JobRequest::Identify { task: Some(task), .. } => {
            task.stages().into_iter().map(str::to_owned).collect()
        }
        _ => Vec::new(),
    }
}

fn unknown(id: i64) -> Refused {
    Refused::missing(format!("there is no job {id}"))
}
