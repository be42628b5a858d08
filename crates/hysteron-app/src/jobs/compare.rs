//! Runs a comparison of structures.

use std::time::{Duration, Instant};

use hysteron_identify::modes::{self, compare_modes};
use hysteron_identify::structure::{Candidate, Selection, compare_from};
use hysteron_identify::{CampaignRecord, Compared, Options, Stop};
use hysteron_model::axes::AxesRecord;
use hysteron_report::{comparison, modes_comparison, write_page};

use super::identify::campaign_record;
use super::plan::{self, candidate};
use super::{Ended, Jobs};
use crate::api::{Job, JobRequest, JobResult, Problem};
use crate::clock::maker;
use crate::refused::{Answer, Refused};

/// Runs the job.
///
/// # Errors
/// If the records cannot be read or cannot rank structures.
pub(super) fn run(jobs: &Jobs, job: &Job, stop: &Stop) -> Answer<Ended> {
    let workspace = &*jobs.workspace;
    let JobRequest::Compare { records, candidates, quick, time_limit_s, continued, inputs, outputs, report } =
        &job.request
    else {
        return Err(Refused::failed("this is no comparison"));
    };
    if !inputs.is_empty() {
        return run_axes(jobs, job, stop, (inputs, outputs));
    }
    let campaign: Vec<CampaignRecord> =
        records.iter().map(|id| campaign_record(workspace, id)).collect::<Answer<_>>()?;
    let candidates: Vec<Candidate> = candidates.iter().map(|name| candidate(name)).collect::<Answer<_>>()?;
    let selection = Selection::of(&candidates, *quick);
    let options = Options { continued: *continued, ..Options::default() };
    let begun = Instant::now();
    let resume = plan::resumed(workspace, job)?;
    let kept = workspace.path(&plan::kept_beside(job))?;
    let watch = jobs.watch_of_race(job.id, stop, &kept);
    let found = match time_limit_s.and_then(|limit| Duration::try_from_secs_f64(limit).ok()) {
        None => compare_from(&campaign, selection, &options, &watch, resume),
        Some(limit) => {
            let watch = watch.within(limit, move || begun.elapsed());
            compare_from(&campaign, selection, &options, &watch, resume)
        }
    };
    drop(watch);
    let found = match found {
        Ok(found) => found,
        // What a stop leaves unfinished may fail in any way.
        Err(_) if stop.is_requested() => {
            let error = Some(Problem::new("it was stopped before a first structure was fitted", None));
            let resumable = kept.is_file();
            return Ok(Ended { result: job.result.clone(), error, stopped: true, resumable });
        }
        Err(e) => return Err(Refused::cannot(e)),
    };
    let found = Compared::new(found, &campaign, Vec::new(), &move || begun.elapsed());
    let mut result = JobResult { comparison: Some(found.summary()), ..JobResult::default() };
    if let Some(id) = report {
        let page = comparison::page(&found, &maker(&job.command.shell));
        write_page(&workspace.path(id)?, &page).map_err(Refused::failed)?;
        result.reports.push(id.clone());
    }
    let stopped = found.comparison.interrupted;
    if !stopped {
        let _ = std::fs::remove_file(&kept);
    }
    // What is finished is kept; the candidate that ran begins anew.
    Ok(Ended { result, error: None, stopped, resumable: stopped && kept.is_file() })
}

/// Runs a comparison of several axes.
fn run_axes(jobs: &Jobs, job: &Job, stop: &Stop, (inputs, outputs): (&[String], &[String])) -> Answer<Ended> {
    let workspace = &*jobs.workspace;
    let JobRequest::Compare { records, candidates, report, .. } = &job.request else {
        return Err(Refused::failed("this is no comparison"));
    };
    let axes =
        |id: &String| AxesRecord::new(&workspace.read(id)?.record, inputs, outputs).map_err(Refused::bad);
    let records: Vec<AxesRecord> = records.iter().map(axes).collect::<Answer<_>>()?;
    let candidates = plan::axes_candidates(candidates)?;
    let resume = plan::resumed(workspace, job)?;
    let kept = workspace.path(&plan::kept_beside(job))?;
    let watch = jobs.watch_of_race(job.id, stop, &kept);
    let found = compare_modes(&records, &candidates, &modes::Options::default(), &watch, resume);
    drop(watch);
    let found = found.map_err(Refused::cannot)?;
    let mut result = JobResult { axes_comparison: Some(found.summary()), ..JobResult::default() };
    if let Some(id) = report {
        let page = modes_comparison::page(&found, &maker(&job.command.shell));
        write_page(&workspace.path(id)?, &page).map_err(Refused::failed)?;
        result.reports.push(id.clone());
    }
    let stopped = found.interrupted;
    if !stopped {
        let _ = std::fs::remove_file(&kept);
    }
    Ok(Ended { result, error: None, stopped, resumable: stopped && kept.is_file() })
}
