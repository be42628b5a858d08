//! LVM: measurements as text, as LabVIEW writes them: a header block, then for each segment its header and
//! its columns.

use std::collections::HashMap;

use crate::IoError;
use crate::columns::{Columns, Kind};
use crate::container::{self, HeldArray};
use crate::hash::sha256;
use crate::laboratory_text::{KeptNumbers, Text};
use crate::options::MAX_COLUMNS;
use crate::place::{FilePart, Place};
use crate::reader::{Input, Reader};

/// Measurement files of LabVIEW.
pub(crate) const READER: Reader =
    Reader { extensions: &[], recognises: |head| head.starts_with(b"LabVIEW Measurement"), read };

const FORMAT: &str = "LVM";
const END_OF_HEADER: &str = "***End_of_Header***";

/// Column format of the file.
struct Layout {
    separator: char,
    decimal_comma: bool,
    /// Whether each channel has its own column of x.
    multiple_x: bool,
}

/// A block of columns below one header.
#[derive(Default)]
struct Segment {
    channels: Vec<Channel>,
    rows: usize,
}

/// A channel and its values.
#[derive(Default)]
struct Channel {
    name: String,
    unit: String,
    /// Field of its x, and of its values.
    x_field: Option<usize>,
    field: usize,
    start: f64,
    step: f64,
    /// Whether x is time.
    is_time: bool,
    x: Vec<f64>,
    values: Vec<f64>,
}

fn read(mut input: Input<'_>) -> Result<Columns, IoError> {
    let bytes = input.read_to_end()?;
    let text = Text::new(input.file, &bytes);
    let segments = join(segments(&text, &mut KeptNumbers::new(&input))?);
    if segments.is_empty() {
        return Err(text.malformed(FORMAT, 1, "it has no columns below its header".to_owned()));
    }
    let (mut held, mut values) = (Vec::new(), Vec::new());
    let several = segments.len() > 1;
    for (number, segment) in segments.into_iter().enumerate() {
        let group = if several { format!("segment {}/", number + 1) } else { String::new() };
        let one_x = segment.channels.iter().all(|channel| channel.x_field == segment.channels[0].x_field);
        for (place, channel) in segment.channels.into_iter().enumerate() {
            let is_uniform = channel.follows_its_step();
            let group = if one_x { group.clone() } else { format!("{group}{}/", channel.name) };
            if channel.x_field.is_some() && !is_uniform && (place == 0 || !one_x) {
                let mut x = HeldArray::new(
                    &group,
                    if channel.is_time { "time" } else { "x" },
                    vec![channel.x.len()],
                    Kind::Numbers,
                );
                x.unit = channel.is_time.then(|| "s".to_owned());
                held.push(x);
                values.push(channel.x);
            }
            let mut array = HeldArray::new(&group, &channel.name, vec![channel.values.len()], Kind::Numbers);
            array.unit = Some(channel.unit).filter(|unit| !unit.is_empty());
            if is_uniform && channel.is_time {
                array.sample_rate_hz = Some(channel.step.recip());
                array.start_s = channel.start;
            }
            held.push(array);
            values.push(channel.values);
        }
    }
    container::columns(input, &held, sha256(&bytes), |index| Ok(std::mem::take(&mut values[index])))
}

impl Channel {
    /// Whether x agrees with start and step of the header to half a step: its text is then a rounding of it.
    fn follows_its_step(&self) -> bool {
        let expected = |k: usize| self.start + k as f64 * self.step;
        self.step > 0.0
            && self.step.is_finite()
            && self.x.iter().enumerate().all(|(k, x)| (x - expected(k)).abs() <= 0.5 * self.step)
    }

    /// The x after the last one.
    fn next_x(&self) -> f64 {
        self.start + self.values.len() as f64 * self.step
    }
}

