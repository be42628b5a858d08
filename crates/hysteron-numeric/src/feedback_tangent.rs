//! Derivatives of a bank of two-state modes and lags under feedback through plays, a block of parameters at
//! once.

use super::InstructionSet;
use super::dispatch::feedback_tangent;

/// Parameters processed at once: the derivatives of some forty states then stay in the first-level cache.
pub const LANES: usize = 32;

/// One derivative per parameter of the block.
pub type Lanes = [f64; LANES];

/// Target of a parameter's action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// On a channel z before its law.
    Channel(usize),
    /// On a strain w.
    Strain(usize),
    /// On a state of the next step.
    State(usize),
}

/// A parameter's direct action: `factor` times a signal, on a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forcing {
    /// Target of the action.
    pub target: Target,
    /// Lane of the parameter.
    pub lane: usize,
    /// Number of the signal in a row of the trajectory.
    pub signal: usize,
    /// 1 or −1.
    pub factor: f64,
}

/// The linear system along a trajectory, x⁺ = A x + H w, y = C x + D w, z = R x, w_i = Σ over the channels of
/// i of their laws, and the trajectory. Matrices row by row.
#[derive(Clone, Copy, Debug)]
pub struct FeedbackTangent<'a> {
    /// Modes: pairs of states; lags follow them.
    pub modes: usize,
    /// Re and Im of the poles of the modes, then the lags.
    pub transition: &'a [f64],
    /// R: rows of `row` numbers, of which the first belong to the states; empty without feedback.
    pub channels: &'a [f64],
    /// Length of a row of `channels`.
    pub row: usize,
    /// Weights of the plays, `plays` per channel.
    pub weights: &'a [f64],
    /// Plays per channel.
    pub plays: usize,
    /// H: rows of `strains` numbers.
    pub strain_input: &'a [f64],
    /// Number of strains.
    pub strains: usize,
    /// C: one row per output.
    pub output: &'a [f64],
    /// D: rows of `strains` numbers, one per output.
    pub strain_feedthrough: &'a [f64],
    /// Signals of every step, `width` per step.
    pub signals: &'a [f64],
    /// Signals per step.
    pub width: usize,
    /// Slope of each channel's law while no play moves, one row per step.
    pub slopes: &'a [f64],
    /// Bit masks of the plays that moved, one row per step.
    pub moved: &'a [u32],
    /// Steps before the first sample.
    pub before: usize,
    /// Steps per sample.
    pub steps: usize,
}

/// Current derivatives.
#[derive(Clone, Debug, Default)]
pub struct TangentState {
    x: Vec<Lanes>,
    next: Vec<Lanes>,
    z: Vec<Lanes>,
    w: Vec<Lanes>,
    plays: Vec<Lanes>,
    weighted: Vec<Lanes>,
}

impl FeedbackTangent<'_> {
    /// Derivatives of every output at every sample, from derivatives 0 at the first step: `out` holds, output
    /// by output, one [`Lanes`] per sample.
    ///
    /// `out` has outputs · samples entries; entries beyond the trajectory are unchanged.
    pub fn run(&self, set: InstructionSet, forcing: &[Forcing], state: &mut TangentState, out: &mut [Lanes]) {
        let zero = [0.0; LANES];
        let channels = self.channels.len() / self.row.max(1);
        let sized = |lanes: &mut Vec<Lanes>, count: usize| {
            lanes.clear();
            lanes.resize(count, zero);
        };
        sized(&mut state.x, self.transition.len());
        sized(&mut state.next, self.transition.len());
        sized(&mut state.z, channels);
        sized(&mut state.w, self.strains);
        sized(&mut state.plays, channels * self.plays);
        sized(&mut state.weighted, channels);
        feedback_tangent(set, self, forcing, state, out);
    }
}

#[inline(always)]
fn add_scaled(to: &mut Lanes, factor: f64, from: &Lanes) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += factor * from;
    }
}

