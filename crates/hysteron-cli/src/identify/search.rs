//! A search as it is watched, interrupted and resumed, and what to do about one that fails.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use hysteron_identify::{IdentifyError, Searches, Watcher};
use hysteron_optimize::{OptimizeError, Progress as SearchProgress, ResumeError};

use super::Identify;
use crate::failure::Failure;
use crate::progress::Progress;

/// Largest file of interrupted searches read \[bytes\].
const MAX_RESUME_BYTES: u64 = 256 << 20;

/// Progress bar and Ctrl-C.
pub(super) struct Console<'a> {
    stop: &'a AtomicBool,
    shown: Option<(String, Progress)>,
}

impl<'a> Console<'a> {
    pub(super) fn new(stop: &'a AtomicBool) -> Self {
        Self { stop, shown: None }
    }
}

impl Watcher for Console<'_> {
    fn progress(
        &mut self,
        step: &str,
        progress: &SearchProgress<'_>,
        _: &dyn Fn() -> Searches,
    ) -> ControlFlow<()> {
        if self.shown.as_ref().is_none_or(|(name, _)| name != step) {
            self.shown = Some((step.to_owned(), Progress::new(step, progress.generations as u64)));
        }
        if let Some((_, bar)) = &self.shown {
            bar.set(progress.generation as u64, format!("best RMSE {:.5}", progress.best_cost));
        }
        if self.stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

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

/// The library's error with what to do about it.
pub(super) fn explain(error: &IdentifyError) -> Failure {
    const TITLE: &str = "no model was identified";
    let failure = Failure::new(TITLE).because(error);
    match error {
        IdentifyError::UnknownParameter { .. }
        | IdentifyError::Demand { .. }
        | IdentifyError::CreepTakesJointFit
        | IdentifyError::Option { .. } => Failure::usage(TITLE).because(error),
        IdentifyError::Optimize(OptimizeError::Resume(error)) => {
            let failure = Failure::new(TITLE).hint(
                "resume with the records and options of the interrupted run; or leave --resume out and begin anew",
            );
            match error {
                ResumeError::Problem { .. } => {
                    failure.because("the interrupted searches are of other records or options")
                }
                error => failure.because(error),
            }
        }
        IdentifyError::ModelClass { .. } => failure.hint(
            "look at the record with hysteron inspect; check the columns (--input, --output); --least-fit 0 hands the model \
             out all the same",
        ),
        IdentifyError::NotUniform { .. } => failure.hint("give --sample-rate HZ, or --dynamics none"),
        IdentifyError::Constant { .. } => failure.hint("choose other columns with --input and --output"),
        IdentifyError::Units { .. } => failure.hint("correct the headers, or choose columns with --input and --output"),
        _ => failure,
    }
}
