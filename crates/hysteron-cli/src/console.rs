//! Results to standard output, everything else to standard error.

use std::borrow::Cow;
use std::io::{self, ErrorKind, IsTerminal, Write};

use hysteron_report::results::Listing;
pub use hysteron_report::results::in_unit;
use serde::Serialize;

use crate::failure::Failure;

/// Prints a result to standard output. A closed pipe (`| head`) is not an error.
///
/// # Errors
/// If standard output cannot be written for another reason, e.g. a full disk.
pub fn result(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(without_controls(text).as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::new("cannot write to standard output").because(e))
        }
        _ => Ok(()),
    }
}

/// The text with control characters in names, units and keys of files written as `\u001b`, as JSON has them: a
/// terminal obeys them.
fn without_controls(text: &str) -> Cow<'_, str> {
    let is_obeyed = |c: char| c.is_control() && c != '\n' && c != '\t';
    if !text.contains(is_obeyed) {
        return Cow::Borrowed(text);
    }
    let mut plain = String::with_capacity(text.len());
    for c in text.chars() {
        if is_obeyed(c) { plain += &format!("\\u{:04x}", u32::from(c)) } else { plain.push(c) }
    }
    Cow::Owned(plain)
}

/// Prints one JSON object to standard output.
///
/// # Errors
/// Those of [`result`].
pub fn json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string(value)
        .map_err(|e| Failure::new("cannot write the result as JSON").because(e))?;
    result(&(text + "\n"))
}

/// Prints a line to standard error; a closed stream is ignored.
pub fn message(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", without_controls(text));
}

/// Prints a note; the command continues.
pub fn note(text: &str) {
    message(&format!("note: {text}"));
}

/// Prints a warning, to be read before using the result.
pub fn warning(text: &str) {
    message(&format!("warning: {text}"));
}

/// A text table, with ASCII borders unless standard output is a terminal.
pub fn table(header: &[&str]) -> comfy_table::Table {
    let mut table = comfy_table::Table::new();
    let style = if io::stdout().is_terminal() {
        comfy_table::presets::UTF8_FULL_CONDENSED
    } else {
        comfy_table::presets::ASCII_MARKDOWN
    };
    table.load_style(style).set_header(header.to_vec());
    table
}

/// A table of a result.
pub fn listed(listing: &Listing) -> comfy_table::Table {
    let mut table = table(&listing.columns.iter().map(String::as_str).collect::<Vec<_>>());
    table.add_rows(&listing.rows);
    table
}

/// A clock that starts now.
pub fn clock() -> impl Fn() -> std::time::Duration {
    let begun = std::time::Instant::now();
    move || begun.elapsed()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_terminal_obeys_nothing_in_a_text() {
        assert_eq!(
            without_controls("a\u{1b}[31m\u{7}b\r\u{9b}c\td\n"),
            "a\\u001b[31m\\u0007b\\u000d\\u009bc\td\n"
        );
        // Those above 0x7e stand in JSON as they are; it is read the same.
        let text = serde_json::to_string("a\u{9b}\u{1b}\u{7f}").unwrap();
        let plain: String = serde_json::from_str(&without_controls(&text)).unwrap();
        assert_eq!(plain, "a\u{9b}\u{1b}\u{7f}");
        assert!(matches!(without_controls("5 µm, 3 × 10⁻⁵\n"), Cow::Borrowed(_)));
    }
}
