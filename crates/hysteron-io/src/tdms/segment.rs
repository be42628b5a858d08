//! Segments of a TDMS file: which objects it holds, and where their raw data stand.

use std::collections::HashMap;

use super::number::DataType;
use super::property::{Properties, is_read, read_value};
use crate::bytes::Bytes;
use crate::container::MOST_PATH_BYTES;
use crate::place::shown;

/// First bytes of a segment.
pub(super) const TAG: &[u8] = b"TDSm";
/// Bytes in front of the metadata: tag, contents, version, length of the segment, length of the metadata.
const LEAD_IN_BYTES: usize = 28;
/// Length of a segment whose writing was interrupted.
const UNKNOWN: u64 = u64::MAX;
/// Most objects of a file: channels, groups, and the file itself.
const MAX_OBJECTS: usize = 1 << 12;
/// Most places of channels in the layouts of all segments together, and most visits to them.
const MAX_PARTS: usize = 1 << 22;
const MAX_VISITS: usize = 1 << 27;
/// Most properties of all objects together, of those that are read.
const MAX_PROPERTIES: usize = 1 << 18;
const TOO_MANY_CHANGES: &str =
    "it has too many channels in too many segments to be read; defragment the file";
/// Index of an object without data, and of one with the data of the last segment.
const NO_DATA: u32 = 0xFFFF_FFFF;
const SAME_AS_BEFORE: u32 = 0;
/// Index of an object with raw data of a DAQmx device: of analogue channels, of digital lines.
const DAQMX: u32 = 0x1269;
const DAQMX_LINES: u32 = 0x1369;

/// The file, a group or a channel.
pub(super) struct Object {
    /// Names of group and channel.
    pub path: Vec<String>,
    pub properties: Properties,
    /// Type of its values, where they are not read as numbers.
    pub refused: Option<String>,
    /// Whether it is a channel of timestamps.
    pub timestamps: bool,
    /// Number of its values.
    pub values: u64,
    last_index: Option<Index>,
    /// Its place in the list of objects of the current segment.
    listed: Option<usize>,
}

/// Raw-data index of an object: its values in one chunk of a segment.
#[derive(Clone, Copy, PartialEq)]
enum Index {
    Values { data_type: DataType, values: u64, bytes: u64 },
    Daqmx { values: u64 },
}

/// Values of a channel in each chunk of a segment.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct ChannelValues {
    pub object: usize,
    pub data_type: DataType,
    pub values: u64,
    pub bytes: u64,
    /// Bytes in front of them in a whole chunk.
    pub offset: u64,
    /// Bytes in front of a value in a row of interleaved channels.
    pub offset_in_row: u32,
}

/// Layout of the chunks of a segment, in this order.
#[derive(Default, PartialEq)]
pub(super) struct Layout {
    pub parts: Vec<ChannelValues>,
    pub chunk_bytes: u64,
    /// Bytes of a row of interleaved channels.
    pub row_bytes: usize,
    /// Places of the parts in the order of their objects.
    places: Vec<u32>,
    /// Whether all channels have equally many values, of a known size, in a chunk: only then can they be
    /// interleaved.
    equally_many: bool,
    /// Whether all values have a known size.
    sized: bool,
    /// Objects with data of a DAQmx device, and number of their values in a chunk; then the parts are no use.
    daqmx: Vec<(usize, u64)>,
}

/// A last chunk of a segment that is not whole: of each part the number of its values and their place.
#[derive(Clone, Copy, Default)]
pub(super) struct Rest {
    pub values: u64,
    /// Bytes in front of them in the chunk.
    pub offset: u64,
}

/// Key of an incomplete last chunk: layout, bytes, interleaved, cut off.
type RestKey = (usize, u64, bool, bool);

/// Raw data of a segment.
pub(super) struct Segment {
    pub start: usize,
    pub bytes: usize,
    /// Number of its layout.
    pub layout: usize,
    pub interleaved: bool,
    pub big_endian: bool,
    /// Whether the file ends within it.
    pub cut_off: bool,
    /// Number of its incomplete last chunk.
    pub rest: Option<usize>,
}

