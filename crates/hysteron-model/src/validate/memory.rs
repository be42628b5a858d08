//! Initial hysteresis memory of a device, estimated from the record.

use super::{OffsetTreatment, ScoreError, Scoring, mean, root_mean_square, scored_samples};
use crate::hammerstein::Model;
use crate::record::{InputOutput, Timing, range_of};
use crate::start::Start;
use rayon::prelude::*;

/// Memories tried before the best is refined: the error may have several minima.
const COARSE: usize = 9;
/// Precision of the memory, as a share of its range.
const PRECISION: f64 = 1e-5;

/// A difference below this share of the largest is that of a memory forgotten.
const FORGOTTEN: f64 = 1e-3;

/// The start at rest at u(0) with the memory from which `model` explains the record best (smallest RMSE), its
/// RMSE and the simulation from it. The memory is searched over
/// [`Hysteresis::memory_range`](crate::hysteresis::Hysteresis::memory_range): first on a grid, then by
/// parabolas. `None` where there is no memory to search.
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
    let simulated = |value: f64| model.simulate(&record.u, &record.time, &remembering(value));
    let forgotten = match [simulated(least), simulated(most)] {
        [Ok(a), Ok(b)] => Forgotten::new([(least, a), (most, b)]),
        _ => None,
    };
    let error = |simulated: &[f64]| error_of(record, simulated, &scored, scoring.offset);
    let rmse = |value: f64| {
        let simulated = match &forgotten {
            Some(forgotten) => forgotten.simulated(value, |samples| {
                let timing = Timing::from(&record.time).of_first(samples);
                model.simulate(&record.u[..samples], timing, &remembering(value))
            }),
            None => simulated(value),
        };
        simulated.map_or(f64::INFINITY, |simulated| error(&simulated))
    };
    let value = minimum(rmse, least, most);
    // A memory that cannot be simulated is discarded.
    let Ok(simulated) = simulated(value) else { return Ok(None) };
    Ok(Some((error(&simulated), remembering(value), simulated)))
}

/// A record of which only the first part depends on the memory from before it: what a memory left behind is
/// lost at the first larger swing (wiping-out).
struct Forgotten {
    /// The least and the greatest memory, and the simulation from each.
    ends: [(f64, Vec<f64>); 2],
    /// Samples of the first part.
    samples: usize,
}

impl Forgotten {
    /// `None` where the first part is most of the record.
    fn new(ends: [(f64, Vec<f64>); 2]) -> Option<Self> {
        let [(_, a), (_, b)] = &ends;
        let apart = |(a, b): (&f64, &f64)| (a - b).abs();
        let largest = a.iter().zip(b).map(apart).fold(0.0, f64::max);
        let last = a.iter().zip(b).rposition(|two| apart(two) > FORGOTTEN * largest);
        let samples = last.map_or(1, |last| last + 1);
        (2 * samples < a.len()).then_some(Self { ends, samples })
    }

