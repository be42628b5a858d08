//! The next drive for a model.

use hysteron_identify::Listener;
use hysteron_identify::design::{DesignBasis, design as designed};
use hysteron_model::model::Capability;
use hysteron_model::record::{TimeBase, Unit};
use hysteron_report::results::design::{expected, verdict};

use crate::api::{DesignRequest, Figure, Outcome, Series};
use crate::command;
use crate::draw::{Along, over_time};
use crate::refused::{Answer, Refused};
use crate::workspace::Workspace;

/// Width of drawings \[pixels\].
const PIXELS: usize = 1000;

/// The drive after whose record the model is known best for a purpose; written as a record.
///
/// # Errors
/// If the model holds no covariance, or options are out of range.
pub(crate) fn design(
    workspace: &Workspace,
    id: &str,
    request: &DesignRequest,
    listener: Listener<'_>,
) -> Answer<Outcome> {
    let model = workspace.model(id)?;
    let body = model.hammerstein(Capability::Design).map_err(Refused::cannot)?;
    let found = designed(&DesignBasis::from(body.data()), &request.options, listener);
    let found = found.map_err(Refused::cannot)?;
    let summary = found.summary();
    let command = command::design(id, &request.options, &request.save);
    workspace.keep_predicted(&request.save, &found.record())?;
    workspace.history.add_action(&command)?;
    workspace.look();
    let along = Along::new("u", &Unit::new(&found.unit), &found.drive);
    let time = TimeBase::uniform(found.sample_rate_hz);
    let curve = over_time(&time, &along, 0..found.drive.len(), PIXELS);
    let series = vec![Series { name: "drive".to_owned(), curve }];
    let mut sentences = vec![verdict(&summary)];
    sentences.extend(summary.findings.iter().map(|finding| finding.text.clone()));
    sentences.extend(summary.segments.iter().cloned());
    Ok(Outcome {
        sentences,
        tables: vec![super::listed("What becomes how certain", expected(&summary))],
        figures: vec![Figure { title: "Drive".to_owned(), series, log_across: false, log_up: false }],
        files: vec![request.save.clone()],
        command,
    })
}
