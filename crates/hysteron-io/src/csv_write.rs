//! Record to CSV file.

use std::io::{self, Write};
use std::path::Path;

use crate::atomic_file::write_atomically_with;
use hysteron_model::record::Record;

use crate::IoError;
use crate::csv::loosely_number;
use crate::read::is_recognised;
use crate::write::{check, headers};

/// Writes a record as comma-separated text that [`read_record`](crate::read_record) reads back to the same
/// numbers: column `t_s` where there is a time base, one column a channel (`u_V`), `valid` where there is a
/// mask. The file is complete or not there.
///
/// # Errors
/// [`IoError::Record`] where the record is not sound ([`Record::check`]) or a channel has the header of time
/// or mask, [`IoError::Write`].
pub fn write_csv(path: &Path, record: &Record) -> Result<(), IoError> {
    check(path, record)?;
    Ok(write_atomically_with(path, |out| write_csv_to(out, record))?)
}

/// Writes the text of [`write_csv`] to any sink. The record must be sound ([`Record::check`]): rows end with
/// its shortest channel.
///
/// # Errors
/// Those of the sink.
pub fn write_csv_to(out: &mut dyn Write, record: &Record) -> io::Result<()> {
    let headers: Vec<String> = headers(record).iter().map(|header| quoted(header)).collect();
    writeln!(out, "{}", headers.join(","))?;
    let mut line = String::new();
    let rows = record.channels.iter().map(|c| c.samples.len()).min().unwrap_or(0);
    for k in 0..rows {
        line.clear();
        if let Some(t) = record.time.time_s(k) {
            push_number(&mut line, t);
        }
        for channel in &record.channels {
            push_number(&mut line, channel.samples[k]);
        }
        if let Some(valid) = &record.valid {
            line.push_str(if valid.get(k).copied().unwrap_or(true) { "1," } else { "0," });
        }
        line.pop();
        line.push('\n');
        out.write_all(line.as_bytes())?;
    }
    Ok(())
}

/// Shortest text that parses back to the same number, and a comma.
fn push_number(line: &mut String, value: f64) {
    use std::fmt::Write;
    let magnitude = value.abs();
    // Writing to a String cannot fail.
    let _ = if value == 0.0 || (1e-5..1e15).contains(&magnitude) {
        write!(line, "{value},")
    } else {
        write!(line, "{value:e},")
    };
}

/// The header, in quotes where a reader would take it for something else.
fn quoted(header: &str) -> String {
    let is_taken = header.starts_with(['#', '%'])
        || is_recognised(header.as_bytes())
        || loosely_number(header.as_bytes()).is_some();
    if is_taken || header.contains([',', '"', ';', '\t']) {
        format!("\"{}\"", header.replace('"', "\"\""))
    } else {
        header.to_string()
    }
}
