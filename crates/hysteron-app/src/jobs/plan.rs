//! What a job is to do, decided when it is queued: options, names of what it writes, commands.

use std::path::PathBuf;

use hysteron_identify::modes::{self, ModesCandidate};
use hysteron_identify::structure::Candidate;
use hysteron_identify::{FamilyChoice, Options, Searches, Task};
use hysteron_io::load_json;

use crate::api::{Command, Job, JobRequest, RecordEntry, kind_for};
use crate::command;
use crate::refused::{Answer, Refused};
use crate::workspace::{Workspace, device_of, stem_of};

/// Largest file of searches that is read \[bytes\].
const MOST_SEARCHES: u64 = 256 << 20;

/// A job to be queued.
pub(super) struct Plan {
    pub request: JobRequest,
    pub name: String,
    pub command: Command,
    pub unit: String,
}

/// Completes a request; `taken`: models of jobs that have not ended.
///
/// # Errors
/// For records that are not there, names that are none, structures that are unknown.
pub(super) fn plan(workspace: &Workspace, request: JobRequest, taken: &[String]) -> Answer<Plan> {
    match request {
        JobRequest::Identify { records, task, structure, start, model, inputs, outputs, report } => {
            let entries = entries(workspace, &records)?;
            let axes = !(inputs.is_empty() && outputs.is_empty());
            let task = task_of(task, (structure.as_deref(), axes), &entries)?;
            if task.takes_several_axes() && (inputs.is_empty() || outputs.is_empty()) {
                return Err(Refused::bad("a model of several axes needs the columns of inputs and outputs"));
            }
            let model = match model {
                Some(model) => named_model(workspace, &model)?,
                None => free_name(workspace, &entries, &task, taken)?,
            };
            if let Some(start) = &start {
                started(workspace, &task, start)?;
            }
            let page = report.then(|| beside(&model, "html"));
            let axes = (&inputs[..], &outputs[..]);
            let from = start.as_deref();
            let command = command::identify(&entries, &task, &model, from, axes, page.as_deref());
            let name = stem_of(&model).to_owned();
            let unit = unit(&entries);
            let (task, model) = (Some(task), Some(model));
            let request = JobRequest::Identify {
                records,
                task,
                structure: None,
                start,
                model,
                inputs,
                outputs,
                report,
            };
            Ok(Plan { request, name, command, unit })
        }
        JobRequest::Compare {
            records,
            candidates,
            quick,
            time_limit_s,
            continued,
            inputs,
            outputs,
            report,
        } => {
            let entries = entries(workspace, &records)?;
            let axes = !(inputs.is_empty() && outputs.is_empty());
            if axes {
                of_axes(&inputs, &outputs, time_limit_s, continued)?;
                axes_candidates(&candidates).map(drop)?;
            } else {
                candidates.iter().try_for_each(|name| candidate(name).map(drop))?;
            }
            if time_limit_s.is_some_and(|limit| !(limit.is_finite() && limit > 0.0)) {
                return Err(Refused::bad("the time limit must be a positive number of seconds"));
            }
            if let Some(report) = &report {
                workspace.path(report)?;
                if !report.ends_with(".html") {
                    return Err(Refused::bad("a report's name ends in .html"));
                }
            }
            let quick = quick && !axes;
            let continued = continued || (continue_one_another(&entries) && !axes);
            let (page, named) = (report.as_deref(), (&inputs[..], &outputs[..]));
            let command = match axes {
                true => command::compare_axes(&entries, &candidates, named, page),
                false => command::compare(&entries, &candidates, quick, time_limit_s, continued, page),
            };
            let request = JobRequest::Compare {
                records,
                candidates,
                quick,
                time_limit_s,
                continued,
                inputs,
                outputs,
                report,
            };
            Ok(Plan { request, name: "compare".to_owned(), command, unit: unit(&entries) })
        }
    }
}

/// Refuses what a comparison of several axes does not take.
fn of_axes(inputs: &[String], outputs: &[String], time_limit_s: Option<f64>, continued: bool) -> Answer<()> {
    if inputs.is_empty() || outputs.is_empty() {
        return Err(Refused::bad("several axes need the columns of inputs and outputs"));
    }
    if time_limit_s.is_some() || continued {
        return Err(Refused::bad("a time limit and parts of one run do not go with several axes yet"));
    }
    Ok(())
}

/// Structures of several axes by their names.
///
/// # Errors
/// For an unknown one.
pub(super) fn axes_candidates(names: &[String]) -> Answer<Vec<ModesCandidate>> {
    names.iter().map(|name| name.parse().map_err(Refused::bad)).collect()
}

fn entries(workspace: &Workspace, records: &[String]) -> Answer<Vec<RecordEntry>> {
    if records.is_empty() {
        return Err(Refused::bad("no record is given"));
    }
    records.iter().map(|id| workspace.entry(id)).collect()
}

fn unit(entries: &[RecordEntry]) -> String {
    entries.first().map_or_else(String::new, |entry| entry.output_unit.clone())
}

