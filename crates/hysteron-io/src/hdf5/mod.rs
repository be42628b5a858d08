//! HDF5 files, and with them MAT files of version 7.3: datasets by their paths, `group/dataset`, those of MATLAB `rec.u`.

use std::collections::HashSet;

use hdf5_reader::error::Error;
use hdf5_reader::group::Group;
use hdf5_reader::messages::datatype::Datatype;
use hdf5_reader::{Dataset, Hdf5File, OpenOptions};

use crate::IoError;
use crate::columns::{Columns, Kind};
use crate::container::{self, Held, MAX_ARRAYS, MOST_PATH_BYTES, shape_of_texts};
use crate::hash::sha256;
use crate::place::{Part, Place};
use crate::reader::{Input, Reader};

/// Files of h5py, LabVIEW, MATLAB and others.
pub(crate) const READER: Reader = Reader { extensions: &["h5", "hdf5", "hdf", "nxs"], recognises, read };

const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
/// What a MAT file of version 7.3 begins with; the HDF5 file stands behind the first 512 bytes.
const MATLAB: &[u8] = b"MATLAB 7.3 MAT-file";
/// Groups within one another.
const MOST_DEPTH: usize = 32;
/// Most bytes of one chunk of a dataset.
const MOST_CHUNK_BYTES: usize = 256 << 20;
/// Most bytes of what describes one object.
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
    let whole = |error| malformed(Part::Whole, error);
    let file = Hdf5File::from_vec_with_options(bytes, limits).map_err(whole)?;
    let mut walk = Walk { of_matlab, ..Walk::default() };
    walk.group(&file.root_group().map_err(whole)?, "").map_err(whole)?;
    let Walk { held, datasets, .. } = walk;
    if held.is_empty() {
        let problem = "it holds no datasets".to_owned();
        return Err(IoError::Malformed { place: Place::new(&name, Part::Whole), format: "HDF5", problem });
    }
    container::columns(input, &held, sha, |index| {
        let part = || Part::Array(held[index].path.as_str().into());
        let dataset = &datasets[index];
        let is_too_large = dataset.raw_byte_len().map_or(true, |length| length as u64 > most_unpacked_bytes);
        if is_too_large {
            let place = Place::new(&name, part());
            return Err(IoError::TooLarge { place, limit_bytes: most_unpacked_bytes });
        }
        let bytes = dataset.read_native_bytes().map_err(|e| malformed(part(), e))?;
        Ok(numbers(&bytes, dataset.dtype()))
    })
}

/// Goes through the groups of a file.
#[derive(Default)]
struct Walk {
    of_matlab: bool,
    held: Vec<Held>,
    datasets: Vec<Dataset>,
    /// Addresses of the datasets.
    known: HashSet<u64>,
    /// Addresses of the groups around the one gone through: a group may be linked to within itself.
    around: Vec<u64>,
    /// Groups gone through so far.
    groups: usize,
}

impl Walk {
    /// Takes up what a group holds; `path` with the separator behind it.
    fn group(&mut self, group: &Group, path: &str) -> Result<(), Error> {
        self.groups += 1;
        if self.groups > MAX_ARRAYS {
            return Err(Error::ResourceLimit(format!("it holds more than {MAX_ARRAYS} groups")));
        }
        let (groups, datasets) = group.members()?;
        for dataset in datasets {
            if self.held.len() > MAX_ARRAYS {
                return Ok(());
            }
            check_length(path, dataset.name())?;
            let is_alias = !self.known.insert(dataset.address());
            self.held.push(Held { is_alias, ..self.held_by(&dataset, path) });
            self.datasets.push(dataset);
        }
        // MATLAB keeps the contents of its cells in #refs#, and its objects in #subsystem#.
        let of_matlab = self.of_matlab;
        let own = |group: &&Group| !(of_matlab && group.name().starts_with('#'));
        let separator = if of_matlab { "." } else { "/" };
        self.around.push(group.address());
        for inner in groups.iter().filter(own) {
            if self.around.len() <= MOST_DEPTH && !self.around.contains(&inner.address()) {
                check_length(path, inner.name())?;
                self.group(inner, &format!("{path}{}{separator}", inner.name()))?;
            }
        }
        self.around.pop();
        Ok(())
    }

