//! Derivatives of a bank of two-state modes and lags under feedback through plays, a block of parameters at
//! once.

use nalgebra::RealField;

use super::InstructionSet;
use super::dispatch::{feedback_tangent, feedback_tangent_single};

/// Parameters processed at once: the derivatives of some forty states then stay in the first-level cache.
pub const LANES: usize = 32;

/// One derivative per parameter of the block.
pub type Lanes<T> = [T; LANES];

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
pub struct FeedbackTangent<'a, T> {
    /// Modes: pairs of states; lags follow them.
    pub modes: usize,
    /// Re and Im of the poles of the modes, then the lags.
    pub transition: &'a [T],
    /// R: rows of `row` numbers, of which the first belong to the states; empty without feedback.
    pub channels: &'a [T],
    /// Length of a row of `channels`.
    pub row: usize,
    /// Weights of the plays, `plays` per channel.
    pub weights: &'a [T],
    /// Plays per channel.
    pub plays: usize,
    /// H: rows of `strains` numbers.
    pub strain_input: &'a [T],
    /// Number of strains.
    pub strains: usize,
    /// C: one row per output.
    pub output: &'a [T],
    /// D: rows of `strains` numbers, one per output.
    pub strain_feedthrough: &'a [T],
    /// Signals of every step, `width` per step.
    pub signals: &'a [T],
    /// Signals per step.
    pub width: usize,
    /// Slope of each channel's law while no play moves, one row per step.
    pub slopes: &'a [T],
    /// Bit masks of the plays that moved, one row per step.
    pub moved: &'a [u32],
    /// Steps before the first sample.
    pub before: usize,
    /// Steps per sample.
    pub steps: usize,
}

/// Current derivatives.
#[derive(Clone, Debug)]
struct TangentState<T> {
    x: Vec<Lanes<T>>,
    z: Vec<Lanes<T>>,
    w: Vec<Lanes<T>>,
    plays: Vec<Lanes<T>>,
    weighted: Vec<Lanes<T>>,
}

/// Precision of the derivatives: `f32` or `f64`.
pub trait TangentNumber: RealField + Copy + Into<f64> {
    /// Runs the recursion.
    #[doc(hidden)]
    fn follow(set: InstructionSet, recursion: Recursion<'_, '_, Self>);
}

impl TangentNumber for f32 {
    fn follow(set: InstructionSet, recursion: Recursion<'_, '_, f32>) {
        feedback_tangent_single(set, recursion);
    }
}

impl TangentNumber for f64 {
    fn follow(set: InstructionSet, recursion: Recursion<'_, '_, f64>) {
        feedback_tangent(set, recursion);
    }
}

impl<T: TangentNumber> FeedbackTangent<'_, T> {
    /// Derivatives of every output at every sample, from derivatives 0 at the first step: `out` holds, output
    /// by output, one [`Lanes`] per sample.
    ///
    /// `out` has outputs · samples entries; entries beyond the trajectory are unchanged.
    pub fn run(&self, set: InstructionSet, forcing: &[Forcing], out: &mut [Lanes<T>]) {
        let channels = self.channels.len() / self.row.max(1);
        let zeros = |count: usize| vec![[T::zero(); LANES]; count];
        let state = TangentState {
            x: zeros(self.transition.len()),
            z: zeros(channels),
            w: zeros(self.strains),
            plays: zeros(channels * self.plays),
            weighted: zeros(channels),
        };
        T::follow(set, Recursion { system: self, forcing, state, out });
    }
}

/// The recursion, every step of the trajectory in turn.
#[doc(hidden)]
#[derive(Debug)]
pub struct Recursion<'r, 's, T> {
    system: &'r FeedbackTangent<'s, T>,
    forcing: &'r [Forcing],
    state: TangentState<T>,
    out: &'r mut [Lanes<T>],
}

#[inline(always)]
pub(super) fn feedback_tangent_kernel(recursion: Recursion<'_, '_, f64>) {
    follow(recursion);
}

#[inline(always)]
pub(super) fn feedback_tangent_single_kernel(recursion: Recursion<'_, '_, f32>) {
    follow(recursion);
}

/// Lanes of several rows whose sums are computed together: with AVX2, those of six rows in double precision take
/// 12 of the 16 registers. Sixteen in single precision are not vectorised.
const ABREAST: usize = 8;

#[inline(always)]
fn add_scaled<T: RealField + Copy>(to: &mut [T], factor: T, from: &[T]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += factor * *from;
    }
}

/// start + Σ_k row_k from_k, in this order. The sum is a local: through a reference it would not stay in vector
/// registers.
#[inline(always)]
fn combined<T: RealField + Copy>(start: &Lanes<T>, row: &[T], from: &[Lanes<T>]) -> Lanes<T> {
    let mut sum = *start;
    for (factor, from) in row.iter().zip(from) {
        add_scaled(&mut sum, *factor, from);
    }
    sum
}

/// The first R rows of to = matrix · from; every term is loaded once.
#[inline(always)]
fn rows_times<T: RealField + Copy, const R: usize>(
    matrix: &[T],
    row: usize,
    from: &[Lanes<T>],
    to: &mut [Lanes<T>],
) {
    let rows: [&[T]; R] = std::array::from_fn(|r| &matrix[r * row..r * row + from.len()]);
    for first in (0..LANES).step_by(ABREAST) {
        let mut sums = [[T::zero(); ABREAST]; R];
        for (k, from) in from.iter().enumerate() {
            for (sum, row) in sums.iter_mut().zip(rows) {
                add_scaled(sum, row[k], &from[first..first + ABREAST]);
            }
        }
        for (to, sum) in to.iter_mut().zip(&sums) {
            to[first..first + ABREAST].copy_from_slice(sum);
        }
    }
}

