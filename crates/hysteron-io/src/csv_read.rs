//! CSV file to record, one pass, in memory for the numbers kept.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use hysteron_model::record::{ChannelChoice, InputOutput, Record, RecordError, Signal};

use crate::dialect::{declared_delimiter, detect_delimiter, loosely_number, split_fields};
use crate::header::{Chosen, Header};
use crate::lines::{Line, Lines, is_skipped};
use crate::table::Table;
use crate::{IoError, ReadOptions};

/// Input and output of a file, and what was decided without being told.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOutcome {
    /// The two channels, ready for a fit.
    pub data: InputOutput,
    /// Plain sentences for the user.
    pub notes: Vec<String>,
}

/// Reads a record; see the crate's description for the format.
///
/// # Errors
/// Any [`IoError`]; it names the file, and line and column where there are any.
pub fn read_csv(path: &Path, options: &ReadOptions) -> Result<Record, IoError> {
    Ok(read(&path.display().to_string(), open(path)?, options)?.0)
}

/// Reads a record from memory; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_csv`].
pub fn read_csv_bytes(name: &str, bytes: &[u8], options: &ReadOptions) -> Result<Record, IoError> {
    Ok(read(name, bytes, options)?.0)
}

/// Reads a record and takes its input and output: as the options name them, otherwise by the rules of
/// [`Record::select`](hysteron_model::record::Record::select).
///
/// # Errors
/// As [`read_csv`]; [`IoError::Record`] where input or output cannot be decided.
pub fn read_input_output(path: &Path, options: &ReadOptions) -> Result<ReadOutcome, IoError> {
    selected(&path.display().to_string(), open(path)?, options)
}

/// Reads a record and takes its drive alone: as the options name it, otherwise by the rules of [`Record::drive`].
///
/// # Errors
/// As [`read_csv`]; [`IoError::Record`] where the drive cannot be decided.
pub fn read_drive(path: &Path, options: &ReadOptions) -> Result<Signal, IoError> {
    read_alone(path, options, |record, chosen| record.drive(chosen.input.as_deref()))
}

/// Reads a record and takes the reference alone: as the options name it, otherwise by the rules of [`Record::reference`].
///
/// # Errors
/// As [`read_csv`]; [`IoError::Record`] where the reference cannot be decided.
pub fn read_reference(path: &Path, options: &ReadOptions) -> Result<Signal, IoError> {
    read_alone(path, options, |record, chosen| record.reference(chosen.reference.as_deref()))
}

fn read_alone(
    path: &Path,
    options: &ReadOptions,
    take: impl FnOnce(&Record, &Chosen) -> Result<Signal, RecordError>,
) -> Result<Signal, IoError> {
    let file = path.display().to_string();
    let (record, chosen) = read(&file, open(path)?, options)?;
    take(&record, &chosen).map_err(|source| IoError::Record { file, source: Box::new(source) })
}

/// [`read_input_output`] from memory.
///
/// # Errors
/// As [`read_input_output`].
pub fn read_input_output_bytes(
    name: &str,
    bytes: &[u8],
    options: &ReadOptions,
) -> Result<ReadOutcome, IoError> {
    selected(name, bytes, options)
}

pub(crate) fn open(path: &Path) -> Result<File, IoError> {
    let failed = |source| IoError::Open { file: path.display().to_string(), source };
    let file = File::open(path).map_err(failed)?;
    if file.metadata().map_err(failed)?.is_dir() {
        return Err(failed(std::io::Error::from(std::io::ErrorKind::IsADirectory)));
    }
    Ok(file)
}

fn selected(file: &str, source: impl Read, options: &ReadOptions) -> Result<ReadOutcome, IoError> {
    let (record, Chosen { input, output, .. }) = read(file, source, options)?;
    let choice = ChannelChoice { input, output };
    let failed = |source| IoError::Record { file: file.to_string(), source: Box::new(source) };
    let notes = record.select(&choice).map_err(failed)?.notes;
    let data = record.input_output(&choice).map_err(failed)?;
    Ok(ReadOutcome { data, notes })
}

/// A line kept until the next one explains it.
struct Kept {
    number: u64,
    ended: bool,
    bytes: Vec<u8>,
}

impl Kept {
    fn line(&self) -> Line<'_> {
        Line { number: self.number, bytes: &self.bytes, ended: self.ended }
    }
}

fn read(file: &str, source: impl Read, options: &ReadOptions) -> Result<(Record, Chosen), IoError> {
    let (table, sha256) =
        read_table(file, source, options, |line, fields| Header::new(file, line, fields, options))?;
    let chosen = table.chosen();
    Ok((table.into_record(sha256, options.sample_rate_hz)?, chosen))
}

