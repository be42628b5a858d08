//! Identification.

use hysteron_identify::{
    CampaignRecord, DynamicsChoice, FamilyChoice, FitRecords, Initial, Method, Searches, fit,
};
use hysteron_model::UnknownName;
use hysteron_model::axes::AxesRecord;
use hysteron_model::dynamics::{Creep, Scheme};
use hysteron_model::model_file::Kind;
use hysteron_model::record::{ChannelChoice, InterSample};
use pyo3::prelude::*;
use serde::Serialize;

use crate::errors::{from_json, raised, to_json};
use crate::model::{Figures, Model, figures, maker};
use crate::record::{Record, single};
use crate::task::task;
use crate::work;

/// An identified model and the results of its fit.
#[pyclass(frozen, module = "hysteron_models._native")]
pub struct Fit {
    inner: hysteron_identify::Fit,
}

#[pymethods]
impl Fit {
    #[getter]
    fn model(&self) -> Model {
        self.inner.model.clone().into()
    }

    /// Output of `hysteron identify --json`.
    fn to_json(&self) -> PyResult<String> {
        to_json(&self.inner)
    }

    /// Name and figures of the score of every record.
    #[getter]
    fn scores(&self) -> Vec<(String, Figures)> {
        self.inner.scores.iter().map(|score| (score.record.clone(), figures(score))).collect()
    }

    /// Treatment of the data, in words.
    #[getter]
    fn treatment(&self) -> Vec<String> {
        self.inner.treatment.clone()
    }

    /// The fit was stopped; the model is the best so far.
    #[getter]
    fn interrupted(&self) -> bool {
        self.inner.interrupted
    }

    /// Checkpoints of the searches, for `identify(resume=…)`.
    fn searches(&self) -> PyResult<String> {
        to_json(&self.inner.resume)
    }

    /// The report as a page of HTML.
    fn report(&self, py: Python<'_>, name: &str) -> PyResult<String> {
        let page = work::run(py, || hysteron_report::fit::report(name, &self.inner, None))?;
        Ok(page.map_err(raised)?.to_html())
    }
}

/// Identifies a model. Returns the best so far, and the exception that stopped the fit, if any.
#[pyfunction]
#[pyo3(signature = (
    records, kind, options, *, inputs=Vec::new(), outputs=Vec::new(), start=None, resume=None, progress=None
))]
#[allow(clippy::too_many_arguments, reason = "keywords of a call from Python")]
pub fn identify(
    py: Python<'_>,
    records: Vec<PyRef<'_, Record>>,
    kind: &str,
    options: &str,
    inputs: Vec<String>,
    outputs: Vec<String>,
    start: Option<PyRef<'_, Model>>,
    resume: Option<&str>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(Fit, Option<PyErr>)> {
    let kind = UnknownName::find("kind of model", kind, Kind::ALL, Kind::name);
    let mut task = task(kind.map_err(raised)?, options)?;
    if let Some(start) = start {
        task = task.starting_from(start.core()).map_err(raised)?;
    }
    let resume = resume.map(from_json::<Searches>).transpose()?;
    let records = if task.takes_several_axes() {
        let axes = records.iter().map(|record| AxesRecord::new(&record.inner, &inputs, &outputs));
        FitRecords::Several(axes.collect::<Result<_, _>>().map_err(raised)?)
    } else {
        let choice = ChannelChoice { input: inputs.first().cloned(), output: outputs.first().cloned() };
        FitRecords::Single(campaign(&records, &choice)?)
    };
    let work = |watch: &hysteron_identify::Watch<'_>| fit(&records, &task, watch, resume, &maker());
    let (inner, interruption) = work::watched(py, task.threads(), progress.as_ref(), work)?;
    Ok((Fit { inner }, interruption))
}

/// Records to identify from.
pub fn campaign(records: &[PyRef<'_, Record>], choice: &ChannelChoice) -> PyResult<Vec<CampaignRecord>> {
    let campaign = single(records, choice)?.into_iter();
    Ok(campaign.map(|data| CampaignRecord { data, role: None }).collect())
}

/// Names that options take, each with a line about it, as JSON.
#[pyfunction]
pub fn choices() -> PyResult<String> {
    type Named = Vec<(&'static str, &'static str)>;
    #[derive(Serialize)]
    struct Choices {
        hysteresis: Named,
        dynamics: Named,
        creep: Named,
        method: Named,
        initial: Named,
        scheme: Named,
        inter_sample: Named,
        kinds: Vec<&'static str>,
    }
    fn named<T: Copy>(
        all: impl IntoIterator<Item = T>,
        name: impl Fn(T) -> &'static str,
        summary: impl Fn(T) -> &'static str,
    ) -> Named {
        all.into_iter().map(|one| (name(one), summary(one))).collect()
    }
    to_json(&Choices {
        hysteresis: named(FamilyChoice::offered(), FamilyChoice::name, FamilyChoice::summary),
        dynamics: named(DynamicsChoice::ALL, DynamicsChoice::name, DynamicsChoice::summary),
        creep: named(Creep::USUAL, Creep::name, Creep::summary),
        method: named(Method::ALL, Method::name, Method::summary),
        initial: named(Initial::ALL, Initial::name, Initial::summary),
        scheme: named(Scheme::ALL, Scheme::name, Scheme::summary),
        inter_sample: named(InterSample::ALL, InterSample::name, InterSample::summary),
        kinds: Kind::ALL.iter().map(|kind| kind.name()).collect(),
    })
}
