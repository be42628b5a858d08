//! Rows of text to columns of numbers.

use std::collections::HashMap;

use super::dialect::{loosely_number, split_fields};
use super::lines::{Line, is_spreadsheet_error};
use super::plain::plain_columns;
use super::utf8;
use crate::columns::{ColumnForm, Columns, Headings, SampleLines};
use crate::options::MAX_NUMBER_BYTES;
use crate::place::{FilePart, Place, shown};
use crate::{IoError, ReadOptions};

/// The columns read so far.
pub(crate) struct Table {
    headings: Headings,
    /// Form in which each column is read.
    wanted: Vec<ColumnForm>,
    /// Which columns are read as numbers.
    numbers: Vec<bool>,
    /// Indices of the distinct texts of each column, in the order of first occurrence.
    texts: Vec<HashMap<String, usize>>,
    /// Whether numbers may be missing or not finite, NaN then: a cut may leave them out.
    keeps_missing: bool,
    delimiter: u8,
    /// One list a column of the file; empty for those not read.
    columns: Vec<Vec<f64>>,
    rows: usize,
    lines: SampleLines,
    values_left: usize,
    /// First lines with a decimal point and with a decimal comma.
    point_line: Option<u64>,
    comma_line: Option<u64>,
}

impl Table {
    pub fn new(headings: Headings, wanted: Vec<ColumnForm>, delimiter: u8, options: &ReadOptions) -> Self {
        Table {
            columns: vec![Vec::new(); headings.columns.len()],
            texts: vec![HashMap::new(); headings.columns.len()],
            headings,
            numbers: wanted.iter().map(|wanted| *wanted == ColumnForm::Numbers).collect(),
            wanted,
            keeps_missing: !options.cut.is_whole(),
            delimiter,
            rows: 0,
            lines: SampleLines::default(),
            values_left: options.max_values,
            point_line: None,
            comma_line: None,
        }
    }

    /// Adds a block of whole lines below line `before`, if they hold plain numbers; returns their number.
    /// `None`: they have to go through [`Self::push_row`].
    pub fn push_block(&mut self, block: &[u8], before: u64) -> Option<u64> {
        if block.is_empty()
            || self.wanted.contains(&ColumnForm::Texts)
            || self.comma_line.is_some()
            || (self.point_line.is_none() && block.contains(&b'.'))
        {
            return None;
        }
        let (rows, columns) = plain_columns(block, self.delimiter, &self.numbers)?;
        self.values_left = self.values_left.checked_sub(columns.iter().map(Vec::len).sum())?;
        for (to, values) in self.columns.iter_mut().zip(columns) {
            to.extend(values);
        }
        self.lines.note(self.rows, before + 1);
        self.rows += rows;
        Some(rows as u64)
    }

    /// Adds one line of data.
    pub fn push_row(&mut self, line: Line<'_>) -> Result<(), IoError> {
        self.lines.note(self.rows, line.number);
        self.rows += 1;
        let expected = self.columns.len();
        if line.bytes.contains(&b'"') {
            let fields = split_fields(line.bytes, self.delimiter).map_err(|column| {
                let place = Place::cell(&self.headings.file, line.number, column, "");
                IoError::UnclosedQuote { place }
            })?;
            self.check_count(fields.len(), line)?;
            for (column, field) in fields.iter().take(expected).enumerate() {
                self.push_field(column, field, line)?;
            }
            return Ok(());
        }
        let delimiter = self.delimiter;
        self.check_count(1 + line.bytes.iter().filter(|&&b| b == delimiter).count(), line)?;
        for (column, field) in line.bytes.split(|&b| b == delimiter).take(expected).enumerate() {
            self.push_field(column, field, line)?;
        }
        Ok(())
    }

    /// Explains a wrong number of fields; one empty field more (a delimiter at the end of the line) is
    /// accepted.
    fn check_count(&self, found: usize, line: Line<'_>) -> Result<(), IoError> {
        let expected = self.columns.len();
        let trailing = found == expected + 1 && line.bytes.last() == Some(&self.delimiter);
        if trailing || found == expected {
            return Ok(());
        }
        let place = self.line(line);
        let numbers = || {
            line.bytes.split(|&b| b == self.delimiter).all(|f| f.is_empty() || loosely_number(f).is_some())
        };
        // A decimal point anywhere rules decimal commas out.
        let points = self.point_line.is_some() || line.bytes.contains(&b'.');
        if self.delimiter == b',' && !points && found > expected && found <= 2 * expected && numbers() {
            return Err(IoError::DecimalCommas { place, found, expected });
        }
        if found < expected && !line.ended {
            return Err(IoError::Truncated { place, found, expected });
        }
        let hint = if found == 1 && expected > 1 {
            "; is another delimiter used below the header?"
        } else if found < expected {
            "; complete or delete the line"
        } else {
            "; remove the surplus, or name its columns in the header"
        };
        Err(IoError::Ragged { place, found, expected, header_line: self.headings.line.unwrap_or(1), hint })
    }

