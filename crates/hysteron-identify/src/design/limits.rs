//! What the amplifier, the time and the sample rate allow a drive.

use crate::IdentifyError;

/// Most samples of a drive: some minutes at 10 kHz.
const MOST_SAMPLES: f64 = 4e6;
/// Fewest samples of a drive.
const FEWEST_SAMPLES: f64 = 400.0;
/// Fewest samples in a period of the fastest motion.
pub(super) const SAMPLES_A_PERIOD: f64 = 10.0;
/// Share of the slew rate that a waveform uses: the difference of two samples rounds.
const WITHIN: f64 = 0.999;

/// Limits of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limits {
    /// Lowest voltage \[V\].
    pub(super) low: f64,
    /// Highest voltage \[V\].
    pub(super) high: f64,
    /// Largest slew rate \[V/s\].
    pub(super) slew: f64,
    /// Sample rate \[Hz\].
    pub(super) rate_hz: f64,
    /// Number of samples.
    pub(super) samples: usize,
    /// Highest frequency that a waveform excites \[Hz\].
    pub(super) highest_hz: f64,
}

impl Limits {
    /// Checked limits of a drive of `time_s`.
    ///
    /// # Errors
    /// [`IdentifyError::Option`] for a number out of range.
    pub(super) fn new(
        [low, high]: [f64; 2],
        slew: f64,
        rate_hz: f64,
        time_s: f64,
        highest_hz: f64,
    ) -> Result<Self, IdentifyError> {
        let refuse = |option, value, wanted| Err(IdentifyError::Option { option, value, wanted });
        if !(low < high && low.is_finite() && high.is_finite()) {
            return refuse("range", high - low, "a lowest voltage below the highest");
        }
        if !(rate_hz > 0.0 && rate_hz.is_finite()) {
            return refuse("sample rate", rate_hz, "a rate above 0");
        }
        let samples = (time_s * rate_hz).round();
        if !(FEWEST_SAMPLES..=MOST_SAMPLES).contains(&samples) {
            return Err(IdentifyError::DesignTime {
                time_s,
                rate_hz,
                least_s: FEWEST_SAMPLES / rate_hz,
                most_s: MOST_SAMPLES / rate_hz,
            });
        }
        if !(highest_hz > 0.0 && highest_hz <= rate_hz / SAMPLES_A_PERIOD * (1.0 + 1e-9)) {
            return refuse("highest frequency", highest_hz, "above 0 and at most a tenth of the sample rate");
        }
        // Twice over the range, or a drive could not even be a loop.
        if !(slew > 0.0 && slew.is_finite()) || 4.0 * (high - low) > slew * time_s {
            return refuse("slew rate", slew, "enough for two loops over the range in the time");
        }
        Ok(Self { low, high, slew, rate_hz, samples: samples as usize, highest_hz })
    }

    /// These limits at a rate lower by the whole factor `coarser`.
    pub(super) fn coarser(self, coarser: usize) -> Self {
        Self { rate_hz: self.rate_hz / coarser as f64, samples: self.samples / coarser, ..self }
    }

    /// Middle of the range \[V\].
    pub(super) fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// Half the range \[V\].
    pub(super) fn half(&self) -> f64 {
        0.5 * (self.high - self.low)
    }

    /// Largest amplitude of a sine \[V\] by range and slew rate.
    pub(super) fn amplitude(&self, frequency_hz: f64) -> f64 {
        self.half().min(WITHIN * self.slew / (std::f64::consts::TAU * frequency_hz))
    }

    /// Voltage at rest, before the drive and after it: 0 V or the end of the range nearest to it.
    pub(super) fn rest(&self) -> f64 {
        0.0f64.clamp(self.low, self.high)
    }

    /// The drive from rest that follows `targets` as fast as the slew rate allows: within range and slew rate
    /// whatever the targets.
    pub(super) fn followed(&self, targets: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let step = WITHIN * self.slew / self.rate_hz;
        let mut at = self.rest();
        let mut drive = Vec::with_capacity(self.samples);
        for target in targets.into_iter().take(self.samples) {
            drive.push(at);
            let moved = at + (target.clamp(self.low, self.high) - at).clamp(-step, step);
            // The sum rounds.
            at = moved.clamp(self.low, self.high);
        }
        drive
    }

    /// The whole drive of these targets, from rest and back to it.
    pub(super) fn drive(&self, targets: &[f64]) -> Vec<f64> {
        let back = ((self.high - self.low) * self.rate_hz / (WITHIN * self.slew)).ceil() as usize + 2;
        let before = targets.len().min(self.samples).saturating_sub(back);
        let resting = std::iter::repeat(self.rest());
        self.followed(targets[..before].iter().copied().chain(resting))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_drive_keeps_range_and_slew_whatever_its_targets(
            targets in prop::collection::vec(-50.0..50.0f64, 400..900),
            low in -20.0..5.0f64,
            span in 0.5..30.0f64,
            faster in 1.0..40.0f64,
        ) {
            let (rate_hz, high) = (1000.0, low + span);
            let time_s = targets.len() as f64 / rate_hz;
            let slew = 4.0 * span / time_s * faster;
            let limits = Limits::new([low, high], slew, rate_hz, time_s, 100.0).unwrap();
            let drive = limits.drive(&targets);
            prop_assert_eq!(drive.len(), limits.samples);
            prop_assert!(drive.iter().all(|u| (low..=high).contains(u)));
            prop_assert!(drive.windows(2).all(|w| (w[1] - w[0]).abs() * rate_hz <= slew));
            prop_assert_eq!(drive[0], limits.rest());
            prop_assert!((drive[drive.len() - 1] - limits.rest()).abs() <= 1e-12 * span);
        }
    }
}
