//! JPK force archives: a zip of properties and of arrays of numbers, one a channel, segment and curve.
//!
//! Columns are the channels of a curve over all of its segments (`height`; in a map `index/3/height`) and
//! those of each segment (`segments/0/height`), in the unit that the file shows by default; in others as
//! `height (volts)`.

mod channel;
mod listing;
mod properties;

use std::collections::{BTreeMap, HashMap};
use std::io::Read;
use std::sync::Arc;

use crate::IoError;
use crate::columns::Columns;
use crate::container::{self, MAX_ARRAYS, MOST_PATH_BYTES};
use crate::hash::sha256;
use crate::place::{FilePart, Place};
use crate::reader::{Archive, Input};
use channel::{Channel, Description};
use listing::{Listing, Source};
use properties::Properties;

/// Longest list of properties \[bytes\].
const MAX_PROPERTIES_BYTES: u64 = 1 << 22;
/// Total size of the property lists allowed for any archive \[bytes\], and per byte of a larger one.
const LEAST_PROPERTIES_BYTES: u64 = 32 << 20;
const PROPERTIES_PER_BYTE: u64 = 16;
/// Most channels of a segment, segments of a curve, and arrays that are read.
const MAX_CHANNELS: usize = 256;
const MAX_SEGMENTS: usize = 4096;
const MAX_READ: usize = 1 << 18;
/// Most bytes that one byte of a deflated entry unpacks to.
const LARGEST_RATIO: u64 = 1032;

/// Curves in order, each by the length of its group's name and the group, and their segments.
type Curves = BTreeMap<(usize, String), BTreeMap<u64, Segment>>;

