//! Ctrl-C (SIGINT) and SIGTERM: the first asks the work to stop and says what becomes of it, the second aborts.

use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

use crate::console;
use crate::failure::Failure;

/// What shells expect of a program ended by signal N: 128 + N.
const SIGNALLED: u8 = 128;

/// What to do about an interrupted fit that keeps no state of its search.
pub const ANEW: &str = "use it as it is, or run the command again: this kind of model begins anew";

/// Whether the work is asked to stop; a flag that becomes true at the first signal.
#[derive(Clone)]
pub struct Interrupt {
    raised: Arc<AtomicBool>,
    exit_code: Arc<AtomicU8>,
}

impl Deref for Interrupt {
    type Target = AtomicBool;

    fn deref(&self) -> &AtomicBool {
        &self.raised
    }
}

impl Interrupt {
    /// Listens, once a process; `kept`: what becomes of the work done.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn listen(kept: &'static str) -> Result<Self, Failure> {
        let interrupt = Self { raised: Arc::default(), exit_code: Arc::new(AtomicU8::new(0)) };
        let own = interrupt.clone();
        let raise = move |signal: u8| {
            if own.raised.load(Ordering::Relaxed) {
                std::process::exit(i32::from(SIGNALLED + signal));
            }
            own.exit_code.store(SIGNALLED + signal, Ordering::Relaxed);
            own.raised.store(true, Ordering::Relaxed);
            console::message(&format!("stopping: {kept}; press Ctrl-C again to abort at once"));
        };
        listen(raise).map_err(|e| Failure::new("cannot listen for Ctrl-C").because(e))?;
        Ok(interrupt)
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

/// Where the best so far of an interrupted fit goes: `model.partial.json` beside `model.json`, which stays as it was.
pub fn partial(model: &Path) -> PathBuf {
    model.with_extension("partial.json")
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