    fn push_field(&mut self, column: usize, field: &[u8], line: Line<'_>) -> Result<(), IoError> {
        let value = match self.wanted.get(column) {
            None | Some(ColumnForm::Nothing) => return Ok(()),
            Some(ColumnForm::Numbers) => self.number(column, field, line)?,
            Some(ColumnForm::Texts) => self.text(column, field, line)?,
        };
        self.values_left = self.values_left.checked_sub(1).ok_or_else(|| IoError::TooManyValues {
            place: self.line(line),
            limit: self.columns.iter().map(Vec::len).sum(),
        })?;
        self.columns[column].push(value);
        Ok(())
    }

    /// Index of a field among the distinct texts of its column.
    fn text(&mut self, column: usize, field: &[u8], line: Line<'_>) -> Result<f64, IoError> {
        let place = || Place::cell(&self.headings.file, line.number, column + 1, "");
        let text = utf8(field.trim_ascii(), place)?;
        let Some(texts) = self.texts.get_mut(column) else { return Ok(0.0) };
        let next = texts.len();
        let number = match texts.get(text) {
            Some(number) => *number,
            None => *texts.entry(text.to_owned()).or_insert(next),
        };
        Ok(number as f64)
    }

    fn number(&mut self, column: usize, field: &[u8], line: Line<'_>) -> Result<f64, IoError> {
        let field = field.trim_ascii();
        let text = utf8(field, || Place::cell(&self.headings.file, line.number, column + 1, ""))?;
        let looks_long = text.len() > MAX_NUMBER_BYTES;
        let parsed = if looks_long { None } else { text.parse::<f64>().ok() };
        let point = (self.point_line.is_none() || self.comma_line.is_some()) && field.contains(&b'.');
        if point {
            self.point_line = self.point_line.or(Some(line.number));
        }
        let value = match parsed {
            Some(value) => value,
            None if text.is_empty() && line.ended && self.keeps_missing => return Ok(f64::NAN),
            None => {
                self.comma_number(text, line.number).ok_or_else(|| self.not_a_number(column, text, line))?
            }
        };
        if let (Some(point_line), Some(comma_line)) = (self.point_line, self.comma_line) {
            let (other, other_line) = if point { ("comma", comma_line) } else { ("point", point_line) };
            return Err(IoError::MixedDecimalMarks {
                place: self.cell(column, line),
                found: shown(field),
                other,
                other_line,
            });
        }
        if value.is_finite() || self.keeps_missing {
            return Ok(value);
        }
        Err(IoError::NotFinite { place: self.cell(column, line), found: shown(field) })
    }

    /// Number with a decimal comma, where the comma is not the delimiter.
    fn comma_number(&mut self, text: &str, line: u64) -> Option<f64> {
        if self.delimiter == b',' && !text.contains(',') || text.len() > MAX_NUMBER_BYTES {
            return None;
        }
        let value = (text.contains(',')).then(|| loosely_number(text.as_bytes())).flatten()?;
        self.comma_line = self.comma_line.or(Some(line));
        Some(value)
    }

    fn not_a_number(&self, column: usize, text: &str, line: Line<'_>) -> IoError {
        if text.is_empty() && !line.ended {
            return IoError::Truncated {
                place: self.line(line),
                found: column,
                expected: self.columns.len(),
            };
        }
        let place = self.cell(column, line);
        if text.is_empty() {
            return IoError::MissingValue { place };
        }
        let hint = if is_spreadsheet_error(text.as_bytes()) {
            ": the spreadsheet it comes from could not compute this cell"
        } else if self.rows == 1 {
            "; if this is a second header line, put the units into the column names (`u_V`) and delete it or \
             begin it with #"
        } else if !line.ended {
            "; the file ends in this line: was the recording interrupted? Delete it to use the rest"
        } else if text.contains(['.', ',']) && text.chars().all(|c| c.is_ascii_digit() || ".,'- ".contains(c))
        {
            "; thousands separators are not read"
        } else if text.contains([' ', '|', ';']) {
            "; is another delimiter used here?"
        } else {
            "; correct it, or choose other columns"
        };
        IoError::NotANumber { place, found: shown(text.as_bytes()), hint }
    }

    fn line(&self, line: Line<'_>) -> Place {
        Place::new(&self.headings.file, FilePart::Line(line.number))
    }

    fn cell(&self, column: usize, line: Line<'_>) -> Place {
        Place::cell(&self.headings.file, line.number, column + 1, self.headings.header(column))
    }

    /// The columns read, after the last line.
    pub fn into_columns(self, sha256: String) -> Columns {
        let Table { headings, columns: values, texts, lines, .. } = self;
        let in_order = |texts: HashMap<String, usize>| {
            let mut texts: Vec<(usize, String)> = texts.into_iter().map(|(text, i)| (i, text)).collect();
            texts.sort_unstable();
            texts.into_iter().map(|(_, text)| text).collect()
        };
        let texts = texts.into_iter().map(in_order).collect();
        Columns { headings, values, texts, lines, rate: None, sha256 }
    }
}
