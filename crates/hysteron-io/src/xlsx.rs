//! XLSX: the sheets of a workbook. A column is called `sheet!header`, without a header `sheet!B`.
//!
//! Cells are read one by one: a sheet may declare 16 000 million of them and have two.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};

use calamine::{DataRef, Reader as _, SheetType, Xlsx, XlsxError};
use hysteron_model::record::split_header;

use crate::IoError;
use crate::columns::{Columns, Kind};
use crate::container::{self, HeldArray};
use crate::hash::sha256;
use crate::laboratory_text::KeptNumbers;
use crate::options::MAX_COLUMNS;
use crate::place::{FilePart, Place, shown};
use crate::reader::{Archive, Input};

/// Most bytes of all that is not the cells: texts, styles, relations.
const MAX_TEXT_BYTES: u64 = 256 << 20;
const SECONDS_A_DAY: f64 = 86_400.0;

/// A column of a sheet.
#[derive(Default)]
struct Column {
    /// Empty where the sheet has no header.
    header: String,
    values: Vec<f64>,
    /// Date of its first cell \[days\].
    first_date: Option<f64>,
    /// Why it is not read as numbers.
    refused: Option<String>,
}

/// Content of a cell.
enum Cell {
    Number(f64),
    /// Days; the unit is a second.
    Duration(f64),
    Date(f64),
    Text(String),
    Other(&'static str),
}

/// A sheet as it is read from top to bottom.
#[derive(Default)]
struct Sheet {
    columns: BTreeMap<u32, Column>,
    /// Rows with cells below the header.
    rows: usize,
    has_header: bool,
}

/// Whether the archive is a workbook.
pub(crate) fn recognises(archive: &Archive<'_>) -> bool {
    archive.index_for_name("xl/workbook.xml").is_some()
}

/// Reads the columns of all sheets.
pub(crate) fn read(input: Input<'_>, bytes: &[u8], mut archive: Archive<'_>) -> Result<Columns, IoError> {
    check_size(&mut archive, input.file, input.options.most_unpacked_bytes(input.file_bytes))?;
    drop(archive);
    let file = input.file.to_owned();
    let malformed = |part, problem: String| IoError::Malformed {
        place: Place::new(&file, part),
        format: "XLSX",
        problem,
    };
    let whole = |error: XlsxError| malformed(FilePart::Whole, error.to_string());
    let mut workbook = Xlsx::new(Cursor::new(bytes)).map_err(whole)?;
    let sheets = workbook.sheets_metadata().iter().filter(|sheet| sheet.typ == SheetType::WorkSheet);
    let names: Vec<String> = sheets.map(|sheet| sheet.name.clone()).collect();
    let mut kept = KeptNumbers::new(&input);
    let (mut held, mut values) = (Vec::new(), Vec::new());
    for name in names {
        let part = || FilePart::Array(name.as_str().into());
        let sheet = Sheet::read(&mut workbook, &name, &mut || kept.add(&file))
            .map_err(|problem: Problem| problem.unwrap_or_else(|problem| malformed(part(), problem)))?;
        if sheet.columns.len() > MAX_COLUMNS {
            let place = Place::new(&file, part());
            return Err(IoError::TooManyColumns { place, found: sheet.columns.len(), limit: MAX_COLUMNS });
        }
        for (letter, column) in sheet.columns {
            let header = if column.header.is_empty() { letters(letter) } else { column.header };
            let in_seconds = column.first_date.is_some();
            let kind = match column.refused {
                Some(found) => Kind::Other(found),
                // A program that does not compute formulas leaves their cells without values.
                None if column.values.is_empty() && sheet.rows > 0 => {
                    Kind::Other("empty cells, or formulas without values".to_owned())
                }
                None if in_seconds && !["", "s"].contains(&split_header(&header).1.symbol()) => {
                    Kind::Other("dates".to_owned())
                }
                None => Kind::Numbers,
            };
            let mut array = HeldArray::new(&format!("{name}!"), &header, vec![column.values.len()], kind);
            array.unit = in_seconds.then(|| "s".to_owned());
            held.push(array);
            values.push(column.values);
        }
    }
    if held.is_empty() {
        return Err(malformed(FilePart::Whole, "its sheets have no columns".to_owned()));
    }
    container::columns(input, &held, sha256(bytes), |index| Ok(std::mem::take(&mut values[index])))
}

/// Unpacks all parts of the file once, to check that none is larger than allowed.
fn check_size(archive: &mut Archive<'_>, file: &str, max_bytes: u64) -> Result<(), IoError> {
    let place = || Place::new(file, FilePart::Whole);
    let malformed = |problem| IoError::Malformed { place: place(), format: "XLSX", problem };
    let (mut left, mut left_texts) = (max_bytes, MAX_TEXT_BYTES.min(max_bytes));
    for index in 0..archive.len() {
        let entry = archive.by_index(index).map_err(|e| malformed(e.to_string()))?;
        let is_sheet = entry.name().is_ok_and(|name| name.starts_with("xl/worksheets/"));
        let limit = if is_sheet { left } else { left_texts };
        let size = std::io::copy(&mut entry.take(limit.saturating_add(1)), &mut std::io::sink());
        let size = size.map_err(|e| malformed(e.to_string()))?;
        if size > left {
            return Err(IoError::TooLarge { place: place(), limit_bytes: max_bytes });
        }
        if !is_sheet && size > left_texts {
            return Err(malformed(format!("its texts have more than {MAX_TEXT_BYTES} bytes")));
        }
        left -= size;
        left_texts = if is_sheet { left_texts } else { left_texts - size };
    }
    Ok(())
}

/// Failure on a sheet: an error, or a problem of the file.
type Problem = Result<IoError, String>;

impl Sheet {
    /// Reads the cells of a sheet.
    fn read(
        workbook: &mut Xlsx<Cursor<&[u8]>>,
        name: &str,
        keep: &mut dyn FnMut() -> Result<(), IoError>,
    ) -> Result<Self, Problem> {
        let problem = |error: XlsxError| Err(error.to_string());
        let mut cells = workbook.worksheet_cells_reader(name).map_err(problem)?;
        let mut sheet = Sheet::default();
        let mut row = Vec::new();
        let mut row_number = 0;
        loop {
            let next = cells.next_cell().map_err(problem)?;
            let Some(next) = next else { break };
            let (number, column) = next.get_position();
            let Some(cell) = Cell::new(next.get_value()) else { continue };
            if number != row_number {
                if number < row_number {
                    return Err(Err(format!("row {} follows row {}", number + 1, row_number + 1)));
                }
                sheet.push(&mut row, row_number);
                row_number = number;
            }
            keep().map_err(Ok::<_, String>)?;
            row.push((column, cell));
        }
        sheet.push(&mut row, row_number);
        Ok(sheet)
    }

