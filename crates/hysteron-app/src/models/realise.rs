//! A model as real poles and pole pairs that run sample by sample.

use std::time::Instant;

use hysteron_model::model::{Capability, CheckedRealisation};
use hysteron_model::realise::{self, realise as realised};
use hysteron_report::number::significant;
use hysteron_report::results::realisation::{facts, sections};

use crate::api::{Outcome, RealiseOptions};
use crate::command;
use crate::refused::{Answer, Refused};
use crate::workspace::Workspace;

/// Realises the dynamics at a controller's sample rate and checks them against the batch simulation.
///
/// # Errors
/// If the model cannot be realised so.
pub(crate) fn realise(workspace: &Workspace, id: &str, asked: &RealiseOptions) -> Answer<Outcome> {
    let model = workspace.model(id)?;
    let body = model.hammerstein(Capability::Realisation).map_err(Refused::cannot)?;
    let rate = super::export::rate(body, asked.sample_rate_hz)?;
    if !(asked.accuracy > 0.0 && asked.accuracy < 1.0) {
        return Err(Refused::bad("the accuracy is a fraction of the range, above 0 and below 1"));
    }
    let options =
        realise::RealiseOptions { accuracy: asked.accuracy, lowest_frequency_hz: asked.lowest_frequency_hz };
    let options = body.realise_options(rate, options);
    let realisation = realised(body.law(), rate, &options).map_err(Refused::bad)?;
    let begun = Instant::now();
    let clock = move || begun.elapsed();
    let found = CheckedRealisation::new(realisation, body.data(), asked.accuracy, &clock);
    let found = found.map_err(Refused::bad)?;
    let command = command::realise(id, rate, asked);
    workspace.history.add_action(&command)?;
    let low = options.lowest_frequency_hz.filter(|_| asked.lowest_frequency_hz.is_none());
    let creeps = low.map(|low| {
        format!(
            "The model creeps for ever; realised down to {} Hz, a thousandth of its records' lowest.",
            significant(low, 3)
        )
    });
    Ok(Outcome {
        sentences: creeps.into_iter().collect(),
        tables: vec![
            super::listed("Size, exactness and cost", facts(&found)),
            super::listed("Sections: x ← x + g (w − x), output c·x", sections(&found)),
        ],
        command,
        ..Outcome::default()
    })
}
