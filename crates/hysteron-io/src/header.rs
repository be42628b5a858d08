//! The header line: what each column is.

use hysteron_model::record::{Quantity, Unit, header_of, split_header};

use crate::options::MAX_COLUMNS;
use crate::{IoError, ReadOptions};

/// One column of a file.
#[derive(Clone, Debug)]
pub(crate) struct Column {
    /// Header as written.
    pub header: String,
    pub name: String,
    pub unit: Unit,
    pub role: ColumnRole,
}

/// What a column is read as.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ColumnRole {
    /// Time; the factor makes seconds of it.
    Time(f64),
    Mask,
    /// Frequency, positive; the factor makes hertz of it. Of a frequency response, never of a record.
    Frequency(f64),
    Channel,
    /// Not read.
    Skipped,
}

/// A file's columns and the input and output chosen by the options.
#[derive(Debug)]
pub(crate) struct Header {
    pub columns: Vec<Column>,
    /// Line it stands in.
    pub line: u64,
    pub chosen: Chosen,
}

/// Headers of the channels chosen by the options, by name or number.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chosen {
    pub input: Option<String>,
    pub output: Option<String>,
    pub reference: Option<String>,
}

impl Header {
    /// Understands the fields of the header line.
    pub fn new(file: &str, line: u64, fields: &[Vec<u8>], options: &ReadOptions) -> Result<Header, IoError> {
        let mut columns = named_columns(file, line, fields)?;
        let place = Place { file, line };
        let input = place.chosen(&columns, options.input.as_deref(), "--input")?;
        let output = place.chosen(&columns, options.output.as_deref(), "--output")?;
        let reference = place.chosen(&columns, options.reference.as_deref(), "--reference")?;
        let chosen = [input, output, reference];
        let time = place.time_column(&columns, options.time.as_deref(), chosen)?;
        if time.is_none()
            && chosen.iter().all(Option::is_none)
            && let Some(column) = columns.iter().find(|c| is_spectral(c))
        {
            return Err(IoError::FrequencyResponse {
                file: file.to_string(),
                line,
                column: column.header.clone(),
            });
        }
        let only_chosen = input.is_some() && output.is_some();
        for (i, column) in columns.iter_mut().enumerate() {
            column.role = if chosen.contains(&Some(i)) {
                ColumnRole::Channel
            } else if Some(i) == time {
                ColumnRole::Time(match column.unit.base() {
                    (Quantity::Time, factor) => factor,
                    _ => 1.0,
                })
            } else if column.name.eq_ignore_ascii_case("valid") {
                ColumnRole::Mask
            } else if only_chosen || column.header.is_empty() {
                ColumnRole::Skipped
            } else {
                ColumnRole::Channel
            };
        }
        if !columns.iter().any(|c| c.role == ColumnRole::Channel) {
            return Err(IoError::NoChannels { file: file.to_string(), line, found: list(&columns) });
        }
        let header_at =
            |i: Option<usize>| i.and_then(|i| columns.get(i)).map(|c| header_of(&c.name, &c.unit));
        let [input, output, reference] = chosen.map(header_at);
        Ok(Header { columns, line, chosen: Chosen { input, output, reference } })
    }
}

/// Names and units, checked; all roles still open.
pub(crate) fn named_columns(file: &str, line: u64, fields: &[Vec<u8>]) -> Result<Vec<Column>, IoError> {
    if fields.len() > MAX_COLUMNS {
        return Err(IoError::TooManyColumns {
            file: file.to_string(),
            line,
            found: fields.len(),
            limit: MAX_COLUMNS,
        });
    }
    let mut columns: Vec<Column> = Vec::with_capacity(fields.len());
    for (i, field) in fields.iter().enumerate() {
        let text = std::str::from_utf8(field).map_err(|e| IoError::NotUtf8 {
            file: file.to_string(),
            line,
            column: i + 1,
            byte: field.get(e.valid_up_to()).copied().unwrap_or(0),
            hint: "it may be Latin-1 or Windows-1252, or a binary file",
        })?;
        if text.contains('\r') {
            return Err(IoError::BareCarriageReturn { file: file.to_string(), line });
        }
        let last = i + 1 == fields.len() && i > 0;
        if text.is_empty() && !last || text.chars().any(char::is_control) {
            return Err(IoError::UnnamedColumn { file: file.to_string(), line, column: i + 1 });
        }
        let (name, unit) = split_header(text);
        if let Some(first) = columns.iter().position(|c| c.name == name && c.unit == unit) {
            return Err(IoError::DuplicateColumn {
                file: file.to_string(),
                line,
                name: text.to_string(),
                first: first + 1,
                second: i + 1,
            });
        }
        columns.push(Column { header: text.to_string(), name, unit, role: ColumnRole::Skipped });
    }
    Ok(columns)
}

