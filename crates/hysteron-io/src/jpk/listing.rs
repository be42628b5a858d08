//! The columns of an archive: those of each curve over all of its segments, and those of each segment.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::Segment;
use super::channel::{Channel, Description, Slot};
use crate::columns::Kind;
use crate::container::{HeldArray, MAX_ARRAYS};

/// Relative tolerance for equal sample rates of segments.
const SAME_RATE: f64 = 1e-9;

/// Where the numbers of a column are.
pub(super) enum Source {
    /// Concatenated arrays of the archive.
    Arrays(Vec<Array>),
    /// Segments, each with its number of samples and its duration \[s\].
    Time(Vec<(usize, f64)>),
}

/// An array of the archive, in one of its units.
pub(super) struct Array {
    /// Number of the entry.
    pub entry: usize,
    pub samples: usize,
    pub description: Arc<Description>,
    /// Number of the unit.
    pub slot: usize,
}

/// Columns and where their numbers are.
#[derive(Default)]
pub(super) struct Listing {
    pub held: Vec<HeldArray>,
    pub sources: Vec<Source>,
    /// Whether segments are listed beside the curve that they make, and other units beside the default one.
    pub parts_too: bool,
}

impl Listing {
    /// Whether there are more than a file may have.
    pub fn is_full(&self) -> bool {
        self.held.len() > MAX_ARRAYS
    }

    /// Lists the columns of one curve.
    pub fn curve(&mut self, group: &str, segments: &BTreeMap<u64, Segment>) {
        if segments.len() > 1 {
            self.whole(group, segments);
        }
        if !self.parts_too && segments.len() > 1 {
            return;
        }
        let mut start_s = 0.0;
        for (number, segment) in segments {
            let rate = segment.rate_hz().map(|hz| (hz, start_s));
            let group = format!("{group}segments/{number}/");
            for channel in &segment.channels {
                for slot in self.slots(channel) {
                    if self.is_full() {
                        return;
                    }
                    self.push(&group, channel, slot, rate, vec![channel.array(slot)]);
                }
            }
            start_s += segment.duration_s.unwrap_or_default();
        }
    }

    /// Lists the columns of a curve over its segments.
    fn whole(&mut self, group: &str, segments: &BTreeMap<u64, Segment>) {
        let rates = segments.values().map(Segment::rate_hz).collect::<Option<Vec<f64>>>().unwrap_or_default();
        let is_one = |first: &f64| rates.iter().all(|r| (r / first - 1.0).abs() < SAME_RATE);
        let one_rate = rates.first().copied().filter(is_one);
        let durations: Option<Vec<(usize, f64)>> =
            segments.values().map(|segment| Some((segment.samples, segment.duration_s?))).collect();
        if let (None, Some(durations)) = (one_rate, durations) {
            let samples = durations.iter().fold(0usize, |sum, (samples, _)| sum.saturating_add(*samples));
            let time = HeldArray::new(group, "time", vec![samples], Kind::Numbers);
            self.held.push(HeldArray { unit: Some("s".to_owned()), ..time });
            self.sources.push(Source::Time(durations));
        }
        let Some(first) = segments.values().next() else { return };
        for channel in &first.channels {
            for slot in self.slots(channel) {
                // A channel that only some segments have is no channel of the curve.
                let of_segment = |segment: &Segment| {
                    let is_own =
                        |own: &&Channel| own.name == channel.name && own.description.encoding.is_ok();
                    let own = segment.channels.iter().find(is_own)?;
                    let name = &channel.description.slots[slot].name;
                    Some(own.array(own.description.slots.iter().position(|own| own.name == *name)?))
                };
                if let Some(arrays) = segments.values().map(of_segment).collect::<Option<Vec<_>>>() {
                    self.push(group, channel, slot, one_rate.map(|hz| (hz, 0.0)), arrays);
                }
            }
        }
    }

    /// Numbers of the units in which a channel is listed.
    fn slots(&self, channel: &Channel) -> Vec<usize> {
        let slots = &channel.description.slots;
        (0..slots.len()).filter(|&slot| self.parts_too || slots[slot].is_default).collect()
    }

    /// Lists a channel in one of its units; with its sample rate and the time of its first sample.
    fn push(
        &mut self,
        group: &str,
        channel: &Channel,
        slot: usize,
        rate: Option<(f64, f64)>,
        arrays: Vec<Array>,
    ) {
        let slot: &Slot = &channel.description.slots[slot];
        let kind = match &channel.description.encoding {
            Ok(_) => Kind::Numbers,
            Err(found) => Kind::Other(found.clone()),
        };
        let samples = arrays.iter().fold(0usize, |sum, array| sum.saturating_add(array.samples));
        let mut held = HeldArray::new(group, &slot.name_of(&channel.name), vec![samples], kind);
        held.unit = Some(slot.unit.clone()).filter(|unit| !unit.is_empty());
        if let Some((hz, start_s)) = rate {
            (held.sample_rate_hz, held.start_s) = (Some(hz), start_s);
        }
        self.held.push(held);
        self.sources.push(Source::Arrays(arrays));
    }
}

impl Channel {
    /// Its array in one of its units.
    fn array(&self, slot: usize) -> Array {
        let description = Arc::clone(&self.description);
        Array { entry: self.entry, samples: self.samples, description, slot }
    }
}
