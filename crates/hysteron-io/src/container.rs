//! Files of named arrays: contents, and conversion to columns by the same rules for every format.

use std::ops::Range;

use hysteron_model::record::{Unit, split_header};

use crate::IoError;
use crate::columns::{
    ArrayHeading, ColumnForm, Columns, Heading, Headings, Kind, Rate, SampleLines, shape_text,
};
use crate::place::{FilePart, Place};
use crate::reader::Input;

/// Most arrays of a file that are looked at.
pub(crate) const MAX_ARRAYS: usize = 1 << 16;
/// Longest path of an array in a format that composes it.
pub(crate) const MOST_PATH_BYTES: usize = 1024;
/// Most columns of a matrix; a larger one is an image or a table of something else.
const MAX_MATRIX_COLUMNS: usize = 16;
/// Relative tolerance for equal sample rates, as of a period written with few digits.
const RATE_TOLERANCE: f64 = 1e-6;

/// One array of a file.
#[derive(Clone, Debug)]
pub(crate) struct HeldArray {
    /// Where it stands: `rec.u`, `signals(2).values`, `group/channel`, `sheet!B`.
    pub path: String,
    /// Bytes of the path in front of its last component, to which the rules for names and units apply.
    pub group_bytes: usize,
    /// Unit that the file gives apart from the name.
    pub unit: Option<String>,
    pub shape: Vec<usize>,
    /// Whether the last index runs fastest in the list of values.
    pub row_major: bool,
    pub kind: Kind,
    /// Sample rate \[Hz\] that the file gives for this array.
    pub sample_rate_hz: Option<f64>,
    /// Time of its first sample \[s\], beside a rate.
    pub start_s: f64,
    /// Whether it is an alias, another path of an array above.
    pub is_alias: bool,
}

/// A column of an array.
struct Column {
    /// Number of the array.
    array: usize,
    slice: Slice,
    heading: Heading,
}

/// Part of an array.
#[derive(Clone, Copy)]
enum Slice {
    Whole,
    Column(usize),
    Row(usize),
}

impl HeldArray {
    /// An array without anything but name and shape; `group` with the separator behind it.
    pub fn new(group: &str, name: &str, shape: Vec<usize>, kind: Kind) -> Self {
        // Paths are shown in messages.
        let path = format!("{group}{name}").replace(char::is_control, "\u{FFFD}");
        let group_bytes = group.replace(char::is_control, "\u{FFFD}").len();
        HeldArray {
            path,
            group_bytes,
            unit: None,
            shape,
            row_major: true,
            kind,
            sample_rate_hz: None,
            start_s: 0.0,
            is_alias: false,
        }
    }

    /// Number of values; `None` on overflow.
    pub fn values(&self) -> Option<usize> {
        self.shape.iter().try_fold(1usize, |product, &n| product.checked_mul(n))
    }

    /// The last component of the path.
    fn name(&self) -> &str {
        self.path.get(self.group_bytes..).unwrap_or(&self.path)
    }

    /// The path in front of the last component.
    fn group(&self) -> &str {
        self.path.get(..self.group_bytes).unwrap_or_default()
    }

    /// Name and unit: that of the name, else the one the file gives.
    pub fn name_and_unit(&self) -> (String, Unit) {
        let (name, unit) = split_header(self.name());
        match self.unit.as_deref().map(str::trim) {
            Some(symbol) if unit.symbol().is_empty() && !symbol.is_empty() => {
                (name, Unit::new(&symbol.replace(char::is_control, "\u{FFFD}")))
            }
            _ => (name, unit),
        }
    }

    /// Rows and columns, lengths of 1 left out; `None` beyond two dimensions.
    fn matrix(&self) -> Option<(usize, usize)> {
        let mut lengths = self.shape.iter().copied().filter(|&n| n != 1);
        match (lengths.next(), lengths.next(), lengths.next()) {
            (rows, columns, None) => Some((rows.unwrap_or(1), columns.unwrap_or(1))),
            _ => None,
        }
    }

    /// The columns: a vector itself, those of a high matrix, the rows of a wide one. `None` for anything
    /// else.
    fn columns(&self, index: usize) -> Option<Vec<Column>> {
        let (rows, columns) = self.matrix()?;
        let (name, unit) = self.name_and_unit();
        let of = |slice, length| {
            let suffix = match slice {
                Slice::Whole => String::new(),
                Slice::Column(column) => format!("(:,{})", column + 1),
                Slice::Row(row) => format!("({},:)", row + 1),
            };
            let (path, name) = (&self.path, &name);
            let array = ArrayHeading {
                group_bytes: self.group_bytes,
                shape: self.shape.clone(),
                length: Some(length),
                kind: self.kind.clone(),
                is_alias: self.is_alias,
                has_rate: self.sample_rate_hz.is_some(),
            };
            let heading = Heading {
                header: format!("{path}{suffix}"),
                name: format!("{name}{suffix}"),
                unit: unit.clone(),
                array: Some(array),
            };
            Column { array: index, slice, heading }
        };
        match (rows, columns) {
            (length, 1) => Some(vec![of(Slice::Whole, length)]),
            _ if rows == 0 || columns == 0 || self.kind != Kind::Numbers => None,
            _ if columns <= MAX_MATRIX_COLUMNS && columns <= rows => {
                Some((0..columns).map(|column| of(Slice::Column(column), rows)).collect())
            }
            _ if rows <= MAX_MATRIX_COLUMNS => {
                Some((0..rows).map(|row| of(Slice::Row(row), columns)).collect())
            }
            _ => None,
        }
    }

