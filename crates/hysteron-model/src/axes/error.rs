//! Errors of records and models of several axes.

use crate::advice::{Advice, ColumnRole};
use crate::hysteresis::HysteresisError;
use crate::record::RecordError;
use crate::validate::ScoreError;
use hysteron_numeric::display::exact;

/// A record or a model of several axes that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AxesError {
    /// The record is invalid.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// No input was named.
    #[error("no input was named: name the columns")]
    NoInputs,
    /// The channel does not exist.
    #[error("record `{record}`: no channel `{channel}`; there are {available}")]
    NoSuchChannel {
        /// Record.
        record: String,
        /// Name requested.
        channel: String,
        /// Available headers.
        available: String,
    },
    /// A channel is named twice.
    #[error("the channel `{channel}` is named twice among inputs and outputs")]
    Twice {
        /// Its name.
        channel: String,
    },
    /// Channels of one side in different units.
    #[error(
        "record `{record}`: the {role}s are in different units, {first} and {other}: their errors cannot be \
         pooled"
    )]
    Units {
        /// Record.
        record: String,
        /// `input` or `output`.
        role: &'static str,
        /// One unit.
        first: String,
        /// Another.
        other: String,
    },
    /// Dynamics need a uniform time base.
    #[error("record `{record}` has no uniform sample rate: the motion of modes cannot be followed")]
    NotUniform {
        /// Record.
        record: String,
    },
    /// The drive does not repeat.
    #[error(
        "record `{record}`: its inputs do not repeat with one period of a whole number of samples at least \
         twice: modes are identified from a steady state"
    )]
    NotPeriodic {
        /// Record.
        record: String,
    },
    /// A sample of the period is valid in no period.
    #[error("record `{record}`: sample {sample} of its period is valid in none of its periods")]
    Masked {
        /// Record.
        record: String,
        /// Sample of the period, from 0.
        sample: usize,
    },
    /// An input that does not move.
    #[error("record `{record}`: the inputs are constant")]
    NoDrive {
        /// Record.
        record: String,
    },
    /// The inputs of the records are linearly dependent at a frequency.
    #[error(
        "the {inputs} inputs of these {records} records are not independent at {frequency_hz} Hz: drive them \
         with different phases, in {inputs} records or more",
        frequency_hz = exact(*.frequency_hz)
    )]
    Dependent {
        /// Inputs.
        inputs: usize,
        /// Records.
        records: usize,
        /// Frequency \[Hz\].
        frequency_hz: f64,
    },
    /// Too few excited frequencies.
    #[error("the records excite only {lines} frequencies; {need} are needed for {unknowns} unknowns")]
    FewLines {
        /// Frequencies.
        lines: usize,
        /// Needed.
        need: usize,
        /// Unknowns of each entry.
        unknowns: usize,
    },
    /// A list of a model has the wrong length.
    #[error("{what}: expected {expected} numbers, found {found}")]
    Length {
        /// Which.
        what: &'static str,
        /// Expected length.
        expected: usize,
        /// Actual length.
        found: usize,
    },
    /// A number of a model is not allowed.
    #[error("{what} is {value}: expected {expected}", value = exact(*.value))]
    Value {
        /// Which.
        what: &'static str,
        /// The number.
        value: f64,
        /// Allowed values.
        expected: &'static str,
    },
    /// A part of a model is not allowed.
    #[error("{part}.{error}")]
    Part {
        /// Its keys in the file.
        part: String,
        /// What about it.
        error: Box<AxesError>,
    },
    /// A mode or a lag that does not decay.
    #[error(
        "{} is unstable at the level {level}: its pole has the magnitude {magnitude}",
        match mode.checked_sub(*modes) {
            Some(lag @ 1..) => format!("the lag of input {lag}"),
            _ => format!("mode {mode}"),
        },
        level = exact(*.level),
        magnitude = exact(*.magnitude)
    )]
    Unstable {
        /// Number of the mode, from 1; the lags of the inputs come after the modes.
        mode: usize,
        /// Number of modes.
        modes: usize,
        /// Drive level, rms.
        level: f64,
        /// Magnitude of the pole.
        magnitude: f64,
    },
    /// Numbers of channels that do not match.
    #[error("the model has {model} {role}s, the record {record}")]
    Channels {
        /// `input` or `output`.
        role: &'static str,
        /// Of the model.
        model: usize,
        /// Of the record.
        record: usize,
    },
    /// The sample rate differs from the model's.
    #[error(
        "the model was identified at {model_hz} Hz, the record has {record_hz} Hz",
        model_hz = exact(*.model_hz),
        record_hz = exact(*.record_hz)
    )]
    SampleRate {
        /// Of the model \[Hz\].
        model_hz: f64,
        /// Of the record \[Hz\].
        record_hz: f64,
    },
    /// The model cannot be run at the rate of a controller.
    #[error(
        "the model cannot be run at {rate_hz} Hz{}: choose {lowest_hz} Hz or more",
        matched(*error),
        lowest_hz = exact(*.lowest_hz),
        rate_hz = exact(*.rate_hz)
    )]
    Rate {
        /// Rate requested \[Hz\].
        rate_hz: f64,
        /// Lowest rate, a 64th of that of the model's steps \[Hz\].
        lowest_hz: f64,
        /// Relative error of the linear response; infinite where it was not fitted.
        error: f64,
    },
    /// A settled start needs a period within the record.
    #[error("a settled start needs a period of 2 to {samples} samples, found {period_samples}")]
    Period {
        /// Samples of the record.
        samples: usize,
        /// Samples of the period.
        period_samples: usize,
    },
    /// The feedback of the hysteresis diverges.
    #[error(
        "the simulated motion leaves the range of numbers: the hysteresis in feedback is unstable under this \
         drive"
    )]
    RunsAway,
    /// No steady state.
    #[error(
        "no steady state after {periods} periods: the output still changes by {change:e} of its rms in a \
         period"
    )]
    NotSettled {
        /// Periods simulated.
        periods: usize,
        /// Change over the last one.
        change: f64,
    },
    /// A branch that cannot be simulated.
    #[error("{problem}")]
    Branch {
        /// Description of the problem.
        problem: String,
    },
    /// The common poles of all entries could not be computed.
    #[error(
        "the common poles of the frequency response were not found: an eigenvalue problem did not converge"
    )]
    NoPoles,
    /// The drive between its samples.
    #[error("the drive between its samples: {0}")]
    Interpolation(#[from] HysteresisError),
    /// A single output could not be scored.
    #[error(transparent)]
    Score(#[from] ScoreError),
    /// The outputs do not match.
    #[error("the record has {measured} outputs, the simulation {simulated}")]
    Outputs {
        /// Of the record.
        measured: usize,
        /// Of the simulation.
        simulated: usize,
    },
}

impl AxesError {
    /// Remedy available to the user, if any.
    pub fn advice(&self) -> Option<Advice> {
        match self {
            Self::Record(e) => e.advice(),
            Self::NoInputs => {
                Some(Advice::ChooseColumn { role: ColumnRole::Inputs, example: Some("u1_V,u2_V".to_owned()) })
            }
            Self::NotUniform { .. } => Some(Advice::Resample),
            _ => None,
        }
    }
}

/// How well the linear response is matched at another rate.
fn matched(error: f64) -> String {
    if error.is_finite() {
        format!(" (its linear response is matched to {error:.2} only)")
    } else {
        String::new()
    }
}

impl AxesError {
    /// The same of a part of a model.
    pub(super) fn within(self, part: &str) -> Self {
        match self {
            Self::Part { part: inner, error } => Self::Part { part: format!("{part}.{inner}"), error },
            error => Self::Part { part: part.to_owned(), error: Box::new(error) },
        }
    }
}
