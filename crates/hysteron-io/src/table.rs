//! Rows of text to columns of numbers.

use std::path::Path;

use hysteron_model::record::{Channel, Record, RecordError, Source, TimeBase};

use crate::dialect::{loosely_number, split_fields};
use crate::header::{Chosen, ColumnRole, Header};
use crate::lines::{Line, is_spreadsheet_error};
use crate::options::MAX_NUMBER_BYTES;
use crate::plain::plain_columns;
use crate::{IoError, ReadOptions};

/// The columns read so far.
pub(crate) struct Table {
    file: String,
    header: Header,
    delimiter: u8,
    /// One list a column of the file; empty for those not read.
    columns: Vec<Vec<f64>>,
    rows: usize,
    last_line: u64,
    values_left: usize,
    /// The flags that choose columns, for messages.
    choose_with: &'static str,
    /// First lines with a decimal point and with a decimal comma.
    point_line: Option<u64>,
    comma_line: Option<u64>,
}

impl Table {
    pub fn new(file: &str, header: Header, delimiter: u8, options: &ReadOptions) -> Self {
        Table {
            file: file.to_string(),
            columns: vec![Vec::new(); header.columns.len()],
            header,
            delimiter,
            rows: 0,
            last_line: 0,
            values_left: options.max_values,
            choose_with: options.choose_with,
            point_line: None,
            comma_line: None,
        }
    }

    /// Adds a block of whole lines below line `before`, if they hold plain numbers and nothing is wrong with them; returns
    /// their number. `None`: they have to go through [`Self::push_row`].
    pub fn push_block(&mut self, block: &[u8], before: u64) -> Option<u64> {
        if block.is_empty()
            || self.comma_line.is_some()
            || (self.point_line.is_none() && block.contains(&b'.'))
        {
            return None;
        }
        let read: Vec<bool> = self.header.columns.iter().map(|c| c.role != ColumnRole::Skipped).collect();
        let (rows, mut columns) = plain_columns(block, self.delimiter, &read)?;
        let values_left = self.values_left.checked_sub(columns.iter().map(Vec::len).sum())?;
        for ((column, values), earlier) in self.header.columns.iter().zip(&mut columns).zip(&self.columns) {
            let (ColumnRole::Time(factor) | ColumnRole::Frequency(factor)) = column.role else { continue };
            values.iter_mut().for_each(|value| *value *= factor);
            let right = match column.role {
                ColumnRole::Time(_) => earlier.last().into_iter().chain(values.iter()).is_sorted(),
                _ => values.iter().all(|&value| value > 0.0),
            };
            if !right || !values.iter().all(|value| value.is_finite()) {
                return None;
            }
        }
        let is_mask = |role| role == ColumnRole::Mask;
        let masks = self.header.columns.iter().zip(&columns).filter(|(column, _)| is_mask(column.role));
        if masks.flat_map(|(_, values)| values).any(|&value| value != 0.0 && value != 1.0) {
            return None;
        }
        for (to, values) in self.columns.iter_mut().zip(columns) {
            to.extend(values);
        }
        self.values_left = values_left;
        self.rows += rows;
        self.last_line = before + rows as u64;
        Some(rows as u64)
    }

