//! Record to NPZ file.

use std::io::{Cursor, Write};
use std::path::Path;

use hysteron_model::record::{Record, TimeBase};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::IoError;
use crate::atomic_file::write_atomically;
use crate::place::{FilePart, Place};
use crate::write::{check, headers};

/// Writes a record as numpy's `savez` does, one array a column, that [`read_record`](crate::read_record)
/// reads back to the same numbers: `t_s` where there is a time base, one a channel (`u_V`), `valid` (bool)
/// where there is a mask. The same record makes the same bytes. The file is complete or not there.
///
/// # Errors
/// Those of [`write_csv`](crate::write_csv); [`IoError::Malformed`] for a record too large for an archive.
pub fn write_npz(path: &Path, record: &Record) -> Result<(), IoError> {
    Ok(write_atomically(path, &content(path, record)?)?)
}

/// The bytes of [`write_npz`]; `path` is that of the errors.
pub(crate) fn content(path: &Path, record: &Record) -> Result<Vec<u8>, IoError> {
    check(path, record)?;
    archive(record).map_err(|problem| IoError::Malformed {
        place: Place::new(&path.display().to_string(), FilePart::Whole),
        format: "NPZ",
        problem: problem.to_string(),
    })
}

fn archive(record: &Record) -> zip::result::ZipResult<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let mut columns: Vec<Vec<u8>> = Vec::new();
    if !matches!(record.time, TimeBase::Unknown) {
        columns.push(floats((0..record.len()).filter_map(|k| record.time.time_s(k))));
    }
    columns.extend(record.channels.iter().map(|c| floats(c.samples.iter().copied())));
    if let Some(valid) = &record.valid {
        columns.push(array("|b1", valid.len(), valid.iter().map(|&valid| u8::from(valid)).collect()));
    }
    for (header, column) in headers(record).iter().zip(columns) {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::DEFAULT)
            .unix_permissions(0o644)
            .large_file(column.len() > (1 << 31));
        archive.start_file(format!("{header}.npy"), options)?;
        archive.write_all(&column)?;
    }
    Ok(archive.finish()?.into_inner())
}

fn floats(values: impl Iterator<Item = f64>) -> Vec<u8> {
    let bytes: Vec<u8> = values.flat_map(f64::to_le_bytes).collect();
    array("<f8", bytes.len() / 8, bytes)
}

/// An NPY file of version 1: a header, padded to 64 bytes, and the numbers.
fn array(dtype: &str, length: usize, data: Vec<u8>) -> Vec<u8> {
    let header = format!("{{'descr': '{dtype}', 'fortran_order': False, 'shape': ({length},), }}");
    // Magic, version and length of the header are 10 bytes, the line feed at its end one.
    let padded = (header.len() + 11).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((padded as u16).to_le_bytes());
    bytes.extend(format!("{header:<width$}\n", width = padded - 1).bytes());
    bytes.extend(data);
    bytes
}
