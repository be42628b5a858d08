//! Ctrl-C (SIGINT) and SIGTERM: the first requests a stop and reports what is kept, the second aborts.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use hysteron_identify::Stop;

use crate::console;
use crate::failure::Failure;

/// Exit code of a program ended by signal N, by the convention of shells: 128 + N.
const SIGNALLED: u8 = 128;

/// Requests a stop at the first signal.
#[derive(Clone)]
pub struct Interrupt {
    stop: Stop,
    exit_code: Arc<AtomicU8>,
}

impl Interrupt {
    /// Listens for signals, once per process; `kept`: message on the results kept.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn listen(kept: &'static str) -> Result<Self, Failure> {
        let interrupt = Self { stop: Stop::new(), exit_code: Arc::new(AtomicU8::new(0)) };
        let own = interrupt.clone();
        let raise = move |signal: u8| {
            if own.stop.is_requested() {
                std::process::exit(i32::from(SIGNALLED + signal));
            }
            own.exit_code.store(SIGNALLED + signal, Ordering::Relaxed);
            own.stop.request();
            console::message(&format!("stopping: {kept}; press Ctrl-C again to abort at once"));
        };
        listen(raise).map_err(|e| Failure::new("cannot listen for Ctrl-C").because(e))?;
        Ok(interrupt)
    }

    /// Stop signal of the work.
    pub fn stop(&self) -> &Stop {
        &self.stop
    }

    /// The failure, with the exit code of an interruption if there was one.
    pub fn told(&self, failure: Failure) -> Failure {
        if self.stop.is_requested() { failure.exiting_with(self.exit_code()) } else { failure }
    }

    /// The failure of a fit that was interrupted, whose best so far is in `partial`.
    pub fn failure(&self, partial: &Path, resume: &str) -> Failure {
        Failure::new("the fit was interrupted")
            .because(format!("the best so far is in {}", partial.display()))
            .hint(resume)
            .exiting_with(self.exit_code())
    }

    /// Exit code of the command where it was interrupted: 130 after SIGINT, 143 after SIGTERM.
    pub fn exit_code(&self) -> u8 {
        self.exit_code.load(Ordering::Relaxed)
    }
}

/// Path of the best model so far of an interrupted fit: `model.partial.json` beside `model.json`, which is
/// unchanged; in the current folder if the model was to be written to a device or a pipe.
pub fn partial(model: &Path) -> PathBuf {
    match std::fs::metadata(model) {
        Ok(found) if !found.is_file() => PathBuf::from("hysteron.partial.json"),
        _ => model.with_extension("partial.json"),
    }
}

#[cfg(unix)]
fn listen(raise: impl Fn(u8) + Send + 'static) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGHUP])?;
    std::thread::spawn(move || signals.forever().for_each(|signal| raise(u8::try_from(signal).unwrap_or(0))));
    Ok(())
}

#[cfg(not(unix))]
fn listen(raise: impl Fn(u8) + Send + 'static) -> Result<(), ctrlc::Error> {
    const SIGINT: u8 = 2;
    ctrlc::set_handler(move || raise(SIGINT))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_so_far_goes_beside_the_model_but_not_among_devices() {
        assert_eq!(partial(Path::new("a/model.json")), Path::new("a/model.partial.json"));
        #[cfg(unix)]
        assert_eq!(partial(Path::new("/dev/null")), Path::new("hysteron.partial.json"));
    }
}
