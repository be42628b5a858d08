//! Text files with a header block above columns of numbers: code shared by LVM and GCS files.

use std::borrow::Cow;

use crate::IoError;
use crate::options::MAX_NUMBER_BYTES;
use crate::place::{FilePart, Place, shown};
use crate::reader::Input;

/// A text and its lines.
pub(crate) struct Text<'a> {
    pub file: &'a str,
    pub text: Cow<'a, str>,
}

impl<'a> Text<'a> {
    /// The bytes as UTF-8, else as Latin-1, in which older programs write a µ.
    pub fn new(file: &'a str, bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => Cow::Borrowed(text),
            Err(_) => Cow::Owned(bytes.iter().copied().map(char::from).collect()),
        };
        Text { file, text }
    }

    /// Lines with their numbers, without line ends.
    pub fn lines(&self) -> impl Iterator<Item = (u64, &str)> {
        (1..).zip(self.text.lines())
    }

    /// The number in a field.
    pub fn number(&self, field: &str, decimal_comma: bool, line: u64, column: usize) -> Result<f64, IoError> {
        let trimmed = field.trim();
        let place = || Place::cell(self.file, line, column + 1, "");
        if trimmed.is_empty() {
            return Err(IoError::MissingValue { place: place() });
        }
        let text = if decimal_comma { Cow::Owned(trimmed.replace(',', ".")) } else { Cow::Borrowed(trimmed) };
        let number = text.parse().ok().filter(|_| text.len() <= MAX_NUMBER_BYTES);
        number.ok_or_else(|| IoError::NotANumber {
            place: place(),
            found: shown(trimmed.as_bytes()),
            hint: "",
        })
    }

    pub fn malformed(&self, format: &'static str, line: u64, problem: String) -> IoError {
        IoError::Malformed { place: Place::new(self.file, FilePart::Line(line)), format, problem }
    }
}

/// Counts the numbers kept against the limit.
pub(crate) struct KeptNumbers {
    left: usize,
    limit: usize,
}

impl KeptNumbers {
    pub fn new(input: &Input<'_>) -> Self {
        KeptNumbers { left: input.options.max_values, limit: input.options.max_values }
    }

    pub fn add(&mut self, file: &str) -> Result<(), IoError> {
        let too_many =
            || IoError::TooManyValues { place: Place::new(file, FilePart::Whole), limit: self.limit };
        self.left = self.left.checked_sub(1).ok_or_else(too_many)?;
        Ok(())
    }
}
