//! Interface of a format: how its files are recognised, and read into columns.

use std::io::{Cursor, Read};

use zip::ZipArchive;

use crate::columns::{ColumnForm, Columns, Headings};
use crate::place::{FilePart, Place};
use crate::{IoError, ReadOptions};

/// A format.
pub(crate) struct Reader {
    /// Extensions of its files, in lower case.
    pub extensions: &'static [&'static str],
    /// Whether a file that begins with these bytes is of this format, whatever its extension.
    pub recognises: fn(&[u8]) -> bool,
    /// Reads the columns that are wanted.
    pub read: ReadColumns,
}

/// Function that reads the columns of a file.
pub(crate) type ReadColumns = fn(Input<'_>) -> Result<Columns, IoError>;

/// A zip archive in memory, which several formats are.
pub(crate) type Archive<'a> = ZipArchive<Cursor<&'a [u8]>>;

/// A file to be read.
pub(crate) struct Input<'a> {
    /// Its name, for messages.
    pub file: &'a str,
    pub bytes: &'a mut dyn Read,
    pub options: &'a ReadOptions,
    /// Size of the file, once it is read to its end.
    pub file_bytes: u64,
    /// Says which of the columns are to be read.
    pub wanted: &'a mut dyn FnMut(&Headings) -> Result<Vec<ColumnForm>, IoError>,
}

impl Input<'_> {
    /// All bytes of the file.
    pub fn read_to_end(&mut self) -> Result<Vec<u8>, IoError> {
        let (place, limit_bytes) = (Place::new(self.file, FilePart::Whole), self.options.max_bytes);
        let mut bytes = Vec::new();
        match self.bytes.take(limit_bytes.saturating_add(1)).read_to_end(&mut bytes) {
            Err(source) => Err(IoError::Read { place, source }),
            Ok(_) if bytes.len() as u64 > limit_bytes => Err(IoError::TooLarge { place, limit_bytes }),
            Ok(_) => {
                self.file_bytes = bytes.len() as u64;
                Ok(bytes)
            }
        }
    }
}
