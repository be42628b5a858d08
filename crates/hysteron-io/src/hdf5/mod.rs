//! HDF5 files, and with them MAT files of version 7.3: datasets by their paths, `group/dataset`, those of
//! MATLAB `rec.u`, `signals(2).values`, `runs{1}`.

mod matlab;
mod number;
mod walk;

use hdf5_reader::error::Error;
use hdf5_reader::{Hdf5File, OpenOptions};

use crate::IoError;
use crate::columns::Columns;
use crate::container;
use crate::hash::sha256;
use crate::place::{FilePart, Place};
use crate::reader::{Input, Reader};
use matlab::References;
use number::numbers;
use walk::Walk;

/// Files of h5py, LabVIEW, MATLAB and others.
pub(crate) const READER: Reader = Reader { extensions: &["h5", "hdf5", "hdf", "nxs"], recognises, read };

const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Beginning of a MAT file of version 7.3, whose HDF5 file follows the first 512 bytes.
const MATLAB: &[u8] = b"MATLAB 7.3 MAT-file";
/// Most bytes of one chunk of a dataset.
const MOST_CHUNK_BYTES: usize = 256 << 20;
/// Most bytes of an object header.
const MOST_HEADER_BYTES: usize = 16 << 20;

fn recognises(head: &[u8]) -> bool {
    head.starts_with(SIGNATURE) || head.get(512..).is_some_and(|behind| behind.starts_with(SIGNATURE))
}

fn read(mut input: Input<'_>) -> Result<Columns, IoError> {
    let bytes = input.read_to_end()?;
    let (name, options) = (input.file.to_owned(), input.options);
    let malformed = |part, error: Error| IoError::Malformed {
        place: Place::new(&name, part),
        format: "HDF5",
        problem: error.to_string(),
    };
    let sha = sha256(&bytes);
    let most_unpacked_bytes = options.most_unpacked_bytes(bytes.len() as u64);
    let of_matlab = bytes.starts_with(MATLAB);
    let limits = OpenOptions::default()
        .with_max_chunk_bytes(MOST_CHUNK_BYTES)
        .with_max_read_bytes(usize::try_from(most_unpacked_bytes).unwrap_or(usize::MAX))
        .with_max_object_header_bytes(MOST_HEADER_BYTES);
    let whole = |error| malformed(FilePart::Whole, error);
    let file = Hdf5File::from_vec_with_options(bytes, limits).map_err(whole)?;
    let root = file.root_group().map_err(whole)?;
    let references = of_matlab.then(|| References::new(&root)).transpose().map_err(whole)?;
    let (held, datasets) = Walk::through(&root, references.as_ref()).map_err(whole)?;
    if held.is_empty() {
        let problem = "it holds no datasets".to_owned();
        return Err(IoError::Malformed {
            place: Place::new(&name, FilePart::Whole),
            format: "HDF5",
            problem,
        });
    }
    container::columns(input, &held, sha, |index| {
        let part = || FilePart::Array(held[index].path.as_str().into());
        let Some(dataset) = &datasets[index] else { return Ok(Vec::new()) };
        let is_too_large = dataset.raw_byte_len().map_or(true, |length| length as u64 > most_unpacked_bytes);
        if is_too_large {
            let place = Place::new(&name, part());
            return Err(IoError::TooLarge { place, limit_bytes: most_unpacked_bytes });
        }
        let bytes = dataset.read_native_bytes().map_err(|e| malformed(part(), e))?;
        Ok(numbers(&bytes, dataset.dtype()))
    })
}