/// All segments of a file.
fn segments(text: &Text<'_>, kept: &mut KeptNumbers) -> Result<Vec<Segment>, IoError> {
    let mut segments: Vec<Segment> = Vec::new();
    let mut layout: Option<Layout> = None;
    let mut header: HashMap<&str, Vec<&str>> = HashMap::new();
    let mut special = false;
    // The line below a segment's header names its columns.
    let mut names_follow = false;
    for (line, content) in text.lines() {
        let trimmed = content.trim();
        if trimmed.starts_with("***Start_Special***") || trimmed.starts_with("***End_Special***") {
            special = trimmed.starts_with("***Start");
            continue;
        }
        if special || trimmed.trim_matches([',', ';']).is_empty() && !names_follow {
            continue;
        }
        let Some(Layout { separator, decimal_comma, multiple_x }) = layout else {
            if trimmed.starts_with(END_OF_HEADER) {
                layout = Some(Layout::new(text, &std::mem::take(&mut header), line)?);
            } else {
                let mut fields = content.split(['\t', ',', ';']);
                header.insert(fields.next().unwrap_or_default().trim(), fields.map(str::trim).collect());
            }
            continue;
        };
        let mut fields = content.split(separator);
        let first = fields.next().unwrap_or_default().trim();
        if trimmed.starts_with(END_OF_HEADER) {
            names_follow = true;
        } else if names_follow {
            segments.push(Segment::new(
                text,
                content.split(separator),
                multiple_x,
                &std::mem::take(&mut header),
                line,
                decimal_comma,
            )?);
            names_follow = false;
        } else if !first.is_empty()
            && first.starts_with(|c: char| c.is_ascii_alphabetic())
            && !is_number(first)
        {
            header.insert(first, fields.map(str::trim).collect());
        } else if let Some(segment) = segments.last_mut() {
            segment.push_row(text, content, separator, decimal_comma, line, kept)?;
        } else {
            let place = Place::new(text.file, FilePart::Line(line));
            return Err(IoError::NoHeader {
                place,
                columns: 1 + fields.count(),
                suggestion: "X_Value".to_owned(),
            });
        }
    }
    Ok(segments)
}

/// NaN and infinities begin with letters, too.
fn is_number(text: &str) -> bool {
    text.parse::<f64>().is_ok()
}

impl Layout {
    fn new(text: &Text<'_>, header: &HashMap<&str, Vec<&str>>, line: u64) -> Result<Self, IoError> {
        let entry =
            |key: &str| header.get(key).and_then(|values| values.first().copied()).unwrap_or_default();
        let separator = match entry("Separator").to_lowercase().as_str() {
            "" | "tab" => '\t',
            "comma" => ',',
            "semicolon" => ';',
            other => {
                return Err(text.malformed(
                    FORMAT,
                    line,
                    format!("its separator is `{other}`, expected Tab or Comma"),
                ));
            }
        };
        // A comma as separator splits its own line and is lost.
        let decimal_comma = header.contains_key("Decimal_Separator") && entry("Decimal_Separator") != ".";
        if decimal_comma && separator == ',' {
            let problem = "commas separate both columns and decimals".to_owned();
            return Err(text.malformed(FORMAT, line, problem));
        }
        Ok(Layout { separator, decimal_comma, multiple_x: entry("X_Columns").eq_ignore_ascii_case("multi") })
    }
}

