//! Measured records: named channels with units on one time base.

mod unit;

pub use unit::{Quantity, Unit};

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
        /// Largest deviation of a time stamp from the uniform grid, in sample periods (0 where made or given).
        jitter_samples: f64,
    },
    /// One time stamp \[s\] a sample, increasing but not uniform: fine for a static fit, refused for dynamics.
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

impl InputOutput {
    /// Sample rate \[Hz\], if the time base is uniform.
    pub fn sample_rate_hz(&self) -> Option<f64> {
        match self.time {
            TimeBase::Uniform { sample_rate_hz, .. } => Some(sample_rate_hz),
            _ => None,
        }
    }
}
