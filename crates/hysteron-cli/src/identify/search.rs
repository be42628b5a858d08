//! The searches of an interrupted fit, on disk.

use std::path::{Path, PathBuf};

use hysteron_identify::Searches;

use super::Identify;
use crate::failure::Failure;

/// Largest file of interrupted searches read \[bytes\].
const MAX_RESUME_BYTES: u64 = 256 << 20;

impl Identify {
    pub(super) fn write_searches(&self, searches: &Searches) -> Result<(), Failure> {
        let path = self.out.with_extension("searches.json");
        let failure = || Failure::new(format!("cannot write the interrupted searches to {}", path.display()));
        let text = serde_json::to_string(searches).map_err(|e| failure().because(e))?;
        hysteron_io::atomic_file::write_atomically(&path, text.as_bytes())
            .map_err(|e| failure().because(e))?;
        Ok(())
    }
}

/// State of the searches of an interrupted identification, from the file of the searches or from the model beside it.
pub(super) fn read_searches(path: &Path) -> Result<Searches, Failure> {
    let beside = path.to_str().and_then(|path| path.strip_suffix(".partial.json"));
    let beside = beside.map(|stem| PathBuf::from(format!("{stem}.searches.json")));
    let path = beside.as_deref().unwrap_or(path);
    let failure = || {
        Failure::new(format!("cannot resume from {}", path.display()))
            .hint("it must be the MODEL.partial.json (or MODEL.searches.json) that an interrupted identification wrote")
    };
    let size = std::fs::metadata(path).map_err(|e| failure().because(e))?.len();
    if size > MAX_RESUME_BYTES {
        return Err(failure().because(format!("it has {size} bytes; at most {MAX_RESUME_BYTES} are read")));
    }
    let bytes = std::fs::read(path).map_err(|e| failure().because(e))?;
    serde_json::from_slice(&bytes).map_err(|e| failure().because(e))
}
