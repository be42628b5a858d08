//! GCS arrays: data-recorder files of Physik Instrumente controllers, as saved by PI software.

use std::collections::HashMap;

use crate::IoError;
use crate::columns::{Columns, Kind};
use crate::container::{self, HeldArray};
use crate::hash::sha256;
use crate::laboratory_text::{KeptNumbers, Text};
use crate::options::MAX_COLUMNS;
use crate::place::{FilePart, Place};
use crate::reader::{Input, Reader};

/// Arrays of the General Command Set.
pub(crate) const READER: Reader = Reader { extensions: &[], recognises, read };

const FORMAT: &str = "GCS array";

/// Whether comment lines at the start give the separator and the number of columns.
fn recognises(head: &[u8]) -> bool {
    let has =
        |key: &str| head.split(|&byte| byte == b'\n').any(|line| entry(line).is_some_and(|(k, _)| k == key));
    has("SEPARATOR") && (has("DIM") || has("NDATA"))
}

/// Key and value of a header line, `# KEY = VALUE`.
fn entry(line: &[u8]) -> Option<(&str, &str)> {
    let (key, value) = std::str::from_utf8(line).ok()?.strip_prefix('#')?.split_once('=')?;
    Some((key.trim(), value.trim()))
}

fn read(mut input: Input<'_>) -> Result<Columns, IoError> {
    let bytes = input.read_to_end()?;
    let text = Text::new(input.file, &bytes);
    let mut kept = KeptNumbers::new(&input);
    let mut header = HashMap::new();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut separator = ' ';
    let mut last_line = 0;
    for (line, content) in text.lines() {
        last_line = line;
        if content.starts_with('#') {
            header.extend(entry(content.as_bytes()));
            continue;
        }
        // Programs may write lines of their own in front of the header.
        if header.is_empty() || content.trim().is_empty() {
            continue;
        }
        if columns.is_empty() {
            let code = number(&text, &header, "SEPARATOR", line)?.unwrap_or(32);
            separator = u8::try_from(code).map_or(' ', char::from);
            let count = number(&text, &header, "DIM", line)?.unwrap_or(1);
            if count == 0 || count > MAX_COLUMNS {
                let place = Place::new(input.file, FilePart::Line(line));
                return Err(IoError::TooManyColumns { place, found: count, limit: MAX_COLUMNS });
            }
            columns = vec![Vec::new(); count];
        }
        let mut fields = content.trim().split(separator).filter(|field| !field.trim().is_empty());
        for (i, column) in columns.iter_mut().enumerate() {
            kept.add(input.file)?;
            column.push(text.number(fields.next().unwrap_or_default(), false, line, i)?);
        }
        if fields.next().is_some() {
            let problem = format!("more numbers than the {} columns of its header (DIM)", columns.len());
            return Err(text.malformed(FORMAT, line, problem));
        }
    }
    let samples = columns.first().map_or(0, Vec::len);
    if let Some(promised) =
        number(&text, &header, "NDATA", last_line)?.filter(|&promised| promised != samples)
    {
        let problem = format!("it has {samples} of the {promised} samples that its header promises (NDATA)");
        return Err(text.malformed(FORMAT, last_line, problem));
    }
    let sample_time = header.get("SAMPLE_TIME").and_then(|time| time.parse::<f64>().ok());
    let held = (0..columns.len()).map(|i| {
        let name = header.get(format!("NAME{i}").as_str()).filter(|name| !name.is_empty());
        let name = name.map_or_else(|| format!("column{}", i + 1), |name| (*name).to_owned());
        let mut held = HeldArray::new("", &name, vec![samples], Kind::Numbers);
        held.unit = header.get(format!("UNIT{i}").as_str()).map(|unit| (*unit).to_owned());
        held.sample_rate_hz = sample_time.map(f64::recip);
        held
    });
    let held: Vec<HeldArray> = held.collect();
    container::columns(input, &held, sha256(&bytes), |index| Ok(std::mem::take(&mut columns[index])))
}

/// A whole number of the header.
fn number(
    text: &Text<'_>,
    header: &HashMap<&str, &str>,
    key: &str,
    line: u64,
) -> Result<Option<usize>, IoError> {
    let Some(value) = header.get(key) else { return Ok(None) };
    let problem = || format!("`{key} = {value}` in its header is no whole number");
    value.parse().map(Some).map_err(|_| text.malformed(FORMAT, line, problem()))
}