    /// The array as an unusable column: listed, but refused where it is chosen.
    fn apart(&self, index: usize) -> Column {
        let (name, unit) = self.name_and_unit();
        let array = ArrayHeading {
            group_bytes: self.group_bytes,
            shape: self.shape.clone(),
            length: None,
            kind: self.kind.clone(),
            is_alias: self.is_alias,
            has_rate: self.sample_rate_hz.is_some(),
        };
        let heading = Heading { header: self.path.clone(), name, unit, array: Some(array) };
        Column { array: index, slice: Slice::Whole, heading }
    }

    /// One column of the array's values.
    fn slice(&self, values: &[f64], slice: Slice) -> Vec<f64> {
        let (rows, columns) = self.matrix().unwrap_or_default();
        let run = |range: Range<usize>| values.get(range).unwrap_or_default().to_vec();
        let strided = |first: usize, step: usize| values.iter().skip(first).step_by(step).copied().collect();
        match (slice, self.row_major) {
            (Slice::Whole, _) => values.to_vec(),
            (Slice::Column(column), true) => strided(column, columns),
            (Slice::Column(column), false) => run(column * rows..(column + 1) * rows),
            (Slice::Row(row), true) => run(row * columns..(row + 1) * columns),
            (Slice::Row(row), false) => strided(row, rows),
        }
    }
}

/// Shape of an array of MATLAB texts, without the dimension of their characters; empty for a single one.
pub(crate) fn shape_of_texts(letters: &[usize]) -> Vec<usize> {
    let texts = letters.split_last().map(|(_, texts)| texts).unwrap_or_default();
    if texts.iter().all(|&n| n == 1) { Vec::new() } else { texts.to_vec() }
}

/// Reads the wanted columns of a file that holds these arrays; `values` gives the numbers of one of them, in
/// the order of memory.
///
/// A vector is a column, whatever dimensions of length 1 it has besides; a matrix of at most 16 columns or
/// rows gives one column each. Single numbers are no columns where there are others, but may give the sample
/// rate.
pub(crate) fn columns(
    input: Input<'_>,
    held: &[HeldArray],
    sha256: String,
    mut values: impl FnMut(usize) -> Result<Vec<f64>, IoError>,
) -> Result<Columns, IoError> {
    let Input { file, options, file_bytes, wanted, .. } = input;
    let place = |path: &str| Place::new(file, FilePart::Array(path.into()));
    if held.len() > MAX_ARRAYS {
        let place = Place::new(file, FilePart::Whole);
        return Err(IoError::TooManyColumns { place, found: held.len(), limit: MAX_ARRAYS });
    }
    let (columns, headings) = headings(file, held);
    let wanted = wanted(&headings)?;
    let most = options.most_values(file_bytes);
    let mut left = most;
    let mut read = |array: &HeldArray, index| {
        let count = array.values().filter(|&count| count <= options.max_values);
        let place = || place(&array.path);
        let count =
            count.ok_or_else(|| IoError::TooManyValues { place: place(), limit: options.max_values })?;
        left = left.checked_sub(count).ok_or_else(|| match most < options.max_values {
            true => IoError::TooLarge { place: place(), limit_bytes: 8 * most as u64 },
            false => IoError::TooManyValues { place: place(), limit: most },
        })?;
        values(index)
    };
    let mut numbers: Vec<Vec<f64>> = Vec::new();
    // A matrix is read once for all of its columns.
    let mut last: Option<(usize, Vec<f64>)> = None;
    for (column, wanted) in columns.iter().zip(&wanted) {
        let array = &held[column.array];
        if *wanted == ColumnForm::Nothing {
            numbers.push(Vec::new());
            continue;
        }
        check(array, column, place(&array.path))?;
        let of_array = match last.take() {
            Some((index, values)) if index == column.array => values,
            _ => read(array, column.array)?,
        };
        if let Slice::Whole = column.slice {
            numbers.push(of_array);
        } else {
            numbers.push(array.slice(&of_array, column.slice));
            last = Some((column.array, of_array));
        }
    }
    drop(last);
    let is_wanted = |wanted: &ColumnForm| *wanted != ColumnForm::Nothing;
    let used: Vec<&Column> = columns
        .iter()
        .zip(&wanted)
        .filter(|(_, wanted)| is_wanted(wanted))
        .map(|(column, _)| column)
        .collect();
    let mut rates = Vec::new();
    for (index, array) in held.iter().enumerate() {
        let is_used = used.iter().any(|column| column.array == index);
        let is_near = || used.iter().any(|column| column.heading.header.starts_with(array.group()));
        if let Some(hz) = array.sample_rate_hz.filter(|_| is_used) {
            rates.push((usize::MAX, Rate { path: array.path.clone(), hz, start_s: array.start_s }));
        } else if let Some(to_hz) = rate_by_name(array.name())
            && array.is_one_number()
            && !is_used
            && is_near()
        {
            let hz = to_hz(read(array, index)?.first().copied().unwrap_or_default());
            rates.push((array.group_bytes, Rate { path: array.path.clone(), hz, start_s: 0.0 }));
        }
    }
    if let Some((_, rate)) = rates.iter().find(|(_, rate)| !(rate.hz.is_finite() && rate.hz > 0.0)) {
        return Err(IoError::BadRate { place: place(&rate.path), value: rate.hz });
    }
    let rate = nearest(rates, file, options.sample_rate_hz.is_some())?;
    let texts = vec![Vec::new(); headings.columns.len()];
    Ok(Columns { headings, values: numbers, texts, lines: SampleLines::default(), rate, sha256 })
}

