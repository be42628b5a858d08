//! Channels of a segment: how their numbers are stored, and scaled to units.

use std::sync::Arc;

use super::properties::Properties;

/// Longest chain of conversions.
const MAX_CONVERSIONS: usize = 8;

/// Storage format of numbers, all of them big-endian.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Encoding {
    Signed(usize),
    Unsigned(usize),
    Float32,
    Float64,
}

impl Encoding {
    pub fn bytes(&self) -> usize {
        match self {
            Encoding::Signed(bytes) | Encoding::Unsigned(bytes) => *bytes,
            Encoding::Float32 => 4,
            Encoding::Float64 => 8,
        }
    }

    pub fn value(&self, raw: &[u8]) -> f64 {
        let bits = raw.iter().take(8).fold(0u64, |sum, &byte| (sum << 8) | u64::from(byte));
        match self {
            Encoding::Signed(bytes) => {
                let unused = 64 - 8 * bytes;
                (((bits << unused) as i64) >> unused) as f64
            }
            Encoding::Unsigned(_) => bits as f64,
            Encoding::Float32 => f64::from(f32::from_bits(bits as u32)),
            Encoding::Float64 => f64::from_bits(bits),
        }
    }
}

/// A unit that a channel is given in.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Slot {
    /// Its name in the file: `volts`, `nominal`, `force`.
    pub name: String,
    /// Whether the file shows it by default.
    pub is_default: bool,
    pub unit: String,
    /// Multiplier and offset, from the stored numbers on.
    pub scaling: Vec<(f64, f64)>,
}

impl Slot {
    pub fn apply(&self, value: f64) -> f64 {
        self.scaling.iter().fold(value, |value, (multiplier, offset)| multiplier * value + offset)
    }

    /// Name of the column: only units other than the default are named.
    pub fn name_of(&self, channel: &str) -> String {
        if self.is_default { channel.to_owned() } else { format!("{channel}:{}", self.name) }
    }
}

/// A channel of a segment.
pub(super) struct Channel {
    pub name: String,
    /// Number of its array in the archive.
    pub entry: usize,
    pub samples: usize,
    pub description: Arc<Description>,
}

/// Storage format and units of a channel.
#[derive(Debug, PartialEq)]
pub(super) struct Description {
    /// Storage format, else the content of an array that is not read as numbers.
    pub encoding: Result<Encoding, String>,
    pub slots: Vec<Slot>,
}

/// Properties of one channel: those of the segment, else those shared by segments.
struct Lookup<'a> {
    name: &'a str,
    sources: &'a [&'a Properties],
    shared: Option<String>,
}

impl Lookup<'_> {
    fn get(&self, key: &str) -> Option<&str> {
        let own = format!("channel.{}.{key}", self.name);
        let shared = self.shared.as_ref().map(|number| format!("lcd-info.{number}.{key}"));
        let find = |key: &str| self.sources.iter().find_map(|properties| properties.get(key));
        find(&own).or_else(|| find(shared.as_deref()?))
    }

    /// The property of the first of these keys.
    fn any(&self, keys: &[&str]) -> Option<&str> {
        keys.iter().find_map(|key| self.get(key))
    }

    /// Multiplier and offset behind a key.
    fn scaling(&self, keys: &[&str]) -> Result<(f64, f64), String> {
        let property = |key: &str, name: &str| self.get(&format!("{key}.{name}"));
        let Some(key) = keys.iter().find(|key| property(key, "multiplier").is_some()) else {
            return Err("integers without scaling".to_owned());
        };
        if let Some(style) = property(key, "style").filter(|style| *style != "offsetmultiplier") {
            return Err(format!("values with a scaling of style {style}"));
        }
        let number = |name| property(key, name).and_then(|text| text.trim().parse::<f64>().ok());
        number("multiplier").zip(number("offset")).ok_or_else(|| "integers without scaling".to_owned())
    }
}

