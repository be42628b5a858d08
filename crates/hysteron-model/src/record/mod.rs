//! Measured records: named channels with units on one time base.
//!
//! A [`Record`] holds the channels of a file; [`Record::input_output`] takes the two that a fit works with,
//! in its units, as [`InputOutput`]. Preparation returns new records: [`Record::cut`], [`Record::joined`],
//! [`Record::with_channel_scaled`], [`Record::with_trend_removed`], [`Record::resampled`], and several of
//! these in turn [`Prepare`]; [`InputOutput::cropped`], [`InputOutput::decimated`],
//! [`InputOutput::with_offset_removed`], [`InputOutput::with_drift_removed`]. Properties of a record are
//! found by [`find_periods`], [`noise_floor`], [`linear_drift`], [`find_delay`], [`loop_shape`],
//! [`excitation_kind`], and all at once, with the reasons in plain words, by [`inspect`].
//!
//! A time base gives the time of a sample ([`TimeBase::time_s`]) and its rate, where it has one; its kinds
//! are known only here, so that segments of different rates could be one more kind.

mod channel;
mod crop;
mod cut;
mod dead_band;
mod delay;
mod detrend;
mod error;
mod excitation_kind;
mod frequency_response;
mod further_drives;
mod gaps;
mod inspect;
mod inspection_summary;
mod inter_sample;
mod join;
mod keyed;
mod loop_shape;
mod noise_floor;
mod periods;
mod pieces;
mod plausibility;
mod prepare;
mod rates;
mod resample;
mod runs;
mod scale;
mod segments;
mod selection;
mod sensor;
mod servo;
mod start_up;
mod swings;
mod time_base;
mod timing;
mod trend;
mod turning_points;
mod unit;

pub use channel::{header_of, split_header};
pub use cut::{Admitted, Condition, Cut, CutError, Turns};
pub use dead_band::{DeadBand, DeadBandError};
pub use delay::{
    DelayFinding, Response, delay_from_phase, find_delay, fundamental_response, low_frequency_responses,
};
pub use detrend::Trend;
pub use error::RecordError;
pub use excitation_kind::{ExcitationKind, WaveShape, excitation_kind};
#[doc(hidden)]
pub use frequency_response::NOISY;
pub use frequency_response::{FrequencyResponse, unwrapped_phase_deg};
pub use gaps::Gap;
pub use inspect::{Inspection, inspect};
pub use inspection_summary::{
    ChannelSummary, DelaySummary, DriveSummary, InspectionFinding, InspectionSummary, LoopSummary,
    PeriodsSummary,
};
pub use inter_sample::InterSample;
pub use keyed::{Keyed, key_in};
pub use loop_shape::{LoopSense, LoopShape, loop_shape};
pub use noise_floor::{NoiseFloor, NoiseMethod, noise_floor};
pub use periods::{Periods, find_periods};
pub use pieces::{GAP_PERIODS, UniformSegment, even_times};
pub use plausibility::implausible_units;
pub use prepare::{ColumnRange, Prepare, Prepared, PreparedSummary, Step};
#[doc(hidden)]
pub use rates::{Dependence, Pace, paces_on};
pub use resample::low_pass;
pub use runs::{MeasurementRun, RunPart, follow_each_other};
pub use scale::Scale;
pub use segments::Segment;
pub use selection::{ChannelChoice, Driven, Selection, Signal};
pub use sensor::{Clipping, clipping, quantisation_step};
pub use servo::{Servo, servo};
pub use start_up::{StartUp, fit_start_up};
pub use swings::{Swings, oscillation_hz};
pub use time_base::{GIVEN_RATE_TOLERANCE, UNIFORM_TOLERANCE_SAMPLES};
pub use timing::Timing;
pub use trend::{LinearDrift, linear_drift};
pub use turning_points::{TurningPoint, shortest_swing, turning_points};
#[doc(hidden)]
pub use turning_points::{ends_of, range_of, span};
pub use unit::{Quantity, Unit};

/// Largest magnitude of a sample, in any unit: the sum of squares of all samples of a record stays finite.
pub const MOST_MAGNITUDE: f64 = 1e100;
/// Sample rates \[Hz\]: from one sample in thirty years to one a picosecond.
pub const RATES_HZ: std::ops::RangeInclusive<f64> = 1e-9..=1e12;

/// One measured (or simulated) run: named channels with units on one time base. Never changed in place:
/// every preparation step returns a new record.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Short name for messages and reports, usually the file name.
    pub name: String,
    /// When the samples were taken.
    pub time: TimeBase,
    /// The channels, all of the same length.
    pub channels: Vec<Channel>,
    /// Sample mask (`valid` column of a file): `false` samples are not scored. `None`: all are valid.
    pub valid: Option<Vec<bool>>,
    /// Where the record came from; `None` for one made in memory.
    pub source: Option<Source>,
}

