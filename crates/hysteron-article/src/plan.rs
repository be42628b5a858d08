//! Plan of the reproduction.

use super::ArticleError;
use hysteron_rig::CampaignPlan;
use hysteron_rig::excitation::SweepLaw;
use serde::{Deserialize, Serialize};

/// Plan of the reproduction; the default is the full one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Seed of the bench's noise and of every search.
    pub seed: u64,
    /// Runs of every optimiser in the comparison of Table 1, each from its own seed (≥ 2).
    pub runs: usize,
    /// Generations of every population search (article: 150).
    pub generations: usize,
    /// Sample rate of the bench \[Hz\]; the article does not print its own.
    pub sample_rate_hz: f64,
    /// Duration of the 1–100 Hz sweep \[s\].
    pub sweep_s: f64,
    /// Decimation factor of the 1 Hz loop: a rate-independent block loses nothing as long as the turning
    /// points are kept.
    pub loop_decimation: usize,
    /// Duration of each sine \[s\], rounded up to whole periods.
    pub sine_s: f64,
    /// Fewer runs, generations and samples than the article's: a rehearsal, whose numbers do not count.
    pub quick: bool,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            seed: 1,
            runs: 31,
            generations: 150,
            sample_rate_hz: 10_000.0,
            sweep_s: 10.0,
            loop_decimation: 10,
            sine_s: 1.0,
            quick: false,
        }
    }
}

/// Periods of the 1 Hz loop.
pub(super) const LOOP_PERIODS: usize = 3;
/// Frequencies of the sines \[Hz\]: two slow ones for the claim about loops below 5 Hz, then those of Table
/// 3.
pub(super) const SLOW_HZ: [f64; 2] = [2.0, 5.0];
/// Frequencies of Table 3 \[Hz\].
pub(super) const TABLE3_HZ: [f64; 4] = [10.0, 20.0, 50.0, 100.0];

impl Plan {
    /// A rehearsal of the whole run in a few seconds: fewer runs and generations, a shorter sweep at a lower
    /// rate.
    pub fn quick() -> Self {
        Self {
            runs: 3,
            generations: 12,
            sample_rate_hz: 5_000.0,
            sweep_s: 1.0,
            loop_decimation: 10,
            sine_s: 0.5,
            quick: true,
            ..Self::default()
        }
    }

    pub(super) fn validate(&self) -> Result<(), ArticleError> {
        let refuse = |setting, value, wanted| Err(ArticleError::Plan { setting, value, wanted });
        if self.runs < 2 {
            return refuse("runs", self.runs as f64, "at least 2, for quartiles");
        }
        if self.generations == 0 {
            return refuse("generations", 0.0, "at least 1");
        }
        if !(2_000.0..=1e6).contains(&self.sample_rate_hz) {
            return refuse(
                "sample_rate_hz",
                self.sample_rate_hz,
                "2 kHz to 1 MHz, at least 20 samples a period of 100 Hz",
            );
        }
        if self.loop_decimation == 0 || self.loop_decimation as f64 > self.sample_rate_hz / 100.0 {
            return refuse(
                "loop_decimation",
                self.loop_decimation as f64,
                "at least 1, 100 samples a period left",
            );
        }
        if !(0.5..=1e3).contains(&self.sweep_s) {
            return refuse("sweep_s", self.sweep_s, "0.5 to 1000 s");
        }
        if !(0.1..=100.0).contains(&self.sine_s) {
            return refuse("sine_s", self.sine_s, "0.1 to 100 s");
        }
        Ok(())
    }

    /// The article's campaign: 0–10 V, linear sweep (the default law of MATLAB's `chirp`, with which it was
    /// generated).
    pub(super) fn campaign(&self) -> CampaignPlan {
        CampaignPlan {
            sample_rate_hz: self.sample_rate_hz,
            loop_periods: LOOP_PERIODS as f64,
            sweep_law: SweepLaw::Linear,
            sweep_s: self.sweep_s,
            validation_hz: SLOW_HZ.iter().chain(&TABLE3_HZ).copied().collect(),
            validation_s: self.sine_s,
            ..CampaignPlan::default()
        }
    }
}
