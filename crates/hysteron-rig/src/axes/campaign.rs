//! Records of a bench of several axes from which its model is identified.

use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

use hysteron_model::record::Record;

use super::{AxesTruth, measure_axes};
use crate::RigError;

/// Use of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxesRole {
    /// For the fit.
    Identification,
    /// Held out.
    Validation,
}

/// Records of multisines: all inputs at once, phases different from input to input and record to record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AxesPlan {
    /// Sample rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Samples of a period.
    pub period_samples: usize,
    /// Periods of a record; the first settles.
    pub periods: usize,
    /// Highest frequency \[Hz\].
    pub highest_hz: f64,
    /// Corner above which the amplitude of a line falls with the frequency \[Hz\].
    pub corner_hz: f64,
    /// Levels, rms of every input \[V\].
    pub levels_v: Vec<f64>,
}

impl Default for AxesPlan {
    fn default() -> Self {
        Self {
            sample_rate_hz: 5000.0,
            period_samples: 2500,
            periods: 3,
            highest_hz: 1600.0,
            corner_hz: 60.0,
            levels_v: vec![0.5, 1.0, 2.0],
        }
    }
}

/// A record of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct AxesRun {
    /// Its use.
    pub role: AxesRole,
    /// Channels `u1` … \[V\] and `y1` … \[µm\]; the name begins with `simulated_`.
    pub record: Record,
    /// Readings at the ends of a converter's range.
    pub clipped_samples: usize,
    /// Header lines of the file: statement that it is simulated, drive, plant, seed.
    pub comments: Vec<String>,
}

impl AxesPlan {
    /// Checks every number.
    ///
    /// # Errors
    /// [`RigError::Plan`].
    pub fn validate(&self) -> Result<(), RigError> {
        let within = |parameter, value: f64, low: f64, high: f64, expected: &'static str| {
            if (low..=high).contains(&value) {
                Ok(())
            } else {
                Err(RigError::Plan { parameter, value, expected })
            }
        };
        within("sample_rate_hz", self.sample_rate_hz, 1e-3, 1e8, "a rate from 1e-3 to 1e8 Hz")?;
        within("period_samples", self.period_samples as f64, 16.0, 1e6, "a whole number from 16 to 1e6")?;
        within("periods", self.periods as f64, 2.0, 100.0, "a whole number from 2 to 100")?;
        let half = 0.5 * self.sample_rate_hz;
        within("highest_hz", self.highest_hz, 0.0, half, "at most half the sample rate")?;
        within("corner_hz", self.corner_hz, 1e-6, 1e9, "a frequency from 1e-6 to 1e9 Hz")?;
        within("number of levels_v", self.levels_v.len() as f64, 1.0, 20.0, "from 1 to 20 levels")?;
        self.levels_v
            .iter()
            .try_for_each(|v| within("levels_v", *v, 1e-9, 1e6, "a voltage from 1e-9 to 1e6 V rms"))
    }

    /// Drives of one record, one list per input.
    fn drives(&self, inputs: usize, level_v: f64, seed: u64) -> Vec<Vec<f64>> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let period = self.period_samples;
        let lines = (self.highest_hz / self.sample_rate_hz * period as f64).floor().max(1.0) as usize;
        let amplitude = |line: usize| {
            let f = line as f64 * self.sample_rate_hz / period as f64;
            1.0 / (1.0 + f / self.corner_hz)
        };
        let power: f64 = (1..=lines).map(|line| 0.5 * amplitude(line).powi(2)).sum();
        let cosine: Vec<f64> = (0..period).map(|k| (TAU * k as f64 / period as f64).cos()).collect();
        let mut drive = || {
            let mut one = vec![0.0; period];
            for line in 1..=lines {
                let shift = (rng.next_u64() % period as u64) as usize;
                let size = level_v * amplitude(line) / power.sqrt();
                for (k, u) in one.iter_mut().enumerate() {
                    *u += size * cosine[(line * k + shift) % period];
                }
            }
            one.repeat(self.periods)
        };
        (0..inputs).map(|_| drive()).collect()
    }
}

/// Plays the plan: at every level as many records as there are inputs, and one held out.
///
/// # Errors
/// [`RigError`].
pub fn run_axes_campaign(truth: &AxesTruth, plan: &AxesPlan, seed: u64) -> Result<Vec<AxesRun>, RigError> {
    truth.validate()?;
    plan.validate()?;
    let inputs = truth.actuators.len();
    let mut wanted = Vec::new();
    for level in &plan.levels_v {
        for number in 0..=inputs {
            let role = if number < inputs { AxesRole::Identification } else { AxesRole::Validation };
            wanted.push((*level, number, role, wanted.len()));
        }
    }
    let run = |(level, number, role, stream): (f64, usize, AxesRole, usize)| {
        let drives = plan.drives(inputs, level, seed.wrapping_mul(1009).wrapping_add(stream as u64 + 1));
        let millivolts = (1e3 * level).round();
        let name = match role {
            AxesRole::Identification => format!("axes_{millivolts}mV_{}", number + 1),
            AxesRole::Validation => format!("axes_{millivolts}mV_heldout"),
        };
        let (record, clipped_samples) =
            measure_axes(truth, &name, &drives, plan.sample_rate_hz, (seed, stream))?;
        let comments = vec![
            "simulated: this record was computed by the hysteron bench rig, not measured".to_owned(),
            format!("drive: {} periods of multisines to {} Hz, {level} V rms", plan.periods, plan.highest_hz),
            format!("plant: {}", truth.describe()),
            format!("seed {seed}, stream {stream}"),
        ];
        Ok(AxesRun { role, record, clipped_samples, comments })
    };
    wanted.into_par_iter().map(run).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn every_level_has_a_record_per_input_and_one_held_out_and_seeds_repeat() {
        let truth = AxesTruth::with_axes(2).unwrap();
        let plan = AxesPlan { period_samples: 250, periods: 2, ..AxesPlan::default() };
        let runs = run_axes_campaign(&truth, &plan, 3).unwrap();
        assert_eq!(runs.len(), 9);
        assert_eq!(runs.iter().filter(|run| run.role == AxesRole::Validation).count(), 3);
        assert_eq!(runs, run_axes_campaign(&truth, &plan, 3).unwrap());
        assert!(runs.iter().all(|run| run.record.name.starts_with("simulated_axes_")));
        assert!(runs.iter().all(|run| run.comments[0].starts_with("simulated")));
        let u = &runs[0].record.channels[0].samples;
        let rms = (u.iter().map(|u| u * u).sum::<f64>() / u.len() as f64).sqrt();
        assert!((rms - 0.5).abs() < 1e-9, "{rms}");
        assert_eq!(u[..250], u[250..]);
        assert!(AxesPlan { periods: 1, ..plan }.validate().is_err());
    }
}
