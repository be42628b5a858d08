//! Record to file, in the format of its extension.

use std::io::{self, Write};
use std::path::Path;

use hysteron_model::record::{Record, RecordError, TimeBase};

use crate::atomic_file::{AtomicWriteError, write_atomically_with};
use crate::{IoError, mat_write, npz_write, write_csv_to};

/// Writes a record: as NPZ to a file `NAME.npz` ([`write_npz`](crate::write_npz)), as MAT to `NAME.mat`
/// ([`write_mat`](crate::write_mat)), as CSV to any other ([`write_csv`](crate::write_csv)).
///
/// # Errors
/// Those of [`write_csv`](crate::write_csv).
pub fn write_record(path: &Path, record: &Record) -> Result<(), IoError> {
    produce(path, record, |content| write_atomically_with(path, content))
}

/// Formats that are not written: text under such a name is not read back, by this program or by others.
const OTHER_FORMATS: [&str; 12] =
    ["h5", "hdf5", "hdf", "nxs", "xlsx", "xls", "ods", "tdms", "parquet", "feather", "npy", "json"];

/// Hands the content of [`write_record`] to `write`.
pub(crate) fn produce(
    path: &Path,
    record: &Record,
    write: impl FnOnce(&mut dyn FnMut(&mut dyn Write) -> io::Result<()>) -> Result<(), AtomicWriteError>,
) -> Result<(), IoError> {
    let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
    let bytes = match extension.as_deref().and_then(|extension| extension.to_str()) {
        Some("npz") => npz_write::content(path, record)?,
        Some("mat") => mat_write::content(path, record)?,
        Some(other) if OTHER_FORMATS.contains(&other) => {
            return Err(IoError::NotWritten {
                path: path.display().to_string(),
                extension: other.to_owned(),
            });
        }
        _ => {
            check(path, record)?;
            return Ok(write(&mut |out| write_csv_to(out, record))?);
        }
    };
    Ok(write(&mut |out| out.write_all(&bytes))?)
}

/// Headers of a record's columns in a file: time, channels, mask.
pub(crate) fn headers(record: &Record) -> Vec<String> {
    let time = (!matches!(record.time, TimeBase::Unknown)).then(|| "t_s".to_owned());
    let mask = record.valid.is_some().then(|| "valid".to_owned());
    time.into_iter().chain(record.channels.iter().map(|c| c.header())).chain(mask).collect()
}

/// Checks that a record reads back: sound, and no channel has the header of time or mask.
pub(crate) fn check(path: &Path, record: &Record) -> Result<(), IoError> {
    let failed = |source| IoError::Record { file: path.display().to_string(), source: Box::new(source) };
    record.check().map_err(failed)?;
    let headers = headers(record);
    match headers.iter().enumerate().find(|(i, header)| headers[..*i].contains(header)) {
        None => Ok(()),
        Some((_, twice)) => {
            Err(failed(RecordError::DuplicateChannel { record: record.name.clone(), channel: twice.clone() }))
        }
    }
}
