//! The slow state: recent level of the drive.

use super::positive;
use crate::axes::AxesError;

/// Scheduling law: S as a function of the drive level (rms of the inputs about their means, over all inputs).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelLaw {
    /// Level at which S = 0, the highest identified \[V\].
    pub reference: f64,
    /// Exponent of the level; 1: linear in amplitude.
    pub exponent: f64,
    /// Lowest level identified \[V\]; S is constant below.
    pub lowest: f64,
    /// Highest level identified \[V\]; S is constant above.
    pub highest: f64,
    /// Time constant of the running rms where a drive does not repeat \[s\].
    pub time_constant_s: f64,
}

/// Relative distance from the levels identified at which one counts as beyond them.
const SLACK: f64 = 0.05;

impl LevelLaw {
    /// True if this level is one of those identified, to five percent: the modes hardly move by that.
    pub fn holds_at(&self, level: f64) -> bool {
        ((1.0 - SLACK) * self.lowest..=(1.0 + SLACK) * self.highest).contains(&level)
    }

    /// S at a level: (level/reference)^exponent − 1, clamped to the levels identified.
    pub fn state(&self, level: f64) -> f64 {
        (level.max(self.lowest).min(self.highest) / self.reference).powf(self.exponent) - 1.0
    }

    pub(super) fn validate(&self) -> Result<(), AxesError> {
        positive("level.reference", self.reference)?;
        positive("level.exponent", self.exponent)?;
        positive("level.lowest", self.lowest)?;
        positive("level.highest", self.highest)?;
        positive("level.time_constant_s", self.time_constant_s)?;
        if self.lowest > self.highest {
            return Err(AxesError::Value {
                what: "level.lowest",
                value: self.lowest,
                expected: "at most level.highest",
            });
        }
        Ok(())
    }
}

/// The running level of a drive: first-order low-passes of u and u² of every input.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelTracker {
    keep: f64,
    means: Vec<f64>,
    squares: Vec<f64>,
}

impl LevelTracker {
    /// Steady state at the mean inputs `u` with a motion of rms `level` about them.
    pub fn new(law: &LevelLaw, sample_rate_hz: f64, u: &[f64], level: f64) -> Self {
        Self {
            keep: (-1.0 / (law.time_constant_s * sample_rate_hz)).exp(),
            means: u.to_vec(),
            squares: u.iter().map(|u| u * u + level * level).collect(),
        }
    }

    /// Level after the next sample.
    pub fn step(&mut self, u: &[f64]) -> f64 {
        let mut sum = 0.0;
        for ((mean, square), u) in self.means.iter_mut().zip(&mut self.squares).zip(u) {
            *mean += (1.0 - self.keep) * (u - *mean);
            *square += (1.0 - self.keep) * (u * u - *square);
            sum += (*square - *mean * *mean).max(0.0);
        }
        (sum / self.means.len().max(1) as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: LevelLaw =
        LevelLaw { reference: 0.3, exponent: 1.0, lowest: 0.1, highest: 0.3, time_constant_s: 1.0 };

    #[test]
    fn the_state_is_linear_in_amplitude_and_held_outside_the_levels() {
        assert!((LAW.state(0.2) + 1.0 / 3.0).abs() < 1e-15);
        assert_eq!(LAW.state(0.05), LAW.state(0.1));
        assert_eq!(LAW.state(3.0), 0.0);
        let square = LevelLaw { exponent: 2.0, ..LAW };
        assert!((square.state(0.15) + 0.75).abs() < 1e-15);
    }

    #[test]
    fn the_running_level_of_a_biased_sine_tends_to_its_rms() {
        let mut tracker = LevelTracker::new(&LAW, 1000.0, &[2.0], 0.0);
        let sine = |k: usize| 2.0 + 0.2 * (0.3 * k as f64).sin();
        let last = (0..20_000).map(|k| tracker.step(&[sine(k)])).last().unwrap();
        assert!((last / (0.2 / 2f64.sqrt()) - 1.0).abs() < 5e-3, "{last}");
    }
}
