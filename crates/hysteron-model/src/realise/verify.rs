//! Comparison of a realisation with the batch simulation of its model.

use std::f64::consts::TAU;

use super::stream::StreamParts;
use super::{Realisation, RealiseError};
use crate::start::Start;
use crate::{Finding, FindingKind};
use hysteron_numeric::display::short_to;

/// Deviation of a realisation from the batch simulation along one drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verification {
    /// Largest difference to the batch simulation, as a share of its range.
    pub largest: f64,
    /// Root mean square of the differences, as a share of the range.
    pub rms: f64,
    /// Range of the batch simulation \[µm\].
    pub range: f64,
    /// Samples compared.
    pub samples: usize,
}

impl Verification {
    /// What is to be said where the difference exceeds the accuracy of the dynamics.
    pub fn finding(&self, accuracy: f64) -> Option<Finding> {
        (self.largest > accuracy).then(|| {
            let text = format!(
                "Along the sweep the difference to the batch simulation is {} of the range, more than {}: the \
                 excess over the error of the dynamics arises between the samples (see \
                 docs/theory/realisation.md).",
                short_to(self.largest, 2),
                short_to(accuracy, 2)
            );
            Finding::new(FindingKind::Verdict, "sweep", text)
        })
    }
}

/// Share of a record at its end that is not compared under `band-limited`, which is not causal there.
const END: f64 = 0.01;

/// Runs realisation and batch simulation along `drive` \[V\] from rest at its first sample.
///
/// # Errors
/// [`RealiseError::Simulation`] where the batch simulation fails; as [`super::Stream::step`].
pub fn verify(realisation: &Realisation, drive: &[f64]) -> Result<Verification, RealiseError> {
    let Some(&first) = drive.first() else {
        return Ok(Verification { largest: 0.0, rms: 0.0, range: 0.0, samples: 0 });
    };
    let start = Start::Rest { voltage_v: first };
    let batch = realisation.model.simulate(drive, Some(realisation.sample_rate_hz), &start)?;
    let mut parts = StreamParts::new(realisation)?;
    let mut stream = parts.stream()?;
    stream.rest_at(first)?;
    let mut out = vec![0.0; drive.len()];
    stream.run(drive, &mut out)?;
    let samples = drive.len() - (END * drive.len() as f64) as usize;
    let (batch, out) = (&batch[..samples], &out[..samples]);
    let [low, high] = batch.iter().fold([f64::MAX, f64::MIN], |[low, high], &y| [low.min(y), high.max(y)]);
    let (mut largest, mut squares) = (0.0_f64, 0.0);
    for (a, b) in batch.iter().zip(out) {
        largest = largest.max((a - b).abs());
        squares += (a - b).powi(2);
    }
    let range = high - low;
    let rms = (squares / samples.max(1) as f64).sqrt();
    Ok(Verification { largest: largest / range, rms: rms / range, range, samples })
}

/// A drive between two voltages: a logarithmic sweep between two frequencies \[Hz\] at full, then at half
/// amplitude.
pub fn sweep(
    voltages: (f64, f64),
    frequencies_hz: (f64, f64),
    sample_rate_hz: f64,
    samples: usize,
) -> Vec<f64> {
    let (middle, reach) = (0.5 * (voltages.0 + voltages.1), 0.5 * (voltages.1 - voltages.0));
    let half = samples.div_ceil(2);
    let (low, high) = frequencies_hz;
    let seconds = half as f64 / sample_rate_hz;
    let growth = (high / low).ln().max(1e-9);
    let phase = |t: f64| TAU * low * seconds / growth * (growth * t / seconds).exp_m1();
    // The second half begins where the first ends, and goes back down.
    let end = phase(seconds);
    (0..samples)
        .map(|k| {
            if k < half {
                middle - reach * phase(k as f64 / sample_rate_hz).cos()
            } else {
                let back = phase(seconds - (k - half) as f64 / sample_rate_hz);
                let fade = 0.75 + 0.25 * (TAU * 0.5 * (k - half) as f64 / half as f64).cos();
                middle - reach * fade * (2.0 * end - back).cos()
            }
        })
        .collect()
}
