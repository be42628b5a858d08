//! NPZ: a zip archive of NPY arrays; each array is a column, named with its unit.

use std::io::Read;

use zip::read::ZipFile;

use crate::IoError;
use crate::columns::{Columns, Kind};
use crate::container::{self, HeldArray, MAX_ARRAYS};
use crate::hash::sha256;
use crate::npy::{Array, Budget, Type};
use crate::place::{FilePart, Place, shown};
use crate::reader::{Archive, Input};

/// An array of the archive.
struct Entry {
    /// Its number in the archive.
    index: usize,
    name: String,
    array: Array,
}

/// Reads the arrays of an archive.
pub(crate) fn read(input: Input<'_>, bytes: &[u8], mut archive: Archive<'_>) -> Result<Columns, IoError> {
    let (file, options) = (input.file, input.options);
    let whole = || Place::new(file, FilePart::Whole);
    if archive.len() > MAX_ARRAYS {
        return Err(IoError::TooManyColumns { place: whole(), found: archive.len(), limit: MAX_ARRAYS });
    }
    let mut entries = Vec::new();
    for index in 0..archive.len() {
        let name =
            archive.name_for_index(index).transpose().map_err(|e| malformed(whole(), e.to_string()))?;
        let Some(name) = name.as_deref().and_then(|name| name.strip_suffix(".npy")).map(str::to_owned) else {
            continue;
        };
        let array = open(&mut archive, index)
            .and_then(|mut entry| Array::read_header(&mut entry))
            .map_err(|problem| malformed(Place::new(file, FilePart::Array(name.as_str().into())), problem))?;
        entries.push(Entry { index, name, array });
    }
    if entries.is_empty() {
        return Err(malformed(whole(), "it holds no arrays (`NAME.npy`)".to_owned()));
    }
    let held: Vec<HeldArray> = entries.iter().map(Entry::held).collect();
    let mut budget = Budget::new(options);
    container::columns(input, &held, sha256(bytes), |index| {
        let place = Place::new(file, FilePart::Array(entries[index].name.as_str().into()));
        column(&mut archive, &entries[index], &place, &mut budget)
    })
}

impl Entry {
    fn held(&self) -> HeldArray {
        let kind = match &self.array.values {
            Type::Number(_) => Kind::Numbers,
            Type::Fields(_) => Kind::Other("structure".to_owned()),
            Type::Other(dtype) => Kind::Other(shown(dtype.as_bytes())),
        };
        let row_major = !self.array.is_column_major;
        HeldArray { row_major, ..HeldArray::new("", &self.name, self.array.shape(), kind) }
    }
}

fn open<'a>(archive: &'a mut Archive<'_>, index: usize) -> Result<ZipFile<'a, impl Read>, String> {
    archive.by_index(index).map_err(|e| e.to_string())
}

/// The numbers of one array.
fn column(
    archive: &mut Archive<'_>,
    entry: &Entry,
    place: &Place,
    budget: &mut Budget,
) -> Result<Vec<f64>, IoError> {
    let Type::Number(number) = entry.array.values else { return Ok(Vec::new()) };
    budget.spend(place, &entry.array, 1)?;
    let mut values = open(archive, entry.index)
        .and_then(|mut bytes| {
            Array::read_header(&mut bytes)?;
            entry.array.read_values(bytes, &[(0, number)])
        })
        .map_err(|problem| malformed(place.clone(), problem))?;
    Ok(values.pop().unwrap_or_default())
}

fn malformed(place: Place, problem: String) -> IoError {
    IoError::Malformed { place, format: "NPZ", problem }
}
