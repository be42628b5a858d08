//! Beginning of a pass of operators over a drive, and the samples of it that are kept.

use super::HysteresisError;
use crate::start::Start;

/// Rest voltage \[V\] before the drive `u` and the memory there, `None` where the operator is virgin; `None`
/// for the periodic steady state under `u`.
///
/// # Errors
/// [`HysteresisError::Period`] for a period that is not the whole of `u`.
#[inline]
pub(super) fn at_rest(start: Start<f64>, u: &[f64]) -> Result<Option<(f64, Option<f64>)>, HysteresisError> {
    match start {
        Start::AsIdentified => Ok(Some((u.first().copied().unwrap_or(0.0), None))),
        Start::Rest { voltage_v } => Ok(Some((voltage_v, None))),
        Start::Remembering { voltage_v, memory } => Ok(Some((voltage_v, Some(memory)))),
        Start::Settled { period_samples: Some(samples), .. } if samples != u.len() => {
            Err(HysteresisError::Period { samples: u.len(), period_samples: samples })
        }
        Start::Settled { .. } => Ok(None),
    }
}

/// Picks every `factor`-th sample, the first one first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Every {
    factor: usize,
    until: usize,
}

impl Every {
    /// # Errors
    /// [`HysteresisError::Factor`] for 0.
    pub(super) fn new(factor: usize) -> Result<Self, HysteresisError> {
        if factor == 0 {
            return Err(HysteresisError::Factor);
        }
        Ok(Self { factor, until: 0 })
    }

    /// True if the next sample is one of them.
    #[inline(always)]
    pub(super) fn take(&mut self) -> bool {
        let take = self.until == 0;
        if take {
            self.until = self.factor;
        }
        self.until -= 1;
        take
    }
}