/// Σ_k row_k from_k.
#[inline(always)]
fn combined(row: &[f64], from: &[Lanes]) -> Lanes {
    let mut sum = [0.0; LANES];
    for (factor, from) in row.iter().zip(from) {
        add_scaled(&mut sum, *factor, from);
    }
    sum
}

/// The recursion; every step of the trajectory in turn.
#[inline(always)]
pub(super) fn feedback_tangent_kernel(
    system: &FeedbackTangent<'_>,
    forcing: &[Forcing],
    state: &mut TangentState,
    out: &mut [Lanes],
) {
    let s = system;
    let states = s.transition.len();
    let channels = state.z.len();
    let outputs = s.output.len() / states.max(1);
    let samples = out.len() / outputs.max(1);
    let rows = s.signals.chunks_exact(s.width);
    for (step, signals) in rows.enumerate() {
        if channels > 0 {
            for (z, row) in state.z.iter_mut().zip(s.channels.chunks_exact(s.row)) {
                *z = combined(&row[..states], &state.x);
            }
            for f in forcing {
                if let Target::Channel(i) = f.target {
                    state.z[i][f.lane] += f.factor * signals[f.signal];
                }
            }
            state.w.iter_mut().for_each(|w| *w = [0.0; LANES]);
            let slopes = &s.slopes[step * channels..(step + 1) * channels];
            let moved = &s.moved[step * channels..(step + 1) * channels];
            for i in 0..channels {
                let z = state.z[i];
                // A play that moves follows z; the sum over the plays changes by those alone.
                for j in (0..s.plays).filter(|j| moved[i] >> j & 1 == 1) {
                    let play = &mut state.plays[i * s.plays + j];
                    let weight = s.weights[i * s.plays + j];
                    for ((sum, play), z) in state.weighted[i].iter_mut().zip(play.iter_mut()).zip(&z) {
                        *sum += weight * (z - *play);
                        *play = *z;
                    }
                }
                let w = &mut state.w[i % s.strains];
                add_scaled(w, slopes[i], &z);
                add_scaled(w, 1.0, &state.weighted[i]);
            }
            for f in forcing {
                if let Target::Strain(i) = f.target {
                    state.w[i][f.lane] += f.factor * signals[f.signal];
                }
            }
        }
        if step >= s.before && (step - s.before).is_multiple_of(s.steps) {
            let sample = (step - s.before) / s.steps;
            for m in 0..outputs {
                let mut y = combined(&s.output[m * states..(m + 1) * states], &state.x);
                if channels > 0 {
                    let row = &s.strain_feedthrough[m * s.strains..(m + 1) * s.strains];
                    for (factor, w) in row.iter().zip(&state.w) {
                        add_scaled(&mut y, *factor, w);
                    }
                }
                if let Some(slot) = out.get_mut(m * samples + sample) {
                    *slot = y;
                }
            }
        }
        for k in 0..s.modes {
            let (a, b) = (s.transition[2 * k], s.transition[2 * k + 1]);
            let (re, im) = (state.x[2 * k], state.x[2 * k + 1]);
            for lane in 0..LANES {
                state.next[2 * k][lane] = a * re[lane] - b * im[lane];
                state.next[2 * k + 1][lane] = a * im[lane] + b * re[lane];
            }
        }
        for k in 2 * s.modes..states {
            for (next, x) in state.next[k].iter_mut().zip(&state.x[k]) {
                *next = s.transition[k] * x;
            }
        }
        if channels > 0 {
            for (next, row) in state.next.iter_mut().zip(s.strain_input.chunks_exact(s.strains)) {
                for (factor, w) in row.iter().zip(&state.w) {
                    add_scaled(next, *factor, w);
                }
            }
        }
        for f in forcing {
            if let Target::State(k) = f.target {
                state.next[k][f.lane] += f.factor * signals[f.signal];
            }
        }
        std::mem::swap(&mut state.x, &mut state.next);
    }
}