/// A segment: approach, pause or retract.
#[derive(Default)]
struct Segment {
    channels: Vec<Channel>,
    samples: usize,
    duration_s: Option<f64>,
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
        .map_err(|problem| malformed(FilePart::Whole, problem))?;
    let mut listing = Listing::default();
    // A map of very many curves is listed by its curves only.
    for parts_too in [true, false] {
        listing = Listing { parts_too, ..Listing::default() };
        for ((_, group), segments) in &curves {
            if !listing.is_full() {
                listing.curve(group, segments);
            }
        }
        if !listing.is_full() {
            break;
        }
    }
    drop(curves);
    let Listing { held, sources, .. } = listing;
    if held.is_empty() {
        return Err(malformed(FilePart::Whole, "it holds no channels of a force curve".to_owned()));
    }
    let (mut left, mut left_arrays) = (max_bytes, MAX_READ);
    container::columns(input, &held, sha256(bytes), |index| match &sources[index] {
        Source::Time(segments) => Ok(times(segments)),
        Source::Arrays(arrays) => {
            let mut values = Vec::new();
            left_arrays = left_arrays.checked_sub(arrays.len()).ok_or_else(|| {
                malformed(FilePart::Whole, format!("the columns to read are of more than {MAX_READ} arrays"))
            })?;
            for array in arrays {
                let part = || FilePart::Array(held[index].path.as_str().into());
                let (Ok(encoding), Some(slot)) =
                    (&array.description.encoding, array.description.slots.get(array.slot))
                else {
                    continue;
                };
                let size = array.samples as u64 * encoding.bytes() as u64;
                let too_large =
                    || IoError::TooLarge { place: Place::new(&file, part()), limit_bytes: max_bytes };
                left = left.checked_sub(size).ok_or_else(too_large)?;
                let raw = entry_bytes(&mut archive, array.entry, size)
                    .map_err(|problem| malformed(part(), problem))?;
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

impl Segment {
    fn rate_hz(&self) -> Option<f64> {
        let rate = self.samples as f64 / self.duration_s?;
        Some(rate).filter(|rate| rate.is_finite() && *rate > 0.0)
    }
}

/// The curves of the archive, each with its segments: the only one, or those of a map (`index/3/`).
fn curves(archive: &mut Archive<'_>, archive_bytes: u64, max_bytes: u64) -> Result<Curves, String> {
    let most_properties =
        LEAST_PROPERTIES_BYTES.max(archive_bytes.saturating_mul(PROPERTIES_PER_BYTE)).min(max_bytes);
    let mut left = most_properties;
    let mut properties = |archive: &mut Archive<'_>, name: &str, entry: Option<usize>| {
        let Some(entry) = entry else { return Ok(Properties::default()) };
        let text = entry_bytes(archive, entry, MAX_PROPERTIES_BYTES.min(left))?;
        if text.len() as u64 > MAX_PROPERTIES_BYTES {
            return Err(format!("`{name}` has more than {MAX_PROPERTIES_BYTES} bytes"));
        }
        let too_many = || format!("its properties have more than {most_properties} bytes");
        left = left.checked_sub(text.len() as u64).ok_or_else(too_many)?;
        Ok::<_, String>(Properties::new(&text))
    };
    let [general, shared] = ["header.properties", "shared-data/header.properties"].map(|name| {
        let entry = archive.index_for_name(name);
        properties(archive, name, entry)
    });
    let (general, shared) = (general?, shared?);
    // The archive searches all of its names for a missing one.
    let (mut entries, mut headers) = (Vec::new(), HashMap::new());
    for entry in 0..archive.len() {
        let name = archive.name_for_index(entry).transpose().map_err(|e| e.to_string())?;
        let Some(name) = name.as_deref() else { continue };
        if let Some(place) = channel_place(name) {
            if name.len() > MOST_PATH_BYTES {
                return Err(format!("an entry has a path of more than {MOST_PATH_BYTES} bytes"));
            }
            entries.push((entry, place));
        } else if name.ends_with("/segment-header.properties") {
            headers.insert(name.to_owned(), entry);
        }
    }
    let mut descriptions = Descriptions::default();
    let mut curves = Curves::new();
    // The header of the last entry's segment: entries of one segment stand side by side.
    let mut last: Option<(String, Properties)> = None;
    entries.sort_by(|(_, a), (_, b)| (&a.group, a.segment).cmp(&(&b.group, b.segment)));
    for (entry, ChannelPlace { group, segment, name }) in entries {
        let path = format!("{group}segments/{segment}/segment-header.properties");
        let header = match last.take() {
            Some((of, header)) if of == path => header,
            _ => properties(archive, &path, headers.get(&path).copied())?,
        };
        let stored = archive.by_index_raw(entry).map_err(|e| e.to_string())?;
        let (bytes, packed_bytes) = (stored.size(), stored.compressed_size().min(archive_bytes));
        drop(stored);
        if bytes > packed_bytes.saturating_mul(LARGEST_RATIO) {
            return Err(format!("its array `{name}` cannot have the {bytes} bytes that the archive says"));
        }
        let description = descriptions.of(&name, &[&header, &shared, &general])?;
        if curves.len() > MAX_ARRAYS {
            return Err(format!("it holds more than {MAX_ARRAYS} curves"));
        }
        let of_curve = curves.entry((group.len(), group)).or_default();
        if of_curve.len() == MAX_SEGMENTS && !of_curve.contains_key(&segment) {
            return Err(format!("a curve has more than {MAX_SEGMENTS} segments"));
        }
        let of_segment = of_curve.entry(segment).or_default();
        if of_segment.channels.len() == MAX_CHANNELS {
            return Err(format!("a segment has more than {MAX_CHANNELS} channels"));
        }
        let channel = Channel::new(name, entry, bytes, description);
        of_segment.samples = of_segment.samples.max(channel.samples);
        of_segment.duration_s = header.number("force-segment-header.duration");
        of_segment.channels.push(channel);
        last = Some((path, header));
    }
    Ok(curves)
}

/// Descriptions of channels, of which a map has the same for each of its curves.
#[derive(Default)]
struct Descriptions {
    /// Those of channels that their segments describe only by the number of a shared description.
    shared: HashMap<(String, Option<String>), Arc<Description>>,
    /// The last one of each channel that its segment describes.
    own: HashMap<String, Arc<Description>>,
    distinct: usize,
}

impl Descriptions {
    /// Description of a channel by the properties of its segment and those of all.
    fn of(&mut self, name: &str, sources: &[&Properties; 3]) -> Result<Arc<Description>, String> {
        let [header, ..] = sources;
        let is_own = header.describes(name);
        let key = (name.to_owned(), header.shared_number(name).map(str::to_owned));
        if let Some(known) = self.shared.get(&key).filter(|_| !is_own) {
            return Ok(Arc::clone(known));
        }
        let description = Description::new(name, sources);
        if let Some(known) = self.own.get(name).filter(|known| is_own && ***known == description) {
            return Ok(Arc::clone(known));
        }
        self.distinct += 1;
        if self.distinct > MAX_ARRAYS {
            return Err(format!("it describes channels in more than {MAX_ARRAYS} ways"));
        }
        let description = Arc::new(description);
        if is_own {
            self.own.insert(name.to_owned(), Arc::clone(&description));
        } else {
            self.shared.insert(key, Arc::clone(&description));
        }
        Ok(description)
    }
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

/// Bytes of an entry of the archive, at most `most` + 1.
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
