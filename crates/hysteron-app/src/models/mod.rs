//! Models of the workspace: in the list, in full, on records, exported, inverted.

mod adapt;
mod curves;
mod decouple;
mod design;
mod export;
mod follow;
mod realise;
mod recalibrate;
mod report;
mod score;
mod simulate;
mod track_axes;

pub(crate) use adapt::adapt;
pub(crate) use curves::{curves, response};
pub(crate) use decouple::decouple;
pub(crate) use design::design;
pub(crate) use export::{archive, preview};
pub(crate) use follow::{follow, track};
pub(crate) use realise::realise;
pub(crate) use recalibrate::recalibrate;
pub(crate) use report::report;
pub(crate) use score::scores;
pub(crate) use simulate::simulate;
pub(crate) use track_axes::track_axes;

use hysteron_identify::{FitParameter, Place};
use hysteron_io::sha256;
use hysteron_model::Model;
use hysteron_model::model::Capability;
use hysteron_model::model_file::{Document, typographic};
use hysteron_report::model::{Number, numbers_of};
use hysteron_report::number::with_std_error;
use hysteron_report::record_curves::is_simulated;
use hysteron_report::results::Listing;
use serde_json::Value;

use crate::api::{Listed, ModelDetail, ModelEntry, ParameterRow, Score};
use crate::jobs::FitFound;
use crate::refused::{Answer, Refused};
use crate::workspace::{Found, Kind, Workspace, device_of, shown, stem_of};

/// Ending of the best model so far of an interrupted fit.
const PARTIAL: &str = ".partial.json";

/// The models of the workspace.
pub(crate) fn list(workspace: &Workspace) -> Vec<ModelEntry> {
    workspace.look().of(Kind::Model).filter_map(|found| entry(workspace, found)).collect()
}

/// The entry of a file; `None` where the file is JSON of another kind.
fn entry(workspace: &Workspace, found: &Found) -> Option<ModelEntry> {
    let bare = bare(found);
    match workspace.model(&found.id) {
        Ok(model) => Some(described(bare, &model)),
        Err(refused) => {
            let path = workspace.path(&found.id).ok()?;
            let says = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).contains("hysteron-model");
            let is_model = std::fs::read(path).is_ok_and(says);
            is_model.then(|| ModelEntry { error: Some(refused.into_problem()), ..bare })
        }
    }
}

fn bare(found: &Found) -> ModelEntry {
    ModelEntry {
        id: found.id.clone(),
        device: device_of(&found.id).to_owned(),
        name: stem_of(&found.id).to_owned(),
        bytes: found.bytes,
        modified: found.modified(),
        kind: None,
        hysteresis: None,
        dynamics: None,
        unit: String::new(),
        input_unit: String::new(),
        records: Vec::new(),
        made: None,
        command: None,
        scores: Vec::new(),
        simulated: false,
        interrupted: found.id.ends_with(PARTIAL),
        error: None,
    }
}

fn described(entry: ModelEntry, model: &Model) -> ModelEntry {
    let data = data(model);
    let kind_of = |block: &str| data[block]["kind"].as_str().map(str::to_owned);
    let provenance = model.provenance();
    let records: Vec<String> =
        provenance.map(|p| p.records.iter().map(|r| r.path.clone()).collect()).unwrap_or_default();
    ModelEntry {
        kind: Some(model.kind()),
        hysteresis: kind_of("hysteresis"),
        dynamics: kind_of("dynamics"),
        unit: typographic(&model.units().output),
        input_unit: typographic(&model.units().input),
        made: provenance.and_then(|p| p.created.clone()),
        command: provenance.and_then(|p| p.command.clone()),
        scores: training_scores(&data, &typographic(&model.units().output)),
        simulated: records.iter().any(|record| is_simulated(record)),
        records,
        ..entry
    }
}

/// The data of a model as its file holds them.
fn data(model: &Model) -> Value {
    serde_json::to_value(Document::from(model.clone())).unwrap_or_default()
}

/// Scores on the records of the identification.
fn training_scores(data: &Value, unit: &str) -> Vec<Score> {
    let score = |score: &Value| {
        let number = |key: &str| score[key].as_f64();
        Score {
            record: score["record"].as_str().unwrap_or_default().to_owned(),
            unit: score["unit"].as_str().map_or_else(|| unit.to_owned(), typographic),
            samples: score["samples"].as_u64().and_then(|n| usize::try_from(n).ok()).unwrap_or(0),
            rmse: number("rmse").unwrap_or(f64::NAN),
            max_abs_error: number("max_abs_error").unwrap_or(f64::NAN),
            rmse_percent_of_stroke: number("rmse_percent_of_stroke"),
            max_percent_of_stroke: number("max_percent_of_stroke"),
            fit_percent: number("fit_percent"),
            offset: number("offset"),
        }
    };
    data["scores"].as_array().map(|scores| scores.iter().map(score).collect()).unwrap_or_default()
}

