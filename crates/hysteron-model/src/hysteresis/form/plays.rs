//! Plays: one column a threshold.

use hysteron_rt::{Dual, Scalar, play};

use super::super::HysteresisError;
use super::super::outputs::Columns;
use super::super::pass::{Every, at_rest};
use crate::start::Start;

/// A play with its derivatives with respect to its threshold and to the memory.
type Play = Dual<f64, 2>;

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
        let half_width = Play::variable(threshold, 0);
        let step = |state: Play, u: f64| play(half_width, state, Play::constant(u));
        let mut state = match at_rest {
            Some((rest, None)) => Play::constant(rest),
            Some((rest, Some(memory))) => step(Play::variable(memory, 1), rest),
            None => {
                // Exact after one period; what no voltage of the record moves stands in the middle
                // (`PrandtlIshlinskii`).
                let middle = Play::constant(0.5 * low + 0.5 * high);
                u.iter().fold(middle, |state, &u| step(state, u))
            }
        };
        if !state.value.is_finite() {
            return Err(HysteresisError::Drive { index: 0 });
        }
        if at_rest.is_some() {
            (out.rest[index], out.rest_by_memory[index]) = (state.value, state.partials[1]);
        }
        let Columns { values, partials, by_memory, .. } = &mut *out;
        let values = &mut values[index];
        let mut by_memory = by_memory.get_mut(index);
        let mut partial = if derived(index) { partials.get_mut(next) } else { None };
        next += usize::from(partial.is_some());
        if let Some(partial) = &mut partial
            && at_rest.is_some()
        {
            partial.rest = state.partials[0];
        }
        for (k, moves) in u.chunks(factor).enumerate() {
            state = step(state, moves[0]);
            values[k] = state.value;
            if let Some(by_memory) = &mut by_memory {
                by_memory[k] = state.partials[1];
            }
            if let Some(partial) = &mut partial {
                partial.values[k] = state.partials[0];
            }
            state = moves[1..].iter().fold(state, |state, &u| step(state, u));
        }
    }
    Ok(())
}
