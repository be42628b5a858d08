//! The report of a model.

use std::path::Path;

use hysteron_model::Start;
use hysteron_model::validate::Scoring;
use hysteron_report::model::report as of_data;
use hysteron_report::validation::{Validated, page};

use super::score::signals;
use crate::clock::maker;
use crate::refused::{Answer, Refused};
use crate::workspace::{Workspace, stem_of};

/// The report that the fit wrote beside the model, where there is one; else the model on those of its records
/// that are in the workspace; else its numbers alone.
///
/// # Errors
/// If there is no such model.
pub(crate) fn report(workspace: &Workspace, id: &str) -> Answer<Vec<u8>> {
    let beside = format!("{}.html", id.strip_suffix(".json").unwrap_or(id));
    if let Ok(path) = workspace.existing(&beside) {
        return std::fs::read(path).map_err(Refused::failed);
    }
    let model = workspace.model(id)?;
    let recorded = model.provenance().map_or(&[][..], |provenance| &provenance.records);
    let scored = recorded.iter().filter_map(|record| {
        let signals = signals(workspace, &model, &record.path).ok()?;
        let score = model.score(&signals, Start::AsIdentified, &Scoring::default()).ok()?;
        Some((signals, score))
    });
    let records: Vec<_> = scored.collect();
    let page = if records.is_empty() {
        let found = super::detail(workspace, id)?.findings;
        of_data(stem_of(id), &model, &found).map_err(Refused::failed)?
    } else {
        page(&[Validated { path: Path::new(id), model: &model, records: &records }], &maker(""))
    };
    Ok(page.to_html().into_bytes())
}