impl Channel {
    /// The channel stored in an entry of this many bytes.
    pub fn new(name: String, entry: usize, bytes: u64, description: Arc<Description>) -> Self {
        let size = description.encoding.as_ref().map_or(1, Encoding::bytes) as u64;
        let samples = usize::try_from(bytes / size).unwrap_or(usize::MAX);
        Channel { name, entry, samples, description }
    }
}

impl Description {
    /// Description of a channel from the properties of a segment, then from those of all.
    pub fn new(name: &str, sources: &[&Properties]) -> Self {
        let number = sources.iter().find_map(|own| own.shared_number(name));
        let lookup = Lookup { name, sources, shared: number.map(str::to_owned) };
        match described(&lookup) {
            Ok((encoding, slots)) => Description { encoding: Ok(encoding), slots },
            Err(found) => {
                let slots = vec![Slot { is_default: true, ..Slot::default() }];
                Description { encoding: Err(found), slots }
            }
        }
    }
}

/// Storage format and units of a channel; else the reason why it is not read.
fn described(lookup: &Lookup<'_>) -> Result<(Encoding, Vec<Slot>), String> {
    let encoding =
        match (lookup.any(&["data.encoder.type", "encoder.type"]), lookup.any(&["data.type", "type"])) {
            (Some("signedshort"), _) => Encoding::Signed(2),
            (Some("unsignedshort"), _) => Encoding::Unsigned(2),
            (Some("signedinteger"), _) => Encoding::Signed(4),
            (Some("unsignedinteger"), _) => Encoding::Unsigned(4),
            (Some("signedlong"), _) => Encoding::Signed(8),
            (Some("unsignedlong"), _) => Encoding::Unsigned(8),
            (None, Some("float" | "float-data")) => Encoding::Float32,
            (None, Some("double" | "double-data")) => Encoding::Float64,
            (encoder, kind) => {
                return Err(format!(
                    "values of type {}",
                    encoder.or(kind).unwrap_or("that the file does not name")
                ));
            }
        };
    let mut stored = Vec::new();
    if matches!(encoding, Encoding::Signed(_) | Encoding::Unsigned(_)) {
        stored.push(lookup.scaling(&["data.encoder.scaling", "encoder.scaling"])?);
    }
    let unit = lookup.any(&[
        "data.encoder.scaling.unit.unit",
        "encoder.scaling.unit.unit",
        "data.encoder.scaling.unit",
        "encoder.scaling.unit",
        "unit.unit",
        "unit",
    ]);
    let base = lookup.get("conversion-set.conversions.base").unwrap_or_default();
    let default = lookup.get("conversion-set.conversions.default").unwrap_or(base);
    let mut slots = vec![Slot {
        name: base.to_owned(),
        is_default: base == default,
        unit: unit.unwrap_or_default().to_owned(),
        scaling: stored.clone(),
    }];
    for name in lookup.get("conversion-set.conversions.list").unwrap_or_default().split_whitespace() {
        if name != base && slots.len() <= MAX_CONVERSIONS {
            slots.extend(slot(lookup, name, base, &stored, name == default));
        }
    }
    if !slots.iter().any(|slot| slot.is_default) {
        slots[0].is_default = true;
    }
    Ok((encoding, slots))
}

/// A unit by the chain of conversions from the stored one.
fn slot(
    lookup: &Lookup<'_>,
    name: &str,
    base: &str,
    stored: &[(f64, f64)],
    is_default: bool,
) -> Option<Slot> {
    let mut conversions = Vec::new();
    let mut current = name;
    while current != base {
        let key = format!("conversion-set.conversion.{current}");
        conversions.push(lookup.scaling(&[&format!("{key}.scaling")]).ok()?);
        current = lookup.get(&format!("{key}.base-calibration-slot"))?;
        if conversions.len() > MAX_CONVERSIONS {
            return None;
        }
    }
    let key = format!("conversion-set.conversion.{name}.scaling.unit");
    let unit = lookup.any(&[&format!("{key}.unit"), &key]).unwrap_or_default().to_owned();
    let scaling = stored.iter().copied().chain(conversions.into_iter().rev()).collect();
    Some(Slot { name: name.to_owned(), is_default, unit, scaling })
}
