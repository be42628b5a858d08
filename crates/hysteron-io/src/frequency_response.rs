//! Columns to frequency response.

use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::io::Read;
use std::path::Path;

use hysteron_model::record::FrequencyResponse;
use hysteron_model::record::{Source, Unit, split_header};
use hysteron_numeric::Complex64;

use crate::columns::{ColumnForm, Columns, Heading, Headings, SEPARATORS};
use crate::read::{open, read_columns};
use crate::{IoError, ReadOptions, ResponseFileError};

/// Choice among a file's responses.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ResponseOptions {
    /// Name of the response, the prefix of its columns before `_re`, `_im` and the like; needed for several.
    pub response: Option<String>,
    /// Name of a response that it is divided by, e.g. an amplifier's, measured from the same command.
    pub over: Option<String>,
    /// Largest file read \[bytes\]; `None`: as for records.
    pub max_bytes: Option<u64>,
}

/// Reads a frequency response.
///
/// Columns: frequency `f`, `freq` or `frequency` in Hz (or `f_kHz`, `f_MHz`, `omega_rad_per_s`); real and
/// imaginary part `re`, `im`, or magnitude and phase `magnitude` (`magnitude_dB`), `phase_deg` (`phase_rad`),
/// each behind a name and an underscore where there are several responses (`stage_re`, `ampV_re`); with or
/// without a standard deviation `std` (√E|error|², of the complex value). A unit stands at the end
/// (`re_um_per_V`). Other columns are not read. Lines may be in any order; frequencies must differ and be
/// above 0.
///
/// # Errors
/// Any [`IoError`]; it names the file, and line and column where there are any.
pub fn read_frequency_response(path: &Path, options: &ResponseOptions) -> Result<FrequencyResponse, IoError> {
    read(&path.display().to_string(), open(path)?, options)
}

/// [`read_frequency_response`] from memory; `name` stands for the file in messages.
///
/// # Errors
/// Those of [`read_frequency_response`].
pub fn read_frequency_response_bytes(
    name: &str,
    bytes: &[u8],
    options: &ResponseOptions,
) -> Result<FrequencyResponse, IoError> {
    read(name, bytes, options)
}

fn read(file: &str, source: impl Read, options: &ResponseOptions) -> Result<FrequencyResponse, IoError> {
    let defaults = ReadOptions::default();
    let limits = ReadOptions { max_bytes: options.max_bytes.unwrap_or(defaults.max_bytes), ..defaults };
    let wanted = |headings: &Headings| Ok(Layout::new(headings, options)?.wanted(headings.columns.len()));
    let mut columns = read_columns(file, source, &limits, wanted)?;
    let layout = Layout::new(&columns.headings, options)?;
    columns.check_lengths(layout.frequency.0, layout.parts())?;
    to_hertz(&mut columns, layout.frequency)?;
    let failed = |source| ResponseFileError::Unusable { file: file.to_string(), source: Box::new(source) };
    let mut response = layout.response.assemble(file, &columns.values, layout.frequency.0)?;
    if let Some(over) = &layout.over {
        let over = over.assemble(file, &columns.values, layout.frequency.0)?;
        response = response.over(&over).map_err(failed)?;
    }
    response.source = Some(Source { path: file.to_string(), sha256: columns.sha256 });
    Ok(response)
}

/// Converts the frequency column to hertz by a factor; all must be positive.
fn to_hertz(columns: &mut Columns, (column, factor): (usize, f64)) -> Result<(), ResponseFileError> {
    let values = columns.values.get_mut(column).map(Vec::as_mut_slice).unwrap_or_default();
    let below = values.iter().position(|&value| value.is_nan() || value * factor <= 0.0);
    if let Some(at) = below {
        let found = values[at].to_string();
        return Err(ResponseFileError::BadFrequency { place: columns.place(column, at), found });
    }
    values.iter_mut().for_each(|value| *value *= factor);
    Ok(())
}

/// The part of a complex number that a column holds.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ComplexPart {
    Real,
    Imaginary,
    Magnitude,
    Decibels,
    /// With its factor to radians.
    Phase(f64),
    Deviation,
}

/// The columns of one response.
#[derive(Clone, Debug, Default)]
struct Group {
    name: String,
    unit: String,
    parts: Vec<(ComplexPart, usize)>,
}

/// Columns of frequency and the wanted responses.
struct Layout {
    /// Column, and its factor to hertz.
    frequency: (usize, f64),
    response: Group,
    over: Option<Group>,
}