/// Objects and segments of a file.
#[derive(Default)]
pub(super) struct Contents {
    pub objects: Vec<Object>,
    pub layouts: Vec<Layout>,
    pub segments: Vec<Segment>,
    /// Last chunks that are not whole, one value a part of their layouts.
    pub rests: Vec<Vec<Rest>>,
    rest_numbers: HashMap<RestKey, usize>,
    by_path: HashMap<String, usize>,
    /// Objects of the current segment with their raw-data indices.
    list: Vec<(usize, Option<Index>)>,
    parts: usize,
    visits: usize,
    /// Number of the properties kept.
    properties: usize,
}

impl Contents {
    /// Reads the metadata of all segments. An error says what is wrong with them.
    pub fn read(file: &[u8]) -> Result<Self, String> {
        let mut contents = Contents::default();
        let mut start = 0;
        let mut layout = None;
        while let Some(lead_in) = file.get(start..start + LEAD_IN_BYTES) {
            if !lead_in.starts_with(TAG) {
                return Err(format!("at byte {start} no segment begins (`TDSm`)"));
            }
            let mut bytes = Bytes::new(lead_in, false);
            bytes.take(TAG.len())?;
            let flags = bytes.u32()?;
            let flag = |bit: u32| flags & (1 << bit) != 0;
            let (metadata, new_list, raw, interleaved, big_endian) =
                (flag(1), flag(2), flag(3), flag(5), flag(6));
            bytes.big_endian = big_endian;
            bytes.u32()?;
            let (length, metadata_length) = (bytes.u64()?, bytes.u64()?);
            let body = start + LEAD_IN_BYTES;
            let in_file = |length: u64| usize::try_from(length).ok().and_then(|n| n.checked_add(body));
            let end = in_file(length).filter(|&end| length != UNKNOWN && end <= file.len());
            let cut_off = end.is_none();
            let end = end.unwrap_or(file.len());
            let Some(data) = in_file(metadata_length).filter(|&data| data <= end) else {
                if cut_off {
                    break;
                }
                return Err(format!(
                    "the metadata of the segment at byte {start} are longer than the segment"
                ));
            };
            if metadata {
                let metadata = Bytes::new(file.get(body..data).unwrap_or_default(), big_endian);
                let read = contents.read_metadata(metadata, new_list);
                read.map_err(|problem| format!("metadata of the segment at byte {start}: {problem}"))?;
                layout = None;
            }
            if raw && data < end {
                let current = match layout {
                    Some(current) => current,
                    None => contents.current_layout()?,
                };
                layout = Some(current);
                let bytes = end - data;
                contents.push(Segment {
                    start: data,
                    bytes,
                    layout: current,
                    interleaved,
                    big_endian,
                    cut_off,
                    rest: None,
                })?;
            }
            start = end;
        }
        Ok(contents)
    }

    /// Applies the metadata of one segment.
    fn read_metadata(&mut self, mut bytes: Bytes<'_>, new_list: bool) -> Result<(), String> {
        if new_list {
            for (object, _) in self.list.drain(..) {
                self.objects[object].listed = None;
            }
        }
        for _ in 0..bytes.u32()? {
            let path = bytes.raw_text()?;
            if path.len() > MOST_PATH_BYTES {
                return Err(format!("a path of more than {MOST_PATH_BYTES} bytes"));
            }
            let path = String::from_utf8_lossy(path).into_owned();
            let number = match self.by_path.get(&path) {
                Some(&number) => number,
                None => self.add(path)?,
            };
            let index = self.read_index(&mut bytes, number)?;
            let object = &mut self.objects[number];
            match object.listed {
                Some(place) => self.list[place].1 = index,
                None => {
                    object.listed = Some(self.list.len());
                    self.list.push((number, index));
                }
            }
            for _ in 0..bytes.u32()? {
                let name = bytes.raw_text()?;
                let value = read_value(&mut bytes)?;
                if is_read(name) {
                    let name = String::from_utf8_lossy(name).into_owned();
                    self.properties +=
                        usize::from(self.objects[number].properties.insert(name, value).is_none());
                }
                if self.properties > MAX_PROPERTIES {
                    return Err(format!("more than {MAX_PROPERTIES} properties of scales"));
                }
            }
        }
        Ok(())
    }

    fn add(&mut self, path: String) -> Result<usize, String> {
        let number = self.objects.len();
        if number == MAX_OBJECTS {
            return Err(format!("more than {MAX_OBJECTS} objects"));
        }
        self.objects.push(Object {
            path: components(&path)
                .ok_or_else(|| format!("`{}` is no path of an object", shown(path.as_bytes())))?,
            properties: Properties::new(),
            refused: None,
            timestamps: false,
            values: 0,
            last_index: None,
            listed: None,
        });
        self.by_path.insert(path, number);
        Ok(number)
    }

