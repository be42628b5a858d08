//! Named columns of numbers, the result of every reader.

use hysteron_model::record::{Quantity, Unit, header_of, split_header};

use crate::IoError;
use crate::options::MAX_COLUMNS;
use crate::place::{FilePart, Place};

/// Characters between the components of a path.
pub(crate) const SEPARATORS: [char; 3] = ['.', '/', '!'];

/// Parsed header of one column.
#[derive(Clone, Debug)]
pub(crate) struct Heading {
    /// As written in the file; of an array, its whole path.
    pub header: String,
    pub name: String,
    pub unit: Unit,
    /// In a file of named arrays, the array of the column.
    pub array: Option<ArrayHeading>,
}

/// Metadata of a named array, or of a column of it.
#[derive(Clone, Debug)]
pub(crate) struct ArrayHeading {
    /// Bytes of the header in front of its last component.
    pub group_bytes: usize,
    pub shape: Vec<usize>,
    /// Number of samples; `None` where it is no column, by its shape.
    pub length: Option<usize>,
    pub kind: Kind,
    /// Whether it is an alias, another path of an array above.
    pub is_alias: bool,
    /// Whether the file gives a sample rate for it.
    pub has_rate: bool,
}

/// Element type of an array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Numbers,
    /// A type that is not read as numbers: its name.
    Other(String),
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
    /// One list of numbers a heading; empty for those not read. For a text column, indices into its
    /// [`Self::texts`].
    pub values: Vec<Vec<f64>>,
    /// One list a heading: the distinct texts of a text column, in the order of first occurrence.
    pub texts: Vec<Vec<String>>,
    /// Lines that the samples stand in; none for a binary file.
    pub lines: SampleLines,
    /// Sample rate that the file gives.
    pub rate: Option<Rate>,
    /// SHA-256 of the file's bytes.
    pub sha256: String,
}

/// Sample rate that a file gives.
#[derive(Clone, Debug)]
pub(crate) struct Rate {
    /// The array that gives it.
    pub path: String,
    pub hz: f64,
    /// Time of the first sample \[s\].
    pub start_s: f64,
}

/// Form in which a column is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ColumnForm {
    Nothing,
    Numbers,
    /// Texts, as indices of the distinct ones.
    Texts,
}

/// Line numbers of samples: the first sample and its line of every run of lines without a gap.
#[derive(Debug, Default)]
pub(crate) struct SampleLines(Vec<(usize, u64)>);

impl Headings {
    /// Splits headers into names and units, and checks them.
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
                    None => Place::new(file, FilePart::Array(header.into())),
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
            headings.columns.push(Heading { header, name, unit, array: None });
        }
        Ok(headings)
    }

    /// The place of the headers.
    pub fn place(&self) -> Place {
        Place::new(&self.file, self.line.map_or(FilePart::Whole, FilePart::Line))
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

impl Heading {
    /// The path in front of the last component, with its separator; empty outside of a group.
    pub fn group(&self) -> &str {
        self.array.as_ref().and_then(|array| self.header.get(..array.group_bytes)).unwrap_or_default()
    }

    /// Whether name and unit are those of a time column.
    pub fn is_named_as_time(&self) -> bool {
        (self.unit.base().0 == Quantity::Time || self.unit.symbol().is_empty())
            && ["t", "time", "timestamp"].contains(&self.name.to_lowercase().as_str())
    }

    /// Whether it is an alias, another path of a column above.
    pub fn is_alias(&self) -> bool {
        self.array.as_ref().is_some_and(|array| array.is_alias)
    }

    /// Whether a file of named arrays holds something here that is no column of numbers.
    pub fn is_unreadable(&self) -> bool {
        self.array.as_ref().is_some_and(|array| array.length.is_none() || array.kind != Kind::Numbers)
    }

    /// Whether `asked` is the column's header or name, with or without its unit.
    pub fn is_called(&self, asked: &str, fold: &dyn Fn(&str) -> String) -> bool {
        self.spellings().iter().any(|text| fold(text) == asked)
    }

    /// Whether `asked` is the last components of the column's path.
    pub fn ends_in(&self, asked: &str, fold: &dyn Fn(&str) -> String) -> bool {
        let group = fold(self.group());
        let ends = |text: &String| {
            let text = fold(text);
            let last = text.get(group.len()..).unwrap_or(&text);
            asked.ends_with(last)
                && text.strip_suffix(asked).is_some_and(|before| before.ends_with(SEPARATORS))
        };
        !asked.is_empty() && !group.is_empty() && self.spellings().iter().any(ends)
    }

    /// Whether `asked` is a path within this one.
    pub fn holds(&self, asked: &str) -> bool {
        asked.strip_prefix(self.header.as_str()).is_some_and(|within| within.starts_with(SEPARATORS))
    }

    /// Header, and name with and without unit; of an array behind its group.
    fn spellings(&self) -> [String; 3] {
        let group = self.group();
        [
            self.header.clone(),
            format!("{group}{}", self.name),
            format!("{group}{}", header_of(&self.name, &self.unit)),
        ]
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
            place: Place::new(&self.headings.file, FilePart::Array(self.headings.header(other).into())),
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
            None => Place::new(file, FilePart::Element { array: name.into(), index: sample }),
        }
    }
}

impl SampleLines {
    /// Notes that `sample` and those behind it, up to the next one noted, stand in `line` and the lines
    /// below.
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
    let headers = columns.into_iter().filter(|column| !column.header.is_empty());
    listed(headers.map(|column| format!("`{}`", column.header)))
}

/// List of the named arrays of a file, for messages: path, shape, unit.
pub(crate) fn list_arrays<'a>(columns: impl IntoIterator<Item = &'a Heading>) -> String {
    listed(columns.into_iter().map(|column| {
        let unit = match column.unit.symbol() {
            "" => String::new(),
            symbol => format!(" in {symbol}"),
        };
        let Some(array) = &column.array else { return format!("`{}`", column.header) };
        let kind = match &array.kind {
            Kind::Numbers => String::new(),
            Kind::Other(kind) => format!(", {kind}"),
        };
        format!("`{}` ({}{kind}){unit}", column.header, shape_text(&array.shape))
    }))
}

/// A shape as messages show it: `100×1`.
pub(crate) fn shape_text(shape: &[usize]) -> String {
    if shape.is_empty() {
        return "one value".to_owned();
    }
    shape.iter().map(usize::to_string).collect::<Vec<_>>().join("×")
}

/// Most columns that a message lists.
const MOST_LISTED: usize = 24;

fn listed(items: impl Iterator<Item = String>) -> String {
    let mut items: Vec<String> = items.collect();
    if items.len() > MOST_LISTED + 1 {
        let left_out = items.len() - MOST_LISTED;
        items.truncate(MOST_LISTED);
        items.push(format!("and {left_out} more"));
    }
    items.join(", ")
}
