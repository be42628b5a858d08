//! MAT files of versions 4 to 7: variables and the fields of structures, each by its path `rec.u`,
//! `signals(2).values`, `runs{1}`.
//!
//! Format: The MathWorks, *MAT-File Format*, R2019b. A MAT file of version 7.3 is an HDF5 file.

mod element;
mod v4;
mod v5;

use crate::IoError;
use crate::columns::Columns;
use crate::container::{self, HeldArray};
use crate::hash::sha256;
use crate::place::{FilePart, Place};
use crate::reader::{Input, Reader};
use element::Numbers;

/// Files of MATLAB, Octave and SciPy.
pub(crate) const READER: Reader =
    Reader { extensions: &["mat"], recognises: |head| v5::is_little_endian(head).is_some(), read };

/// Arrays of a file, and where the numbers of each stand.
#[derive(Default)]
struct Variables {
    held: Vec<HeldArray>,
    /// One an array; `None` for what is no array of numbers.
    numbers: Vec<Option<Numbers>>,
    /// Variables as they stand in the file or unpacked.
    buffers: Vec<Vec<u8>>,
}

fn read(mut input: Input<'_>) -> Result<Columns, IoError> {
    let file = input.read_to_end()?;
    let (name, options) = (input.file.to_owned(), input.options);
    let place = || Place::new(&name, FilePart::Whole);
    let malformed = |problem| IoError::Malformed { place: place(), format: "MAT", problem };
    let sha = sha256(&file);
    let variables = match v5::is_little_endian(&file) {
        Some(little_endian) => {
            let limit_bytes = options.most_unpacked_bytes(file.len() as u64);
            match v5::variables(&file, !little_endian, limit_bytes) {
                Err(v5::Problem::TooLarge) => return Err(IoError::TooLarge { place: place(), limit_bytes }),
                Err(v5::Problem::Malformed(problem)) => return Err(malformed(problem)),
                Ok(variables) => variables,
            }
        }
        None => v4::variables(file).map_err(malformed)?,
    };
    if variables.held.is_empty() {
        return Err(malformed("it holds no variables".to_owned()));
    }
    let Variables { held, numbers, buffers } = variables;
    container::columns(input, &held, sha, |index| match &numbers[index] {
        Some(numbers) => numbers.read(&buffers).map_err(|problem| IoError::Malformed {
            place: Place::new(&name, FilePart::Array(held[index].path.as_str().into())),
            format: "MAT",
            problem,
        }),
        None => Ok(Vec::new()),
    })
}
