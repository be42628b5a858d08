//! Time from one sample to the next.

use super::MisfitError;
use crate::record::Timing;

/// Steps of a drive, or of blocks of its samples.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Steps {
    /// All alike \[s\].
    Even(f64),
    /// Times of the samples \[s\].
    Uneven(Vec<f64>),
}

impl Steps {
    /// # Errors
    /// [`MisfitError::NoTimes`] where only the order of the samples is known.
    pub(super) fn new(timing: Timing<'_>, samples: usize) -> Result<Self, MisfitError> {
        match timing {
            Timing::Rate(rate_hz) => Ok(Self::Even(1.0 / rate_hz)),
            Timing::Stamps(times_s) if times_s.len() == samples => Ok(Self::Uneven(times_s.to_vec())),
            Timing::Stamps(_) | Timing::Unknown => Err(MisfitError::NoTimes),
        }
    }

    /// Steps between the means of blocks of `factor` samples.
    pub(super) fn of_blocks(&self, factor: usize) -> Self {
        match self {
            Self::Even(step_s) => Self::Even(step_s * factor as f64),
            Self::Uneven(times_s) => {
                let mean = |block: &[f64]| block.iter().sum::<f64>() / block.len() as f64;
                Self::Uneven(times_s.chunks_exact(factor).map(mean).collect())
            }
        }
    }

    /// Time from the sample before to sample `k` \[s\]; to the first one, as to the second.
    pub(super) fn s(&self, k: usize) -> f64 {
        match self {
            Self::Even(step_s) => *step_s,
            Self::Uneven(times_s) => match (times_s.get(k.max(1) - 1), times_s.get(k.max(1))) {
                (Some(from), Some(to)) => to - from,
                _ => 0.0,
            },
        }
    }
}
