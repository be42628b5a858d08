//! Ctrl-C: the first asks the work to stop and says what becomes of it, the second aborts.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::console;
use crate::failure::Failure;

/// What shells expect of a program ended by Ctrl-C: 128 + SIGINT.
const ABORTED: i32 = 130;

/// Installs the handler, once a process; `kept`: what becomes of the work done. The flag becomes true at the first Ctrl-C (or SIGTERM).
///
/// # Errors
/// If the operating system refuses the handler.
pub fn stop_flag(kept: &'static str) -> Result<Arc<AtomicBool>, Failure> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    let handler = move || {
        if raised.swap(true, Ordering::Relaxed) {
            std::process::exit(ABORTED);
        }
        console::message(&format!("stopping: {kept}; press Ctrl-C again to abort at once"));
    };
    ctrlc::set_handler(handler).map_err(|e| Failure::new("cannot listen for Ctrl-C").because(e))?;
    Ok(flag)
}
