//! JPK force archives: a zip of properties and of arrays of numbers, one a channel, segment and curve.
//!
//! Columns are the channels of a curve over all of its segments (`height`; in a map `index/3/height`) and
//! those of each segment (`segments/0/height`), in the unit that the file shows by default; in others as
//! `height (volts)`.

mod channel;
mod properties;

use std::collections::BTreeMap;
use std::io::Read;

use crate::IoError;
use crate::columns::{Columns, Kind};
use crate::container::{self, Held, MAX_ARRAYS};
use crate::hash::sha256;
use crate::place::{Part, Place};
use crate::reader::{Archive, Input};
use channel::{Channel, Encoding, Slot};
use properties::Properties;

/// Longest list of properties \[bytes\].
const MAX_PROPERTIES_BYTES: u64 = 1 << 22;
/// Most bytes that one byte of a deflated entry unpacks to.
const LARGEST_RATIO: u64 = 1032;
/// Relative difference of sample rates of segments that are one.
const SAME_RATE: f64 = 1e-9;

/// Curves in order, each by the length of its group's name and the group, and their segments.
type Curves = BTreeMap<(usize, String), BTreeMap<u64, Segment>>;

/// A segment: approach, pause or retract.
#[derive(Default)]
struct Segment {
    channels: Vec<Channel>,
    samples: usize,
    duration_s: Option<f64>,
}

/// Where the numbers of a column are.
enum Source {
    /// Arrays of the archive, one behind the other.
    Arrays(Vec<(usize, usize, Encoding, Slot)>),
    /// Segments, each with its number of samples and its duration \[s\].
    Time(Vec<(usize, f64)>),
}

/// Whether the archive is one of JPK's.
pub(crate) fn recognises(archive: &Archive<'_>) -> bool {
    archive.index_for_name("header.properties").is_some()
}

/// Reads the columns of an archive.
pub(crate) fn read(input: Input<'_>, bytes: &[u8], mut archive: Archive<'_>) -> Result<Columns, IoError> {
    let file = input.file.to_owned();
    let max_bytes = input.options.max_bytes;
    let malformed =
        |part, problem| IoError::Malformed { place: Place::new(&file, part), format: "JPK", problem };
    let curves = curves(&mut archive, bytes.len() as u64, max_bytes)
        .map_err(|problem| malformed(Part::Whole, problem))?;
    let (mut held, mut sources) = (Vec::new(), Vec::new());
    for parts_too in [true, false] {
        (held, sources) = (Vec::new(), Vec::new());
        for ((_, group), segments) in &curves {
            list(group, segments, parts_too, &mut held, &mut sources);
        }
        // A map of very many curves is listed by its curves only.
        if held.len() <= MAX_ARRAYS {
            break;
        }
    }
    if held.is_empty() {
        return Err(malformed(Part::Whole, "it holds no channels of a force curve".to_owned()));
    }
    let mut left = max_bytes;
    container::columns(input, &held, sha256(bytes), |index| match &sources[index] {
        Source::Time(segments) => Ok(times(segments)),
        Source::Arrays(arrays) => {
            let mut values = Vec::new();
            for (entry, samples, encoding, slot) in arrays {
                let part = || Part::Array(held[index].path.as_str().into());
                let size = *samples as u64 * encoding.bytes() as u64;
                let too_large =
                    || IoError::TooLarge { place: Place::new(&file, part()), limit_bytes: max_bytes };
                left = left.checked_sub(size).ok_or_else(too_large)?;
                let raw =
                    entry_bytes(&mut archive, *entry, size).map_err(|problem| malformed(part(), problem))?;
                if raw.len() as u64 != size {
                    let problem = format!("it has {} bytes where the archive says {size}", raw.len());
                    return Err(malformed(part(), problem));
                }
                values.extend(raw.chunks_exact(encoding.bytes()).map(|raw| slot.apply(encoding.value(raw))));
            }
            Ok(values)
        }
    })
}