    /// The simulation from the memory `value`, by that of the first part. Afterwards, where dynamics let a small
    /// rest of the difference fade, it is interpolated between the ends.
    fn simulated<E>(
        &self,
        value: f64,
        first_part: impl FnOnce(usize) -> Result<Vec<f64>, E>,
    ) -> Result<Vec<f64>, E> {
        let mut simulated = first_part(self.samples)?;
        let [(least, a), (most, b)] = &self.ends;
        let share = (value - least) / (most - least);
        let rest = a.iter().zip(b).skip(self.samples);
        simulated.extend(rest.map(|(a, b)| a + share * (b - a)));
        Ok(simulated)
    }
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
fn minimum(f: impl Fn(f64) -> f64 + Sync, low: f64, high: f64) -> f64 {
    let step = (high - low) / (COARSE - 1) as f64;
    let at = |k: usize| low + step * k as f64;
    let values: Vec<f64> = (0..COARSE).into_par_iter().map(|k| f(at(k))).collect();
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let best = values.iter().position(|value| *value == least).unwrap_or(0);
    let ends = [at(best.saturating_sub(1)), at((best + 1).min(COARSE - 1))];
    parabolic(&f, ends, (at(best), least), PRECISION * (high - low))
}

/// A golden section of 1.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// Minimum of `f` between two `ends` from a point there and its value, to a width: by parabolas through the three
/// lowest points, by golden section where these do not close in (R. P. Brent, *Algorithms for Minimization Without
/// Derivatives* (1973), ch. 5).
fn parabolic(f: &impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2], best: (f64, f64), width: f64) -> f64 {
    let (mut best, mut second, mut third) = (best, best, best);
    // The last two steps.
    let (mut last, mut before) = (0.0_f64, 0.0_f64);
    while best.0 - low > width || high - best.0 > width {
        let x = best.0;
        let [a, b] = [(x - second.0) * (best.1 - third.1), (x - third.0) * (best.1 - second.1)];
        let parabola = ((x - third.0) * b - (x - second.0) * a) / (2.0 * (a - b));
        let closes_in = parabola.abs() < 0.5 * before.abs() && (low..=high).contains(&(x + parabola));
        let to_farther = if x < 0.5 * (low + high) { high - x } else { low - x };
        let step = if closes_in { parabola } else { GOLDEN * to_farther };
        before = if closes_in { last } else { to_farther };
        // Never nearer to the point, or to an end, than half of the width.
        let least = 0.5 * width;
        let step = if step.abs() < least { least.copysign(to_farther) } else { step };
        let inside = least.min(0.4 * (high - low));
        let next = (x + step).clamp(low + inside, high - inside);
        last = next - x;
        let next = (next, f(next));
        let is_better = next.1 <= best.1;
        if is_better == (next.0 > best.0) {
            low = if is_better { best.0 } else { next.0 };
        } else {
            high = if is_better { best.0 } else { next.0 };
        }
        if is_better {
            (best, second, third) = (next, best, second);
        } else if next.1 <= second.1 || second.0 == best.0 {
            (second, third) = (next, second);
        } else if next.1 <= third.1 || third.0 == best.0 || third.0 == second.0 {
            third = next;
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{Dynamics, Scheme};
    use crate::hysteresis::{ArticleOperator, Hysteresis};
    use crate::record::{InterSample, TimeBase};
    use std::f64::consts::TAU;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn the_minimum_of_a_parabola_and_of_two_valleys_is_found_inside_and_on_the_edge() {
        assert!((minimum(|z| (z - 0.37).powi(2), -2.0, 3.0) - 0.37).abs() < 1e-4);
        assert!((minimum(|z| z, -2.0, 3.0) + 2.0).abs() < 1e-4);
        // Steps of parabolas: as few evaluations as that takes.
        let evaluations = AtomicUsize::new(0);
        let hyperbola = |z: f64| {
            evaluations.fetch_add(1, Ordering::Relaxed);
            (1.0 + (z - 0.37).powi(2)).sqrt()
        };
        assert!((minimum(hyperbola, -2.0, 3.0) - 0.37).abs() < 1e-4);
        assert!(evaluations.into_inner() < COARSE + 12);
        assert!(minimum(|_| f64::INFINITY, -2.0, 3.0).is_finite());
        assert_eq!(minimum(|z| z, 1.0, 1.0), 1.0);
        let valleys = |z: f64| ((z - 2.0).powi(2)).min((z + 1.5).powi(2) + 0.1);
        assert!((minimum(valleys, -3.0, 3.0) - 2.0).abs() < 1e-4);
    }

    #[test]
    fn a_forgotten_memory_needs_the_first_part_of_the_record() {
        let hysteresis = ArticleOperator::new(vec![3.0], 1.0, 0.4, 0.1, 1.0).unwrap();
        let model = Model {
            hysteresis: Hysteresis::from(hysteresis),
            dynamics: Dynamics::None,
            offset: 0.0,
            delay_s: 0.0,
            scheme: Scheme::Tustin,
            inter_sample: InterSample::Linear,
            sample_rate_hz: None,
        };
        let u: Vec<f64> = (0..2000).map(|k| 5.0 * (TAU * f64::from(k) / 200.0).sin()).collect();
        let time = TimeBase::uniform(1000.0);
        let from = |value: f64, samples: usize| {
            let start = Start::Remembering { voltage_v: u[0], memory: model.hysteresis.memory(value) };
            model.simulate(&u[..samples], Timing::from(&time).of_first(samples), &start).unwrap()
        };
        let (least, most) = model.hysteresis.memory_range(-5.0, 5.0).unwrap();
        let forgotten = Forgotten::new([least, most].map(|value| (value, from(value, u.len())))).unwrap();
        assert!(forgotten.samples < 400, "{}", forgotten.samples);
        for share in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let value = least + share * (most - least);
            let whole = from(value, u.len());
            let parts = forgotten.simulated::<()>(value, |samples| Ok(from(value, samples))).unwrap();
            let apart = whole.iter().zip(&parts).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart <= 0.1 * FORGOTTEN * (most - least), "{share}: {apart}");
        }
        // A memory that is kept to the end leaves no other part.
        let small: Vec<f64> = u.iter().map(|u| 0.01 * u).collect();
        let kept = |value: f64| small.iter().map(|u| value + u).collect();
        assert!(Forgotten::new([(0.0, kept(0.0)), (1.0, kept(1.0))]).is_none());
    }
}
