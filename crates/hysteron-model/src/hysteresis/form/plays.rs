//! Plays: one column a threshold.
//!
//! F ← max(u − r, min(u + r, F)): where a move carries the play, ∂F/∂r = ∓1 and nothing of the past is left;
//! where it does not, F keeps its value and its derivatives.

use super::super::HysteresisError;
use super::super::outputs::Columns;
use super::super::pass::{Every, at_rest};
use crate::start::Start;

/// A play and its derivatives with respect to its threshold and to the memory.
#[derive(Clone, Copy)]
struct Play {
    value: f64,
    by_threshold: f64,
    by_memory: f64,
}

impl Play {
    #[inline(always)]
    fn step(&mut self, threshold: f64, u: f64) {
        let (low, high) = (u - threshold, u + threshold);
        if self.value < low {
            *self = Self { value: low, by_threshold: -1.0, by_memory: 0.0 };
        } else if self.value > high {
            *self = Self { value: high, by_threshold: 1.0, by_memory: 0.0 };
        }
    }
}

pub(super) fn run(
    thresholds: &[f64],
    factor: usize,
    u: &[f64],
    start: Start<f64>,
    wanted: Option<&[bool]>,
    out: &mut Columns,
) -> Result<(), HysteresisError> {
    Every::new(factor)?;
    let samples = u.len().div_ceil(factor);
    let derived = |play: usize| wanted.is_some_and(|wanted| wanted.get(play) == Some(&true));
    let pairs: Vec<(usize, usize)> =
        (0..thresholds.len()).filter(|&play| derived(play)).map(|play| (play, play)).collect();
    out.resize(thresholds.len(), samples, &pairs, wanted.is_some());
    if let Some(index) = u.iter().position(|u| !u.is_finite()) {
        return Err(HysteresisError::Drive { index });
    }
    let at_rest = at_rest(start, u)?;
    let (low, high) = u.iter().fold((f64::MAX, f64::MIN), |(low, high), &u| (low.min(u), high.max(u)));
    let mut next = 0;
    for (index, &threshold) in thresholds.iter().enumerate() {
        if !(threshold.is_finite() && threshold > 0.0) {
            return Err(HysteresisError::Threshold { index, value: threshold, above: 0.0 });
        }
        let at = |value, by_memory| Play { value, by_threshold: 0.0, by_memory };
        let mut play = match at_rest {
            Some((rest, None)) => at(rest, 0.0),
            Some((rest, Some(memory))) => {
                let mut play = at(memory, 1.0);
                play.step(threshold, rest);
                play
            }
            None => {
                // Exact after one period; what no voltage of the record moves stands in the middle
                // (`PrandtlIshlinskii`).
                let mut play = at(0.5 * low + 0.5 * high, 0.0);
                u.iter().for_each(|&u| play.step(threshold, u));
                play
            }
        };
        if !play.value.is_finite() {
            return Err(HysteresisError::Drive { index: 0 });
        }
        if at_rest.is_some() {
            (out.rest[index], out.rest_by_memory[index]) = (play.value, play.by_memory);
        }
        let Columns { values, partials, by_memory, .. } = &mut *out;
        let values = &mut values[index];
        let mut by_memory = by_memory.get_mut(index);
        let mut partial = if derived(index) { partials.get_mut(next) } else { None };
        next += usize::from(partial.is_some());
        if let Some(partial) = &mut partial
            && at_rest.is_some()
        {
            partial.rest = play.by_threshold;
        }
        for (k, moves) in u.chunks(factor).enumerate() {
            play.step(threshold, moves[0]);
            values[k] = play.value;
            if let Some(by_memory) = &mut by_memory {
                by_memory[k] = play.by_memory;
            }
            if let Some(partial) = &mut partial {
                partial.values[k] = play.by_threshold;
            }
            moves[1..].iter().for_each(|&u| play.step(threshold, u));
        }
    }
    Ok(())
}
