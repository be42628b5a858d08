//! Scale of a channel, e.g. of sensor volts in µm or of command volts at the actuator.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::{Record, RecordError, Unit};

/// Scale of one channel, parsed from `y=2.5um/V`, `y=2.5um` or `u=15V/V`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Scale {
    channel: String,
    factor: f64,
    unit: Unit,
    /// Unit the factor is per; `None`: the column's own.
    per: Option<Unit>,
}

impl FromStr for Scale {
    type Err = RecordError;

    fn from_str(text: &str) -> Result<Self, RecordError> {
        let form = || RecordError::ScaleText("expected COL=FACTOR and a unit, e.g. y=2.5um/V");
        let (channel, scale) = text.split_once('=').ok_or_else(form)?;
        let (scale, per) = match scale.split_once('/') {
            Some((scale, per)) => (scale, Some(per.trim())),
            None => (scale, None),
        };
        // The longest beginning that is a number is the factor: `1e3um` is a thousand µm, not one `e3um`.
        let ends = scale.char_indices().map(|(i, c)| i + c.len_utf8()).rev();
        let number = |end: usize| scale.get(..end)?.trim().parse::<f64>().ok().map(|factor| (factor, end));
        let (factor, end) = ends.into_iter().find_map(number).ok_or_else(form)?;
        let unit = scale.get(end..).unwrap_or_default().trim();
        if channel.trim().is_empty() || unit.is_empty() || per.is_some_and(str::is_empty) {
            return Err(form());
        }
        if !(factor.is_finite() && factor != 0.0) {
            return Err(RecordError::ScaleText("the factor must be finite and not 0"));
        }
        Ok(Scale {
            channel: channel.trim().to_owned(),
            factor,
            unit: Unit::new(unit),
            per: per.map(Unit::new),
        })
    }
}

/// The text it is parsed from: `y=2.5um/V`.
impl fmt::Display for Scale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}{}", self.channel, self.factor, self.unit.symbol())?;
        self.per.as_ref().map_or(Ok(()), |per| write!(f, "/{}", per.symbol()))
    }
}

impl TryFrom<String> for Scale {
    type Error = RecordError;

    fn try_from(text: String) -> Result<Self, RecordError> {
        text.parse()
    }
}

impl From<Scale> for String {
    fn from(scale: Scale) -> Self {
        scale.to_string()
    }
}

impl Scale {
    /// Channel that is scaled, as it was named.
    pub fn channel(&self) -> &str {
        &self.channel
    }

    /// The record with the channel scaled.
    ///
    /// # Errors
    /// [`RecordError::ScaleUnit`] for a unit of another quantity than the factor's; those of
    /// [`Record::with_channel_scaled`].
    pub fn apply(&self, record: &Record) -> Result<Record, RecordError> {
        let mut factor = self.factor;
        if let (Some(per), Some(channel)) = (&self.per, record.channel(&self.channel))
            && !channel.unit.symbol().is_empty()
        {
            let ((quantity, base), (per_quantity, per_base)) = (channel.unit.base(), per.base());
            if channel.unit != *per {
                if quantity != per_quantity || !(channel.unit.is_known() && per.is_known()) {
                    return Err(RecordError::ScaleUnit {
                        record: record.name.clone(),
                        channel: self.channel.clone(),
                        unit: channel.unit.to_string(),
                        per: per.to_string(),
                    });
                }
                factor *= base / per_base;
            }
        }
        record.with_channel_scaled(&self.channel, factor, self.unit.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{Channel, TimeBase};

    fn scaled(text: &str, unit: &str) -> Result<(String, f64), String> {
        let channel = Channel::new("y", unit, vec![1.0, 2.0]);
        let record = Record::new("r", TimeBase::uniform(1.0), vec![channel]).unwrap();
        let scale: Scale = text.parse().map_err(|e: RecordError| e.to_string())?;
        let scaled = scale.apply(&record).map_err(|e| e.to_string())?;
        Ok((scaled.channels[0].header(), scaled.channels[0].samples[1]))
    }

    #[test]
    fn a_factor_is_per_the_unit_named_or_the_columns_own() {
        assert_eq!(scaled("y=2.5um/V", "V"), Ok(("y_um".into(), 5.0)));
        assert_eq!(scaled("y=2.5um", "V"), Ok(("y_um".into(), 5.0)));
        assert_eq!(scaled("y=2500um/V", "mV"), Ok(("y_um".into(), 5.0)));
        assert_eq!(scaled("y = -1e3 µm / V", "V"), Ok(("y_um".into(), -2000.0)));
        assert_eq!(scaled("y=15V/V", "V"), Ok(("y_V".into(), 30.0)));
        assert_eq!(scaled("y=3um/V", ""), Ok(("y_um".into(), 6.0)));
    }

    #[test]
    fn a_scale_comes_back_from_its_text() {
        for text in ["y=2.5um/V", "y=-1000um", "u=1e-7V/mV"] {
            let scale: Scale = text.parse().unwrap();
            assert_eq!(scale.to_string().parse(), Ok(scale.clone()), "{text}");
            let json = serde_json::to_string(&scale).unwrap();
            assert_eq!(serde_json::from_str::<Scale>(&json).unwrap(), scale, "{json}");
        }
    }

    #[test]
    fn nonsense_is_refused_with_the_form_or_the_units() {
        for text in ["y", "y=", "y=um", "y=2.5", "=2um", "y=2um/", "y=/V", "y=nan um", "y=0um", "y=1e999um"] {
            assert!(text.parse::<Scale>().is_err(), "{text}");
        }
        assert!(scaled("y=2um/V", "N").unwrap_err().contains("`y` is in N, its scale is per V"));
        assert!(scaled("z=2um", "V").unwrap_err().contains("no channel `z`"));
    }
}
