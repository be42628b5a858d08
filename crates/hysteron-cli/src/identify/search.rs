//! File of the searches of an interrupted fit.

use std::path::{Path, PathBuf};

use hysteron_identify::Searches;
use hysteron_io::atomic_file::Batch;
use hysteron_io::load_json;

use super::Identify;
use crate::failure::Failure;
use crate::interrupt::partial;
use crate::output;

/// Largest file of interrupted searches read \[bytes\].
const MAX_RESUME_BYTES: u64 = 256 << 20;

impl Identify {
    /// Adds the searches to files that are written together.
    pub(super) fn add_searches(&self, batch: &mut Batch, searches: &Searches) -> Result<(), Failure> {
        let path = partial(&self.out).with_extension("").with_extension("searches.json");
        let failure = || Failure::new("cannot write the interrupted searches");
        let text = serde_json::to_string(searches).map_err(|e| failure().because(e))?;
        batch.add(&path, text.as_bytes()).map_err(|e| output::cannot_write("the searches", &path, e))
    }
}

/// State of the searches of an interrupted identification, from the file of the searches or from the model
/// beside it.
pub(super) fn read_searches(path: &Path) -> Result<Searches, Failure> {
    let beside = path.to_str().and_then(|path| path.strip_suffix(".partial.json"));
    let beside = beside.map(|stem| PathBuf::from(format!("{stem}.searches.json")));
    let path = beside.as_deref().unwrap_or(path);
    load_json(path, MAX_RESUME_BYTES).map_err(|e| {
        Failure::new(format!("cannot resume from {}", path.display())).because(e).hint(
            "it must be the MODEL.partial.json (or MODEL.searches.json) that an interrupted identification \
                wrote",
        )
    })
}
