//! File of the searches of an interrupted fit.

use hysteron_identify::Searches;

use super::Identify;
use crate::failure::Failure;
use crate::kept;
use crate::outputs::Outputs;

impl Identify {
    /// Adds the searches to files that are written together.
    pub(super) fn add_searches(&self, outputs: &mut Outputs, searches: &Searches) -> Result<(), Failure> {
        let path = kept::beside(&self.out);
        let failure = || Failure::new("cannot write the interrupted searches");
        let text = serde_json::to_string(searches).map_err(|e| failure().because(e))?;
        outputs.add("the searches", &path, text.as_bytes())
    }
}
