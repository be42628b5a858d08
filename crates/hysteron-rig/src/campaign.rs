//! The article's measurement campaign on the simulated bench.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{RigRun, Truth, measure};
use crate::RigError;
use crate::excitation::{Excitation, ExcitationSpec, SweepLaw, Waveform};

/// Purpose of a record of the campaign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// Slow loop to identify the hysteresis block.
    QuasiStatic,
    /// Sweep to identify the dynamic block.
    Sweep,
    /// Sine for validation.
    Validation {
        /// Its frequency \[Hz\].
        frequency_hz: f64,
    },
    /// Band-limited random signal for validation.
    Tracking,
    /// Slow loops of decreasing amplitude for validation.
    NestedLoops,
}

/// One record of the campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignRun {
    /// Purpose.
    pub role: Role,
    /// Measured and true signals.
    pub run: RigRun,
}

/// Plan of the records; the default is the article's campaign (which does not print sample rate and voltage
/// span).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CampaignPlan {
    /// Sample rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Lowest command \[V\].
    pub low_v: f64,
    /// Highest command \[V\].
    pub high_v: f64,
    /// Frequency of the quasi-static loop \[Hz\].
    pub loop_hz: f64,
    /// Periods of the quasi-static loop.
    pub loop_periods: f64,
    /// Law of the sweep.
    pub sweep_law: SweepLaw,
    /// Lowest frequency of the sweep \[Hz\].
    pub sweep_start_hz: f64,
    /// Highest frequency of the sweep \[Hz\].
    pub sweep_end_hz: f64,
    /// Duration of the sweep \[s\].
    pub sweep_s: f64,
    /// Frequencies of the validation sines \[Hz\].
    pub validation_hz: Vec<f64>,
    /// Duration of each validation sine \[s\], rounded up to whole periods.
    pub validation_s: f64,
    /// Duration of a random tracking signal up to `sweep_end_hz` \[s\]; 0: none.
    pub tracking_s: f64,
    /// Amplitudes (fractions of the span) of slow nested loops; empty: none.
    pub nested_amplitudes: Vec<f64>,
}

impl Default for CampaignPlan {
    fn default() -> Self {
        CampaignPlan {
            sample_rate_hz: 10_000.0,
            low_v: 0.0,
            high_v: 10.0,
            loop_hz: 1.0,
            loop_periods: 3.0,
            sweep_law: SweepLaw::Logarithmic,
            sweep_start_hz: 1.0,
            sweep_end_hz: 100.0,
            sweep_s: 10.0,
            validation_hz: vec![10.0, 20.0, 50.0, 100.0],
            validation_s: 1.0,
            tracking_s: 0.0,
            nested_amplitudes: Vec::new(),
        }
    }
}

impl CampaignPlan {
    /// The article's campaign with a random tracking record and nested loops for further validation.
    pub fn extended() -> Self {
        CampaignPlan {
            tracking_s: 5.0,
            nested_amplitudes: vec![1.0, 0.8, 0.6, 0.4, 0.2],
            ..CampaignPlan::default()
        }
    }

    /// The waveforms in the order they are played.
    ///
    /// # Errors
    /// [`RigError::Waveform`] for an invalid waveform.
    pub fn drives(&self, seed: u64) -> Result<Vec<(Role, Excitation)>, RigError> {
        let make = |name: String, waveform, soft_start_s| -> Result<Excitation, RigError> {
            let spec = ExcitationSpec {
                name: Some(name),
                soft_start_s,
                seed,
                ..ExcitationSpec::new(self.sample_rate_hz, self.low_v, self.high_v, waveform)
            };
            spec.generate()
        };
        let loop_hz = self.loop_hz;
        let mut drives = vec![
            (
                Role::QuasiStatic,
                make(
                    format!("loop_{loop_hz}hz"),
                    Waveform::Sine { frequency_hz: loop_hz, periods: self.loop_periods },
                    0.0,
                )?,
            ),
            (
                Role::Sweep,
                make(
                    format!("sweep_{}_{}hz", self.sweep_start_hz, self.sweep_end_hz),
                    Waveform::Sweep {
                        law: self.sweep_law,
                        start_hz: self.sweep_start_hz,
                        end_hz: self.sweep_end_hz,
                        duration_s: self.sweep_s,
                    },
                    0.0,
                )?,
            ),
        ];
        for &frequency_hz in &self.validation_hz {
            let periods = (self.validation_s * frequency_hz - 1e-9).ceil().max(1.0);
            let sine = make(format!("sine_{frequency_hz}hz"), Waveform::Sine { frequency_hz, periods }, 0.0)?;
            drives.push((Role::Validation { frequency_hz }, sine));
        }
        if self.tracking_s != 0.0 {
            let waveform =
                Waveform::Random { low_hz: 0.0, high_hz: self.sweep_end_hz, duration_s: self.tracking_s };
            drives.push((Role::Tracking, make("tracking".into(), waveform, 0.2)?));
        }
        if !self.nested_amplitudes.is_empty() {
            let waveform = Waveform::NestedLoops {
                frequency_hz: loop_hz,
                amplitudes: self.nested_amplitudes.clone(),
                periods_each: 1,
            };
            drives.push((Role::NestedLoops, make("nested_loops".into(), waveform, 0.0)?));
        }
        Ok(drives)
    }
}

/// Plays a campaign, each record from rest, over as many threads as rayon has; the result does not depend on
/// their number.
///
/// # Errors
/// The first [`RigError`] in the order of the records.
pub fn run_campaign(truth: &Truth, plan: &CampaignPlan, seed: u64) -> Result<Vec<CampaignRun>, RigError> {
    truth.validate()?;
    let drives = plan.drives(seed)?;
    let runs: Vec<Result<CampaignRun, RigError>> = drives
        .par_iter()
        .enumerate()
        .map(|(stream, (role, drive))| {
            measure(truth, drive, seed, stream).map(|run| CampaignRun { role: *role, run })
        })
        .collect();
    runs.into_iter().collect()
}
