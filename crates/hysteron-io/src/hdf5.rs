//! HDF5 files, and with them MAT files of version 7.3: datasets by their paths, `group/dataset`, those of MATLAB `rec.u`.

use hdf5_reader::error::Error;
use hdf5_reader::group::Group;
use hdf5_reader::messages::datatype::Datatype;
use hdf5_reader::{Dataset, Hdf5File, OpenOptions};

use crate::IoError;
use crate::columns::{Columns, Kind};
use crate::container::{self, Held, MAX_ARRAYS};
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
    let of_matlab = bytes.starts_with(MATLAB);
    let limits = OpenOptions::default()
        .with_max_chunk_bytes(MOST_CHUNK_BYTES)
        .with_max_read_bytes(options.max_values.saturating_mul(8))
        .with_max_object_header_bytes(MOST_HEADER_BYTES);
    let whole = |error| malformed(Part::Whole, error);
    let file = Hdf5File::from_vec_with_options(bytes, limits).map_err(whole)?;
    let mut walk = Walk { of_matlab, held: Vec::new(), datasets: Vec::new() };
    walk.group(&file.root_group().map_err(whole)?, "", 0).map_err(whole)?;
    let Walk { held, datasets, .. } = walk;
    if held.is_empty() {
        let problem = "it holds no datasets".to_owned();
        return Err(IoError::Malformed { place: Place::new(&name, Part::Whole), format: "HDF5", problem });
    }
    container::columns(input, &held, sha, |index| {
        let part = || Part::Array(held[index].path.as_str().into());
        let dataset = &datasets[index];
        let bytes = dataset.read_native_bytes().map_err(|e| malformed(part(), e))?;
        Ok(numbers(&bytes, dataset.dtype()))
    })
}

/// Goes through the groups of a file.
struct Walk {
    of_matlab: bool,
    held: Vec<Held>,
    datasets: Vec<Dataset>,
}

impl Walk {
    /// Takes up what a group holds; `path` with the separator behind it.
    fn group(&mut self, group: &Group, path: &str, depth: usize) -> Result<(), Error> {
        let (groups, datasets) = group.members()?;
        for dataset in datasets {
            if self.held.len() > MAX_ARRAYS {
                return Ok(());
            }
            self.held.push(self.held_by(&dataset, path));
            self.datasets.push(dataset);
        }
        // MATLAB keeps the contents of its cells in #refs#, and its objects in #subsystem#.
        let own = |group: &&Group| !(self.of_matlab && group.name().starts_with('#'));
        let separator = if self.of_matlab { "." } else { "/" };
        // A group may be linked to within itself.
        for inner in groups.iter().filter(own).filter(|_| depth < MOST_DEPTH).collect::<Vec<_>>() {
            self.group(inner, &format!("{path}{}{separator}", inner.name()), depth + 1)?;
        }
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
        let kind = match text("MATLAB_class").filter(|_| self.of_matlab).as_deref() {
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