/// The columns, followed by everything else in the file.
fn headings(file: &str, held: &[HeldArray]) -> (Vec<Column>, Headings) {
    let has_lists = held.iter().any(|array| array.kind == Kind::Numbers && array.values() != Some(1));
    let (mut columns, mut apart) = (Vec::new(), Vec::new());
    for (index, array) in held.iter().enumerate() {
        let is_column = !has_lists || array.values() != Some(1);
        match array.columns(index).filter(|_| is_column) {
            Some(of_array) => columns.extend(of_array),
            None => apart.push(array.apart(index)),
        }
    }
    columns.append(&mut apart);
    let headings = columns.iter().map(|column| column.heading.clone()).collect();
    (columns, Headings { file: file.to_owned(), line: None, columns: headings })
}

/// Rejects anything but a column of numbers.
fn check(array: &HeldArray, column: &Column, place: Place) -> Result<(), IoError> {
    if let Kind::Other(found) = &array.kind {
        return Err(IoError::ArrayType { place, found: found.clone() });
    }
    let length = column.heading.array.as_ref().and_then(|array| array.length);
    if length.is_none() {
        return Err(IoError::ArrayShape { place, found: shape_text(&array.shape) });
    }
    Ok(())
}

impl HeldArray {
    fn is_one_number(&self) -> bool {
        self.kind == Kind::Numbers && self.values() == Some(1)
    }
}

/// The rate nearest to the columns by path; those equally near must agree, unless the user gives one.
fn nearest(rates: Vec<(usize, Rate)>, file: &str, is_given: bool) -> Result<Option<Rate>, IoError> {
    let Some(near) = rates.iter().map(|(near, _)| *near).max() else { return Ok(None) };
    let mut rates = rates.into_iter().filter(|(own, _)| *own == near).map(|(_, rate)| rate);
    let first = rates.next();
    let differs = |first: &Rate, other: &Rate| (other.hz / first.hz - 1.0).abs() > RATE_TOLERANCE;
    match first
        .as_ref()
        .and_then(|first| rates.find(|other| differs(first, other)).map(|other| (first, other)))
    {
        Some((first, other)) if !is_given => Err(IoError::ChooseRate {
            place: Place::new(file, FilePart::Array(other.path.as_str().into())),
            hz: other.hz,
            other: first.path.clone(),
            other_hz: first.hz,
        }),
        _ => Ok(first),
    }
}

/// Conversion of a number of this name to the sample rate \[Hz\]; `None` for other names.
fn rate_by_name(name: &str) -> Option<fn(f64) -> f64> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ReadOptions;

    fn channel(name: &str, sample_rate_hz: f64) -> HeldArray {
        let array = HeldArray::new("run/", name, vec![3], Kind::Numbers);
        HeldArray { sample_rate_hz: Some(sample_rate_hz), ..array }
    }

    /// The rate of a file of these channels where the last ones are read.
    fn rate(held: &[HeldArray], read: usize) -> Result<Option<f64>, IoError> {
        let wanted = &mut |headings: &Headings| {
            let first = headings.columns.len() - read;
            let of = |i| if i < first { ColumnForm::Nothing } else { ColumnForm::Numbers };
            Ok((0..headings.columns.len()).map(of).collect())
        };
        let options = &ReadOptions::default();
        let input = Input { file: "run", bytes: &mut std::io::empty(), options, file_bytes: 0, wanted };
        let columns = columns(input, held, String::new(), |_| Ok(vec![1.0, 2.0, 3.0]))?;
        Ok(columns.rate.map(|rate| rate.hz))
    }

    #[test]
    fn a_channel_has_its_own_rate_and_not_that_of_one_whose_name_its_name_begins_with() {
        let held = [channel("u", 10.0), channel("u2", 50.0), channel("y2", 50.0)];
        assert_eq!(rate(&held, 2).unwrap(), Some(50.0));
        let differ = rate(&held, 3).unwrap_err().to_string();
        assert!(differ.contains("`run/u2`: 50 Hz, but 10 Hz by `run/u`"), "{differ}");
    }
}
