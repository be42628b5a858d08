//! Errors of a record.

use hysteron_numeric::display::{exact, short};

use super::time_base::NO_TIMES;
use super::{MOST_MAGNITUDE, RATES_HZ};
use crate::advice::{Advice, ColumnRole};

/// Fault of a record, or the reason why a step cannot be done with it. Sample indices count from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// A record without channels.
    #[error("record `{record}` has no channels: it needs at least one column of samples")]
    NoChannels {
        /// Name of the record.
        record: String,
    },
    /// Too few samples for what was asked.
    #[error("record `{record}` has {got} sample(s), but {purpose} needs at least {need}")]
    TooShort {
        /// Name of the record.
        record: String,
        /// Samples found.
        got: usize,
        /// Samples needed.
        need: usize,
        /// Purpose they are needed for.
        purpose: &'static str,
    },
    /// Channels, times or mask of different lengths.
    #[error(
        "record `{record}`: {what} has {got} entries where the first channel has {expected} samples; all \
         must be of one length"
    )]
    LengthMismatch {
        /// Name of the record.
        record: String,
        /// The channel, the time stamps or the mask.
        what: String,
        /// Entries found.
        got: usize,
        /// Samples of the first channel.
        expected: usize,
    },
    /// NaN or infinity in a channel.
    #[error(
        "record `{record}`, channel `{channel}`, sample {index}: {value} is not a finite number; cut the \
         record there, or fill the gap from its neighbours and mark it 0 in a `valid` column",
        value = exact(*.value)
    )]
    NotFinite {
        /// Name of the record.
        record: String,
        /// Name of the channel.
        channel: String,
        /// Sample index, from 0.
        index: usize,
        /// The value found.
        value: f64,
    },
    /// A sample beyond what any quantity measures, with which sums of squares overflow.
    #[error(
        "record `{record}`, channel `{channel}`, sample {index}: {value:e} is larger than any measured quantity \
         (at most {MOST_MAGNITUDE:e}); check the file's numbers"
    )]
    TooLarge {
        /// Name of the record.
        record: String,
        /// Name of the channel.
        channel: String,
        /// Sample index, from 0.
        index: usize,
        /// The value found.
        value: f64,
    },
    /// A channel name that cannot be written to a file and read back.
    #[error(
        "record `{record}`: `{}` is not a channel name; use printable characters, not empty, no blanks at \
         the ends",
        name.escape_debug()
    )]
    BadChannelName {
        /// Name of the record.
        record: String,
        /// The name found.
        name: String,
    },
    /// A unit that cannot be written to a file and read back.
    #[error("record `{record}`: the unit of channel `{channel}` has control characters; use printable ones")]
    BadUnit {
        /// Name of the record.
        record: String,
        /// Name of the channel.
        channel: String,
    },
    /// Two channels with the same header.
    #[error("record `{record}` has two channels `{channel}`; rename one of them")]
    DuplicateChannel {
        /// Name of the record.
        record: String,
        /// Header (name and unit) of both.
        channel: String,
    },
    /// The chosen channel does not exist.
    #[error(
        "record `{record}` has no channel `{asked}` to be the {role}; it has {available}; choose one of them"
    )]
    NoSuchChannel {
        /// Name of the record.
        record: String,
        /// The channel requested.
        asked: String,
        /// Role it is chosen for.
        role: ColumnRole,
        /// The channels there are.
        available: String,
    },
    /// Several channels could be meant.
    #[error("record `{record}`: which of {candidates} is the {role}? Choose one")]
    AmbiguousChannel {
        /// Name of the record.
        record: String,
        /// Role to be filled.
        role: ColumnRole,
        /// The channels that could be meant.
        candidates: String,
        /// The first of them, for the example.
        first: String,
    },
    /// No channel looks like the input or the output.
    #[error("record `{record}`: none of {available} looks like the {role} ({expected}); choose one")]
    NoCandidate {
        /// Name of the record.
        record: String,
        /// Role to be filled.
        role: ColumnRole,
        /// Features of such a channel.
        expected: &'static str,
        /// The channels there are.
        available: String,
    },
    /// One channel only, where an input and an output are needed.
    #[error(
        "record `{record}` has only one channel besides time, {channel}: a fit needs two, the drive (e.g. \
         `u_V`) and the displacement (e.g. `y_um`); measure both in one file"
    )]
    OnlyOneChannel {
        /// Name of the record.
        record: String,
        /// Its only channel.
        channel: String,
    },
    /// Input and output are the same channel.
    #[error(
        "record `{record}`: `{channel}` is chosen both as input and as output; choose another for one of them"
    )]
    SameChannel {
        /// Name of the record.
        record: String,
        /// The channel chosen twice.
        channel: String,
    },
    /// A channel whose unit cannot belong to its role.
    #[error(
        "record `{record}`: channel `{channel}` is in {unit}, which cannot be the unit of the {role}; \
         expected {expected}: correct the unit in the column's header, or choose another column"
    )]
    WrongUnit {
        /// Name of the record.
        record: String,
        /// Role of the channel.
        role: ColumnRole,
        /// The channel.
        channel: String,
        /// Its unit.
        unit: String,
        /// Accepted units.
        expected: &'static str,
    },
    /// Time stamps that run backwards.
    #[error(
        "record `{record}`: time runs backwards at sample {index}: {after} s follows {before} s; sort the \
         rows, or split the file where the clock was reset",
        after = exact(*.after),
        before = exact(*.before)
    )]
    TimeDecreases {
        /// Name of the record.
        record: String,
        /// Index of the sample that is earlier than its predecessor.
        index: usize,
        /// Time of the predecessor \[s\].
        before: f64,
        /// Time of the sample \[s\].
        after: f64,
    },
    /// All time stamps are the same.
    #[error(
        "record `{record}`: all {samples} time stamps are {time_s} s; write time with more digits, or leave \
         the column out and give the sample rate",
        time_s = exact(*.time_s)
    )]
    TimeStandsStill {
        /// Name of the record.
        record: String,
        /// Number of samples.
        samples: usize,
        /// The one time stamp \[s\].
        time_s: f64,
    },
    /// A sample rate that no instrument has.
    #[error(
        "record `{record}`: a sample rate of {value:e} Hz is not possible; it must be from {:e} to {:e} Hz",
        RATES_HZ.start(),
        RATES_HZ.end()
    )]
    BadSampleRate {
        /// Name of the record.
        record: String,
        /// The value given \[Hz\].
        value: f64,
    },
    /// A given sample rate that the time column contradicts.
    #[error(
        "record `{record}`: the sample rate given is {given_hz} Hz, but {samples} samples span {} s by the \
         time column, {} Hz; correct the one or drop the other",
        short(*.duration_s),
        short(*.measured_hz),
        given_hz = exact(*.given_hz)
    )]
    RateContradictsTime {
        /// Name of the record.
        record: String,
        /// Rate given \[Hz\].
        given_hz: f64,
        /// Mean rate by the time column \[Hz\].
        measured_hz: f64,
        /// Number of samples.
        samples: usize,
        /// Duration by the time column \[s\].
        duration_s: f64,
    },
    /// A step that needs uniform sampling.
    #[error(
        "record `{record}`: {purpose} needs uniform sampling, but {found}; resample it first, or give the \
         sample rate if the stamps are only badly written"
    )]
    NotUniform {
        /// Name of the record.
        record: String,
        /// Operation requested.
        purpose: &'static str,
        /// Description of the time base.
        found: &'static str,
    },
    /// A range of samples that is not inside the record.
    #[error("record `{record}`: samples {start} to {end} are not a range within its {samples} samples")]
    BadRange {
        /// Name of the record.
        record: String,
        /// First sample requested.
        start: usize,
        /// End of the range (exclusive).
        end: usize,
        /// Samples there are.
        samples: usize,
    },
    /// A factor that cannot scale a channel.
    #[error(
        "record `{record}`, channel `{channel}`: cannot scale by {factor}; the factor must be finite and not \
         zero",
        factor = exact(*.factor)
    )]
    BadScale {
        /// Name of the record.
        record: String,
        /// The channel.
        channel: String,
        /// The factor given.
        factor: f64,
    },
    /// A scale per another unit than the channel's.
    #[error("record `{record}`: channel `{channel}` is in {unit}, its scale is per {per}")]
    ScaleUnit {
        /// Name of the record.
        record: String,
        /// The channel.
        channel: String,
        /// Its unit.
        unit: String,
        /// Unit that the factor is per.
        per: String,
    },
    /// Text that is no [`Scale`](super::Scale).
    #[error("{0}")]
    ScaleText(&'static str),
    /// A setting of a preparation step out of its range.
    #[error("record `{record}`: {setting} = {value} is not possible; {allowed}", value = exact(*.value))]
    BadSetting {
        /// Name of the record.
        record: String,
        /// The setting.
        setting: &'static str,
        /// The value given.
        value: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    /// A signal that never changes.
    #[error(
        "record `{record}`: channel `{channel}` is constant ({}) over all samples, so {purpose} is not \
         possible; was the drive connected, the right column chosen?",
        short(*.value)
    )]
    ConstantSignal {
        /// Name of the record.
        record: String,
        /// The channel.
        channel: String,
        /// Its one value.
        value: f64,
        /// Operation requested.
        purpose: &'static str,
    },
    /// A signal in which no period was found.
    #[error("record `{record}`: no repeating period found, so {purpose} is not possible")]
    NotPeriodic {
        /// Name of the record.
        record: String,
        /// Operation requested.
        purpose: &'static str,
    },
    /// A step that needs time stamps.
    #[error(
        "record `{record}`: {purpose} needs time stamps, and it has neither a time column nor a sample rate"
    )]
    NoTimes {
        /// Name of the record.
        record: String,
        /// Operation requested.
        purpose: &'static str,
    },
    /// A cut that keeps fewer than two samples.
    #[error(
        "record `{record}`: the cut keeps {kept} of {samples} samples, at least 2 are needed; the record \
         holds {holds}"
    )]
    EmptyCut {
        /// Name of the record.
        record: String,
        /// Samples kept.
        kept: usize,
        /// Samples of the record.
        samples: usize,
        /// Range of its time and of the columns requested.
        holds: String,
    },
    /// A text condition on a column of numbers.
    #[error(
        "record `{record}`: channel `{channel}` holds numbers, `{text}` is none; ask for a number or a range"
    )]
    TextCondition {
        /// Name of the record.
        record: String,
        /// The channel.
        channel: String,
        /// The text.
        text: String,
    },
    /// Fewer turning points than requested.
    #[error("record `{record}`: channel `{channel}` turns {found} times, turning point {asked} is asked for")]
    TooFewTurns {
        /// Name of the record.
        record: String,
        /// The channel.
        channel: String,
        /// Number of the turning point, from 1.
        asked: usize,
        /// Turning points there are.
        found: usize,
    },
    /// Records whose columns differ.
    #[error("records `{first}` and `{second}` cannot be joined: {difference}")]
    JoinColumns {
        /// Name of the first record.
        first: String,
        /// Name of the other.
        second: String,
        /// Their difference.
        difference: String,
    },
    /// Records that overlap in time.
    #[error(
        "record `{later}` begins at {begins_s} s, before `{earlier}` ends at {ends_s} s: time must increase \
         from record to record; give them in order, and cut what overlaps",
        begins_s = exact(*.begins_s),
        ends_s = exact(*.ends_s)
    )]
    JoinOrder {
        /// Name of the record before.
        earlier: String,
        /// Name of the later record.
        later: String,
        /// Last stamp of the one \[s\].
        ends_s: f64,
        /// First stamp of the other \[s\].
        begins_s: f64,
    },
    /// Lists of different lengths.
    #[error("frequency response `{name}`: {what} has {found} entries where there are {expected} frequencies")]
    ResponseLength {
        /// The response.
        name: String,
        /// Which list.
        what: &'static str,
        /// Entries found.
        found: usize,
        /// Number of frequencies.
        expected: usize,
    },
    /// A frequency that is not positive and finite, or not above the one before.
    #[error(
        "frequency response `{name}`, point {index}: frequency {value} Hz; frequencies must be positive, \
         finite and strictly ascending",
        value = exact(*.value)
    )]
    ResponseFrequency {
        /// The response.
        name: String,
        /// Point, from 1.
        index: usize,
        /// Frequency found \[Hz\].
        value: f64,
    },
    /// A value that is not finite, or zero where it has to be divided by.
    #[error(
        "frequency response `{name}`, {frequency_hz} Hz: the value {found} is not {wanted}",
        frequency_hz = exact(*.frequency_hz)
    )]
    ResponseValue {
        /// The response.
        name: String,
        /// Frequency \[Hz\].
        frequency_hz: f64,
        /// Value found.
        found: String,
        /// Property required of the value.
        wanted: &'static str,
    },
    /// A standard deviation that is not positive and finite.
    #[error(
        "frequency response `{name}`, {frequency_hz} Hz: the standard deviation is {found}; it must be \
         positive and finite",
        frequency_hz = exact(*.frequency_hz),
        found = exact(*.found)
    )]
    ResponseUncertainty {
        /// The response.
        name: String,
        /// Frequency \[Hz\].
        frequency_hz: f64,
        /// Standard deviation found.
        found: f64,
    },
    /// Two responses that do not share their frequencies.
    #[error("cannot divide frequency response `{over}` by `{under}`: they are not at the same frequencies")]
    OtherFrequencies {
        /// Numerator.
        over: String,
        /// Denominator.
        under: String,
    },
}

impl RecordError {
    /// Remedy available to the user, if any.
    pub fn advice(&self) -> Option<Advice> {
        match self {
            Self::NoSuchChannel { role, .. }
            | Self::NoCandidate { role, .. }
            | Self::WrongUnit { role, .. } => Some(Advice::ChooseColumn { role: *role, example: None }),
            Self::AmbiguousChannel { role, first, .. } => {
                Some(Advice::ChooseColumn { role: *role, example: Some(first.clone()) })
            }
            Self::SameChannel { .. } => Some(Advice::ChooseColumns),
            Self::NotUniform { found, .. } if *found == NO_TIMES => Some(Advice::GiveSampleRate),
            Self::NotUniform { .. } => Some(Advice::Resample),
            Self::NoTimes { .. } => Some(Advice::GiveSampleRate),
            Self::EmptyCut { .. } | Self::TextCondition { .. } | Self::TooFewTurns { .. } => {
                Some(Advice::CutOtherwise)
            }
            _ => None,
        }
    }
}