struct Place<'a> {
    file: &'a str,
    line: u64,
}

impl Place<'_> {
    /// Column that a flag names: by header or bare name exactly, else ignoring case, else by number from 1.
    fn chosen(
        &self,
        columns: &[Column],
        asked: Option<&str>,
        flag: &'static str,
    ) -> Result<Option<usize>, IoError> {
        let Some(asked) = asked.map(str::trim) else { return Ok(None) };
        let same = |fold: &dyn Fn(&str) -> String| -> Vec<usize> {
            let asked = fold(asked);
            (0..columns.len())
                .filter(|&i| {
                    let c = &columns[i];
                    !c.header.is_empty()
                        && [c.header.as_str(), c.name.as_str(), header_of(&c.name, &c.unit).as_str()]
                            .iter()
                            .any(|text| fold(text) == asked)
                })
                .collect()
        };
        let mut found = same(&str::to_string);
        if found.is_empty() {
            found = same(&str::to_lowercase);
        }
        if found.is_empty()
            && let Ok(number) = asked.parse::<usize>()
            && (1..=columns.len()).contains(&number)
        {
            found.push(number - 1);
        }
        match found.as_slice() {
            [one] => Ok(Some(*one)),
            [] => Err(IoError::NoSuchColumn {
                file: self.file.to_string(),
                line: self.line,
                asked: asked.to_string(),
                flag,
                available: list(columns),
            }),
            several => Err(self.ambiguous(columns, several, asked, flag)),
        }
    }

    fn time_column(
        &self,
        columns: &[Column],
        asked: Option<&str>,
        taken: [Option<usize>; 3],
    ) -> Result<Option<usize>, IoError> {
        let free = |i: &usize| !taken.contains(&Some(*i));
        if let Some(index) = self.chosen(columns, asked, "--time")? {
            let column = &columns[index];
            if !column.unit.symbol().is_empty() && column.unit.base().0 != Quantity::Time {
                return Err(IoError::NotTime {
                    file: self.file.to_string(),
                    line: self.line,
                    name: column.header.clone(),
                    unit: column.unit.to_string(),
                });
            }
            return Ok(Some(index));
        }
        let is_time = |c: &Column| c.unit.base().0 == Quantity::Time;
        let has_time_name = |c: &Column| {
            (is_time(c) || c.unit.symbol().is_empty())
                && ["t", "time", "timestamp"].contains(&c.name.to_lowercase().as_str())
        };
        let by_name: Vec<usize> =
            (0..columns.len()).filter(|&i| has_time_name(&columns[i])).filter(free).collect();
        if by_name.is_empty() {
            // A lone unit of time makes a time column, but never of a column that is named as an input or an output.
            let by_unit: Vec<usize> = (0..columns.len())
                .filter(|&i| is_time(&columns[i]) && !columns[i].name.starts_with(['u', 'y', 'U', 'Y']))
                .filter(free)
                .collect();
            return Ok(match by_unit.as_slice() {
                [one] => Some(*one),
                _ => None,
            });
        }
        match by_name.as_slice() {
            [one] => Ok(Some(*one)),
            several => Err(self.ambiguous(columns, several, "time", "--time")),
        }
    }

    fn ambiguous(&self, columns: &[Column], several: &[usize], asked: &str, flag: &'static str) -> IoError {
        let candidates: Vec<Column> = several.iter().map(|&i| columns[i].clone()).collect();
        IoError::AmbiguousColumn {
            file: self.file.to_string(),
            line: self.line,
            asked: asked.to_string(),
            flag,
            candidates: list(&candidates),
        }
    }
}

/// Frequency, or the real or imaginary part of something.
fn is_spectral(column: &Column) -> bool {
    let name = column.name.to_lowercase();
    ["f", "freq", "frequency", "omega"].contains(&name.as_str())
        || (["Hz", "kHz", "MHz"].contains(&column.unit.symbol()) && !name.starts_with(['u', 'y']))
}

pub(crate) fn list(columns: &[Column]) -> String {
    let names: Vec<String> =
        columns.iter().filter(|c| !c.header.is_empty()).map(|c| format!("`{}`", c.header)).collect();
    names.join(", ")
}
