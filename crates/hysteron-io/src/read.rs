//! Any file to record: the reader is chosen by content and extension, all else is common.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use hysteron_model::Finding;
use hysteron_model::record::{ChannelChoice, Driven, InputOutput, Record, RecordError, Signal};

use crate::assemble::{Assembled, assemble};
use crate::columns::{ColumnForm, Columns, Headings};
use crate::place::{FilePart, Place};
use crate::reader::{Input, ReadColumns, Reader};
use crate::rename::renamed;
use crate::roles::{Chosen, Roles};
use crate::{IoError, ReadOptions, archive, csv, gcs, hdf5, lvm, mat, npy, tdms};

/// Formats of named arrays. A file of none of them is read as text.
static READERS: [Reader; 7] =
    [hdf5::READER, mat::READER, npy::READER, archive::READER, tdms::READER, lvm::READER, gcs::READER];

/// Usual extensions of text, and of the formats that only their content tells.
const OTHER_EXTENSIONS: [&str; 10] =
    ["csv", "txt", "tsv", "dat", "lvm", "xlsx", "gcs", "jpk-force", "jpk-force-map", "jpk-force-qi"];

/// Usual extensions of files that hold records, in lower case. A file of another extension may hold one too.
pub fn record_extensions() -> impl Iterator<Item = &'static str> {
    READERS.iter().flat_map(|reader| reader.extensions.iter().copied()).chain(OTHER_EXTENSIONS)
}

/// Bytes at the start of a file that [`Reader::recognises`] looks at.
const HEAD_BYTES: u64 = 1024;

/// Input and output of a file, and notes on automatic choices.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOutcome {
    /// The two channels, ready for a fit.
    pub data: InputOutput,
    /// Plain sentences for the user.
    pub notes: Vec<Finding>,
}

/// A record and its part of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct PartRead {
    /// The record.
    pub record: Record,
    /// Number of samples in the file, of which [`ReadOptions::cut`] keeps those of the record.
    pub file_samples: usize,
    /// Headers in the record of the input and the output that the options name.
    pub chosen: ChannelChoice,
}

/// Reads a record; see the crate's description for the formats.
///
/// # Errors
/// Any [`IoError`]; it names the file, and line and column or array where there are any.
pub fn read_record(path: &Path, options: &ReadOptions) -> Result<Record, IoError> {
    Ok(read_part(path, options)?.record)
}

/// [`read_record`], with the number of samples in the file.
///
/// # Errors
/// Those of [`read_record`].
pub fn read_part(path: &Path, options: &ReadOptions) -> Result<PartRead, IoError> {
    let Assembled { record, file_samples, chosen, .. } =
        read(&path.display().to_string(), open(path)?, options)?;
    let chosen = ChannelChoice { input: chosen.input, output: chosen.output };
    Ok(PartRead { record, file_samples, chosen })
}

/// Reads a record from memory; `name` stands for the file in messages, and its extension may choose the
/// format.
///
/// # Errors
/// Those of [`read_record`].
pub fn read_record_bytes(name: &str, bytes: &[u8], options: &ReadOptions) -> Result<Record, IoError> {
    Ok(read(name, bytes, options)?.record)
}

/// Reads a record and takes its input and output: as the options name them, otherwise by the rules of
/// [`Record::select`](hysteron_model::record::Record::select).
///
/// # Errors
/// Those of [`read_record`]; [`IoError::Record`] where input or output cannot be decided.
pub fn read_input_output(path: &Path, options: &ReadOptions) -> Result<ReadOutcome, IoError> {
    selected(&path.display().to_string(), open(path)?, options)
}

/// [`read_input_output`] from memory; `name` as for [`read_record_bytes`].
///
/// # Errors
/// Those of [`read_input_output`].
pub fn read_input_output_bytes(
    name: &str,
    bytes: &[u8],
    options: &ReadOptions,
) -> Result<ReadOutcome, IoError> {
    selected(name, bytes, options)
}

/// Reads a record and takes its drive alone: as the options name it, otherwise by the rules of
/// [`Record::drive`].
///
/// # Errors
/// Those of [`read_record`]; [`IoError::Record`] where the drive cannot be decided.
pub fn read_drive(path: &Path, options: &ReadOptions) -> Result<Driven, IoError> {
    read_alone(path, options, |record, chosen| record.driven(chosen.input.as_deref()))
}

