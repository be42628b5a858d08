//! Record to MAT file of version 5.

use std::path::Path;

use hysteron_model::record::{Record, TimeBase};

use crate::IoError;
use crate::atomic_file::write_atomically;
use crate::place::{FilePart, Place};
use crate::write::{check, headers};

/// Longest name of a variable in MATLAB.
const MOST_NAME_BYTES: usize = 63;
/// Classes and types of elements.
const CLASS_DOUBLE: u32 = 6;
const CLASS_UINT8: u32 = 9;
const LOGICAL: u32 = 0x0200;
const INT8: u32 = 1;
const UINT8: u32 = 2;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;

/// Writes a record as MATLAB's `save -v6` does, one variable a column, that
/// [`read_record`](crate::read_record) reads back to the same numbers: `t_s` where there is a time base, one
/// a channel (`u_V`), `valid` (logical) where there is a mask. The same record makes the same bytes. The file
/// is complete or not there.
///
/// # Errors
/// Those of [`write_csv`](crate::write_csv); [`IoError::Malformed`] for a channel whose name MATLAB does not
/// allow, or of more than 4 GiB.
pub fn write_mat(path: &Path, record: &Record) -> Result<(), IoError> {
    Ok(write_atomically(path, &content(path, record)?)?)
}

/// The bytes of [`write_mat`]; `path` is that of the errors.
pub(crate) fn content(path: &Path, record: &Record) -> Result<Vec<u8>, IoError> {
    check(path, record)?;
    let headers = headers(record);
    let refused = |header: &str, problem: &str| IoError::Malformed {
        place: Place::new(&path.display().to_string(), FilePart::Array(header.into())),
        format: "MAT",
        problem: problem.to_owned(),
    };
    let is_name = |name: &str| {
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
        name.len() <= MOST_NAME_BYTES
            && name.starts_with(|c: char| c.is_ascii_alphabetic())
            && name.chars().all(plain)
    };
    if let Some(header) = headers.iter().find(|header| !is_name(header)) {
        let problem =
            "it is no name of a variable in MATLAB (letters, digits and _, at most 63); rename the channel";
        return Err(refused(header, problem));
    }
    if record.len() > (u32::MAX / 8) as usize - 16 {
        return Err(refused(&headers[0], "a variable holds at most 4 GiB"));
    }
    let mut bytes = format!("{:<124}", "MATLAB 5.0 MAT-file, written by hysteron").into_bytes();
    bytes.extend([0, 1, b'I', b'M']);
    let mut names = headers.iter();
    let mut put = |class, data: Vec<u8>| {
        if let Some(name) = names.next() {
            bytes.extend(variable(name, class, record.len(), &data));
        }
    };
    let doubles = |values: &mut dyn Iterator<Item = f64>| values.flat_map(f64::to_le_bytes).collect();
    if !matches!(record.time, TimeBase::Unknown) {
        put(CLASS_DOUBLE, doubles(&mut (0..record.len()).filter_map(|k| record.time.time_s(k))));
    }
    for channel in &record.channels {
        put(CLASS_DOUBLE, doubles(&mut channel.samples.iter().copied()));
    }
    if let Some(valid) = &record.valid {
        put(CLASS_UINT8 | LOGICAL, valid.iter().map(|&valid| u8::from(valid)).collect());
    }
    Ok(bytes)
}

/// A column as an element.
fn variable(name: &str, class: u32, length: usize, data: &[u8]) -> Vec<u8> {
    let words = |words: [u32; 2]| words.into_iter().flat_map(u32::to_le_bytes).collect::<Vec<_>>();
    let numbers = if class == CLASS_DOUBLE { DOUBLE } else { UINT8 };
    let parts = [
        element(UINT32, &words([class, 0])),
        element(INT32, &words([length as u32, 1])),
        element(INT8, name.as_bytes()),
        element(numbers, data),
    ];
    element(MATRIX, &parts.concat())
}

/// Type, length, bytes, and zeros up to a multiple of eight.
fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes: Vec<u8> = [kind, data.len() as u32].into_iter().flat_map(u32::to_le_bytes).collect();
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}
