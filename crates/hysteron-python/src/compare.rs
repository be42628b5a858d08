//! Comparison of structures.

use std::time::{Duration, Instant};

use hysteron_identify::modes::{ModesCandidate, Options as ModesOptions, compare_modes};
use hysteron_identify::structure::{Candidate, Selection, compare as compare_structures};
use hysteron_identify::{Compared, FitRecords, IdentifyError, Options, Task, fit};
use hysteron_model::axes::AxesRecord;
use hysteron_model::record::ChannelChoice;
use pyo3::prelude::*;

use crate::errors::{option, raised, to_json};
use crate::fit::campaign;
use crate::model::{Model, maker};
use crate::record::Record;
use crate::work;

/// Comparison of structures by the held-out error of their simulation: the result as JSON, its page, the
/// model of the preferred structure, and the exception that stopped it, if any.
#[pyfunction]
#[pyo3(signature = (
    records, candidates=Vec::new(), quick=false, time_limit=None, continued=false, input=None, output=None,
    threads=None, progress=None,
))]
#[allow(clippy::too_many_arguments, reason = "keywords of a call from Python")]
pub fn compare(
    py: Python<'_>,
    records: Vec<PyRef<'_, Record>>,
    candidates: Vec<String>,
    quick: bool,
    time_limit: Option<f64>,
    continued: bool,
    input: Option<String>,
    output: Option<String>,
    threads: Option<usize>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(String, String, Option<Model>, Option<PyErr>)> {
    let campaign = campaign(&records, &ChannelChoice { input, output })?;
    let candidates = candidates.iter().map(|name| name.parse::<Candidate>());
    let candidates = candidates.collect::<Result<Vec<_>, _>>().map_err(option)?;
    let options = Options { continued, threads, ..Options::default() };
    if quick && !candidates.is_empty() {
        return Err(option("quick is a search: it takes no candidates"));
    }
    let limit = time_limit.map(|seconds| match seconds {
        _ if seconds > 0.0 => Ok(Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)),
        _ => Err(option(format!("time_limit is {seconds}: it must be a number of seconds above 0"))),
    });
    let limit = limit.transpose()?;
    let begun = Instant::now();
    let work = |watch: &hysteron_identify::Watch<'_>| {
        let selection = Selection::of(&candidates, quick);
        let comparison = match limit {
            None => compare_structures(&campaign, selection, &options, watch)?,
            Some(limit) => {
                let watch = watch.within(limit, move || begun.elapsed());
                compare_structures(&campaign, selection, &options, &watch)?
            }
        };
        let found = Compared::new(comparison, &campaign, Vec::new(), &move || begun.elapsed());
        let preferred = match watch.is_stopped() {
            true => None,
            false => found.identify_preferred(&campaign, watch, &maker()),
        };
        let model = preferred.map(|(_, fit)| fit).transpose()?.map(|fit| fit.model);
        Ok::<_, IdentifyError>((found, model))
    };
    let ((found, model), interruption) = work::watched(py, threads, progress.as_ref(), work)?;
    let page = hysteron_report::comparison::page(&found, &maker()).to_html();
    Ok((to_json(&found)?, page, model.map(Model::from), interruption))
}

/// Comparison of structures of modes of several axes: what [`compare`] returns.
#[pyfunction]
#[pyo3(signature = (records, inputs, outputs, candidates=Vec::new(), threads=None, progress=None))]
pub fn compare_axes(
    py: Python<'_>,
    records: Vec<PyRef<'_, Record>>,
    inputs: Vec<String>,
    outputs: Vec<String>,
    candidates: Vec<String>,
    threads: Option<usize>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(String, String, Option<Model>, Option<PyErr>)> {
    let axes = records.iter().map(|record| AxesRecord::new(&record.inner, &inputs, &outputs));
    let axes = axes.collect::<Result<Vec<_>, _>>().map_err(raised)?;
    let candidates = candidates.iter().map(|name| name.parse::<ModesCandidate>());
    let candidates = candidates.collect::<Result<Vec<_>, _>>().map_err(option)?;
    let options = ModesOptions::default();
    let work = |watch: &hysteron_identify::Watch<'_>| {
        let found = compare_modes(&axes, &candidates, &options, watch, None)?;
        let model = match found.preferred(&options) {
            Some((_, own)) if !watch.is_stopped() => {
                Some(fit(&FitRecords::Several(axes), &Task::Modes(own), watch, None, &maker())?.model)
            }
            _ => None,
        };
        Ok::<_, IdentifyError>((found, model))
    };
    let ((found, model), interruption) = work::watched(py, threads, progress.as_ref(), work)?;
    let page = hysteron_report::modes_comparison::page(&found, &maker()).to_html();
    Ok((to_json(&found)?, page, model.map(Model::from), interruption))
}
