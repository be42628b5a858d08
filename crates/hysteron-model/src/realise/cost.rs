//! Cost per sample of models, side by side.

use std::time::Duration;

use super::stream::{StreamParts, nanoseconds_per_sample};
use super::{RealiseError, RealiseOptions, realise};
use crate::hammerstein::Model;

/// Cost of one realised model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// States of its dynamic block.
    pub states: usize,
    /// Nanoseconds per sample on this machine: least of the rounds.
    pub nanoseconds: f64,
}

/// Realises `models` for `sample_rate_hz` and times them along the same drive in turns. Comparable with each
/// other, not with another run or machine; `now` is a clock. A model that cannot be realised does not affect
/// the others.
pub fn side_by_side(
    models: &[&Model],
    sample_rate_hz: f64,
    options: &RealiseOptions,
    drive: &[f64],
    rounds: usize,
    now: &dyn Fn() -> Duration,
) -> Vec<Result<Cost, RealiseError>> {
    let first = drive.first().copied().unwrap_or(0.0);
    let mut parts: Vec<Result<(usize, StreamParts), RealiseError>> = models
        .iter()
        .map(|model| {
            let realised = realise(model, sample_rate_hz, options)?;
            let mut parts = StreamParts::new(&realised)?;
            // A model that fails on its own would end the timing of all.
            let mut out = vec![0.0; drive.len()];
            parts.stream().and_then(|mut stream| {
                stream.rest_at(first)?;
                stream.run(drive, &mut out)
            })?;
            Ok((realised.dynamics.states(), parts))
        })
        .collect();
    let mut streams = Vec::new();
    for (_, parts) in parts.iter_mut().flatten() {
        if let Ok(stream) = parts.stream() {
            streams.push(stream);
        }
    }
    let times = nanoseconds_per_sample(&mut streams, drive, rounds, now);
    let mut times = times.unwrap_or_default().into_iter();
    parts
        .into_iter()
        .map(|parts| {
            let (states, _) = parts?;
            Ok(Cost { states, nanoseconds: times.next().unwrap_or(f64::NAN) })
        })
        .collect()
}
