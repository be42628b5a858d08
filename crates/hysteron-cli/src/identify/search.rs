//! File of the searches of an interrupted fit.

use hysteron_identify::Searches;
use hysteron_io::atomic_file::Batch;

use super::Identify;
use crate::failure::Failure;
use crate::kept;
use crate::output;

impl Identify {
    /// Adds the searches to files that are written together.
    pub(super) fn add_searches(&self, batch: &mut Batch, searches: &Searches) -> Result<(), Failure> {
        let path = kept::beside(&self.out);
        let failure = || Failure::new("cannot write the interrupted searches");
        let text = serde_json::to_string(searches).map_err(|e| failure().because(e))?;
        batch.add(&path, text.as_bytes()).map_err(|e| output::cannot_write("the searches", &path, e))
    }
}