    /// Adds one line of data.
    pub fn push_row(&mut self, line: Line<'_>) -> Result<(), IoError> {
        self.rows += 1;
        self.last_line = line.number;
        let expected = self.columns.len();
        if line.bytes.contains(&b'"') {
            let fields = split_fields(line.bytes, self.delimiter).map_err(|column| {
                IoError::UnclosedQuote { file: self.file.clone(), line: line.number, column }
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

    /// Explains a wrong number of fields; one empty field more (a delimiter at the end of the line) is accepted.
    fn check_count(&self, found: usize, line: Line<'_>) -> Result<(), IoError> {
        let expected = self.columns.len();
        let trailing = found == expected + 1 && line.bytes.last() == Some(&self.delimiter);
        if trailing || found == expected {
            return Ok(());
        }
        let file = self.file.clone();
        let numbers = || {
            line.bytes.split(|&b| b == self.delimiter).all(|f| f.is_empty() || loosely_number(f).is_some())
        };
        if self.delimiter == b',' && found > expected && found <= 2 * expected && numbers() {
            return Err(IoError::DecimalCommas { file, line: line.number, found, expected });
        }
        if found < expected && !line.ended {
            return Err(IoError::Truncated { file, line: line.number, found, expected });
        }
        let hint = if found == 1 && expected > 1 {
            "; is another delimiter used below the header?"
        } else if found < expected {
            "; complete or delete the line"
        } else {
            "; remove the surplus, or name its columns in the header"
        };
        Err(IoError::Ragged { file, line: line.number, found, expected, header_line: self.header.line, hint })
    }

    fn push_field(&mut self, column: usize, field: &[u8], line: Line<'_>) -> Result<(), IoError> {
        let role = self.header.columns[column].role;
        if role == ColumnRole::Skipped {
            return Ok(());
        }
        let mut value = self.number(column, field, line)?;
        match role {
            ColumnRole::Time(factor) => {
                value *= factor;
                if let Some(&before) = self.columns[column].last()
                    && value < before
                {
                    return Err(IoError::TimeDecreases {
                        file: self.file.clone(),
                        line: line.number,
                        column: column + 1,
                        name: self.name(column),
                        before,
                        after: value,
                    });
                }
            }
            ColumnRole::Frequency(factor) => {
                value *= factor;
                if value <= 0.0 {
                    return Err(IoError::BadFrequency {
                        file: self.file.clone(),
                        line: line.number,
                        column: column + 1,
                        name: self.name(column),
                        found: shown(field),
                    });
                }
            }
            ColumnRole::Mask if value != 0.0 && value != 1.0 => {
                return Err(IoError::BadMask {
                    file: self.file.clone(),
                    line: line.number,
                    column: column + 1,
                    name: self.name(column),
                    found: shown(field),
                });
            }
            _ => {}
        }
        self.values_left = self.values_left.checked_sub(1).ok_or_else(|| IoError::TooManyValues {
            file: self.file.clone(),
            line: line.number,
            limit: self.columns.iter().map(Vec::len).sum(),
            choose_with: self.choose_with,
        })?;
        self.columns[column].push(value);
        Ok(())
    }

    fn number(&mut self, column: usize, field: &[u8], line: Line<'_>) -> Result<f64, IoError> {
        let field = field.trim_ascii();
        let text = std::str::from_utf8(field).map_err(|e| IoError::NotUtf8 {
            file: self.file.clone(),
            line: line.number,
            column: column + 1,
            byte: field.get(e.valid_up_to()).copied().unwrap_or(0),
            hint: "it may be Latin-1 or Windows-1252, or a binary file",
        })?;
        let looks_long = text.len() > MAX_NUMBER_BYTES;
        let parsed = if looks_long { None } else { text.parse::<f64>().ok() };
        let point = (self.point_line.is_none() || self.comma_line.is_some()) && field.contains(&b'.');
        if point {
            self.point_line = self.point_line.or(Some(line.number));
        }
        let value = match parsed {
            Some(value) => value,
            None => {
                self.comma_number(text, line.number).ok_or_else(|| self.not_a_number(column, text, line))?
            }
        };
        if let (Some(point_line), Some(comma_line)) = (self.point_line, self.comma_line) {
            let (other, other_line) = if point { ("comma", comma_line) } else { ("point", point_line) };
            return Err(IoError::MixedDecimalMarks {
                file: self.file.clone(),
                line: line.number,
                column: column + 1,
                name: self.name(column),
                found: shown(field),
                other,
                other_line,
            });
        }
        if value.is_finite() {
            return Ok(value);
        }
        Err(IoError::NotFinite {
            file: self.file.clone(),
            line: line.number,
            column: column + 1,
            name: self.name(column),
            found: shown(field),
        })
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
        let (file, number, name) = (self.file.clone(), line.number, self.name(column));
        let column = column + 1;
        if text.is_empty() && !line.ended {
            return IoError::Truncated {
                file,
                line: number,
                found: column - 1,
                expected: self.columns.len(),
            };
        }
        if text.is_empty() {
            return IoError::MissingValue { file, line: number, column, name };
        }
        let hint = if is_spreadsheet_error(text.as_bytes()) {
            ": the spreadsheet it comes from could not compute this cell"
        } else if self.rows == 1 {
            "; if this is a second header line, put the units into the column names (`u_V`) and delete it or begin it with #"
        } else if !line.ended {
            "; the file ends in this line: was the recording interrupted? Delete it to use the rest"
        } else if text.contains(['.', ',']) && text.chars().all(|c| c.is_ascii_digit() || ".,'- ".contains(c))
        {
            "; thousands separators are not read"
        } else if text.contains([' ', '|', ';']) {
            "; is another delimiter used here?"
        } else {
            &format!("; correct it, or choose other columns with {}", self.choose_with)
        };
        let (found, hint) = (shown(text.as_bytes()), hint.to_string());
        IoError::NotANumber { file, line: number, column, name, found, hint }
    }

    fn name(&self, column: usize) -> String {
        self.header.columns.get(column).map(|c| c.header.clone()).unwrap_or_default()
    }

    /// Channels chosen by the options.
    pub fn chosen(&self) -> Chosen {
        self.header.chosen.clone()
    }

    /// The numbers of every column that was read, in the order of the file; empty for the others.
    pub fn into_columns(self) -> Vec<Vec<f64>> {
        self.columns
    }

    /// The record, after the last line.
    pub fn into_record(self, sha256: String, sample_rate_hz: Option<f64>) -> Result<Record, IoError> {
        if self.rows < 2 {
            return Err(IoError::OneSample { file: self.file, line: self.last_line });
        }
        let file = self.file;
        let name = Path::new(&file)
            .file_name()
            .map_or_else(|| file.clone(), |name| name.to_string_lossy().into_owned());
        let (mut times, mut valid, mut channels) = (None, None, Vec::new());
        for (column, samples) in self.header.columns.into_iter().zip(self.columns) {
            match column.role {
                ColumnRole::Time(_) => times = Some(samples),
                ColumnRole::Mask => valid = Some(samples.iter().map(|&v| v == 1.0).collect()),
                ColumnRole::Channel => {
                    channels.push(Channel { name: column.name, unit: column.unit, samples });
                }
                ColumnRole::Frequency(_) | ColumnRole::Skipped => {}
            }
        }
        let failed = |source: RecordError| IoError::Record { file: file.clone(), source: Box::new(source) };
        let time = match (times, sample_rate_hz) {
            (Some(times), None) => TimeBase::from_times(&name, times).map_err(failed)?,
            (Some(times), Some(rate)) => TimeBase::from_times_at_rate(&name, &times, rate).map_err(failed)?,
            (None, Some(rate)) => TimeBase::uniform(rate),
            (None, None) => TimeBase::Unknown,
        };
        let source = Some(Source { path: file.clone(), sha256 });
        let record = Record { name, time, channels, valid, source };
        record.check().map_err(failed)?;
        Ok(record)
    }
}

/// A field as quoted in messages: control characters escaped, cut to a readable length.
fn shown(field: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(field).escape_debug().take(41).collect();
    match text.char_indices().nth(40) {
        Some((at, _)) => format!("{}…", &text[..at]),
        None => text,
    }
}