/// Lists the columns of one curve.
fn list(
    group: &str,
    segments: &BTreeMap<u64, Segment>,
    parts_too: bool,
    held: &mut Vec<Held>,
    sources: &mut Vec<Source>,
) {
    let mut add = |group: &str, name: &str, samples, slot: &Slot, kind, rate: Option<(f64, f64)>, source| {
        let mut array = Held::new(group, name, vec![samples], kind);
        array.unit = Some(slot.unit.clone()).filter(|unit| !unit.is_empty());
        if let Some((hz, start_s)) = rate {
            (array.sample_rate_hz, array.start_s) = (Some(hz), start_s);
        }
        held.push(array);
        sources.push(source);
    };
    let kind = |channel: &Channel| match &channel.encoding {
        Ok(_) => Kind::Numbers,
        Err(found) => Kind::Other(found.clone()),
    };
    let array = |channel: &Channel, slot: &Slot| {
        let encoding = channel.encoding.clone().unwrap_or(Encoding::Float32);
        (channel.entry, channel.samples, encoding, slot.clone())
    };
    let durations: Option<Vec<(usize, f64)>> =
        segments.values().map(|segment| Some((segment.samples, segment.duration_s?))).collect();
    let rates = segments.values().map(Segment::rate_hz).collect::<Option<Vec<f64>>>().unwrap_or_default();
    let one_rate =
        rates.first().copied().filter(|first| rates.iter().all(|r| (r / first - 1.0).abs() < SAME_RATE));
    let Some(first) = segments.values().next() else { return };
    if segments.len() > 1 {
        let samples = segments.values().map(|segment| segment.samples).sum();
        if let (None, Some(durations)) = (one_rate, durations) {
            let seconds = Slot { unit: "s".to_owned(), ..Slot::default() };
            add(group, "time", samples, &seconds, Kind::Numbers, None, Source::Time(durations));
        }
        for channel in &first.channels {
            for slot in channel.slots.iter().filter(|slot| parts_too || slot.is_default) {
                // A channel that only some segments have is no channel of the curve.
                let of_segment = |segment: &Segment| {
                    let own = segment
                        .channels
                        .iter()
                        .find(|own| own.name == channel.name && own.encoding.is_ok())?;
                    let own_slot = own.slots.iter().find(|own| own.name == slot.name)?;
                    Some(array(own, own_slot))
                };
                let Some(arrays) = segments.values().map(of_segment).collect::<Option<Vec<_>>>() else {
                    continue;
                };
                let samples = arrays.iter().map(|(_, samples, ..)| samples).sum();
                let rate = one_rate.map(|hz| (hz, 0.0));
                let name = slot.name_of(&channel.name);
                add(group, &name, samples, slot, kind(channel), rate, Source::Arrays(arrays));
            }
        }
    }
    if !parts_too && segments.len() > 1 {
        return;
    }
    let mut start_s = 0.0;
    for (number, segment) in segments {
        let rate = segment.rate_hz().map(|hz| (hz, start_s));
        for channel in &segment.channels {
            for slot in channel.slots.iter().filter(|slot| parts_too || slot.is_default) {
                let group = format!("{group}segments/{number}/");
                let source = Source::Arrays(vec![array(channel, slot)]);
                add(&group, &slot.name_of(&channel.name), channel.samples, slot, kind(channel), rate, source);
            }
        }
        start_s += segment.duration_s.unwrap_or_default();
    }
}

impl Segment {
    fn rate_hz(&self) -> Option<f64> {
        let rate = self.samples as f64 / self.duration_s?;
        Some(rate).filter(|rate| rate.is_finite() && *rate > 0.0)
    }
}

