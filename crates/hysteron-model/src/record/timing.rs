//! Times of the samples of a drive, for a simulation.

use super::TimeBase;

/// Times of samples, borrowed: a rate, the stamps of a [`TimeBase`], or unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Timing<'a> {
    /// Only their order is known.
    Unknown,
    /// At this rate \[Hz\].
    Rate(f64),
    /// At these times \[s\], increasing.
    Stamps(&'a [f64]),
}

impl Timing<'_> {
    /// The rate \[Hz\], where there is one.
    pub fn sample_rate_hz(self) -> Option<f64> {
        match self {
            Self::Rate(sample_rate_hz) => Some(sample_rate_hz),
            Self::Unknown | Self::Stamps(_) => None,
        }
    }

    /// Those of the first so many samples.
    #[must_use]
    pub fn of_first(self, samples: usize) -> Self {
        match self {
            Self::Stamps(times_s) => Self::Stamps(times_s.get(..samples).unwrap_or(times_s)),
            other => other,
        }
    }
}

impl From<Option<f64>> for Timing<'_> {
    fn from(sample_rate_hz: Option<f64>) -> Self {
        sample_rate_hz.map_or(Self::Unknown, Self::Rate)
    }
}

impl<'a> From<&'a TimeBase> for Timing<'a> {
    fn from(base: &'a TimeBase) -> Self {
        match base {
            TimeBase::Uniform { sample_rate_hz, .. } => Self::Rate(*sample_rate_hz),
            TimeBase::NonUniform { times_s } => Self::Stamps(times_s),
            TimeBase::Unknown => Self::Unknown,
        }
    }
}