impl Layout {
    fn new(headings: &Headings, options: &ResponseOptions) -> Result<Self, ResponseFileError> {
        let columns = &headings.columns;
        let place = || headings.place();
        let is_read = |column: &Heading| !column.is_unreadable() && !column.is_alias();
        let readable = columns.iter().enumerate().filter(|(_, column)| is_read(column));
        let frequencies: Vec<(usize, f64)> =
            readable.clone().filter_map(|(i, c)| Some((i, hertz(c)?))).collect();
        if frequencies.is_empty() {
            return Err(ResponseFileError::NoFrequency { place: place(), found: headings.list() });
        }
        let mut groups: Vec<Group> = Vec::new();
        for (i, column) in readable.filter(|(_, column)| hertz(column).is_none()) {
            let Some((name, part, unit)) = part_of(column) else { continue };
            let name = match (column.group().trim_end_matches(SEPARATORS), name.is_empty()) {
                ("", _) => name,
                (group, true) => group.to_owned(),
                (_, false) => format!("{}{name}", column.group()),
            };
            let index = groups.iter().position(|g| g.name == name).unwrap_or_else(|| {
                groups.push(Group { name, ..Group::default() });
                groups.len() - 1
            });
            let group = &mut groups[index];
            if group.unit.is_empty() {
                group.unit = unit;
            }
            group.parts.push((part, i));
        }
        groups.retain(Group::is_complete);
        if groups.is_empty() {
            return Err(ResponseFileError::NoResponse { place: place(), found: headings.list() });
        }
        let available = groups.iter().map(|g| format!("`{}`", g.shown_name())).collect::<Vec<_>>().join(", ");
        let choose = |problem: String, divisor| ResponseFileError::Choose {
            place: place(),
            problem,
            available: available.clone(),
            divisor,
        };
        let named = |asked: &str, divisor| {
            let same = |g: &&Group| g.shown_name() == asked.trim();
            let found = groups.iter().find(same).cloned();
            found.ok_or_else(|| choose(format!("no response `{}`", asked.trim()), divisor))
        };
        let response = match (&options.response, groups.as_slice()) {
            (Some(asked), _) => named(asked, false)?,
            (None, [only]) => only.clone(),
            _ => return Err(choose(format!("{} responses", groups.len()), false)),
        };
        let over = options.over.as_deref().map(|asked| named(asked, true)).transpose()?;
        let frequency = nearest_frequency(columns, &frequencies, &response);
        if let Some(over) = &over
            && nearest_frequency(columns, &frequencies, over) != frequency
        {
            return Err(choose(format!("`{}` has frequencies of its own", over.shown_name()), true));
        }
        let Some(frequency) = frequency else {
            return Err(ResponseFileError::NoFrequency { place: place(), found: headings.list() });
        };
        Ok(Self { frequency, response, over })
    }

    /// Columns of the responses.
    fn parts(&self) -> impl Iterator<Item = usize> {
        let groups = [Some(&self.response), self.over.as_ref()].into_iter().flatten();
        groups.flat_map(|group| group.parts.iter().map(|&(_, column)| column))
    }

    /// Which of the file's columns are read.
    fn wanted(&self, columns: usize) -> Vec<ColumnForm> {
        let is_read = |i| i == self.frequency.0 || self.parts().any(|part| part == i);
        (0..columns).map(|i| if is_read(i) { ColumnForm::Numbers } else { ColumnForm::Nothing }).collect()
    }
}

impl Group {
    /// Column of a part.
    fn column(&self, is: impl Fn(ComplexPart) -> bool) -> Option<(ComplexPart, usize)> {
        self.parts.iter().find(|(part, _)| is(*part)).copied()
    }

    fn magnitude(&self) -> Option<(ComplexPart, usize)> {
        self.column(|p| matches!(p, ComplexPart::Magnitude | ComplexPart::Decibels))
    }

    fn phase(&self) -> Option<(ComplexPart, usize)> {
        self.column(|p| matches!(p, ComplexPart::Phase(_)))
    }

    fn is_complete(&self) -> bool {
        let has = |part| self.column(|p| p == part).is_some();
        has(ComplexPart::Real) && has(ComplexPart::Imaginary)
            || self.magnitude().is_some() && self.phase().is_some()
    }

    fn shown_name(&self) -> &str {
        if self.name.is_empty() { "response" } else { &self.name }
    }