impl Segment {
    /// A segment of these columns: `X_Value`, names of channels, `Comment`.
    fn new<'a>(
        text: &Text<'_>,
        names: impl Iterator<Item = &'a str>,
        multiple_x: bool,
        header: &HashMap<&str, Vec<&str>>,
        line: u64,
        decimal_comma: bool,
    ) -> Result<Self, IoError> {
        let mut segment = Segment::default();
        let mut x_field = None;
        for (field, name) in names.map(str::trim).enumerate() {
            match name {
                "X_Value" => x_field = Some(field),
                "Comment" => break,
                "" => {}
                name => {
                    let number = segment.channels.len();
                    let entry = |key: &str| {
                        let Some(values) = header.get(key) else { return "" };
                        // Where each channel has its x, entries may stand above the channels, or one behind
                        // the other.
                        let above = multiple_x && values.get(1).is_some_and(|value| value.is_empty());
                        values
                            .get(if above { field.saturating_sub(1) } else { number })
                            .copied()
                            .unwrap_or_default()
                    };
                    let value =
                        |key: &str| text.number(entry(key), decimal_comma, line, 0).unwrap_or_default();
                    let dimension = entry("X_Dimension");
                    segment.channels.push(Channel {
                        name: name.to_owned(),
                        unit: unit(entry("Y_Unit_Label")).to_owned(),
                        x_field,
                        field,
                        start: value("X0"),
                        step: value("Delta_X"),
                        is_time: dimension.is_empty() || dimension.eq_ignore_ascii_case("time"),
                        ..Channel::default()
                    });
                    if multiple_x {
                        x_field = None;
                    }
                }
            }
            if segment.channels.len() > MAX_COLUMNS {
                let (place, found) = (Place::new(text.file, FilePart::Line(line)), segment.channels.len());
                return Err(IoError::TooManyColumns { place, found, limit: MAX_COLUMNS });
            }
        }
        if segment.channels.is_empty() {
            return Err(text.malformed(
                FORMAT,
                line,
                "no names of channels stand below its header".to_owned(),
            ));
        }
        Ok(segment)
    }

    fn push_row(
        &mut self,
        text: &Text<'_>,
        row: &str,
        separator: char,
        decimal_comma: bool,
        line: u64,
        kept: &mut KeptNumbers,
    ) -> Result<(), IoError> {
        let fields: Vec<&str> = row.split(separator).collect();
        let field = |i: usize| fields.get(i).map_or("", |field| field.trim());
        for channel in &mut self.channels {
            // A channel may end before the others; a gap within it is found by the next value.
            if field(channel.field).is_empty() {
                continue;
            }
            if channel.values.len() < self.rows {
                let place = Place::cell(text.file, line - 1, channel.field + 1, &channel.name);
                return Err(IoError::MissingValue { place });
            }
            kept.add(text.file)?;
            channel.values.push(text.number(field(channel.field), decimal_comma, line, channel.field)?);
            // Where x is not written its column is empty.
            if let Some(x) = channel.x_field.filter(|&x| !field(x).is_empty()) {
                kept.add(text.file)?;
                channel.x.push(text.number(field(x), decimal_comma, line, x)?);
            }
        }
        self.rows += 1;
        Ok(())
    }

    /// Whether the segment continues the channels of the previous one in time.
    fn continues(&self, before: &Segment) -> bool {
        let goes_on = |(own, before): (&Channel, &Channel)| {
            let gap = match (own.x.first(), before.x.last()) {
                (Some(first), Some(last)) => *first > *last,
                _ => (own.start - before.next_x()).abs() <= 0.1 * before.step,
            };
            (&own.name, &own.unit, own.step) == (&before.name, &before.unit, before.step) && gap
        };
        self.channels.len() == before.channels.len()
            && self.channels.iter().zip(&before.channels).all(goes_on)
    }
}

/// Joins segments that continue the previous ones.
fn join(segments: Vec<Segment>) -> Vec<Segment> {
    let mut joined: Vec<Segment> = Vec::new();
    for mut segment in segments {
        match joined.last_mut() {
            Some(before) if segment.continues(before) => {
                for (channel, more) in before.channels.iter_mut().zip(&mut segment.channels) {
                    channel.x.append(&mut more.x);
                    channel.values.append(&mut more.values);
                }
            }
            _ => joined.push(segment),
        }
    }
    for channel in joined.iter_mut().flat_map(|segment| &mut segment.channels) {
        if channel.x.len() != channel.values.len() {
            channel.x_field = None;
            channel.x.clear();
        }
    }
    joined
}

/// The symbol of a unit that LabVIEW writes as a word.
fn unit(label: &str) -> &str {
    match label {
        "Volts" | "Volt" | "volts" => "V",
        "Amps" | "Ampere" => "A",
        "Meters" | "meters" => "m",
        "Newtons" => "N",
        other => other,
    }
}
