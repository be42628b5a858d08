//! Drives of all actuators of a model of several axes.

use hysteron_model::axes::AxesRecord;
use hysteron_model::record::{TimeBase, Unit};
use hysteron_report::results::decoupling::{actuators, axes, sentences};

use crate::api::{DecoupleRequest, Figure, Outcome, Series};
use crate::command;
use crate::draw::{Along, over_time};
use crate::refused::{Answer, Refused};
use crate::workspace::Workspace;

/// Width of drawings \[pixels\].
const PIXELS: usize = 1000;

/// The drives with which all axes follow the references of a record; written as a record where asked.
///
/// # Errors
/// If the model is not of several axes, or its references cannot be followed.
pub(crate) fn decouple(workspace: &Workspace, id: &str, request: &DecoupleRequest) -> Answer<Outcome> {
    let model = workspace.model(id)?;
    let (inputs, outputs) = model
        .channels()
        .ok_or_else(|| Refused::bad("the model is of one axis: follow a reference instead"))?;
    let read = workspace.read(&request.references)?;
    let references = AxesRecord::new(&read.record, outputs, &[]).map_err(Refused::bad)?;
    let (found, summary) = model.decouple_for(&references, &request.options).map_err(Refused::cannot)?;
    let file = request.save.as_deref().unwrap_or("drives.csv");
    let command = command::decouple(id, request, file);
    let units = model.units();
    let time = references.time.clone();
    let figure =
        |title: &str, series| Figure { title: title.to_owned(), series, log_across: false, log_up: false };
    let draw = |names: &[String], prefix: &str, unit: &str, lists: &[Vec<f64>]| -> Vec<Series> {
        let one =
            |(name, samples): (&String, &Vec<f64>)| drawn(&time, &format!("{prefix}{name}"), unit, samples);
        names.iter().zip(lists).map(one).collect()
    };
    let errors: Vec<Vec<f64>> = references
        .u
        .iter()
        .zip(&found.predicted)
        .map(|(r, y)| r.iter().zip(y).map(|(r, y)| r - y).collect())
        .collect();
    let figures = vec![
        figure("Drives", draw(inputs, "", &units.input, &found.drive)),
        figure("References", draw(outputs, "", &units.output, &references.u)),
        figure("Predicted errors", draw(outputs, "reference − ", &units.output, &errors)),
    ];
    if let Some(save) = &request.save {
        let record = model.decoupled_record(save, references, found).map_err(Refused::failed)?;
        workspace.keep_predicted(save, &record)?;
        workspace.history.add_action(&command)?;
        workspace.look();
    }
    Ok(Outcome {
        sentences: sentences(&summary),
        tables: vec![super::listed("Actuators", actuators(&summary)), super::listed("Axes", axes(&summary))],
        figures,
        files: request.save.iter().cloned().collect(),
        command,
    })
}

pub(super) fn drawn(time: &TimeBase, name: &str, unit: &str, samples: &[f64]) -> Series {
    let unit = Unit::new(unit);
    Series {
        name: name.to_owned(),
        curve: over_time(time, &Along::new(name, &unit, samples), 0..samples.len(), PIXELS),
    }
}
