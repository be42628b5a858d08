//! Identification of a force against a displacement: known answers from independent code, measured dampers.
#![allow(clippy::unwrap_used)] // A failure is a failed test.
#![allow(clippy::print_stdout)] // What is skipped is said.

mod measured;
mod recovery;

use hysteron_identify::IdentifyError;
use hysteron_identify::force::{Identification, Options};
use hysteron_model::record::InputOutput;

fn identify(records: &[InputOutput], options: &Options) -> Result<Identification, IdentifyError> {
    hysteron_identify::force::identify(records, options, &hysteron_identify::Watch::silent(), None)
}
