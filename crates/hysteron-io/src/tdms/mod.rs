//! TDMS: segments of raw data as LabVIEW writes them; each channel is a column, its path `group/channel`.

mod number;
mod property;
mod scaling;
mod segment;
mod values;

use std::collections::HashMap;

use crate::IoError;
use crate::columns::{Columns, Kind};
use crate::container::{self, HeldArray};
use crate::hash::sha256;
use crate::place::{FilePart, Place};
use crate::reader::{Input, Reader};
use property::{Properties, Value};
use scaling::Scaling;
use segment::{Contents, TAG};

/// Files of LabVIEW and other programs of National Instruments.
pub(crate) const READER: Reader =
    Reader { extensions: &["tdms"], recognises: |head| head.starts_with(TAG), read };

/// A channel of a file.
struct Channel {
    /// Number of the object.
    object: usize,
    held: HeldArray,
    scaling: Scaling,
}

fn read(mut input: Input<'_>) -> Result<Columns, IoError> {
    let file = input.read_to_end()?;
    let place = Place::new(input.file, FilePart::Whole);
    let malformed = |problem| IoError::Malformed { place: place.clone(), format: "TDMS", problem };
    let contents = Contents::read(&file).map_err(malformed)?;
    let channels = channels(&contents);
    if channels.is_empty() {
        return Err(malformed("it holds no channels".to_owned()));
    }
    let held: Vec<HeldArray> = channels.iter().map(|channel| channel.held.clone()).collect();
    container::columns(input, &held, sha256(&file), |index| {
        let mut values = values::raw_values(&file, &contents, channels[index].object);
        channels[index].scaling.apply(&mut values);
        Ok(values)
    })
}

/// The channels of all groups.
fn channels(contents: &Contents) -> Vec<Channel> {
    let none = Properties::new();
    let by_path: HashMap<&[String], &Properties> =
        contents.objects.iter().map(|object| (object.path.as_slice(), &object.properties)).collect();
    let properties = |path: &[String]| by_path.get(path).copied().unwrap_or(&none);
    let mut channels = Vec::new();
    for (number, object) in contents.objects.iter().enumerate() {
        let [group, name] = object.path.as_slice() else { continue };
        let own = &object.properties;
        let scaling = Scaling::new(&[own, properties(std::slice::from_ref(group)), properties(&[])]);
        let kind = match (&object.refused, &scaling) {
            (Some(found), _) | (None, Err(found)) => Kind::Other(found.clone()),
            (None, Ok(_)) => Kind::Numbers,
        };
        let samples = usize::try_from(object.values).unwrap_or(usize::MAX);
        let mut held = HeldArray::new(&format!("{group}/"), name, vec![samples], kind);
        let unit = own.get("unit_string").and_then(Value::text);
        held.unit = unit.or(object.timestamps.then_some("s")).map(str::to_owned);
        let seconds = |name: &str| own.get(name).and_then(Value::number).filter(|s| s.is_finite());
        // LabVIEW writes an increment of 0 where there is none, and one in hertz for a spectrum.
        let of_time =
            own.get("wf_xunit_string").and_then(Value::text).is_none_or(|unit| ["", "s"].contains(&unit));
        held.sample_rate_hz = seconds("wf_increment").filter(|&s| s > 0.0 && of_time).map(f64::recip);
        held.start_s = seconds("wf_start_offset").unwrap_or(0.0);
        channels.push(Channel { object: number, held, scaling: scaling.unwrap_or_default() });
    }
    channels
}
