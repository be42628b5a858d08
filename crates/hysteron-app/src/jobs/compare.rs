//! Runs a comparison of structures.

use std::time::{Duration, Instant};

use hysteron_identify::structure::{Candidate, Selection, compare};
use hysteron_identify::{CampaignRecord, Compared, Options, Stop};
use hysteron_report::{comparison, write_page};

use super::identify::campaign_record;
use super::plan::candidate;
use super::{Ended, Jobs};
use crate::api::{Job, JobRequest, JobResult};
use crate::clock::maker;
use crate::refused::{Answer, Refused};

/// Runs the job.
///
/// # Errors
/// If the records cannot be read or cannot rank structures.
pub(super) fn run(jobs: &Jobs, job: &Job, stop: &Stop) -> Answer<Ended> {
    let workspace = &*jobs.workspace;
    let JobRequest::Compare { records, candidates, quick, time_limit_s, continued, report } = &job.request
    else {
        return Err(Refused::failed("this is no comparison"));
    };
    let campaign: Vec<CampaignRecord> =
        records.iter().map(|id| campaign_record(workspace, id)).collect::<Answer<_>>()?;
    let candidates: Vec<Candidate> = candidates.iter().map(|name| candidate(name)).collect::<Answer<_>>()?;
    let selection = Selection::of(&candidates, *quick);
    let options = Options { continued: *continued, ..Options::default() };
    let begun = Instant::now();
    let watch = jobs.plain_watch(job.id, stop);
    let found = match time_limit_s.and_then(|limit| Duration::try_from_secs_f64(limit).ok()) {
        None => compare(&campaign, selection, &options, &watch),
        Some(limit) => {
            let watch = watch.within(limit, move || begun.elapsed());
            compare(&campaign, selection, &options, &watch)
        }
    };
    drop(watch);
    let found = found.map_err(Refused::cannot)?;
    let found = Compared::new(found, &campaign, Vec::new(), &move || begun.elapsed());
    let mut result = JobResult { comparison: Some(found.summary()), ..JobResult::default() };
    if let Some(id) = report {
        let page = comparison::page(&found, &maker(&job.command.shell));
        write_page(&workspace.path(id)?, &page).map_err(Refused::failed)?;
        result.reports.push(id.clone());
    }
    // What is finished is kept; a comparison has no searches to go on from.
    Ok(Ended { result, error: None, stopped: found.comparison.interrupted, resumable: false })
}
