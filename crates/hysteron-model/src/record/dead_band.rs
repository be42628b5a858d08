//! Dead band of a device or an amplifier: a drive below a threshold does nothing.

use super::selection::in_base_unit;
use super::{ChannelChoice, Record, RecordError};
use crate::finding::{Finding, FindingKind};

/// What counts of a drive, by a threshold d > 0 in the unit of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeadBand {
    /// u where |u| ≥ d, else 0: an amplifier with a threshold.
    Jump(f64),
    /// The excess sign(u) (|u| − d) where |u| ≥ d, else 0: a valve with overlap, backlash about a centre.
    Excess(f64),
}

/// Thresholds that are none of a drive.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DeadBandError {
    /// Two thresholds of one drive.
    #[error("a drive has a dead band or a dead zone, not both")]
    Both,
    /// A threshold that is not positive.
    #[error("expected a positive threshold of the drive, found {0}")]
    NotPositive(f64),
}

impl DeadBand {
    /// A dead band ([`DeadBand::Jump`]) or a dead zone ([`DeadBand::Excess`]), where one is given.
    ///
    /// # Errors
    /// [`DeadBandError`] where both are given, or the threshold is not positive.
    pub fn given(dead_band: Option<f64>, dead_zone: Option<f64>) -> Result<Option<Self>, DeadBandError> {
        let band = match (dead_band, dead_zone) {
            (None, None) => return Ok(None),
            (Some(threshold), None) => Self::Jump(threshold),
            (None, Some(threshold)) => Self::Excess(threshold),
            (Some(_), Some(_)) => return Err(DeadBandError::Both),
        };
        let threshold = band.threshold();
        let is_positive = threshold.is_finite() && threshold > 0.0;
        if is_positive { Ok(Some(band)) } else { Err(DeadBandError::NotPositive(threshold)) }
    }

    /// The threshold d.
    pub fn threshold(self) -> f64 {
        match self {
            Self::Jump(threshold) | Self::Excess(threshold) => threshold,
        }
    }

    /// What counts of a drive `u`.
    pub fn of(self, u: f64) -> f64 {
        match self {
            _ if u.abs() < self.threshold() => 0.0,
            Self::Jump(_) => u,
            Self::Excess(threshold) => u - threshold.copysign(u),
        }
    }

    /// Replaces a drive by what counts of it; returns a finding with the number of samples that count as 0.
    pub fn apply(self, u: &mut [f64]) -> Finding {
        let count = u.iter().filter(|u| u.abs() < self.threshold()).count();
        u.iter_mut().for_each(|u| *u = self.of(*u));
        let threshold = self.threshold();
        let rest = match self {
            Self::Jump(_) => String::new(),
            Self::Excess(_) => format!("; that of the others is less by {threshold}"),
        };
        let text = format!("the drive of {count} samples is below {threshold} and counts as 0{rest}");
        Finding::new(FindingKind::Advice, "dead band", text)
    }
}

impl Record {
    /// This record with what counts of its input in place of it, in the base unit that the threshold has too
    /// (V for a column in mV); and the finding of [`DeadBand::apply`].
    ///
    /// # Errors
    /// Those of [`Record::drive`], where the choice does not determine the input.
    pub fn with_dead_band(
        &self,
        band: DeadBand,
        choice: &ChannelChoice,
    ) -> Result<(Self, Finding), RecordError> {
        let selected = self.select(choice).map(|selection| selection.input);
        let input = selected.or_else(|_| self.input_position(choice.input.as_deref()))?;
        let mut counted = self.clone();
        let channel = &mut counted.channels[input];
        (channel.samples, channel.unit) = in_base_unit(channel);
        let told = band.apply(&mut channel.samples);
        Ok((counted, told))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{Channel, TimeBase};

    #[test]
    fn the_input_of_a_record_is_replaced_by_what_counts() {
        let channels =
            vec![Channel::new("y", "um", vec![1.0, 2.0]), Channel::new("u", "mV", vec![1500.0, -2500.0])];
        let record = Record::new("r", TimeBase::uniform(1.0), channels).unwrap();
        let (counted, told) =
            record.with_dead_band(DeadBand::Excess(2.0), &ChannelChoice::default()).unwrap();
        assert_eq!(counted.channels[1].header(), "u_V");
        assert_eq!(counted.channels[1].samples, [0.0, -0.5]);
        assert_eq!(counted.channels[0], record.channels[0]);
        assert!(told.text.contains("of 1 samples is below 2"), "{}", told.text);
        let other = ChannelChoice { input: Some("z".to_owned()), output: None };
        assert!(record.with_dead_band(DeadBand::Jump(2.0), &other).is_err());
        // A drive alone.
        let drive = Record { channels: vec![record.channels[1].clone()], ..record };
        let (counted, _) = drive.with_dead_band(DeadBand::Jump(2.0), &ChannelChoice::default()).unwrap();
        assert_eq!(counted.channels[0].samples, [0.0, -2.5]);
    }

    #[test]
    fn a_drive_has_one_positive_threshold_or_none() {
        assert_eq!(DeadBand::given(None, None), Ok(None));
        assert_eq!(DeadBand::given(None, Some(2.0)), Ok(Some(DeadBand::Excess(2.0))));
        assert_eq!(DeadBand::given(Some(2.0), Some(2.0)), Err(DeadBandError::Both));
        assert_eq!(DeadBand::given(Some(-0.5), None), Err(DeadBandError::NotPositive(-0.5)));
        assert!(DeadBand::given(Some(f64::NAN), None).is_err());
    }

    #[test]
    fn a_drive_below_the_threshold_counts_as_nothing() {
        let drive = [-3.0, -2.0, -1.0, 0.0, 1.5, 2.5];
        for (band, expected) in [
            (DeadBand::Jump(2.0), [-3.0, -2.0, 0.0, 0.0, 0.0, 2.5]),
            (DeadBand::Excess(2.0), [-1.0, 0.0, 0.0, 0.0, 0.0, 0.5]),
        ] {
            let mut u = drive;
            let told = band.apply(&mut u).text;
            assert_eq!(u, expected);
            assert!(told.contains("of 3 samples is below 2"), "{told}");
        }
    }
}
