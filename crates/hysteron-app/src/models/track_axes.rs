//! Controllers of several axes on the simulated bench.

use hysteron_model::axes::AxesRecord;
use hysteron_model::decoupling::{AxesTrackOptions, track_axes as play};
use hysteron_model::model::{AxesTrackingSummary, Capability, DecouplingRequest};
use hysteron_report::results::axes_tracking::{ABOUT_ERRORS, errors, sentences};
use hysteron_rig::axes::{AxesRigStage, AxesTruth};

use super::decouple::drawn;
use crate::api::{Figure, Outcome, TrackAxesRequest};
use crate::command;
use crate::refused::{Answer, Refused};
use crate::workspace::Workspace;

/// Plays the references of a record with every controller; written as a record where asked.
///
/// # Errors
/// If the model is not of several axes, or its references cannot be followed.
pub(crate) fn track_axes(workspace: &Workspace, id: &str, request: &TrackAxesRequest) -> Answer<Outcome> {
    let model = workspace.model(id)?;
    let modes = model.scheduled_modes(Capability::Tracking).map_err(Refused::cannot)?;
    let (_, outputs) = model
        .channels()
        .ok_or_else(|| Refused::bad("the model is of one axis: simulate its controllers instead"))?;
    let read = workspace.read(&request.references)?;
    let references = AxesRecord::new(&read.record, outputs, &[]).map_err(Refused::bad)?;
    let options = &request.options;
    let limits = DecouplingRequest {
        ranges: options.ranges.clone(),
        slews_per_s: options.slews_per_s.clone(),
        ..DecouplingRequest::default()
    };
    let asked = AxesTrackOptions {
        limits: limits.limits(&model).map_err(Refused::bad)?,
        bandwidth_hz: options.bandwidth_hz,
        preview: options.preview,
        skip_s: options.skip_s,
    };
    let truth = AxesTruth::with_axes(modes.outputs).map_err(Refused::bad)?;
    let stage = AxesRigStage { truth: &truth, seed: options.seed };
    let found =
        play(modes, &references.u, references.sample_rate_hz, &asked, &stage).map_err(Refused::bad)?;
    let summary = AxesTrackingSummary::new(&model, &found);
    let file = request.save.as_deref().unwrap_or("track.csv");
    let command = command::track_axes(id, request, file);
    if let Some(save) = &request.save {
        let record = model.tracked_record(save, &found, &references).map_err(Refused::failed)?;
        workspace.keep_predicted(save, &record)?;
        workspace.history.add_action(&command)?;
        workspace.look();
    }
    let best = found.runs.iter().min_by(|a, b| a.rms.iter().sum::<f64>().total_cmp(&b.rms.iter().sum()));
    let figures = best.map(|run| {
        let errors = references.u.iter().zip(&run.displacement).zip(outputs);
        let series = errors.map(|((reference, moved), name)| {
            let error: Vec<f64> = reference.iter().zip(moved).map(|(r, y)| r - y).collect();
            drawn(&references.time, &format!("reference − {name}"), &model.units().output, &error)
        });
        let title = format!("Errors of {}", run.controller.name());
        Figure { title, series: series.collect(), log_across: false, log_up: false }
    });
    let simulated = format!("Simulated on the bench of several axes ({}).", truth.describe());
    let about = [simulated, ABOUT_ERRORS.to_owned()];
    Ok(Outcome {
        sentences: about.into_iter().chain(sentences(&summary)).collect(),
        tables: vec![super::listed("Controllers", errors(&summary))],
        figures: figures.into_iter().collect(),
        files: request.save.iter().cloned().collect(),
        command,
    })
}
