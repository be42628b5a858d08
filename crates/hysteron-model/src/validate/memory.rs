//! Initial hysteresis memory of a device, estimated from the record.

use super::{OffsetTreatment, ScoreError, Scoring, mean, root_mean_square, scored_samples};
use crate::hammerstein::Model;
use crate::record::{InputOutput, range_of};
use crate::start::Start;

/// Memories tried before the best is refined: the error may have several minima.
const COARSE: usize = 9;
/// Precision of the memory, as a share of its range.
const PRECISION: f64 = 1e-5;

/// The start at rest at u(0) with the memory from which `model` explains the record best (smallest RMSE), its
/// RMSE and the simulation from it. The memory is searched over
/// [`Hysteresis::memory_range`](crate::hysteresis::Hysteresis::memory_range): first on a grid, then by golden
/// section. `None` where there is no memory to search.
///
/// # Errors
/// [`ScoreError`] where the record cannot be scored.
pub(super) fn best_memory(
    model: &Model,
    record: &InputOutput,
    scoring: &Scoring,
) -> Result<Option<(f64, Start, Vec<f64>)>, ScoreError> {
    let (low, high) = range_of(&record.u);
    let Some(&voltage_v) = record.u.first() else { return Ok(None) };
    let Some((least, most)) = model.hysteresis.memory_range(low, high) else { return Ok(None) };
    let scored = scored_samples(record, scoring.skip_s.unwrap_or(0.0))?;
    let remembering = |value: f64| Start::Remembering { voltage_v, memory: model.hysteresis.memory(value) };
    let rmse = |value: f64| match model.simulate(&record.u, &record.time, &remembering(value)) {
        Ok(simulated) => error_of(record, &simulated, &scored, scoring.offset),
        Err(_) => f64::INFINITY,
    };
    let start = remembering(minimum(rmse, least, most));
    // A memory that cannot be simulated is discarded.
    let Ok(simulated) = model.simulate(&record.u, &record.time, &start) else { return Ok(None) };
    Ok(Some((error_of(record, &simulated, &scored, scoring.offset), start, simulated)))
}

/// RMSE over the scored samples, as in the scores.
fn error_of(record: &InputOutput, simulated: &[f64], scored: &[bool], offset: OffsetTreatment) -> f64 {
    let errors = record.y.iter().zip(simulated).zip(scored).filter(|(_, scored)| **scored);
    let errors: Vec<f64> = errors.map(|((y, s), _)| y - s).collect();
    let constant = if offset == OffsetTreatment::Estimated { mean(&errors) } else { 0.0 };
    let rmse = root_mean_square(errors.iter().map(|e| e - constant));
    if rmse.is_finite() { rmse } else { f64::INFINITY }
}

/// Where `f` is smallest on [low, high].
fn minimum(f: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    let step = (high - low) / (COARSE - 1) as f64;
    let at = |k: usize| low + step * k as f64;
    let (mut best, mut least) = (0, f64::INFINITY);
    for k in 0..COARSE {
        let value = f(at(k));
        if value < least {
            (best, least) = (k, value);
        }
    }
    golden_section(&f, at(best.saturating_sub(1)), at((best + 1).min(COARSE - 1)), PRECISION * (high - low))
}

/// Golden-section search (J. Kiefer, Proc. AMS 4 (1953) 502, doi:10.1090/S0002-9939-1953-0055639-3).
fn golden_section(f: &impl Fn(f64) -> f64, mut low: f64, mut high: f64, width: f64) -> f64 {
    let shrink = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut left, mut right) = (high - shrink * (high - low), low + shrink * (high - low));
    let (mut at_left, mut at_right) = (f(left), f(right));
    while high - low > width {
        if at_left <= at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - shrink * (high - low);
            at_left = f(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + shrink * (high - low);
            at_right = f(right);
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_minimum_of_a_parabola_and_of_two_valleys_is_found_inside_and_on_the_edge() {
        assert!((minimum(|z| (z - 0.37).powi(2), -2.0, 3.0) - 0.37).abs() < 1e-4);
        assert!((minimum(|z| z, -2.0, 3.0) + 2.0).abs() < 1e-4);
        let valleys = |z: f64| ((z - 2.0).powi(2)).min((z + 1.5).powi(2) + 0.1);
        assert!((minimum(valleys, -3.0, 3.0) - 2.0).abs() < 1e-4);
    }
}
