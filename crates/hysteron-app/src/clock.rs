//! The time of day, for what is written down.

use std::time::{SystemTime, UNIX_EPOCH};

use hysteron_model::model_file::{Maker, day, timestamp};

/// Program name and version.
pub(crate) const PROGRAM: &str = concat!("hysteron ", env!("CARGO_PKG_VERSION"));

/// Now (ISO 8601, UTC).
pub(crate) fn now() -> String {
    timestamp(seconds())
}

/// Today (UTC).
pub(crate) fn today() -> String {
    day(seconds())
}

fn seconds() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs())
}

/// This program, the time and a command that does the same.
pub(crate) fn maker(command: &str) -> Maker {
    let command = (!command.is_empty()).then(|| command.to_owned());
    Maker { program: PROGRAM.to_owned(), created: Some(now()), command }
}
