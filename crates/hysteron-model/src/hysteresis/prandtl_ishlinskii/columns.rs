//! Plays: one column per threshold.

use hysteron_rt::{Dual, Scalar, play};

use super::super::HysteresisError;
use super::super::columns::{ColumnKernel, simulate_with_sensitivities};
use super::super::outputs::Columns;
use super::super::pass::{Every, at_rest};
use super::super::plays::{PlayStates, check_thresholds};
use crate::start::Start;

/// Columns F_rⱼ ← max(u − rⱼ, min(u + rⱼ, F_rⱼ)) \[V\], rⱼ = `thresholds`\[j\]; without shape numbers.
#[derive(Clone, Debug)]
pub(in crate::hysteresis) struct Plays {
    pub(super) thresholds: Vec<f64>,
}

impl ColumnKernel for Plays {
    type State<S: Scalar<Real = f64>> = PlayStates<S>;

    simulate_with_sensitivities!(0);

    fn shape_names(&self) -> &'static [&'static str] {
        &[]
    }

    fn check(&self, _: &[f64]) -> Result<(), HysteresisError> {
        check_thresholds(&self.thresholds)
    }

    fn columns(&self) -> usize {
        self.thresholds.len()
    }

    fn virgin<S: Scalar<Real = f64>>(&self, _: &[S], u: S) -> PlayStates<S> {
        PlayStates::at(self.thresholds.len(), u)
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        _: &[S],
        state: &mut PlayStates<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        state.advance(self.thresholds.iter().map(|&threshold| S::constant(threshold)), u);
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &PlayStates<S>, out: &mut [S]) {
        state.read(out);
    }
}

/// A play with its derivatives with respect to its threshold and to the memory.
type Play = Dual<f64, 2>;

/// [`HysteresisForm::run`], with derivatives with respect to the thresholds.
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
    out.resize(thresholds.len(), samples, &pairs, false)?;
    if wanted.is_some() {
        out.by_memory.resize_with(thresholds.len(), Vec::new);
        out.by_memory.iter_mut().for_each(Vec::clear);
    }
    if let Some(index) = u.iter().position(|u| !u.is_finite()) {
        return Err(HysteresisError::Drive { index });
    }
    let at_rest = at_rest(start, u)?;
    let (low, high) = u.iter().fold((f64::MAX, f64::MIN), |(low, high), &u| (low.min(u), high.max(u)));
    let mut next = 0;
    let mut plain = Vec::with_capacity(thresholds.len());
    for (index, &threshold) in thresholds.iter().enumerate() {
        let half_width = Play::variable(threshold, 0);
        let step = |state: Play, u: f64| play(half_width, state, Play::constant(u));
        let mut state = match at_rest {
            Some((rest, None)) => Play::constant(rest),
            Some((rest, Some(memory))) => step(Play::variable(memory, 1), rest),
            None => {
                // Exact after one period; plays that the record never moves are in the middle, as they are in
                // [`PrandtlIshlinskii`].
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
        let mut by_memory = by_memory.get_mut(index);
        let mut moves = u.chunks(factor).zip(&mut values[index]);
        if derived(index) {
            let partial = &mut partials[next];
            next += 1;
            if at_rest.is_some() {
                partial.rest = state.partials[0];
            }
            for ((moves, value), by_threshold) in moves.zip(&mut partial.values) {
                state = step(state, moves[0]);
                (*value, *by_threshold) = (state.value, state.partials[0]);
                if let Some(by_memory) = &mut by_memory {
                    by_memory.push(state.partials[1]);
                }
                state = moves[1..].iter().fold(state, |state, &u| step(state, u));
            }
            continue;
        }
        let mut done = 0;
        // Until the drive moves the play, which wipes out the memory.
        if let Some(by_memory) = by_memory {
            while state.partials[1] != 0.0
                && let Some((moved, value)) = moves.next()
            {
                state = step(state, moved[0]);
                *value = state.value;
                by_memory.push(state.partials[1]);
                state = moved[1..].iter().fold(state, |state, &u| step(state, u));
                done += 1;
            }
        }
        plain.push(Plain { index, threshold, state: state.value, done });
    }
    let (fours, rest) = plain.as_chunks_mut();
    for four in fours {
        run_abreast(four, u, factor, &mut out.values);
    }
    for one in rest {
        one.run_to(samples, u, factor, &mut out.values[one.index]);
    }
    Ok(())
}

/// A play without derivatives, simulated up to a sample.
struct Plain {
    index: usize,
    threshold: f64,
    state: f64,
    done: usize,
}

impl Plain {
    /// Runs up to this sample.
    fn run_to(&mut self, end: usize, u: &[f64], factor: usize, values: &mut [f64]) {
        let moves = u.chunks(factor).zip(values).take(end).skip(self.done);
        for (moves, value) in moves {
            self.state = play(self.threshold, self.state, moves[0]);
            *value = self.state;
            self.state = moves[1..].iter().fold(self.state, |state, &u| play(self.threshold, state, u));
        }
        self.done = end;
    }
}

/// Runs four plays to the end: each move depends on the previous one, so that four chains take the time of
/// one.
fn run_abreast(plays: &mut [Plain; 4], u: &[f64], factor: usize, values: &mut [Vec<f64>]) {
    let begin = plays.iter().map(|play| play.done).fold(0, usize::max);
    for play in plays.iter_mut() {
        play.run_to(begin, u, factor, &mut values[play.index]);
    }
    let [a, b, c, d] = plays.each_ref().map(|play| play.index);
    let Ok([a, b, c, d]) = values.get_disjoint_mut([a, b, c, d]) else { return };
    let thresholds = plays.each_ref().map(|play| play.threshold);
    let mut states = plays.each_ref().map(|play| play.state);
    let mut advance = |u: f64| {
        for (state, threshold) in states.iter_mut().zip(thresholds) {
            *state = play(threshold, *state, u);
        }
        states
    };
    let moves = u[(begin * factor).min(u.len())..].chunks(factor);
    let values = a[begin..].iter_mut().zip(&mut b[begin..]).zip(&mut c[begin..]).zip(&mut d[begin..]);
    for (moves, (((a, b), c), d)) in moves.zip(values) {
        [*a, *b, *c, *d] = advance(moves[0]);
        moves[1..].iter().for_each(|&u| {
            advance(u);
        });
    }
}
