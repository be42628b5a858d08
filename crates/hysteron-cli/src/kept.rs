//! State of an interrupted search, in a file beside the model that was to be written.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use hysteron_identify::{Event, Searches, Watch};
use hysteron_io::{load_json, save_json};

use crate::console;
use crate::failure::Failure;
use crate::interrupt::{Interrupt, partial};
use crate::progress;

/// Largest file of an interrupted search read \[bytes\].
const MAX_BYTES: u64 = 256 << 20;

/// File of the state of an interrupted search: `model.searches.json` beside `model.json`.
pub fn beside(model: &Path) -> PathBuf {
    partial(model).with_extension("").with_extension("searches.json")
}

/// State of an interrupted search, from its file or from the model beside it.
pub fn read(path: &Path) -> Result<Searches, Failure> {
    let beside = path.to_str().and_then(|path| path.strip_suffix(".partial.json"));
    let beside = beside.map(|stem| PathBuf::from(format!("{stem}.searches.json")));
    let path = beside.as_deref().unwrap_or(path);
    load_json(path, MAX_BYTES).map_err(|e| {
        Failure::new(format!("cannot resume from {}", path.display())).because(e).hint(
            "it must be the MODEL.partial.json (or MODEL.searches.json) that an interrupted identification \
                or comparison wrote",
        )
    })
}

/// The candidates of a comparison, kept in a file as they finish: what they took survives even a program that
/// is killed.
pub struct KeptCandidates {
    file: Option<PathBuf>,
    is_written: AtomicBool,
}

impl KeptCandidates {
    /// Beside the model; `None`: nowhere.
    pub fn beside(model: Option<&Path>) -> Self {
        Self { file: model.map(beside), is_written: AtomicBool::new(false) }
    }

    /// [`progress::watch`] that keeps the candidates.
    pub fn watch(&self, interrupt: &Interrupt) -> Watch<'_> {
        let mut show = progress::show();
        let told = move |event: &Event<'_>| {
            show(event);
            self.keep(event);
            ControlFlow::Continue(())
        };
        Watch::new(told).stopped_by(interrupt.stop())
    }

    fn keep(&self, event: &Event<'_>) {
        let Some(file) = self.file.as_deref().filter(|_| event.candidates().is_some()) else { return };
        let Some(searches) = event.searches() else { return };
        match save_json(file, &searches, false) {
            Ok(()) => self.is_written.store(true, Ordering::Relaxed),
            Err(e) => console::warning(&format!("the finished candidates cannot be kept: {e}")),
        }
    }

    /// The file, if it was written.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref().filter(|_| self.is_written.load(Ordering::Relaxed))
    }

    /// Removes the file of a search that came to its end.
    pub fn forget(&self) {
        if let Some(file) = self.file() {
            // One that stays does no harm.
            let _ = std::fs::remove_file(file);
        }
    }
}