    /// Adds a row: the first one as header, where it is not all numbers.
    fn push(&mut self, row: &mut Vec<(u32, Cell)>, number: u32) {
        // Comments stand in lines of their own.
        let is_comment =
            |(_, cell): &(u32, Cell)| matches!(cell, Cell::Text(text) if text.starts_with(['#', '%']));
        if row.first().is_none_or(is_comment) {
            row.clear();
            return;
        }
        let is_first = self.columns.is_empty() && self.rows == 0;
        if is_first {
            self.has_header = row.iter().any(|(_, cell)| matches!(cell, Cell::Text(_)));
            for (column, cell) in row.iter_mut() {
                let header = match cell {
                    Cell::Text(text) => std::mem::take(text),
                    _ => String::new(),
                };
                self.columns.insert(*column, Column { header, ..Column::default() });
            }
            if self.has_header {
                row.clear();
                return;
            }
        }
        for (column, cell) in row.drain(..) {
            // Notes beside the columns have no header.
            if let Some(column) = self.columns.get_mut(&column) {
                column.push(cell, self.rows, number);
            }
        }
        self.rows += 1;
    }
}

impl Column {
    /// Adds the cell of a row; `before` rows of the sheet stand above it.
    fn push(&mut self, cell: Cell, before: usize, number: u32) {
        if self.values.len() < before {
            self.refuse(format!("numbers with gaps (above row {})", number + 1));
            self.values.resize(before, f64::NAN);
        }
        // Dates and numbers do not mix: the first value decides.
        let dates = self.first_date.is_some();
        let value = match cell {
            Cell::Number(number) if !dates => number,
            Cell::Duration(days) if dates || self.values.is_empty() => {
                self.first_date.get_or_insert(0.0);
                days * SECONDS_A_DAY
            }
            Cell::Date(days) if dates || self.values.is_empty() => {
                (days - *self.first_date.get_or_insert(days)) * SECONDS_A_DAY
            }
            Cell::Text(text) => {
                self.refuse(format!("text (`{}` in row {})", shown(text.as_bytes()), number + 1));
                f64::NAN
            }
            Cell::Other(found) => {
                self.refuse(format!("{found} (row {})", number + 1));
                f64::NAN
            }
            _ => {
                self.refuse(format!("numbers and dates (row {})", number + 1));
                f64::NAN
            }
        };
        self.values.push(value);
    }

    fn refuse(&mut self, found: String) {
        self.refused.get_or_insert(found);
    }
}

impl Cell {
    /// `None` for an empty one.
    fn new(value: &DataRef<'_>) -> Option<Self> {
        let text = |text: &str| {
            Some(text.trim()).filter(|text| !text.is_empty()).map(|text| Cell::Text(text.to_owned()))
        };
        match value {
            DataRef::Empty => None,
            DataRef::Int(number) => Some(Cell::Number(*number as f64)),
            DataRef::Float(number) => Some(Cell::Number(*number)),
            DataRef::Bool(value) => Some(Cell::Number(f64::from(u8::from(*value)))),
            DataRef::String(own) => text(own),
            DataRef::SharedString(own) => text(own),
            DataRef::DateTime(date) if date.is_duration() => Some(Cell::Duration(date.as_f64())),
            DataRef::DateTime(date) => Some(Cell::Date(date.as_f64())),
            DataRef::DateTimeIso(_) | DataRef::DurationIso(_) => Some(Cell::Other("dates as text")),
            DataRef::Error(_) => Some(Cell::Other("an error of a formula")),
        }
    }
}

/// The letters of a column: A, …, Z, AA, ….
fn letters(column: u32) -> String {
    let mut letters = Vec::new();
    let mut left = column + 1;
    while left > 0 {
        letters.push(char::from(b'A' + ((left - 1) % 26) as u8));
        left = (left - 1) / 26;
    }
    letters.iter().rev().collect()
}

#[cfg(test)]
mod tests {
    use super::letters;

    #[test]
    fn columns_are_lettered_as_in_a_spreadsheet() {
        assert_eq!([0, 25, 26, 701, 702, 16_383].map(letters), ["A", "Z", "AA", "ZZ", "AAA", "XFD"]);
    }
}