/// One channel of a [`Record`].
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name without the unit, e.g. `u`, `y`, `u_cmd`.
    pub name: String,
    /// Unit of the samples.
    pub unit: Unit,
    /// The samples, finite.
    pub samples: Vec<f64>,
}

/// When the samples of a [`Record`] were taken.
#[derive(Clone, Debug, PartialEq)]
pub enum TimeBase {
    /// Sample k at `start_s + k / sample_rate_hz`.
    Uniform {
        /// Time of the first sample \[s\].
        start_s: f64,
        /// Sample rate \[Hz\].
        sample_rate_hz: f64,
        /// Largest deviation of a time stamp from the uniform grid, in sample periods (0 where made or
        /// given).
        jitter_samples: f64,
    },
    /// One time stamp \[s\] per sample, increasing but not uniform: fine for a static fit, refused for
    /// dynamics.
    NonUniform {
        /// Time stamps \[s\].
        times_s: Vec<f64>,
    },
    /// No time column and no sample rate given: fine for a static fit only.
    Unknown,
}

/// File a record was read from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Path as given by the user.
    pub path: String,
    /// SHA-256 of the file's bytes, lower-case hexadecimal.
    pub sha256: String,
}

/// One input and one output of a [`Record`], in the units a fit works in (lengths in µm, angles in µrad).
#[derive(Clone, Debug, PartialEq)]
pub struct InputOutput {
    /// Name of the record.
    pub name: String,
    /// When the samples were taken.
    pub time: TimeBase,
    /// Input samples (drive voltage \[V\]).
    pub u: Vec<f64>,
    /// Output samples (displacement \[µm\] where the output is a length).
    pub y: Vec<f64>,
    /// Rate of the input where it was measured, in its unit per second ([`crate::force::with_rate`]).
    pub rate: Option<Vec<f64>>,
    /// Sample mask; `None`: all valid.
    pub valid: Option<Vec<bool>>,
    /// Name of the input channel.
    pub input: String,
    /// Name of the output channel.
    pub output: String,
    /// Unit of `u`.
    pub u_unit: Unit,
    /// Unit of `y`.
    pub y_unit: Unit,
    /// Where the record came from.
    pub source: Option<Source>,
}

impl Record {
    /// A record without mask or source, checked.
    ///
    /// # Errors
    /// Those of [`Record::check`].
    pub fn new(name: &str, time: TimeBase, channels: Vec<Channel>) -> Result<Self, RecordError> {
        let record = Record { name: name.to_string(), time, channels, valid: None, source: None };
        record.check()?;
        Ok(record)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.channels.first().map_or(0, |c| c.samples.len())
    }

    /// True if there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The channel of this bare name or header, if there is exactly one.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        let mut found = self.channels.iter().filter(|c| c.is_called(name));
        match (found.next(), found.next()) {
            (Some(one), None) => Some(one),
            _ => None,
        }
    }

    /// Checks what every step relies on: at least one channel and two samples, all channels, stamps and mask
    /// of one length, finite samples, distinct printable names, a usable time base.
    ///
    /// # Errors
    /// The first of these that does not hold.
    pub fn check(&self) -> Result<(), RecordError> {
        let record = || self.name.clone();
        if self.channels.is_empty() {
            return Err(RecordError::NoChannels { record: record() });
        }
        let expected = self.len();
        if expected < 2 {
            return Err(RecordError::TooShort {
                record: record(),
                got: expected,
                need: 2,
                purpose: "a record",
            });
        }
        let mismatch = |what: String, got: usize| RecordError::LengthMismatch {
            record: self.name.clone(),
            what,
            got,
            expected,
        };
        for (i, channel) in self.channels.iter().enumerate() {
            let name = &channel.name;
            if name.is_empty() || name.trim() != name || name.chars().any(char::is_control) {
                return Err(RecordError::BadChannelName { record: record(), name: name.clone() });
            }
            if channel.unit.symbol().chars().any(char::is_control) {
                return Err(RecordError::BadUnit { record: record(), channel: name.clone() });
            }
            if self.channels[..i].iter().any(|c| c.name == *name && c.unit == channel.unit) {
                return Err(RecordError::DuplicateChannel { record: record(), channel: channel.header() });
            }
            if channel.samples.len() != expected {
                return Err(mismatch(format!("channel `{name}`"), channel.samples.len()));
            }
            if let Some(index) = channel.samples.iter().position(|x| !x.is_finite()) {
                return Err(RecordError::NotFinite {
                    record: record(),
                    channel: name.clone(),
                    index,
                    value: channel.samples[index],
                });
            }
            if let Some(index) = channel.samples.iter().position(|x| x.abs() > MOST_MAGNITUDE) {
                return Err(RecordError::TooLarge {
                    record: record(),
                    channel: name.clone(),
                    index,
                    value: channel.samples[index],
                });
            }
        }
        if let Some(valid) = &self.valid
            && valid.len() != expected
        {
            return Err(mismatch("the `valid` mask".to_string(), valid.len()));
        }
        match &self.time {
            TimeBase::Uniform { sample_rate_hz, .. } => time_base::check_rate(&self.name, *sample_rate_hz),
            TimeBase::NonUniform { times_s } if times_s.len() != expected => {
                Err(mismatch("the time column".to_string(), times_s.len()))
            }
            TimeBase::NonUniform { times_s } => time_base::check_times(&self.name, times_s),
            TimeBase::Unknown => Ok(()),
        }
    }
}

