//! `--scale COL=FACTOR UNIT[/UNIT]`: what one unit of a column means, e.g. sensor volts in µm or command volts at the actuator.

use hysteron_model::record::{Record, Unit};

/// One channel's scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    channel: String,
    factor: f64,
    unit: Unit,
    /// Unit the factor is per; `None`: the column's own.
    per: Option<Unit>,
}

/// Parses `y=2.5um/V`, `y=2.5um` or `u=15V/V`.
pub fn parse(text: &str) -> Result<Scale, String> {
    let form = || "expected COL=FACTOR and a unit, e.g. y=2.5um/V".to_owned();
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
        return Err("the factor must be finite and not 0".into());
    }
    Ok(Scale { channel: channel.trim().to_owned(), factor, unit: Unit::new(unit), per: per.map(Unit::new) })
}

impl Scale {
    /// The record with the channel scaled.
    ///
    /// # Errors
    /// A sentence: no such channel, or one in a unit that has nothing to do with the factor's.
    pub fn apply(&self, record: &Record) -> Result<Record, String> {
        let mut factor = self.factor;
        if let (Some(per), Some(channel)) = (&self.per, record.channel(&self.channel))
            && !channel.unit.symbol().is_empty()
        {
            let ((quantity, base), (per_quantity, per_base)) = (channel.unit.base(), per.base());
            if channel.unit != *per {
                if quantity != per_quantity || !(channel.unit.is_known() && per.is_known()) {
                    return Err(format!(
                        "column `{}` is in {}, --scale is per {per}",
                        self.channel, channel.unit
                    ));
                }
                factor *= base / per_base;
            }
        }
        record.with_channel_scaled(&self.channel, factor, self.unit.clone()).map_err(|e| e.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_model::record::{Channel, TimeBase};

    fn scaled(text: &str, unit: &str) -> Result<(String, f64), String> {
        let channel = Channel::new("y", unit, vec![1.0, 2.0]);
        let record = Record::new("r", TimeBase::uniform(1.0), vec![channel]).unwrap();
        let scaled = parse(text)?.apply(&record)?;
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
    fn nonsense_is_refused_with_the_form_or_the_units() {
        for text in ["y", "y=", "y=um", "y=2.5", "=2um", "y=2um/", "y=/V", "y=nan um", "y=0um", "y=1e999um"] {
            assert!(parse(text).is_err(), "{text}");
        }
        assert_eq!(scaled("y=2um/V", "N"), Err("column `y` is in N, --scale is per V".into()));
        assert!(scaled("z=2um", "V").unwrap_err().contains("no channel `z`"));
    }
}
