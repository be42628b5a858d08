//! Program name, version and time of the models that the command writes.

use std::time::{SystemTime, UNIX_EPOCH};

use hysteron_model::model_file::{self, Maker, timestamp};
use hysteron_report::shell;

/// This program, the current time and the command line.
pub fn maker() -> Maker {
    Maker {
        program: concat!("hysteron ", env!("CARGO_PKG_VERSION")).to_owned(),
        created: Some(timestamp(now())),
        command: Some(command_line()),
    }
}

/// Today in UTC, or the day that `SOURCE_DATE_EPOCH` says, so that a build can be repeated.
pub fn day() -> String {
    let given = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|seconds| seconds.parse().ok());
    model_file::day(given.unwrap_or_else(now))
}

fn now() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs())
}

/// The command as typed, quoted for a shell.
pub fn command_line() -> String {
    let words = std::env::args_os().skip(1).map(|word| shell::word(&word.to_string_lossy()));
    std::iter::once("hysteron".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}