/// Reads a record and takes the reference alone: as the options name it, otherwise by the rules of
/// [`Record::reference`].
///
/// # Errors
/// Those of [`read_record`]; [`IoError::Record`] where the reference cannot be decided.
pub fn read_reference(path: &Path, options: &ReadOptions) -> Result<Signal, IoError> {
    read_alone(path, options, |record, chosen| record.reference(chosen.reference.as_deref()))
}

fn read_alone<T>(
    path: &Path,
    options: &ReadOptions,
    take: impl FnOnce(&Record, &Chosen) -> Result<T, RecordError>,
) -> Result<T, IoError> {
    let file = path.display().to_string();
    let Assembled { record, chosen, .. } = read(&file, open(path)?, options)?;
    take(&record, &chosen).map_err(|source| IoError::Record { file, source: Box::new(source) })
}

fn selected(file: &str, source: impl Read, options: &ReadOptions) -> Result<ReadOutcome, IoError> {
    let Assembled { record, chosen: Chosen { input, output, .. }, mut notes, .. } =
        read(file, source, options)?;
    let choice = ChannelChoice { input, output };
    let failed = |source| IoError::Record { file: file.to_string(), source: Box::new(source) };
    notes.extend(record.select(&choice).map_err(failed)?.notes);
    let data = record.input_output(&choice).map_err(failed)?;
    Ok(ReadOutcome { data, notes })
}

fn read(file: &str, source: impl Read, options: &ReadOptions) -> Result<Assembled, IoError> {
    let wanted =
        |headings: &Headings| Ok(Roles::new(&renamed(headings, &options.rename)?, options)?.wanted());
    assemble(read_columns(file, source, options, wanted)?, options)
}

pub(crate) fn open(path: &Path) -> Result<File, IoError> {
    let failed = |source| IoError::Open { file: path.display().to_string(), source };
    let file = File::open(path).map_err(failed)?;
    if file.metadata().map_err(failed)?.is_dir() {
        return Err(failed(std::io::Error::from(std::io::ErrorKind::IsADirectory)));
    }
    Ok(file)
}

/// Whether a file is of a format of named arrays rather than a table of text, by its first bytes. A pipe is
/// not asked, since what is read from it is gone.
///
/// # Errors
/// [`IoError::Open`], [`IoError::Read`].
pub fn holds_named_arrays(path: &Path) -> Result<bool, IoError> {
    if std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return Ok(false);
    }
    let file = path.display().to_string();
    let head = head_of(&file, &mut open(path)?)?;
    Ok(reader_of(&file, &head).is_some())
}

/// The first bytes of a file.
fn head_of(file: &str, source: &mut impl Read) -> Result<Vec<u8>, IoError> {
    let mut head = Vec::new();
    let read = source.take(HEAD_BYTES).read_to_end(&mut head);
    read.map_err(|source| IoError::Read { place: Place::new(file, FilePart::Whole), source })?;
    Ok(head)
}

/// Reads those columns of a file of any format that are `wanted`.
pub(crate) fn read_columns(
    file: &str,
    mut source: impl Read,
    options: &ReadOptions,
    mut wanted: impl FnMut(&Headings) -> Result<Vec<ColumnForm>, IoError>,
) -> Result<Columns, IoError> {
    let head = head_of(file, &mut source)?;
    let read = reader_of(file, &head).map_or(csv::read as ReadColumns, |reader| reader.read);
    let mut bytes = head.as_slice().chain(source);
    read(Input { file, bytes: &mut bytes, options, file_bytes: 0, wanted: &mut wanted })
}

/// True if a reader other than that of text takes a file with these first bytes for its own.
pub(crate) fn is_recognised(head: &[u8]) -> bool {
    READERS.iter().any(|reader| (reader.recognises)(head))
}

/// The reader that recognises the first bytes, else the one of the extension; `None`: text.
fn reader_of(file: &str, head: &[u8]) -> Option<&'static Reader> {
    let extension = Path::new(file).extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    let recognised = READERS.iter().find(|reader| (reader.recognises)(head));
    recognised.or_else(|| READERS.iter().find(|reader| reader.extensions.contains(&extension.as_str())))
}
