//! NPZ: a zip archive of NPY arrays; each array is a column, named with its unit.

use std::io::{Cursor, Read};

use zip::ZipArchive;
use zip::read::ZipFile;

use crate::IoError;
use crate::columns::{Columns, Headings, SampleLines, Wanted};
use crate::hash::sha256;
use crate::npy::{Array, Budget, Type};
use crate::options::MAX_COLUMNS;
use crate::place::{Part, Place};
use crate::reader::{Input, Reader};

/// Archives of arrays.
pub(crate) const READER: Reader = Reader {
    extensions: &["npz"],
    recognises: |head| head.starts_with(b"PK\x03\x04") || head.starts_with(b"PK\x05\x06"),
    read,
};

/// An array of the archive.
struct Entry {
    /// Its number in the archive.
    index: usize,
    name: String,
    array: Array,
}

fn read(mut input: Input<'_>) -> Result<Columns, IoError> {
    let bytes = input.read_to_end()?;
    let Input { file, options, wanted, .. } = input;
    let whole = || Place::new(file, Part::Whole);
    let mut archive = ZipArchive::new(Cursor::new(&bytes))
        .map_err(|e| malformed(whole(), format!("not a zip archive ({e})")))?;
    if archive.len() > MAX_COLUMNS {
        return Err(IoError::TooManyColumns { place: whole(), found: archive.len(), limit: MAX_COLUMNS });
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
            .map_err(|problem| malformed(Place::new(file, Part::Array(name.as_str().into())), problem))?;
        entries.push(Entry { index, name, array });
    }
    if entries.is_empty() {
        return Err(malformed(whole(), "it holds no arrays (`NAME.npy`)".to_owned()));
    }
    let mut budget = Budget::new(options);
    let mut sample_rate_hz = None;
    if entries.iter().any(|entry| entry.array.len() != 1) {
        for scalar in entries.extract_if(.., |entry| entry.array.len() == 1) {
            let place = Place::new(file, Part::Array(scalar.name.as_str().into()));
            let (Some(hz), Type::Number(_)) = (sample_rate(&scalar.name), &scalar.array.values) else {
                continue;
            };
            let value = column(&mut archive, &scalar, &place, &mut budget)?.first().map_or(0.0, |&v| hz(v));
            if !(value.is_finite() && value > 0.0) {
                return Err(IoError::BadRate { place, value });
            }
            sample_rate_hz = sample_rate_hz.or(Some((scalar.name, value)));
        }
    }
    let headings = Headings::new(file, None, entries.iter().map(|entry| entry.name.clone()).collect())?;
    let wanted = wanted(&headings)?;
    let mut values = Vec::new();
    for (entry, wanted) in entries.iter().zip(wanted) {
        let place = Place::new(file, Part::Array(entry.name.as_str().into()));
        values.push(match wanted {
            Wanted::Nothing => Vec::new(),
            _ => column(&mut archive, entry, &place, &mut budget)?,
        });
    }
    let lines = SampleLines::default();
    let texts = vec![Vec::new(); headings.columns.len()];
    Ok(Columns { headings, values, texts, lines, sample_rate_hz, sha256: sha256(&bytes) })
}

type Archive<'a> = ZipArchive<Cursor<&'a Vec<u8>>>;

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
    let number = entry.array.as_column(place)?;
    budget.spend(place, &entry.array, 1)?;
    let mut values = open(archive, entry.index)
        .and_then(|mut bytes| {
            Array::read_header(&mut bytes)?;
            entry.array.read_values(bytes, &[(0, number)])
        })
        .map_err(|problem| malformed(place.clone(), problem))?;
    Ok(values.pop().unwrap_or_default())
}

/// How the sample rate \[Hz\] follows from a number of this name, if it does.
fn sample_rate(name: &str) -> Option<fn(f64) -> f64> {
    let name = name.to_lowercase();
    let (stem, unit) = match name.rsplit_once('_') {
        Some((stem, unit @ ("hz" | "khz" | "s" | "ms" | "us"))) => (stem, unit),
        _ => (name.as_str(), ""),
    };
    match (stem, unit) {
        ("fs" | "sample_rate" | "sampling_rate" | "sample_frequency" | "sampling_frequency", unit) => {
            match unit {
                "" | "hz" => Some(|rate| rate),
                "khz" => Some(|rate| 1e3 * rate),
                _ => None,
            }
        }
        ("dt" | "sample_period" | "sampling_period", unit) => match unit {
            "" | "s" => Some(|period| 1.0 / period),
            "ms" => Some(|period| 1e3 / period),
            "us" => Some(|period| 1e6 / period),
            _ => None,
        },
        _ => None,
    }
}

fn malformed(place: Place, problem: String) -> IoError {
    IoError::Malformed { place, format: "NPZ", problem }
}
