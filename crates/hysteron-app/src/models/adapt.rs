//! A model corrected over a record, sample by sample.

use hysteron_identify::online::{FollowOptions, Followed, Term, known_noise};
use hysteron_model::model::Capability;
use hysteron_model::validate::Scoring;
use hysteron_model::{Advice, Start};
use hysteron_report::results::adaptation::{coefficients, errors, method, verdict};

use super::recalibrate::source;
use super::score::in_words;
use crate::api::{AdaptRequest, Outcome, Problem};
use crate::clock::maker;
use crate::command;
use crate::problem::remedy;
use crate::refused::{Answer, Refused};
use crate::workspace::Workspace;

/// Follows a drifting device over a record; writes the model with the last coefficients where asked.
///
/// # Errors
/// If the record does not go with the model, or the options cannot hold.
pub(crate) fn adapt(workspace: &Workspace, id: &str, request: &AdaptRequest) -> Answer<Outcome> {
    let model = workspace.model(id)?;
    let body = model.hammerstein(Capability::Adaptation).map_err(Refused::cannot)?;
    let asked = &request.options;
    let parsed = asked.terms.iter().map(|term| term.parse::<Term>());
    let terms = parsed.collect::<Result<Vec<_>, _>>().map_err(Refused::bad)?;
    let creeps = terms.iter().any(|term| matches!(term, Term::Creep { .. }));
    if request.save.is_some() && creeps {
        return Err(Refused::bad("a model file has no place for the coefficient of a creep term"));
    }
    let data = workspace.read(&request.record)?.data()?.clone();
    if data.sample_rate_hz().is_none() {
        return Err(Refused::bad(
            "the record has no uniform sample rate, and a memory is a number of samples",
        )
        .hint(remedy(&Advice::Resample)));
    }
    let score = model.score(&data.clone().into(), Start::AsIdentified, &Scoring::default());
    let simulation = score.map_err(Refused::cannot)?.simulation;
    let noise = asked.noise.or_else(|| known_noise(body.data(), &data)).ok_or_else(|| {
        Refused::bad("the standard deviation of the residual of a valid model is not known")
            .hint("Give the noise.")
    })?;
    let options = FollowOptions {
        method: asked.method,
        terms,
        noise,
        every: asked.every,
        run_length: asked.run_length,
        reopen: asked.reopen,
    };
    let found = Followed::over(&data, body.law(), &simulation.start, &options).map_err(Refused::cannot)?;
    let command = command::adapt(id, &[workspace.entry(&request.record)?], asked, request.save.as_deref());
    if let Some(save) = &request.save {
        let parent = (body.data(), &source(workspace, id)?);
        let file = found.model_file(&data, &options, parent, &maker(&command.shell));
        let file = file.map_err(|e| Refused::cannot(Problem::new(e, e.advice())))?;
        workspace.keep_model(save, file)?;
        workspace.look();
    }
    workspace.history.add_action(&command)?;
    let unit = data.y_unit.to_string();
    let mut sentences = verdict(&found, &data, &options);
    sentences.push(method(&found, &options, &unit));
    sentences.extend(simulation.remarks.iter().map(|remark| in_words(&model, remark)));
    Ok(Outcome {
        sentences,
        tables: vec![
            super::listed("Coefficients", coefficients(&found)),
            super::listed("Errors", errors(&found, &unit)),
        ],
        files: request.save.iter().cloned().collect(),
        command,
        ..Outcome::default()
    })
}
