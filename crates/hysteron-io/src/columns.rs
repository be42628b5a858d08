//! Named columns of numbers: what every reader gives.

use hysteron_model::record::{Unit, split_header};

use crate::IoError;
use crate::options::MAX_COLUMNS;
use crate::place::{Part, Place};

/// Header of one column, taken apart.
#[derive(Clone, Debug)]
pub(crate) struct Heading {
    /// As written in the file.
    pub header: String,
    pub name: String,
    pub unit: Unit,
}

/// Headers of a file's columns, in its order.
#[derive(Clone, Debug)]
pub(crate) struct Headings {
    pub file: String,
    /// Line they stand in, in a text.
    pub line: Option<u64>,
    pub columns: Vec<Heading>,
}

/// The columns of a file.
#[derive(Debug)]
pub(crate) struct Columns {
    pub headings: Headings,
    /// One list of numbers a heading; empty for those not read. Of a column of texts, which of its [`Self::texts`].
    pub values: Vec<Vec<f64>>,
    /// One list a heading: the different texts of a column of texts, in the order in which they first stand.
    pub texts: Vec<Vec<String>>,
    /// Lines that the samples stand in; none for a binary file.
    pub lines: SampleLines,
    /// Sample rate \[Hz\] that the file gives, and the name it gives it by.
    pub sample_rate_hz: Option<(String, f64)>,
    /// SHA-256 of the file's bytes.
    pub sha256: String,
}

/// What of a column is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    Nothing,
    Numbers,
    /// Texts, as numbers of different ones.
    Texts,
}

/// Line numbers of samples: the first sample and its line of every run of lines without a gap.
#[derive(Debug, Default)]
pub(crate) struct SampleLines(Vec<(usize, u64)>);

impl Headings {
    /// Takes headers apart into names and units, and checks them.
    pub fn new(file: &str, line: Option<u64>, headers: Vec<String>) -> Result<Self, IoError> {
        let mut headings = Headings { file: file.to_owned(), line, columns: Vec::new() };
        if headers.len() > MAX_COLUMNS {
            let place = headings.place();
            return Err(IoError::TooManyColumns { place, found: headers.len(), limit: MAX_COLUMNS });
        }
        let last = headers.len() - usize::from(!headers.is_empty());
        for (i, header) in headers.into_iter().enumerate() {
            // A delimiter may end the header line.
            let unnamed = header.is_empty() && (i == 0 || i < last);
            if unnamed || header.chars().any(char::is_control) {
                let place = match line {
                    Some(line) => Place::cell(file, line, i + 1, ""),
                    None => Place::new(file, Part::Array(header.into())),
                };
                return Err(IoError::UnnamedColumn { place });
            }
            let (name, unit) = split_header(&header);
            if let Some(first) = headings.columns.iter().position(|c| c.name == name && c.unit == unit) {
                return Err(IoError::DuplicateColumn {
                    place: headings.place(),
                    name: header,
                    first: first + 1,
                    second: i + 1,
                });
            }
            headings.columns.push(Heading { header, name, unit });
        }
        Ok(headings)
    }

    /// The place of the headers.
    pub fn place(&self) -> Place {
        Place::new(&self.file, self.line.map_or(Part::Whole, Part::Line))
    }

    /// Header of a column.
    pub fn header(&self, column: usize) -> &str {
        self.columns.get(column).map_or("", |c| &c.header)
    }

    /// The headers, for messages.
    pub fn list(&self) -> String {
        list(&self.columns)
    }
}

impl Columns {
    /// Checks that all columns of `others` are as long as `reference`, and returns that length.
    pub fn check_lengths(
        &self,
        reference: usize,
        mut others: impl Iterator<Item = usize>,
    ) -> Result<usize, IoError> {
        let length = |column: usize| self.values.get(column).map_or(0, Vec::len);
        let expected = length(reference);
        let Some(other) = others.find(|&column| length(column) != expected) else { return Ok(expected) };
        Err(IoError::LengthMismatch {
            place: Place::new(&self.headings.file, Part::Array(self.headings.header(other).into())),
            found: length(other),
            expected,
            reference: self.headings.header(reference).to_owned(),
        })
    }

    /// Takes out the samples that are not to be kept, in all columns.
    pub fn retain(&mut self, keep: &[bool]) {
        let mut lines = SampleLines::default();
        for (sample, (old, _)) in keep.iter().enumerate().filter(|(_, keep)| **keep).enumerate() {
            if let Some(line) = self.lines.line(old) {
                lines.note(sample, line);
            }
        }
        for values in &mut self.values {
            let mut keep = keep.iter();
            values.retain(|_| keep.next().copied().unwrap_or(true));
        }
        self.lines = lines;
    }

    /// The place of a column's sample.
    pub fn place(&self, column: usize, sample: usize) -> Place {
        let (file, name) = (&self.headings.file, self.headings.header(column));
        match self.lines.line(sample) {
            Some(line) => Place::cell(file, line, column + 1, name),
            None => Place::new(file, Part::Element { array: name.into(), index: sample }),
        }
    }
}

impl SampleLines {
    /// Notes that `sample` and those behind it, up to the next one noted, stand in `line` and the lines below.
    pub fn note(&mut self, sample: usize, line: u64) {
        if self.line(sample) != Some(line) {
            self.0.push((sample, line));
        }
    }

    /// The line of a sample.
    pub fn line(&self, sample: usize) -> Option<u64> {
        let runs = self.0.partition_point(|&(first, _)| first <= sample);
        let &(first, line) = self.0.get(runs.checked_sub(1)?)?;
        Some(line + (sample - first) as u64)
    }
}

/// Headers for messages.
pub(crate) fn list<'a>(columns: impl IntoIterator<Item = &'a Heading>) -> String {
    let headers = columns.into_iter().map(|c| c.header.as_str()).filter(|header| !header.is_empty());
    headers.map(|header| format!("`{header}`")).collect::<Vec<_>>().join(", ")
}
