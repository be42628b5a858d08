//! Places in a file.

use std::fmt;

/// Part of a file that a message is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file, as the caller named it.
    pub file: Box<str>,
    /// Line, cell or array within it.
    pub part: FilePart,
}

/// Line, cell or array of a file. Lines and columns count from 1, as editors do; samples of an array from 0,
/// as numpy does.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FilePart {
    /// The file as a whole.
    Whole,
    /// A line of text.
    Line(u64),
    /// One field of a line of text.
    Cell {
        /// The line.
        line: u64,
        /// The column.
        column: u32,
        /// Header of the column; empty where it is in doubt.
        name: Box<str>,
    },
    /// An array, or a field of a structured array, by name.
    Array(Box<str>),
    /// One number of an array.
    Element {
        /// Name of the array.
        array: Box<str>,
        /// Its index.
        index: usize,
    },
}

impl Place {
    pub(crate) fn new(file: &str, part: FilePart) -> Self {
        Place { file: file.into(), part }
    }

    pub(crate) fn cell(file: &str, line: u64, column: usize, name: &str) -> Self {
        let column = u32::try_from(column).unwrap_or(u32::MAX);
        Place::new(file, FilePart::Cell { line, column, name: name.into() })
    }

    /// The part in brackets, behind the words in front of it; nothing for the whole file.
    pub(crate) fn in_brackets(&self, before: &str) -> String {
        match &self.part {
            FilePart::Whole => String::new(),
            part => format!(" ({before}{part})"),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.part {
            FilePart::Whole => write!(f, "`{}`", self.file),
            part => write!(f, "`{}`, {part}", self.file),
        }
    }
}

impl fmt::Display for FilePart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FilePart::Whole => f.write_str("the file"),
            FilePart::Line(line) => write!(f, "line {line}"),
            FilePart::Cell { line, column, name } if name.is_empty() => {
                write!(f, "line {line}, column {column}")
            }
            FilePart::Cell { line, column, name } => write!(f, "line {line}, column {column} (`{name}`)"),
            FilePart::Array(name) => write!(f, "array `{}`", shown(name.as_bytes())),
            FilePart::Element { array, index } => {
                write!(f, "array `{}`, index {index}", shown(array.as_bytes()))
            }
        }
    }
}

/// Text as quoted in messages: control characters escaped, cut to a readable length.
pub(crate) fn shown(text: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(text).escape_debug().take(41).collect();
    match text.char_indices().nth(40) {
        Some((at, _)) => format!("{}…", &text[..at]),
        None => text,
    }
}