    /// Reads the raw-data index of an object; `None` without data.
    fn read_index(&mut self, bytes: &mut Bytes<'_>, number: usize) -> Result<Option<Index>, String> {
        let object = &mut self.objects[number];
        let index = match bytes.u32()? {
            NO_DATA => return Ok(None),
            SAME_AS_BEFORE => {
                let missing =
                    || format!("the data of `{}` are as before, but there are none", object.path.join("/"));
                return object.last_index.map(Some).ok_or_else(missing);
            }
            kind @ (DAQMX | DAQMX_LINES) => {
                bytes.take(8)?;
                let values = bytes.u64()?;
                let scaler_bytes = if kind == DAQMX { 20 } else { 17 };
                for _ in 0..bytes.u32()? {
                    bytes.take(scaler_bytes)?;
                }
                for _ in 0..bytes.u32()? {
                    bytes.take(4)?;
                }
                object.refused = Some("raw data of a DAQmx device".to_owned());
                Index::Daqmx { values }
            }
            _ => {
                let data_type = DataType::new(bytes.u32()?)?;
                let dimension = bytes.u32()?;
                if dimension != 1 {
                    return Err(format!("an array of {dimension} dimensions, where TDMS has 1"));
                }
                let values = bytes.u64()?;
                let size = match data_type.bytes() {
                    Some(size) => values.checked_mul(size as u64),
                    None => Some(bytes.u64()?),
                };
                let size = size.ok_or_else(|| format!("{values} values in a chunk"))?;
                if let Some(name) = data_type.not_a_number() {
                    object.refused = Some(name.to_owned());
                }
                if object.last_index.is_some() && object.timestamps != (data_type == DataType::Timestamp) {
                    object.refused = Some("timestamps and numbers".to_owned());
                }
                object.timestamps = data_type == DataType::Timestamp;
                Index::Values { data_type, values, bytes: size }
            }
        };
        object.last_index = Some(index);
        Ok(Some(index))
    }

    /// Number of the layout of the segments whose metadata were last read.
    fn current_layout(&mut self) -> Result<usize, String> {
        self.visits += self.list.len();
        let mut layout = Layout::default();
        for &(object, index) in &self.list {
            match index {
                Some(Index::Values { data_type, values, bytes }) if bytes > 0 => {
                    let (offset, offset_in_row) = (layout.chunk_bytes, layout.row_bytes as u32);
                    layout.parts.push(ChannelValues {
                        object,
                        data_type,
                        values,
                        bytes,
                        offset,
                        offset_in_row,
                    });
                    let sum = layout.chunk_bytes.checked_add(bytes);
                    layout.chunk_bytes = sum.ok_or("chunks of more bytes than a file can have")?;
                    layout.row_bytes += data_type.bytes().unwrap_or(0);
                }
                Some(Index::Daqmx { values }) => layout.daqmx.push((object, values)),
                _ => {}
            }
        }
        layout.places = (0..layout.parts.len() as u32).collect();
        layout.places.sort_unstable_by_key(|&place| layout.parts[place as usize].object);
        let rows = layout.parts.first().map(|part| part.values);
        layout.sized = layout.parts.iter().all(|part| part.data_type.bytes().is_some());
        layout.equally_many = layout.sized && layout.parts.iter().all(|part| Some(part.values) == rows);
        if self.layouts.last() == Some(&layout) {
            return Ok(self.layouts.len() - 1);
        }
        self.parts += layout.parts.len();
        if self.parts > MAX_PARTS || self.visits > MAX_VISITS {
            return Err(TOO_MANY_CHANGES.to_owned());
        }
        self.layouts.push(layout);
        Ok(self.layouts.len() - 1)
    }

