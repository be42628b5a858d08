//! Delimited text to columns in one pass; only the numbers kept are held in memory.

mod dialect;
mod lines;
mod plain;
mod table;

use std::io::Read;

use hysteron_model::record::{Unit, split_header};

use crate::IoError;
use crate::columns::{Columns, Headings};
use crate::place::{FilePart, Place};
use crate::reader::Input;

pub(crate) use dialect::loosely_number;
use dialect::{declared_delimiter, detect_delimiter, split_fields};
use lines::{Line, Lines, is_skipped};
use table::Table;

/// A line kept until the next one decides its role.
struct KeptLine {
    number: u64,
    ended: bool,
    bytes: Vec<u8>,
}

impl KeptLine {
    fn line(&self) -> Line<'_> {
        Line { number: self.number, bytes: &self.bytes, ended: self.ended }
    }
}

/// Reads delimited text. It cannot be recognised by its first bytes: it is any file that no array reader
/// recognises.
pub(crate) fn read(input: Input<'_>) -> Result<Columns, IoError> {
    let Input { file, bytes, options, wanted, .. } = input;
    let mut lines = Lines::new(file, bytes, options.max_bytes);
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
    let line = header_line.number;
    let fields = split_fields(&header_line.bytes, delimiter)
        .map_err(|column| IoError::UnclosedQuote { place: Place::cell(file, line, column, "") })?;
    // Names that are numbers are in quotes, and the numbers below them are not.
    let has_quotes = |bytes: &[u8]| bytes.contains(&b'"');
    let are_names = has_quotes(&header_line.bytes) && !has_quotes(row_bytes) && first_row.is_some();
    if !are_names && fields.iter().all(|f| loosely_number(f).is_some()) {
        return Err(IoError::NoHeader {
            place: Place::new(file, FilePart::Line(line)),
            columns: fields.len(),
            suggestion: suggested_header(fields.len(), delimiter),
        });
    }
    let names = header_texts(file, line, fields)?;
    let (names, first_row) = match first_row {
        Some(row) => match with_units(&names, row.line(), delimiter) {
            Some(names) => (names, next_fields(&mut lines, &mut Some(delimiter))?.0),
            None => (names, Some(row)),
        },
        None => (names, None),
    };
    let headings = Headings::new(file, Some(line), names)?;
    let wanted = wanted(&headings)?;
    let Some(first_row) = first_row else {
        return Err(IoError::HeaderOnly { place: headings.place() });
    };
    let mut table = Table::new(headings, wanted, delimiter, options);
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
            let Some(line) = lines.next_line()? else { return Ok(table.into_columns(lines.sha256())) };
            if !is_skipped(line.bytes) {
                table.push_row(line)?;
            }
            if lines.position() >= end {
                break;
            }
        }
    }
}

/// The names with the units of the line below them; `None` for a line that is no row of units: it has as many
/// fields, each a unit, in brackets or not, or empty, and none contradicts a unit in its name.
fn with_units(names: &[String], row: Line<'_>, delimiter: u8) -> Option<Vec<String>> {
    let fields = split_fields(row.bytes, delimiter).ok().filter(|fields| fields.len() == names.len())?;
    let units = fields.iter().map(|field| {
        let text = std::str::from_utf8(field).ok()?.trim();
        let bare = text.trim_start_matches(['[', '(']).trim_end_matches([']', ')']).trim();
        (bare.is_empty() || bare == "-" || Unit::new(bare).is_known()).then(|| bare.trim_matches('-'))
    });
    let units = units.collect::<Option<Vec<&str>>>()?;
    let named = |(name, unit): (&String, &&str)| {
        let own = split_header(name).1;
        match (unit.is_empty(), own.symbol().is_empty()) {
            (true, _) => Some(name.clone()),
            (false, true) => Some(format!("{name} [{unit}]")),
            (false, false) => (own == Unit::new(unit)).then(|| name.clone()),
        }
    };
    let named = names.iter().zip(&units).map(named).collect::<Option<Vec<String>>>();
    named.filter(|_| units.iter().any(|unit| !unit.is_empty()))
}

/// The fields of the header line as text.
fn header_texts(file: &str, line: u64, fields: Vec<Vec<u8>>) -> Result<Vec<String>, IoError> {
    let text = |(i, field): (usize, Vec<u8>)| {
        let text = utf8(&field, || Place::cell(file, line, i + 1, ""))?;
        if text.contains('\r') {
            return Err(IoError::BareCarriageReturn { place: Place::new(file, FilePart::Line(line)) });
        }
        Ok(text.to_owned())
    };
    fields.into_iter().enumerate().map(text).collect()
}

/// The text of a field.
fn utf8(field: &[u8], place: impl FnOnce() -> Place) -> Result<&str, IoError> {
    std::str::from_utf8(field).map_err(|e| IoError::NotUtf8 {
        place: place(),
        byte: field.get(e.valid_up_to()).copied().unwrap_or(0),
        hint: "it may be Latin-1 or Windows-1252, or a binary file",
    })
}

/// Next line that has fields, and the comment line last seen on the way. A `sep=` line sets the delimiter.
fn next_fields(
    lines: &mut Lines<impl Read>,
    delimiter: &mut Option<u8>,
) -> Result<(Option<KeptLine>, Option<KeptLine>), IoError> {
    let mut comment = None;
    while let Some(line) = lines.next_line()? {
        let kept = || KeptLine { number: line.number, ended: line.ended, bytes: line.bytes.to_vec() };
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
fn commented_header(comment: KeptLine, row: &KeptLine, delimiter: Option<u8>) -> Option<KeptLine> {
    let text = comment.bytes.trim_ascii_start();
    let text = text.get(1..)?.trim_ascii();
    let delimiter = delimiter.unwrap_or_else(|| detect_delimiter(text, &row.bytes));
    let names = split_fields(text, delimiter).ok()?;
    let numbers = split_fields(&row.bytes, delimiter).ok()?;
    let all_numbers = |fields: &[Vec<u8>]| fields.iter().all(|f| loosely_number(f).is_some());
    let fits = names.len() >= 2 && names.len() == numbers.len();
    (fits && all_numbers(&numbers) && !all_numbers(&names)).then(|| KeptLine {
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
