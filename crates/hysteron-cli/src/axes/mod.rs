//! Records and models of several inputs and outputs.

mod branches;
mod flags;
mod identify;

pub use branches::identify_branches;
pub use flags::AxesFlags;
pub use identify::ModesFlags;

use std::path::PathBuf;

use hysteron_model::Start;
use hysteron_model::axes::AxesRecord;
use hysteron_model::model::Score;
use hysteron_model::validate::Scoring;

use crate::failure::Failure;
use crate::model::Loaded;

/// Scores of a model on the records that it was identified from, each from its start.
///
/// # Errors
/// If one cannot be scored.
fn score_axes(
    loaded: &Loaded,
    records: &[AxesRecord],
    paths: &[PathBuf],
    start: impl Fn(&AxesRecord) -> Start,
) -> Result<Vec<Score>, Failure> {
    let score = |(record, path): (&AxesRecord, &PathBuf)| {
        loaded.score_from(path, &record.clone().into(), start(record), &Scoring::default())
    };
    records.iter().zip(paths).map(score).collect()
}
