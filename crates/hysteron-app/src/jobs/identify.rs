//! Runs an identification.

use hysteron_identify::{
    CampaignRecord, Finding, Fit, FitParameter, FitRecords, IdentifyError, RecordRole, Stop, Task, fit,
    fit_on,
};
use hysteron_io::{save_json, save_model, sha256};
use hysteron_model::axes::AxesRecord;
use hysteron_model::record::InputOutput;
use hysteron_report::write_page;
use serde::{Deserialize, Serialize};

use super::drawing::Drawing;
use super::progress::watch;
use super::{Ended, Jobs, plan};
use crate::api::{Job, JobRequest, JobResult, Problem, Role};
use crate::clock::maker;
use crate::refused::{Answer, Refused};
use crate::workspace::{Workspace, stem_of};

/// What a fit found beside its model.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct FitFound {
    pub parameters: Vec<FitParameter>,
    pub findings: Vec<Finding>,
    pub treatment: Vec<String>,
}

/// Input and output of a record, and its role where the person gave one.
pub(super) fn campaign_record(workspace: &Workspace, id: &str) -> Answer<CampaignRecord> {
    let role = match workspace.history.settings(id)?.role {
        Role::QuasiStatic => Some(RecordRole::QuasiStatic),
        Role::Dynamic => Some(RecordRole::Dynamic),
        _ => None,
    };
    Ok(CampaignRecord { data: workspace.read(id)?.data()?.clone(), role })
}

/// Runs the job.
///
/// # Errors
/// If the records cannot be read, no model describes them, or the result cannot be written.
pub(super) fn run(jobs: &Jobs, job: &Job, stop: &Stop) -> Answer<Ended> {
    let workspace = &*jobs.workspace;
    let JobRequest::Identify { records: ids, task, start, model, inputs, outputs, report, .. } = &job.request
    else {
        return Err(Refused::failed("this is no identification"));
    };
    let mut task = task.clone().unwrap_or_else(|| Task::Hammerstein(Box::default()));
    if let Some(start) = start {
        task = plan::started(workspace, &task, start)?;
    }
    let model = model.clone().unwrap_or_else(|| "model.json".to_owned());
    let partial = plan::beside(&model, "partial.json");
    let searches = plan::beside(&model, "searches.json");
    let records = if task.takes_several_axes() {
        let axes = |id: &String| {
            let read = workspace.read(id)?;
            AxesRecord::new(&read.record, inputs, outputs).map_err(Refused::bad)
        };
        FitRecords::Several(ids.iter().map(axes).collect::<Answer<_>>()?)
    } else {
        FitRecords::Single(ids.iter().map(|id| campaign_record(workspace, id)).collect::<Answer<_>>()?)
    };
    let resume = plan::resumed(workspace, job)?;
    let drawn: Option<(String, InputOutput)> = match &records {
        FitRecords::Single(records) => {
            ids.first().cloned().zip(records.first().map(|record| record.data.clone()))
        }
        FitRecords::Several(_) => None,
    };
    let keep = (workspace.path(&partial)?, workspace.path(&searches)?);
    let found = std::thread::scope(|scope| {
        let drawing = Drawing::begin(scope, jobs, job.id, drawn, keep);
        let watch = watch(jobs, job.id, stop, &drawing);
        let made = maker(&job.command.shell);
        let found = fit_on(task.threads(), || fit(&records, &task, &watch, resume, &made));
        drop(watch);
        drawing.end();
        found
    });
    let found = match found {
        Ok(found) => found,
        // Nothing was found yet: what there was from before stays.
        Err(IdentifyError::Stopped) => return Ok(nothing_yet(workspace, job)),
        // What a stop leaves unfinished may make no model.
        Err(_) if stop.is_requested() => return Ok(nothing_yet(workspace, job)),
        Err(e) => return Err(Refused::cannot(e)),
    };
    let written = if found.interrupted { &partial } else { &model };
    let path = workspace.path(written)?;
    save_model(&path, &found.model).map_err(Refused::failed)?;
    let mut result = JobResult { models: vec![written.clone()], ..JobResult::default() };
    keep_found(workspace, written, &found)?;
    if found.interrupted {
        save_json(&workspace.path(&searches)?, &found.resume, false).map_err(Refused::failed)?;
    } else {
        // The model has taken the place of what was kept on the way.
        for id in [&partial, &searches] {
            let _ = std::fs::remove_file(workspace.path(id)?);
        }
        if *report {
            let page = plan::beside(&model, "html");
            let quiet = hysteron_identify::Watch::silent().stopped_by(stop);
            let others = found.neighbours(&records, &task, &quiet);
            let title = stem_of(&model);
            let report =
                hysteron_report::fit::report(title, &found, others.as_ref()).map_err(Refused::failed)?;
            write_page(&workspace.path(&page)?, &report).map_err(Refused::failed)?;
            result.reports.push(page);
        }
    }
    Ok(Ended { result, error: None, stopped: found.interrupted, resumable: found.interrupted })
}

fn nothing_yet(workspace: &Workspace, job: &Job) -> Ended {
    let models = plan::partial_of(workspace, job).into_iter().collect();
    let resumable = plan::searches_of(workspace, job).is_some();
    let error = Some(Problem::new("it was stopped before a first model was found", None));
    let result = JobResult { models, ..JobResult::default() };
    Ended { error: error.filter(|_| result.models.is_empty()), result, stopped: true, resumable }
}

fn keep_found(workspace: &Workspace, model: &str, found: &Fit) -> Answer<()> {
    let bytes = std::fs::read(workspace.path(model)?).map_err(Refused::failed)?;
    let kept = FitFound {
        parameters: found.parameters.clone(),
        findings: found.findings.clone(),
        treatment: found.treatment.clone(),
    };
    workspace.history.keep_fit(model, &sha256(&bytes), &kept)?;
    Ok(())
}