/// The curves of the archive, each with its segments: the only one, or those of a map (`index/3/`).
fn curves(archive: &mut Archive<'_>, archive_bytes: u64, max_bytes: u64) -> Result<Curves, String> {
    let mut left = max_bytes;
    let mut properties = |archive: &mut Archive<'_>, name: &str| {
        let Some(entry) = archive.index_for_name(name) else { return Ok(Properties::default()) };
        let text = entry_bytes(archive, entry, MAX_PROPERTIES_BYTES.min(left))?;
        if text.len() as u64 > MAX_PROPERTIES_BYTES.min(left) {
            let most = MAX_PROPERTIES_BYTES;
            return Err(format!("`{name}` has more than {most} bytes, or more than `max_bytes` leaves"));
        }
        left -= text.len() as u64;
        Ok::<_, String>(Properties::new(&text))
    };
    let general = properties(archive, "header.properties")?;
    let shared = properties(archive, "shared-data/header.properties")?;
    let mut entries = Vec::new();
    for entry in 0..archive.len() {
        let name = archive.name_for_index(entry).transpose().map_err(|e| e.to_string())?;
        if let Some(place) = name.as_deref().and_then(channel_place) {
            entries.push((entry, place));
        }
    }
    let mut curves = Curves::new();
    let mut headers: BTreeMap<String, Properties> = BTreeMap::new();
    for (entry, ChannelPlace { group, segment, name }) in entries {
        let path = format!("{group}segments/{segment}/segment-header.properties");
        if !headers.contains_key(&path) {
            // Entries of one segment stand side by side: only a few headers are of use at a time.
            if headers.len() > 8 {
                headers.clear();
            }
            headers.insert(path.clone(), properties(archive, &path)?);
        }
        let Some(header) = headers.get(&path) else { continue };
        let stored = archive.by_index_raw(entry).map_err(|e| e.to_string())?;
        let (bytes, packed_bytes) = (stored.size(), stored.compressed_size().min(archive_bytes));
        drop(stored);
        if bytes > packed_bytes.saturating_mul(LARGEST_RATIO) {
            return Err(format!("its array `{name}` cannot have the {bytes} bytes that the archive says"));
        }
        let channel = Channel::new(name, entry, bytes, &[header, &shared, &general]);
        let of_curve = curves.entry((group.len(), group)).or_default();
        let of_segment = of_curve.entry(segment).or_default();
        of_segment.samples = of_segment.samples.max(channel.samples);
        of_segment.duration_s = header.number("force-segment-header.duration");
        of_segment.channels.push(channel);
    }
    Ok(curves)
}

/// Curve, segment and name of a channel.
struct ChannelPlace {
    /// Empty for a single curve; `index/3/` in a map.
    group: String,
    segment: u64,
    name: String,
}

/// The place of a channel by its path in the archive: `index/3/segments/0/channels/height.dat`.
fn channel_place(path: &str) -> Option<ChannelPlace> {
    let parts: Vec<&str> = path.split('/').collect();
    let (group, rest) = match parts.as_slice() {
        ["index", number, rest @ ..] => (format!("index/{}/", number.parse::<u64>().ok()?), rest),
        rest => (String::new(), rest),
    };
    let ["segments", segment, "channels", file] = rest else { return None };
    Some(ChannelPlace { group, segment: segment.parse().ok()?, name: file.strip_suffix(".dat")?.to_owned() })
}

/// Bytes of an entry of the archive, at most so many and one more.
fn entry_bytes(archive: &mut Archive<'_>, entry: usize, most: u64) -> Result<Vec<u8>, String> {
    let entry = archive.by_index(entry).map_err(|e| e.to_string())?;
    let mut bytes = Vec::new();
    entry.take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    Ok(bytes)
}

/// Time of the samples: each segment begins where the one in front of it ends.
fn times(segments: &[(usize, f64)]) -> Vec<f64> {
    let mut start = 0.0;
    let mut times = Vec::new();
    for &(samples, duration) in segments {
        let stop = start + duration;
        let step = (stop - start) / samples as f64;
        times.extend((0..samples).map(|k| k as f64 * step + start));
        start = stop;
    }
    times
}