    fn assemble(
        &self,
        file: &str,
        columns: &[Vec<f64>],
        frequency: usize,
    ) -> Result<FrequencyResponse, ResponseFileError> {
        let column = |i: usize| columns.get(i).map_or(&[][..], Vec::as_slice);
        let of = |part| self.column(|p| p == part).map(|(_, i)| column(i));
        let values: Vec<Complex64> = match (of(ComplexPart::Real), of(ComplexPart::Imaginary)) {
            (Some(re), Some(im)) => re.iter().zip(im).map(|(&re, &im)| Complex64::new(re, im)).collect(),
            _ => match (self.magnitude(), self.phase()) {
                (Some((kind, magnitude)), Some((ComplexPart::Phase(factor), phase))) => {
                    let size = |x: f64| if kind == ComplexPart::Decibels { 10f64.powf(x / 20.0) } else { x };
                    let pairs = column(magnitude).iter().zip(column(phase));
                    pairs.map(|(&m, &p)| Complex64::from_polar(size(m), factor * p)).collect()
                }
                _ => Vec::new(),
            },
        };
        let frequencies = column(frequency);
        let mut order: Vec<usize> = (0..frequencies.len()).collect();
        order.sort_by(|&a, &b| frequencies[a].total_cmp(&frequencies[b]));
        if let Some(two) = order.windows(2).find(|two| frequencies[two[0]] == frequencies[two[1]]) {
            let frequency_hz = frequencies[two[0]];
            return Err(ResponseFileError::RepeatedFrequency { file: file.to_string(), frequency_hz });
        }
        let response = FrequencyResponse {
            name: self.shown_name().to_string(),
            frequency_hz: order.iter().map(|&i| frequencies[i]).collect(),
            values: order.iter().filter_map(|&i| values.get(i).copied()).collect(),
            std_dev: of(ComplexPart::Deviation).map(|s| order.iter().map(|&i| s[i]).collect()),
            unit: self.unit.clone(),
            source: None,
        };
        response.check().map_err(|source| ResponseFileError::Unusable {
            file: file.to_string(),
            source: Box::new(source),
        })?;
        Ok(response)
    }
}

/// Frequency column, with its factor to hertz, in the group of the response or the nearest enclosing one.
fn nearest_frequency(
    columns: &[Heading],
    frequencies: &[(usize, f64)],
    response: &Group,
) -> Option<(usize, f64)> {
    let group_of = |i: usize| columns.get(i).map(Heading::group).unwrap_or_default();
    let own = response.parts.first().map(|&(_, column)| group_of(column)).unwrap_or_default();
    let nearness = |(i, _): &&(usize, f64)| {
        let group = group_of(*i);
        (own.starts_with(group).then_some(group.len()), Reverse(*i))
    };
    frequencies.iter().max_by_key(nearness).copied()
}

/// Factor to hertz of a frequency column.
fn hertz(column: &Heading) -> Option<f64> {
    let name = column.name.to_lowercase();
    match (name.as_str(), column.unit.symbol()) {
        ("f" | "freq" | "frequency", "" | "Hz") => Some(1.0),
        ("f" | "freq" | "frequency", "kHz") => Some(1e3),
        ("f" | "freq" | "frequency", "MHz") => Some(1e6),
        ("omega" | "w" | "frequency", "rad_per_s" | "rad/s") => Some(std::f64::consts::TAU.recip()),
        _ => None,
    }
}

/// Response that a column belongs to, the part it holds, and the unit it gives.
fn part_of(column: &Heading) -> Option<(String, ComplexPart, String)> {
    let unit = column.unit.symbol();
    let lower = column.name.to_lowercase();
    let (text, decibels) = match lower.strip_suffix("_db") {
        Some(rest) => (rest, true),
        None => (lower.as_str(), unit.eq_ignore_ascii_case("dB")),
    };
    let last = text.rsplit('_').next().unwrap_or(text);
    let part = match last {
        "re" | "real" => ComplexPart::Real,
        "im" | "imag" | "imaginary" => ComplexPart::Imaginary,
        "magnitude" | "mag" | "abs" | "gain" | "amplitude" if decibels => ComplexPart::Decibels,
        "magnitude" | "mag" | "abs" | "gain" | "amplitude" => ComplexPart::Magnitude,
        "phase" | "arg" | "angle" => match unit {
            "" | "deg" | "°" => ComplexPart::Phase(1f64.to_radians()),
            "rad" => ComplexPart::Phase(1.0),
            "mrad" => ComplexPart::Phase(1e-3),
            _ => return None,
        },
        "std" | "sigma" | "stddev" | "uncertainty" => ComplexPart::Deviation,
        _ => return None,
    };
    // The text before the part is the response's name, in the letters of the file.
    let before = text.len() - last.len();
    let name = column.name.get(..before)?.trim_end_matches('_');
    let (name, unit_before) =
        if name.is_empty() { (String::new(), Unit::new("")) } else { split_header(name) };
    let own = if decibels || matches!(part, ComplexPart::Phase(_)) { "" } else { unit };
    let unit = if unit_before.symbol().is_empty() { own } else { unit_before.symbol() };
    Some((name, part, unit.to_string()))
}