/// A structure by its name.
///
/// # Errors
/// For an unknown one.
pub(super) fn candidate(name: &str) -> Answer<Candidate> {
    name.parse().map_err(Refused::bad)
}

fn task_of(
    task: Option<Task>,
    (structure, axes): (Option<&str>, bool),
    entries: &[RecordEntry],
) -> Answer<Task> {
    let mut task = match (task, structure) {
        (Some(_), Some(_)) => return Err(Refused::bad("give a task or a structure, not both")),
        (Some(task), None) => task,
        (None, Some(name)) if axes => {
            let candidate: ModesCandidate = name.parse().map_err(Refused::bad)?;
            Task::Modes(candidate.options(&modes::Options::default()))
        }
        (None, Some(name)) => Task::Hammerstein(Box::new(candidate(name)?.options(&Options::default()))),
        (None, None) => Task::of(kind_for(entries)),
    };
    if let Task::Hammerstein(options) = &mut task {
        options.validate().map_err(Refused::bad)?;
        options.continued |= continue_one_another(entries);
    }
    Ok(task)
}

/// The task with the first start of its searches from a model.
///
/// # Errors
/// If there is no such model, or it is of another kind.
pub(super) fn started(workspace: &Workspace, task: &Task, start: &str) -> Answer<Task> {
    task.clone().starting_from(&workspace.model(start)?).map_err(Refused::bad)
}

fn continue_one_another(entries: &[RecordEntry]) -> bool {
    let among = |id: &String| entries.iter().any(|entry| entry.id == *id);
    entries.iter().any(|entry| entry.settings.continues.as_ref().is_some_and(among))
}

fn named_model(workspace: &Workspace, model: &str) -> Answer<String> {
    let model = if model.ends_with(".json") { model.to_owned() } else { format!("{model}.json") };
    workspace.path(&model)?;
    if model.ends_with(".partial.json") || model.ends_with(".searches.json") {
        return Err(Refused::bad("this ending is that of interrupted fits").hint("Choose another name."));
    }
    Ok(model)
}

/// A name after the first record and the structure that is asked for, and a number where it is taken.
fn free_name(
    workspace: &Workspace,
    entries: &[RecordEntry],
    task: &Task,
    taken: &[String],
) -> Answer<String> {
    let first = entries.first().map_or("model", |entry| entry.id.as_str());
    let mut stem = stem_of(first).to_owned();
    match task {
        Task::Hammerstein(options) => {
            if options.hysteresis != FamilyChoice::Usual {
                stem += &format!("-{}", options.hysteresis.name());
            }
            if options.dynamics != Options::default().dynamics {
                stem += &format!("-{}", options.dynamics.name());
            }
        }
        task => stem += &format!("-{}", task.kind().name()),
    }
    let folder = device_of(first);
    let place = if folder.is_empty() { String::new() } else { format!("{folder}/") };
    let names = (1..).map(|k: u32| match k {
        1 => format!("{place}{stem}.json"),
        k => format!("{place}{stem}-{k}.json"),
    });
    let is_free = |id: &String| {
        let beside = [id.clone(), beside(id, "partial.json"), beside(id, "searches.json")];
        !taken.contains(id) && beside.iter().all(|id| workspace.path(id).is_ok_and(|path| !path.exists()))
    };
    names.take(10_000).find(is_free).ok_or_else(|| Refused::conflict("no name is free for the model"))
}

/// The identifier beside a model, of another ending.
pub(super) fn beside(model: &str, ending: &str) -> String {
    format!("{}.{ending}", model.strip_suffix(".json").unwrap_or(model))
}

/// The model that a job writes.
pub(super) fn model_of(job: &Job) -> Option<&String> {
    match &job.request {
        JobRequest::Identify { model, .. } => model.as_ref(),
        JobRequest::Compare { .. } => None,
    }
}

/// Identifier of the file with the state of a job that did not come to its end.
pub(super) fn kept_beside(job: &Job) -> String {
    match model_of(job) {
        Some(model) => beside(model, "searches.json"),
        None => format!("{}-{}.searches.json", job.name, job.id),
    }
}

/// File with the state of a job that did not come to its end, where there is one.
pub(super) fn searches_of(workspace: &Workspace, job: &Job) -> Option<PathBuf> {
    workspace.path(&kept_beside(job)).ok().filter(|path| path.is_file())
}

/// State that a job goes on from; none of one that begins.
///
/// # Errors
/// If its file cannot be read.
pub(super) fn resumed(workspace: &Workspace, job: &Job) -> Answer<Option<Searches>> {
    let Some(path) = searches_of(workspace, job).filter(|_| job.resumable) else { return Ok(None) };
    load_json(&path, MOST_SEARCHES).map(Some).map_err(Refused::bad)
}

/// Identifier of the best model so far of a fit that did not come to its end.
pub(super) fn partial_of(workspace: &Workspace, job: &Job) -> Option<String> {
    let id = beside(model_of(job)?, "partial.json");
    workspace.path(&id).ok()?.is_file().then_some(id)
}