/// to = matrix · from; rows of `row` numbers, of which the first count.
#[inline(always)]
fn times<T: RealField + Copy>(matrix: &[T], row: usize, from: &[Lanes<T>], to: &mut [Lanes<T>]) {
    let mut done = 0;
    while done < to.len() {
        let (matrix, to) = (&matrix[done * row..], &mut to[done..]);
        done += match to.len() {
            6.. => {
                rows_times::<T, 6>(matrix, row, from, to);
                6
            }
            3.. => {
                rows_times::<T, 3>(matrix, row, from, to);
                3
            }
            _ => {
                to[0] = combined(&[T::zero(); LANES], &matrix[..from.len()], from);
                1
            }
        };
    }
}

/// A direct action: row, lane, signal, factor.
type Action<T> = (usize, usize, usize, T);

/// Adds the direct actions on one kind of target.
#[inline(always)]
fn act<T: RealField + Copy>(actions: &[Action<T>], signals: &[T], on: &mut [Lanes<T>]) {
    for (row, lane, signal, factor) in actions {
        on[*row][*lane] += *factor * signals[*signal];
    }
}

#[inline(always)]
fn follow<T: RealField + Copy>(recursion: Recursion<'_, '_, T>) {
    let Recursion { system: s, forcing, state, out } = recursion;
    let TangentState { mut x, mut z, mut w, mut plays, mut weighted } = state;
    let (states, channels) = (s.transition.len(), z.len());
    let outputs = s.output.len() / states.max(1);
    let samples = out.len() / outputs.max(1);
    let on = |place: fn(&Target) -> Option<usize>| -> Vec<Action<T>> {
        let action =
            |f: &Forcing| place(&f.target).map(|row| (row, f.lane, f.signal, nalgebra::convert(f.factor)));
        forcing.iter().filter_map(action).collect()
    };
    let on_channels = on(|target| if let Target::Channel(i) = target { Some(*i) } else { None });
    let on_strains = on(|target| if let Target::Strain(i) = target { Some(*i) } else { None });
    let on_states = on(|target| if let Target::State(i) = target { Some(*i) } else { None });
    let mut y = vec![[T::zero(); LANES]; outputs];
    for (step, signals) in s.signals.chunks_exact(s.width).enumerate() {
        if channels > 0 {
            times(s.channels, s.row, &x, &mut z);
            act(&on_channels, signals, &mut z);
            w.fill([T::zero(); LANES]);
            let slopes = &s.slopes[step * channels..(step + 1) * channels];
            let moved = &s.moved[step * channels..(step + 1) * channels];
            for i in 0..channels {
                let z = &z[i];
                let mut sum = weighted[i];
                // A play that moves follows z; the sum over the plays changes by those alone.
                for j in (0..s.plays).filter(|j| moved[i] >> j & 1 == 1) {
                    let play = &mut plays[i * s.plays + j];
                    let weight = s.weights[i * s.plays + j];
                    for ((sum, play), z) in sum.iter_mut().zip(play.iter()).zip(z) {
                        *sum += weight * (*z - *play);
                    }
                    *play = *z;
                }
                weighted[i] = sum;
                let mut of_strain = w[i % s.strains];
                add_scaled(&mut of_strain, slopes[i], z);
                of_strain.iter_mut().zip(&sum).for_each(|(of_strain, sum)| *of_strain += *sum);
                w[i % s.strains] = of_strain;
            }
            act(&on_strains, signals, &mut w);
        }
        if step >= s.before && (step - s.before).is_multiple_of(s.steps) {
            let sample = (step - s.before) / s.steps;
            times(s.output, states, &x, &mut y);
            for (m, y) in y.iter().enumerate() {
                let row = &s.strain_feedthrough[m * s.strains..(m + 1) * s.strains];
                if let Some(slot) = out.get_mut(m * samples + sample) {
                    *slot = if channels > 0 { combined(y, row, &w) } else { *y };
                }
            }
        }
        // Strains are 0 without feedback.
        let strains = if channels > 0 { &w[..] } else { &[] };
        for (k, p) in s.transition[..2 * s.modes].chunks_exact(2).enumerate() {
            let rows = &s.strain_input[2 * k * s.strains..(2 * k + 2) * s.strains];
            let (of_re, of_im) = rows.split_at(s.strains);
            for first in (0..LANES).step_by(ABREAST) {
                let lanes = first..first + ABREAST;
                let (re, im) = (&x[2 * k][lanes.clone()], &x[2 * k + 1][lanes.clone()]);
                let (mut to_re, mut to_im) = ([T::zero(); ABREAST], [T::zero(); ABREAST]);
                for (((to_re, to_im), re), im) in to_re.iter_mut().zip(&mut to_im).zip(re).zip(im) {
                    *to_re = p[0] * *re - p[1] * *im;
                    *to_im = p[0] * *im + p[1] * *re;
                }
                for ((w, f), g) in strains.iter().zip(of_re).zip(of_im) {
                    let w = &w[lanes.clone()];
                    for ((to_re, to_im), w) in to_re.iter_mut().zip(&mut to_im).zip(w) {
                        *to_re += *f * *w;
                        *to_im += *g * *w;
                    }
                }
                x[2 * k][lanes.clone()].copy_from_slice(&to_re);
                x[2 * k + 1][lanes].copy_from_slice(&to_im);
            }
        }
        for (k, (x, a)) in x.iter_mut().zip(s.transition).enumerate().skip(2 * s.modes) {
            x.iter_mut().for_each(|x| *x *= *a);
            *x = combined(x, &s.strain_input[k * s.strains..(k + 1) * s.strains], strains);
        }
        act(&on_states, signals, &mut x);
    }
}
