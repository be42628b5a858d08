//! The record that a drive will give: its information about the prior, and the weight that a fit will give
//! it.

use super::information::{Noise, Weighted, information, without_last};
use super::prior::Prior;
use crate::IdentifyError;
use crate::sensitivity::{about_mean, sensitivities};
use hysteron_model::hammerstein::Model;
use hysteron_model::record::{InputOutput, TimeBase, Timing, find_periods, noise_floor, range_of};
use hysteron_model::{Memory, Start};
use hysteron_numeric::Meter;
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

/// Step of the hysteresis memory before the record, as a share of its range.
const MEMORY_STEP: f64 = 1e-4;
/// Largest weight of a record over its due one: the floor of noise is found to a few percent.
const MOST_WEIGHT: f64 = 1.0;

/// Records of drives from rest.
#[derive(Clone, Copy)]
pub(super) struct Records<'a> {
    pub(super) prior: &'a Prior,
    /// The nominal model.
    pub(super) model: &'a Model,
    /// Voltage at rest \[V\].
    pub(super) rest_v: f64,
    /// Sample rate \[Hz\].
    pub(super) rate_hz: f64,
}

impl Records<'_> {
    /// Derivatives of the output along the directions of the prior, about their means.
    pub(super) fn derivatives(
        &self,
        drive: &[f64],
        meter: &Meter<'_>,
    ) -> Result<Vec<Vec<f64>>, IdentifyError> {
        let start = Start::Rest { voltage_v: self.rest_v };
        let of = (drive, Timing::Rate(self.rate_hz), &start);
        sensitivities(self.prior.count(), |k, step| self.prior.at(k, step), of, meter)
    }

    /// Information of the record of a drive. The fit estimates the hysteresis memory before it, too.
    pub(super) fn weighted(
        &self,
        drive: &[f64],
        noise: &Noise,
        meter: &Meter<'_>,
    ) -> Result<Weighted, IdentifyError> {
        let mut columns = self.derivatives(drive, meter)?;
        let weight = self.weight(drive, noise)?;
        let matrix = match self.of_memory(drive)? {
            None => information(&columns, noise),
            Some(memory) => {
                columns.push(memory);
                without_last(&information(&columns, noise))
            }
        };
        Ok(Weighted { matrix, weight })
    }

    /// Derivative of the output with respect to the memory before the record; `None` for a model without.
    fn of_memory(&self, drive: &[f64]) -> Result<Option<Vec<f64>>, IdentifyError> {
        let hysteresis = &self.model.hysteresis;
        let ends = drive.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |e, &u| (e.0.min(u), e.1.max(u)));
        let Some((low, high)) = hysteresis.memory_range(ends.0, ends.1) else { return Ok(None) };
        let step = MEMORY_STEP * (high - low);
        let at_rest = match hysteresis.memory(0.0) {
            Memory::Displacement(_) => 0.0,
            Memory::VirginAt(_) => self.rest_v,
        };
        let simulated = |value: f64| {
            let start = Start::Remembering { voltage_v: self.rest_v, memory: hysteresis.memory(value) };
            self.model.simulate(drive, Timing::Rate(self.rate_hz), &start)
        };
        let (up, down) = (simulated(at_rest + step)?, simulated(at_rest - step)?);
        let derivative = about_mean(up.iter().zip(&down).map(|(u, d)| (u - d) / (2.0 * step)).collect());
        Ok(derivative.iter().any(|d| *d != 0.0).then_some(derivative))
    }

    /// Range of the output along a drive.
    pub(super) fn stroke(&self, drive: &[f64]) -> Result<f64, IdentifyError> {
        let (low, high) = range_of(&self.simulated(drive)?);
        Ok(high - low)
    }

    fn simulated(&self, drive: &[f64]) -> Result<Vec<f64>, IdentifyError> {
        let start = Start::Rest { voltage_v: self.rest_v };
        Ok(self.model.simulate(drive, Timing::Rate(self.rate_hz), &start)?)
    }

    /// Share of its due weight that a fit gives the record: the noise over the noise floor that will be found
    /// in it, squared.
    pub(super) fn weight(&self, drive: &[f64], noise: &Noise) -> Result<f64, IdentifyError> {
        let output = self.simulated(drive)?;
        let noise = noise_like(noise, drive.len());
        let noisy = output.iter().zip(&noise).map(|(y, e)| y + e).collect();
        let floor = |y: Vec<f64>| -> Result<f64, IdentifyError> {
            let data = InputOutput::new("next", TimeBase::uniform(self.rate_hz), drive.to_vec(), y)?;
            Ok(noise_floor(&data, find_periods(&data).ok().as_ref()).map_or(f64::INFINITY, |floor| floor.rms))
        };
        let found = floor(noisy)?;
        // Of the noise alone, by the differences of successive samples.
        let due = floor(noise)?;
        Ok(if found > 0.0 { (due / found).powi(2).min(MOST_WEIGHT) } else { MOST_WEIGHT })
    }
}

/// Noise of so many samples: normal numbers, or the residual repeated.
fn noise_like(noise: &Noise, samples: usize) -> Vec<f64> {
    match noise {
        Noise::White(deviation) => {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
            let mut uniform = || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
            // A sum of twelve uniform numbers has variance 1.
            (0..samples).map(|_| deviation * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0)).collect()
        }
        Noise::Like(residual) => residual.iter().copied().cycle().take(samples).collect(),
    }
}