/// Training scores of a model.
pub(super) fn scores_of_training(model: &Model) -> Vec<Score> {
    training_scores(&data(model), &typographic(&model.units().output))
}

/// A model in full.
///
/// # Errors
/// If there is none, or its file is not sound.
pub(crate) fn detail(workspace: &Workspace, id: &str) -> Answer<ModelDetail> {
    let model = workspace.model(id)?;
    let listed = workspace.look();
    let found = listed.of(Kind::Model).find(|found| found.id == id);
    let found = found.ok_or_else(|| Refused::missing(format!("`{}` is no model", shown(id))))?;
    let bytes = std::fs::read(workspace.path(id)?).map_err(Refused::failed)?;
    let fit: FitFound = workspace.history.fit(id, &sha256(&bytes))?.unwrap_or_default();
    let parameters = if fit.parameters.is_empty() {
        numbers_of(&model).map_err(Refused::failed)?.into_iter().map(number).collect()
    } else {
        fit.parameters.into_iter().map(parameter).collect()
    };
    Ok(ModelDetail {
        entry: described(bare(found), &model),
        parameters,
        findings: fit.findings,
        treatment: fit.treatment,
        valid_range: model.valid_range().map(|range| range.in_words()),
        drive_range: model.valid_range().map(|range| [range.input.low, range.input.high]),
        sample_rate_hz: model.sample_rate_hz(),
        correctable: model.hammerstein(Capability::Inversion).is_ok_and(|model| model.correction().is_ok()),
        file: data(&model),
    })
}

fn row(name: String, value: f64, unit: String, std_error: Option<f64>) -> ParameterRow {
    let (text, error) = with_std_error(value, std_error);
    ParameterRow {
        place: None,
        name,
        value,
        text,
        unit,
        std_error,
        std_error_text: std_error.map(|_| error),
        interval: None,
        held: false,
        at_limit: false,
    }
}

fn parameter(p: FitParameter) -> ParameterRow {
    let unit = if p.unit == "1" { String::new() } else { typographic(&p.unit) };
    let place = p.place.map(|place| match place {
        Place::Block(name) | Place::Of(name) => name,
    });
    let (interval, held, at_limit) = (p.interval_95, p.held, p.at_limit);
    ParameterRow { place, interval, held, at_limit, ..row(p.name, p.value, unit, p.std_error) }
}

fn number(n: Number) -> ParameterRow {
    let (place, name) = match n.path.rsplit_once('.') {
        Some((place, name)) => (Some(place.to_owned()), name.to_owned()),
        None => (None, n.path),
    };
    ParameterRow { place, ..row(name, n.value, n.unit, n.std_error) }
}

/// A table of a result.
pub(crate) fn listed(title: &str, listing: Listing) -> Listed {
    Listed { title: title.to_owned(), columns: listing.columns, rows: listing.rows }
}

/// Gives the file of a model another name, and those that belong to it.
///
/// # Errors
/// If there is none, or the name is taken or none.
pub(crate) fn rename(workspace: &Workspace, id: &str, name: &str) -> Answer<ModelEntry> {
    let path = workspace.existing(id)?;
    if name.contains('/') || name.contains('.') {
        return Err(Refused::bad("a model's name has neither folders nor dots"));
    }
    let folder = device_of(id);
    let ending = if id.ends_with(PARTIAL) { PARTIAL } else { ".json" };
    let new = if folder.is_empty() { format!("{name}{ending}") } else { format!("{folder}/{name}{ending}") };
    let target = workspace.path(&new)?;
    let failed = |e: std::io::Error| match e.kind() {
        std::io::ErrorKind::AlreadyExists => Refused::conflict(format!("`{}` is there already", shown(&new))),
        _ => Refused::failed(format!("`{}` cannot be renamed: {e}", shown(id))),
    };
    // A link does not replace a file of the new name, unlike renaming.
    std::fs::hard_link(&path, &target).map_err(failed)?;
    std::fs::remove_file(&path).map_err(failed)?;
    workspace.history.renamed(id, &new)?;
    let listed = workspace.look();
    let found = listed.of(Kind::Model).find(|found| found.id == new);
    let entry = found.and_then(|found| entry(workspace, found));
    entry.ok_or_else(|| Refused::missing(format!("`{}` is no model", shown(&new))))
}