/// Masks the first `samples` of `len` samples as not valid.
pub(crate) fn mask_first(valid: &mut Option<Vec<bool>>, len: usize, samples: usize) {
    if samples > 0 {
        let mask = valid.get_or_insert_with(|| vec![true; len]);
        mask.iter_mut().take(samples).for_each(|valid| *valid = false);
    }
}

impl InputOutput {
    /// Input and output made in memory: `u` \[V\], `y` \[µm\], all samples valid, checked.
    ///
    /// # Errors
    /// Those of [`Record::check`].
    pub fn new(name: &str, time: TimeBase, u: Vec<f64>, y: Vec<f64>) -> Result<Self, RecordError> {
        Record::new(name, time, vec![Channel::new("u", "V", u), Channel::new("y", "um", y)])?
            .input_output(&ChannelChoice::default())
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.u.len()
    }

    /// True if there is no sample.
    pub fn is_empty(&self) -> bool {
        self.u.is_empty()
    }

    /// Path of the record's file, or its name if it has none.
    pub fn label(&self) -> &str {
        self.source.as_ref().map_or(&self.name, |s| &s.path)
    }

    /// True if sample `k` is valid; nothing beyond the mask is.
    pub fn is_valid(&self, k: usize) -> bool {
        self.valid.as_ref().is_none_or(|mask| mask.get(k) == Some(&true))
    }

    /// The record with its first `samples` samples masked as not valid.
    pub fn without_first(&self, samples: usize) -> Self {
        let mut masked = self.clone();
        mask_first(&mut masked.valid, self.len(), samples);
        masked
    }

    /// The first samples of the record, at most so many.
    pub fn first_samples(&self, samples: usize) -> Self {
        let mut first = self.clone();
        first.u.truncate(samples);
        first.y.truncate(samples);
        first.rate.iter_mut().for_each(|rate| rate.truncate(samples));
        first.valid.iter_mut().for_each(|valid| valid.truncate(samples));
        if let TimeBase::NonUniform { times_s } = &mut first.time {
            times_s.truncate(samples);
        }
        first
    }

    /// Sample rate \[Hz\], if the time base is uniform.
    pub fn sample_rate_hz(&self) -> Option<f64> {
        match self.time {
            TimeBase::Uniform { sample_rate_hz, .. } => Some(sample_rate_hz),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn base() -> TimeBase {
        TimeBase::uniform(100.0)
    }

    #[test]
    fn a_record_is_checked_when_made() {
        let two = |n| vec![0.5; n];
        let made = |channels| Record::new("r", base(), channels);
        assert!(made(vec![Channel::new("u", "V", two(2))]).is_ok());
        assert!(matches!(made(vec![]), Err(RecordError::NoChannels { .. })));
        assert!(matches!(
            made(vec![Channel::new("u", "V", two(1))]),
            Err(RecordError::TooShort { got: 1, need: 2, .. })
        ));
        let err = made(vec![Channel::new("u", "V", two(5)), Channel::new("y", "um", two(4))]).unwrap_err();
        assert_eq!(
            err.to_string(),
            "record `r`: channel `y` has 4 entries where the first channel has 5 samples; all must be of one \
             length"
        );
        let err = made(vec![Channel::new("u", "V", vec![0.0, f64::INFINITY])]).unwrap_err();
        assert!(err.to_string().contains("sample 1: inf"), "{err}");
        assert!(matches!(
            made(vec![Channel::new("u", "V", two(2)), Channel::new("u", "V", two(2))]),
            Err(RecordError::DuplicateChannel { .. })
        ));
        assert!(matches!(
            made(vec![Channel::new(" u", "V", two(2))]),
            Err(RecordError::BadChannelName { .. })
        ));
        assert!(matches!(
            Record::new("r", TimeBase::uniform(f64::NAN), vec![Channel::new("u", "V", two(2))]),
            Err(RecordError::BadSampleRate { .. })
        ));
    }

    #[test]
    fn a_channel_is_found_by_name_or_header_unless_two_share_the_name() {
        let record = Record::new(
            "r",
            base(),
            vec![
                Channel::new("u", "V", vec![0.0; 2]),
                Channel::new("u", "mV", vec![1.0; 2]),
                Channel::new("y", "um", vec![2.0; 2]),
            ],
        )
        .unwrap();
        assert_eq!(record.channel("y").unwrap().samples[0], 2.0);
        assert_eq!(record.channel("u_mV").unwrap().samples[0], 1.0);
        assert!(record.channel("u").is_none());
    }
}