    /// Adds raw data.
    fn push(&mut self, mut segment: Segment) -> Result<(), String> {
        let layout = &self.layouts[segment.layout];
        if !layout.daqmx.is_empty() {
            for &(object, values) in &layout.daqmx {
                self.objects[object].values = self.objects[object].values.saturating_add(values);
            }
            return Ok(());
        }
        if layout.chunk_bytes == 0 {
            return Ok(());
        }
        if segment.interleaved && !layout.equally_many {
            return Err(format!(
                "the data at byte {} are interleaved, but are texts or differ in length",
                segment.start
            ));
        }
        self.visits += layout.parts.len();
        if self.visits > MAX_VISITS {
            return Err(TOO_MANY_CHANGES.to_owned());
        }
        segment.rest = self.rest(&segment)?;
        let layout = &self.layouts[segment.layout];
        let rest = segment.rest.map(|rest| self.rests[rest].as_slice()).unwrap_or_default();
        let chunks = layout.chunks(&segment);
        for (place, part) in layout.parts.iter().enumerate() {
            let whole = chunks.saturating_mul(part.values);
            let values = whole.saturating_add(rest.get(place).map_or(0, |rest| rest.values));
            self.objects[part.object].values = self.objects[part.object].values.saturating_add(values);
        }
        self.segments.push(segment);
        Ok(())
    }

    /// Number of a segment's incomplete last chunk, if it has one.
    fn rest(&mut self, segment: &Segment) -> Result<Option<usize>, String> {
        let layout = &self.layouts[segment.layout];
        let left = segment.bytes as u64 % layout.chunk_bytes.max(1);
        if left == 0 || !layout.sized {
            return Ok(None);
        }
        let key = (segment.layout, left, segment.interleaved, segment.cut_off);
        if let Some(&number) = self.rest_numbers.get(&key) {
            return Ok(Some(number));
        }
        self.parts += layout.parts.len();
        if self.parts > MAX_PARTS {
            return Err(TOO_MANY_CHANGES.to_owned());
        }
        self.rests.push(layout.rest(left, segment));
        self.rest_numbers.insert(key, self.rests.len() - 1);
        Ok(Some(self.rests.len() - 1))
    }
}

impl Layout {
    /// Number of whole chunks.
    pub fn chunks(&self, segment: &Segment) -> u64 {
        segment.bytes as u64 / self.chunk_bytes.max(1)
    }

    /// The place of an object's values.
    pub fn place(&self, object: usize) -> Option<usize> {
        let own = |&place: &u32| self.parts[place as usize].object;
        let found = self.places.binary_search_by_key(&object, own).ok()?;
        self.places.get(found).map(|&place| place as usize)
    }

    /// Number and place of the values of each channel in an incomplete last chunk: of interleaved channels,
    /// and where the file continues, in proportion to its bytes; where the file is cut off, as many of each
    /// channel as all of them have.
    fn rest(&self, left: u64, segment: &Segment) -> Vec<Rest> {
        let bytes = |part: &ChannelValues| part.data_type.bytes().unwrap_or(1) as u64;
        let mut offset = 0u64;
        let mut rest = Vec::with_capacity(self.parts.len());
        for part in &self.parts {
            rest.push(if segment.interleaved || !segment.cut_off {
                let values = share(part.values, left, self.chunk_bytes);
                Rest { values, offset }
            } else if let Some(last) = self.parts.last() {
                // All channels before the last are complete once the last has begun.
                let of_last = left.saturating_sub(self.chunk_bytes - last.bytes) / bytes(last).max(1);
                Rest { values: share(part.values, of_last, last.values), offset: part.offset }
            } else {
                Rest::default()
            });
            let own = rest.last().map_or(0, |rest: &Rest| rest.values).saturating_mul(bytes(part));
            offset = offset.saturating_add(own);
        }
        rest
    }
}

/// `values` × `some` / `all`, rounded down.
fn share(values: u64, some: u64, all: u64) -> u64 {
    if let Some(product) = values.checked_mul(some) {
        return product / all.max(1);
    }
    (u128::from(values) * u128::from(some) / u128::from(all.max(1))) as u64
}

/// Names in a path: `/'group'/'channel'`, quotes in names doubled; `/` is the file. `None` for one that is no
/// such path.
fn components(path: &str) -> Option<Vec<String>> {
    let mut names = Vec::new();
    let mut rest = path;
    while !rest.is_empty() && rest != "/" {
        rest = rest.strip_prefix("/'")?;
        let mut name = String::new();
        loop {
            let (before, after) = rest.split_once('\'')?;
            name.push_str(before);
            match after.strip_prefix('\'') {
                Some(more) => {
                    name.push('\'');
                    rest = more;
                }
                None => {
                    rest = after;
                    break;
                }
            }
        }
        names.push(name);
        if names.len() > 2 {
            return None;
        }
    }
    Some(names)
}

#[cfg(test)]
mod tests;
