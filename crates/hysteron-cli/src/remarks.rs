//! Remarks of the library on a simulation, with the flag that overrides its assumption.

use std::path::Path;

use hysteron_model::Model;
use hysteron_model::model::Remark;

use crate::{advice, console};

/// Prints the remarks on the record at `path`.
pub fn tell(path: &Path, model: &Model, remarks: &[Remark]) {
    for remark in remarks {
        let (text, advice) = remark.in_words(model);
        console::note(&format!("{}: {}", path.display(), advice::with_flags(&text, advice.as_ref())));
    }
}
