//! Gain, delay and offset of a model from short records.

use hysteron_identify::recalibrate::{Prior, Recording, recalibrate as fitted};
use hysteron_io::sha256;
use hysteron_model::model::{Capability, SignalRole};
use hysteron_model::record::{Source, Unit};
use hysteron_report::results::recalibration::{numbers, offset, scores, verdicts};

use super::score::in_words;
use crate::api::{Outcome, RecalibrateRequest};
use crate::clock::maker;
use crate::command;
use crate::refused::{Answer, Refused};
use crate::workspace::Workspace;

/// Re-estimates gain, delay and offset, and writes the new model.
///
/// # Errors
/// If the records do not go with the model, or even the new model does not describe them.
pub(crate) fn recalibrate(workspace: &Workspace, id: &str, request: &RecalibrateRequest) -> Answer<Outcome> {
    let model = workspace.model(id)?;
    let body = model.hammerstein(Capability::Recalibration).map_err(Refused::cannot)?;
    let mut remarks = Vec::new();
    let mut read = |record: &String| {
        let mut data = workspace.read(record)?.data()?.clone();
        let mut agreed = |role, unit: &Unit| model.agreed_unit(role, unit, &mut remarks);
        agreed(SignalRole::Input, &data.u_unit).map_err(Refused::cannot)?;
        data.y_unit = agreed(SignalRole::Output, &data.y_unit).map_err(Refused::cannot)?;
        Ok(data)
    };
    let data = request.records.iter().map(&mut read).collect::<Answer<Vec<_>>>()?;
    let options = &request.options;
    let recordings = Recording::of(&model, data, options.continued, &mut remarks).map_err(Refused::cannot)?;
    let prior = Prior::of(body.data());
    let found = fitted(body.law(), prior, &recordings, options.least_fit_percent).map_err(Refused::cannot)?;
    let entries = request.records.iter().map(|id| workspace.entry(id)).collect::<Answer<Vec<_>>>()?;
    let command = command::recalibrate(id, &entries, options, &request.save);
    let file = found.model_file(body.data(), &source(workspace, id)?, prior, &maker(&command.shell));
    workspace.keep_model(&request.save, file)?;
    workspace.history.add_action(&command)?;
    workspace.look();
    let unit = Unit::new(&model.units().output).to_string();
    let mut sentences = verdicts(&found).to_vec();
    sentences.push(offset(&found, &unit));
    sentences.extend(remarks.iter().map(|remark| in_words(&model, remark)));
    Ok(Outcome {
        sentences,
        tables: vec![
            super::listed("Gain and delay", numbers(&found)),
            super::listed("Errors before and after", scores(&found, &unit)),
        ],
        files: vec![request.save.clone()],
        command,
        ..Outcome::default()
    })
}

/// The model's file, as the provenance of a model that comes from it names it.
pub(super) fn source(workspace: &Workspace, id: &str) -> Answer<Source> {
    let bytes = std::fs::read(workspace.existing(id)?).map_err(Refused::failed)?;
    Ok(Source { path: id.to_owned(), sha256: sha256(&bytes) })
}
