//! Zip archives, whose contents determine the format.

use std::io::Cursor;

use zip::ZipArchive;

use crate::columns::Columns;
use crate::place::{FilePart, Place};
use crate::reader::{Input, Reader};
use crate::{IoError, jpk, npz, xlsx};

/// NPZ, JPK and XLSX files.
pub(crate) const READER: Reader = Reader {
    extensions: &["npz"],
    recognises: |head| head.starts_with(b"PK\x03\x04") || head.starts_with(b"PK\x05\x06"),
    read,
};

fn read(mut input: Input<'_>) -> Result<Columns, IoError> {
    let bytes = input.read_to_end()?;
    let archive = ZipArchive::new(Cursor::new(bytes.as_slice())).map_err(|e| IoError::Malformed {
        place: Place::new(input.file, FilePart::Whole),
        format: "NPZ",
        problem: format!("not a zip archive ({e})"),
    })?;
    if jpk::recognises(&archive) {
        jpk::read(input, &bytes, archive)
    } else if xlsx::recognises(&archive) {
        xlsx::read(input, &bytes, archive)
    } else {
        npz::read(input, &bytes, archive)
    }
}
