//! State of an interrupted search, in a file beside the model that was to be written.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use hysteron_identify::{Event, Searches, Watch};
use hysteron_io::{load_json, save_json};

use crate::console;
use crate::failure::Failure;
use crate::interrupt::{Interrupt, partial};
use crate::progress;

/// Largest file of an interrupted search read \[bytes\].
const MAX_BYTES: u64 = 256 << 20;

/// Least time between two states of a running fit that are kept.
const BETWEEN: Duration = Duration::from_secs(2);
/// That time at least, in times of the work for the last one: the fit waits for it.
const REST: u32 = 50;

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

/// The state of running work, kept in a file: what it took survives even a program that is killed.
pub struct Kept {
    file: Option<PathBuf>,
    is_written: AtomicBool,
}

impl Kept {
    /// Beside the model; `None`: nowhere.
    pub fn beside(model: Option<&Path>) -> Self {
        Self { file: model.map(beside), is_written: AtomicBool::new(false) }
    }

    /// [`progress::watch`] that keeps the candidates of a comparison as they finish.
    pub fn watch_candidates(&self, interrupt: &Interrupt) -> Watch<'_> {
        let mut show = progress::show();
        let told = move |event: &Event<'_>| {
            show(event);
            if event.candidates().is_some() {
                self.keep(event);
            }
            ControlFlow::Continue(())
        };
        Watch::new(told).stopped_by(interrupt.stop())
    }

    /// [`progress::watch`] that keeps the searches of a fit every two seconds, and at once when a family has
    /// been fitted.
    pub fn watch_searches(&self, interrupt: &Interrupt) -> Watch<'_> {
        let mut show = progress::show();
        let mut next = Instant::now() + BETWEEN;
        let stop = interrupt.stop().clone();
        let told = move |event: &Event<'_>| {
            show(event);
            let begun = Instant::now();
            // A fit that was stopped passes through stages that it does not finish.
            if event.candidates().is_some() || (begun >= next && !stop.is_requested()) {
                self.keep(event);
                let done = Instant::now();
                next = done + BETWEEN.max((done - begun) * REST);
            }
            ControlFlow::Continue(())
        };
        Watch::new(told).stopped_by(interrupt.stop())
    }

    fn keep(&self, event: &Event<'_>) {
        let Some((file, searches)) = self.file.as_deref().zip(event.searches()) else { return };
        match save_json(file, &searches, false) {
            Ok(()) => self.is_written.store(true, Ordering::Relaxed),
            Err(e) => console::warning(&format!("what is done so far cannot be kept: {e}")),
        }
    }

    /// The file, if it was written.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref().filter(|_| self.is_written.load(Ordering::Relaxed))
    }

    /// A failure to write the result, with what is kept of it.
    pub fn told(&self, failure: Failure) -> Failure {
        match self.file() {
            Some(file) => failure.hint(format!(
                "what was found is not lost: the same command with --resume {} and another -o",
                file.display()
            )),
            None => failure,
        }
    }

    /// Removes the file of a search that came to its end.
    pub fn forget(&self) {
        if let Some(file) = self.file() {
            // One that stays does no harm.
            let _ = std::fs::remove_file(file);
        }
    }
}
