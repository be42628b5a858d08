//! Several inputs and several outputs of a record.

use super::AxesError;
use crate::record::{Channel, Record, Source, TimeBase, Unit, mask_first};

/// Inputs and outputs of a [`Record`] in the units a fit works in: voltages in V, lengths in µm, angles in
/// µrad.
#[derive(Clone, Debug, PartialEq)]
pub struct AxesRecord {
    /// Name of the record.
    pub name: String,
    /// When the samples were taken.
    pub time: TimeBase,
    /// Sample rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Samples of each input \[V\].
    pub u: Vec<Vec<f64>>,
    /// Samples of each output \[µm\].
    pub y: Vec<Vec<f64>>,
    /// Sample mask; `None`: all valid.
    pub valid: Option<Vec<bool>>,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// Unit of the inputs.
    pub u_unit: Unit,
    /// Unit of the outputs.
    pub y_unit: Unit,
    /// Where the record came from.
    pub source: Option<Source>,
}

impl AxesRecord {
    /// The channels of these names (bare, `u1`, or with the unit, `u1_V`; else ignoring case), in this order.
    /// `outputs` may be empty for a drive alone.
    ///
    /// # Errors
    /// [`AxesError::NoInputs`] without inputs, [`AxesError::NoSuchChannel`], [`AxesError::Twice`],
    /// [`AxesError::Units`], [`AxesError::NotUniform`].
    pub fn new(record: &Record, inputs: &[String], outputs: &[String]) -> Result<Self, AxesError> {
        record.check()?;
        if inputs.is_empty() {
            return Err(AxesError::NoInputs);
        }
        let TimeBase::Uniform { sample_rate_hz, .. } = record.time else {
            return Err(AxesError::NotUniform { record: record.name.clone() });
        };
        let mut taken = Vec::new();
        let mut all = |names: &[String], role| -> Result<(Vec<&Channel>, Unit), AxesError> {
            let mut channels = Vec::new();
            for name in names {
                let index = find(record, name)?;
                if taken.contains(&index) {
                    return Err(AxesError::Twice { channel: name.clone() });
                }
                taken.push(index);
                channels.push(&record.channels[index]);
            }
            let unit = one_unit(record, &channels, role)?;
            Ok((channels, unit))
        };
        let (u, u_unit) = all(inputs, "input")?;
        let (y, y_unit) = all(outputs, "output")?;
        let samples = |channels: &[&Channel]| channels.iter().map(|c| in_base_unit(c)).collect();
        let names = |channels: &[&Channel]| channels.iter().map(|c| c.name.clone()).collect();
        Ok(Self {
            name: record.name.clone(),
            time: record.time.clone(),
            sample_rate_hz,
            u: samples(&u),
            y: samples(&y),
            valid: record.valid.clone(),
            inputs: names(&u),
            outputs: names(&y),
            u_unit,
            y_unit,
            source: record.source.clone(),
        })
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.u.first().map_or(0, Vec::len)
    }

    /// True if there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The record with its first `samples` samples masked as not valid.
    pub fn without_first(&self, samples: usize) -> Self {
        let mut masked = self.clone();
        mask_first(&mut masked.valid, self.len(), samples);
        masked
    }

    /// Path of the file, else the name.
    pub fn label(&self) -> String {
        self.source.as_ref().map_or_else(|| self.name.clone(), |s| s.path.clone())
    }
}

fn find(record: &Record, name: &str) -> Result<usize, AxesError> {
    let exact = |c: &Channel| c.name == name || c.header() == name;
    let loose = |c: &Channel| {
        [c.name.clone(), c.header()].iter().any(|known| known.to_lowercase() == name.to_lowercase())
    };
    let mut found = record.channels.iter().position(exact);
    if found.is_none() {
        found = record.channels.iter().position(loose);
    }
    found.ok_or_else(|| AxesError::NoSuchChannel {
        record: record.name.clone(),
        channel: name.to_owned(),
        available: record.channels.iter().map(Channel::header).collect::<Vec<_>>().join(", "),
    })
}

fn one_unit(record: &Record, channels: &[&Channel], role: &'static str) -> Result<Unit, AxesError> {
    let Some(first) = channels.first() else { return Ok(Unit::new("")) };
    let unit = first.unit.base_unit();
    match channels.iter().find(|c| c.unit.base_unit() != unit) {
        None => Ok(unit),
        Some(other) => Err(AxesError::Units {
            record: record.name.clone(),
            role,
            first: first.unit.to_string(),
            other: other.unit.to_string(),
        }),
    }
}

fn in_base_unit(channel: &Channel) -> Vec<f64> {
    let factor = channel.unit.base().1;
    channel.samples.iter().map(|x| x * factor).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record() -> Record {
        let channel = |name: &str, unit: &str, first: f64| Channel::new(name, unit, vec![first, first + 1.0]);
        let channels = vec![
            channel("u1", "mV", 1.0),
            channel("u2", "V", 2.0),
            channel("y1", "nm", 3.0),
            channel("y2", "um", 4.0),
            channel("a", "urad", 5.0),
        ];
        Record::new("stage.csv", TimeBase::uniform(100.0), channels).unwrap()
    }

    fn names(all: &[&str]) -> Vec<String> {
        all.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn channels_come_in_the_order_named_and_in_one_unit() {
        let r = AxesRecord::new(&record(), &names(&["u2", "U1_mV"]), &names(&["y2_um", "y1"])).unwrap();
        assert_eq!(r.u, [[2.0, 3.0], [1e-3, 2e-3]]);
        assert_eq!(r.y, [[4.0, 5.0], [3e-3, 4e-3]]);
        assert_eq!((r.u_unit.symbol(), r.y_unit.symbol()), ("V", "um"));
        assert_eq!((r.inputs, r.outputs), (names(&["u2", "u1"]), names(&["y2", "y1"])));
        assert!(AxesRecord::new(&record(), &names(&["u1"]), &[]).unwrap().y.is_empty());
    }

    #[test]
    fn what_cannot_be_taken_is_named() {
        let refuse = |inputs: &[&str], outputs: &[&str]| {
            AxesRecord::new(&record(), &names(inputs), &names(outputs)).unwrap_err().to_string()
        };
        assert!(refuse(&["u3"], &["y1"]).contains("no channel `u3`; there are u1_mV, u2_V"));
        assert!(refuse(&["u1", "u1_mV"], &["y1"]).contains("named twice"));
        assert!(refuse(&["u1"], &["u1"]).contains("named twice"));
        assert!(refuse(&["u1"], &["y1", "a"]).contains("nm and µrad"));
        assert!(refuse(&[], &["y1"]).contains("no input"));
        let uneven = Record { time: TimeBase::Unknown, ..record() };
        assert!(matches!(
            AxesRecord::new(&uneven, &names(&["u1"]), &names(&["y1"])),
            Err(AxesError::NotUniform { .. })
        ));
    }
}