/// Reads the rows below a header that `understand` makes of the header's line number and fields; and the file's SHA-256.
pub(crate) fn read_table(
    file: &str,
    source: impl Read,
    options: &ReadOptions,
    understand: impl FnOnce(u64, &[Vec<u8>]) -> Result<Header, IoError>,
) -> Result<(Table, String), IoError> {
    let mut lines = Lines::new(file, source, options.max_bytes);
    let mut delimiter = options.delimiter;
    let (first, comment) = next_fields(&mut lines, &mut delimiter)?;
    let Some(first) = first else {
        let what = if comment.is_some() { "holds no data, only comments" } else { "is empty" };
        return Err(IoError::Empty { file: file.to_string(), what });
    };
    let (header_line, first_row) = match comment.and_then(|c| commented_header(c, &first, delimiter)) {
        Some(header) => (header, Some(first)),
        None => (first, next_fields(&mut lines, &mut delimiter)?.0),
    };
    let row_bytes = first_row.as_ref().map_or(&[][..], |r| &r.bytes);
    let delimiter = delimiter.unwrap_or_else(|| detect_delimiter(&header_line.bytes, row_bytes));
    let fields = split_fields(&header_line.bytes, delimiter).map_err(|column| IoError::UnclosedQuote {
        file: file.to_string(),
        line: header_line.number,
        column,
    })?;
    if fields.iter().all(|f| loosely_number(f).is_some()) {
        return Err(IoError::NoHeader {
            file: file.to_string(),
            line: header_line.number,
            columns: fields.len(),
            suggestion: suggested_header(fields.len(), delimiter),
        });
    }
    let header = understand(header_line.number, &fields)?;
    let Some(first_row) = first_row else {
        return Err(IoError::HeaderOnly { file: file.to_string(), line: header_line.number });
    };
    let mut table = Table::new(file, header, delimiter, options);
    table.push_row(first_row.line())?;
    loop {
        let before = lines.line();
        let block = lines.ahead();
        let bytes = block.len();
        if let Some(rows) = table.push_block(block, before) {
            lines.skip(bytes, rows);
            continue;
        }
        let end = lines.position() + bytes as u64;
        loop {
            let Some(line) = lines.next_line()? else { return Ok((table, lines.sha256())) };
            if !is_skipped(line.bytes) {
                table.push_row(line)?;
            }
            if lines.position() >= end {
                break;
            }
        }
    }
}

/// Next line that has fields, and the comment line last seen on the way. A `sep=` line sets the delimiter.
fn next_fields(
    lines: &mut Lines<impl Read>,
    delimiter: &mut Option<u8>,
) -> Result<(Option<Kept>, Option<Kept>), IoError> {
    let mut comment = None;
    while let Some(line) = lines.next_line()? {
        let kept = || Kept { number: line.number, ended: line.ended, bytes: line.bytes.to_vec() };
        if line.number == 1
            && let Some(declared) = declared_delimiter(line.bytes)
        {
            *delimiter = delimiter.or(Some(declared));
        } else if !is_skipped(line.bytes) {
            return Ok((Some(kept()), comment));
        } else if !line.bytes.trim_ascii().is_empty() {
            comment = Some(kept());
        }
    }
    Ok((None, comment))
}

/// The comment as header, where the line below it is all numbers and it has as many fields, not all numbers.
fn commented_header(comment: Kept, row: &Kept, delimiter: Option<u8>) -> Option<Kept> {
    let text = comment.bytes.trim_ascii_start();
    let text = text.get(1..)?.trim_ascii();
    let delimiter = delimiter.unwrap_or_else(|| detect_delimiter(text, &row.bytes));
    let names = split_fields(text, delimiter).ok()?;
    let numbers = split_fields(&row.bytes, delimiter).ok()?;
    let all_numbers = |fields: &[Vec<u8>]| fields.iter().all(|f| loosely_number(f).is_some());
    let fits = names.len() >= 2 && names.len() == numbers.len();
    (fits && all_numbers(&numbers) && !all_numbers(&names)).then(|| Kept {
        number: comment.number,
        ended: comment.ended,
        bytes: text.to_vec(),
    })
}

fn suggested_header(columns: usize, delimiter: u8) -> String {
    let names: Vec<String> = match columns {
        1 => vec!["u_V".to_string()],
        2 => vec!["u_V".to_string(), "y_um".to_string()],
        n => ["t_s".to_string(), "u_V".to_string(), "y_um".to_string()]
            .into_iter()
            .chain((4..=n.min(6)).map(|k| format!("x{k}")))
            .collect(),
    };
    let more = if columns > 6 { "…" } else { "" };
    let delimiter = if delimiter == b'\t' { "<tab>".to_string() } else { char::from(delimiter).to_string() };
    names.join(&delimiter) + more
}