    fn held_by(&self, dataset: &Dataset, path: &str) -> Held {
        let text = |name: &str| {
            let attributes = dataset.attributes();
            let named = attributes.iter().find(|attribute| attribute.name.eq_ignore_ascii_case(name));
            named.and_then(|attribute| attribute.read_string().ok())
        };
        let mut shape: Vec<usize> =
            dataset.shape().iter().map(|&n| usize::try_from(n).unwrap_or(usize::MAX)).collect();
        if self.of_matlab {
            shape.reverse();
        }
        let class = text("MATLAB_class").filter(|_| self.of_matlab);
        if class.as_deref() == Some("char") {
            shape = shape_of_texts(&shape);
        }
        let kind = match class.as_deref() {
            Some("char") => Kind::Other("text".to_owned()),
            Some("cell") => Kind::Other("cells".to_owned()),
            Some("function_handle") => Kind::Other("function".to_owned()),
            _ => kind(dataset.dtype()),
        };
        let unit = ["unit", "units", "unit_string"].into_iter().find_map(text);
        let row_major = !self.of_matlab;
        Held { unit, row_major, ..Held::new(path, dataset.name().trim_start_matches('/'), shape, kind) }
    }
}

/// Refuses paths that no person reads: each of very many datasets would have one.
fn check_length(path: &str, name: &str) -> Result<(), Error> {
    let is_short = path.len() + name.len() <= MOST_PATH_BYTES;
    let problem = || Error::ResourceLimit(format!("it has a path of more than {MOST_PATH_BYTES} bytes"));
    is_short.then_some(()).ok_or_else(problem)
}

/// What a dataset of a type holds.
fn kind(datatype: &Datatype) -> Kind {
    let other = |what: &str| Kind::Other(what.to_owned());
    match datatype {
        Datatype::FixedPoint { size: 1 | 2 | 4 | 8, .. }
        | Datatype::FloatingPoint { size: 2 | 4 | 8, .. } => Kind::Numbers,
        Datatype::Enum { base, .. } => kind(base),
        Datatype::FixedPoint { size, .. } | Datatype::FloatingPoint { size, .. } => {
            Kind::Other(format!("numbers of {size} bytes"))
        }
        Datatype::String { .. } => other("text"),
        Datatype::Compound { fields, .. } => {
            let names: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
            match names.as_slice() {
                ["real", "imag"] | ["r", "i"] => other("complex numbers"),
                _ => Kind::Other(format!("structure of {}", names.join(", "))),
            }
        }
        Datatype::VarLen { .. } => other("lists of various lengths, or text"),
        Datatype::Reference { .. } => other("references"),
        Datatype::Array { .. } => other("arrays within an array"),
        Datatype::Opaque { .. } | Datatype::Bitfield { .. } => other("bytes"),
    }
}

/// Numbers in the byte order of this machine.
fn numbers(bytes: &[u8], datatype: &Datatype) -> Vec<f64> {
    fn each<const N: usize>(bytes: &[u8], value: impl Fn([u8; N]) -> f64) -> Vec<f64> {
        bytes.as_chunks::<N>().0.iter().map(|chunk| value(*chunk)).collect()
    }
    match datatype {
        Datatype::Enum { base, .. } => numbers(bytes, base),
        Datatype::FixedPoint { size: 1, signed: true, .. } => {
            each(bytes, |b| f64::from(i8::from_ne_bytes(b)))
        }
        Datatype::FixedPoint { size: 1, .. } => each(bytes, |b| f64::from(u8::from_ne_bytes(b))),
        Datatype::FixedPoint { size: 2, signed: true, .. } => {
            each(bytes, |b| f64::from(i16::from_ne_bytes(b)))
        }
        Datatype::FixedPoint { size: 2, .. } => each(bytes, |b| f64::from(u16::from_ne_bytes(b))),
        Datatype::FixedPoint { size: 4, signed: true, .. } => {
            each(bytes, |b| f64::from(i32::from_ne_bytes(b)))
        }
        Datatype::FixedPoint { size: 4, .. } => each(bytes, |b| f64::from(u32::from_ne_bytes(b))),
        Datatype::FixedPoint { size: 8, signed: true, .. } => each(bytes, |b| i64::from_ne_bytes(b) as f64),
        Datatype::FixedPoint { size: 8, .. } => each(bytes, |b| u64::from_ne_bytes(b) as f64),
        Datatype::FloatingPoint { size: 2, .. } => each(bytes, |b| of_half(u16::from_ne_bytes(b))),
        Datatype::FloatingPoint { size: 4, .. } => each(bytes, |b| f64::from(f32::from_ne_bytes(b))),
        Datatype::FloatingPoint { size: 8, .. } => each(bytes, f64::from_ne_bytes),
        _ => Vec::new(),
    }
}

/// Half precision (IEEE 754, binary16).
fn of_half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1F), f64::from(bits & 0x3FF));
    match exponent {
        0 => sign * fraction * 2f64.powi(-24),
        0x1F if fraction == 0.0 => sign * f64::INFINITY,
        0x1F => f64::NAN,
        _ => sign * (1024.0 + fraction) * 2f64.powi(exponent - 25),
    }
}
