//! A bank of relaxations for each of several piecewise quadratic inputs, advanced together.
//!
//! ξ' = λ (u − ξ) with u = u₀ + s t + c t². The states are η = ξ − u, for which η(t) = η₀ − g η₀ − γ s t − κ
//! c t², x = λt, g = 1 − e⁻ˣ, γ = g/x, κ = 2 (1 − γ)/x, whatever the step's length and the number of inputs.
//! The rates are a half octave apart, so that all but the first of a chain follow without an exponential:
//! g(2x) = g (2 − g), γ(2x) = γ (1 − g/2), κ(2x) = (κ + γ²)/2.

use super::dispatch::{InstructionSet, bank_advance, bank_read};
use super::elementary::exp_m1;
use super::inner_product::inner_product_kernel;

/// Lengths that differ by less than this share count as equal: the effect of rounding.
const EQUAL: f64 = 1e-8;

/// Inputs side by side in vector code.
pub const ABREAST: usize = 8;

/// One number per input, [`ABREAST`] to a row.
pub type Abreast = [f64; ABREAST];

/// u = u₀ + s t + c t² of several inputs from one time on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parabolas {
    /// u₀.
    pub from: Vec<Abreast>,
    /// s \[1/s\].
    pub slope: Vec<Abreast>,
    /// c \[1/s²\].
    pub bend: Vec<Abreast>,
    /// u at the end.
    pub to: Vec<Abreast>,
    /// True if every c is 0, so that it is not used.
    pub straight: bool,
    /// An input far below any signal, added so that states at rest stay above the subnormal numbers, which
    /// are slow.
    pub(super) level: Vec<Abreast>,
}

/// [`Parabolas::level`] as a share of the last u₀ that was not 0.
const LEVEL: f64 = 1e-280;

impl Parabolas {
    /// Zeros for this number of inputs. Keeps its buffers.
    pub fn reset(&mut self, inputs: usize) {
        for row in [&mut self.from, &mut self.slope, &mut self.bend, &mut self.to, &mut self.level] {
            row.clear();
            row.resize(inputs.div_ceil(ABREAST), [0.0; ABREAST]);
        }
        self.straight = true;
    }

    /// Sets u₀ of all inputs.
    pub fn begin_at(&mut self, from: &[Abreast]) {
        self.from.copy_from_slice(from);
        let levels = self.level.as_flattened_mut().iter_mut();
        for (level, from) in levels.zip(from.as_flattened()).filter(|(_, from)| **from != 0.0) {
            *level = from * LEVEL;
        }
    }

    fn each(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        let rows = self.slope.as_flattened().iter().zip(self.bend.as_flattened());
        self.from.as_flattened().iter().zip(rows).map(|(from, (slope, bend))| (*from, *slope, *bend))
    }
}

/// ξₖ of ξ' = λₖ (u − ξ) of several inputs u.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RelaxationBank {
    rates: Rates,
    /// ηₖ, input by input.
    states: Vec<[f64; LANES]>,
    /// u, input by input.
    inputs: Vec<f64>,
    step: Gains,
    reading: Gains,
}

/// λₖ = λ₀ 2^(k/2) in rows, each of twice the rates of the one before.
#[derive(Clone, Debug, Default, PartialEq)]
struct Rates {
    /// The first row.
    of: [f64; LANES],
    /// 1/λ of the first row.
    times: [f64; LANES],
    rows: usize,
}

/// gₖ, γₖ and, for bent inputs, κₖ of one length, kept for the next one of that length.
#[derive(Clone, Debug, PartialEq)]
struct Gains {
    length_s: f64,
    bent: bool,
    of_state: Vec<[f64; LANES]>,
    of_slope: Vec<[f64; LANES]>,
    of_bend: Vec<[f64; LANES]>,
}

/// Relaxations in a row: [`PER_OCTAVE`] to each of eight octaves.
const LANES: usize = 16;

/// Relaxations per octave of the rates.
pub const PER_OCTAVE: usize = 2;

/// λₖ = λ₀ 2^(k/2) of the slowest rate λ₀.
pub fn relaxation_rate(slowest: f64, k: usize) -> f64 {
    slowest * (k as f64 / PER_OCTAVE as f64).exp2()
}

/// Row and lane of relaxation k; relaxation k + [`PER_OCTAVE`] is in the next row of the same lane, or else
/// in the first row of the next lane.
fn place(k: usize, rows: usize) -> (usize, usize) {
    let (column, in_column) = (k / (PER_OCTAVE * rows), k % (PER_OCTAVE * rows));
    (in_column / PER_OCTAVE, (in_column % PER_OCTAVE) * (LANES / PER_OCTAVE) + column)
}

impl Default for Gains {
    fn default() -> Self {
        let [of_state, of_slope, of_bend] = [const { Vec::new() }; 3];
        Self { length_s: f64::NAN, bent: false, of_state, of_slope, of_bend }
    }
}

impl Gains {
    fn reset(&mut self, rows: usize) {
        self.length_s = f64::NAN;
        for gains in [&mut self.of_state, &mut self.of_slope, &mut self.of_bend] {
            gains.resize(rows, [0.0; LANES]);
        }
    }

    #[inline(always)]
    fn set(&mut self, rates: &Rates, straight: bool, length_s: f64) {
        let is_known = (length_s - self.length_s).abs() <= EQUAL * self.length_s;
        if is_known && (straight || self.bent) {
            return;
        }
        (self.length_s, self.bent) = (length_s, !straight);
        let [mut x, mut g, mut of_slope, mut of_bend] = [[0.0; LANES]; 4];
        let per_s = 1.0 / length_s;
        for i in 0..LANES {
            x[i] = rates.of[i] * length_s;
            g[i] = -exp_m1(-x[i]);
            of_slope[i] = g[i] * (rates.times[i] * per_s);
        }
        if straight {
            for (to_state, to_slope) in self.of_state.iter_mut().zip(&mut self.of_slope) {
                (*to_state, *to_slope) = (g, of_slope);
                for i in 0..LANES {
                    of_slope[i] -= of_slope[i] * (0.5 * g[i]);
                    g[i] *= 2.0 - g[i];
                }
            }
            return;
        }
        for i in 0..LANES {
            let closed = (1.0 - of_slope[i]) * (2.0 * (rates.times[i] * per_s));
            of_bend[i] = if x[i] > SLOW { closed } else { slow_bend(x[i]) };
        }
        let rows = self.of_state.iter_mut().zip(&mut self.of_slope).zip(&mut self.of_bend);
        for ((to_state, to_slope), to_bend) in rows {
            (*to_state, *to_slope, *to_bend) = (g, of_slope, of_bend);
            for i in 0..LANES {
                of_bend[i] = 0.5 * (of_bend[i] + of_slope[i] * of_slope[i]);
                of_slope[i] -= of_slope[i] * (0.5 * g[i]);
                g[i] *= 2.0 - g[i];
            }
        }
    }
}

/// Weights of a sum over ξ of one input.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BankWeights {
    states: Vec<[f64; LANES]>,
    total: f64,
    is_zero: bool,
    /// In the sum after a time t: weights of ηₖ, of s t and of c t².
    ahead: Vec<[f64; LANES]>,
    of_slope: f64,
    of_bend: f64,
    /// t \[s\], and whether the last of them is known.
    length_s: f64,
    bent: bool,
}

impl BankWeights {
    /// Sets the weights of ξₖ. Keeps its buffer.
    pub fn set(&mut self, states: &[f64]) {
        let rows = states.len().div_ceil(LANES);
        for weights in [&mut self.states, &mut self.ahead] {
            weights.clear();
            weights.resize(rows, [0.0; LANES]);
        }
        for (k, weight) in states.iter().enumerate() {
            let (row, lane) = place(k, rows);
            self.states[row][lane] = *weight;
        }
        self.total = states.iter().sum();
        self.is_zero = states.iter().all(|w| *w == 0.0);
        (self.length_s, self.bent) = (f64::NAN, false);
    }

    /// True if the sum is 0 whatever the states.
    pub fn is_zero(&self) -> bool {
        self.is_zero
    }

    #[inline(always)]
    fn look_ahead(&mut self, gains: &Gains) {
        if self.is_zero || (self.length_s == gains.length_s && self.bent >= gains.bent) {
            return;
        }
        (self.length_s, self.bent) = (gains.length_s, gains.bent);
        let states = self.states.as_flattened();
        for (ahead, (weight, g)) in
            self.ahead.as_flattened_mut().iter_mut().zip(states.iter().zip(gains.of_state.as_flattened()))
        {
            *ahead = weight - weight * g;
        }
        self.of_slope = inner_product_kernel(states, gains.of_slope.as_flattened());
        if gains.bent {
            self.of_bend = inner_product_kernel(states, gains.of_bend.as_flattened());
        }
    }
}

impl RelaxationBank {
    /// Sets `count` rates λₖ = λ₀ 2^(k/2), λ₀ = `slowest` > 0 \[rad/s\], and rest at 0 for this number of
    /// inputs. Keeps its buffers.
    pub fn reset(&mut self, slowest: f64, count: usize, inputs: usize) {
        let rows = count.div_ceil(LANES);
        self.rates.rows = rows;
        for k in 0..LANES * rows {
            if let (0, lane) = place(k, rows) {
                self.rates.of[lane] = relaxation_rate(slowest, k);
                self.rates.times[lane] = 1.0 / self.rates.of[lane];
            }
        }
        self.states.clear();
        self.states.resize(rows * inputs, [0.0; LANES]);
        self.inputs.clear();
        self.inputs.resize(inputs, 0.0);
        self.step.reset(rows);
        self.reading.reset(rows);
    }

    /// Begins the parabola of each input; the inputs may jump there.
    pub fn begin(&mut self, inputs: &Parabolas) {
        let rows = self.rates.rows;
        if rows == 0 {
            return;
        }
        let each = self.states.chunks_exact_mut(rows).zip(&mut self.inputs);
        for ((states, before), from) in each.zip(inputs.from.as_flattened()) {
            let jump = from - *before;
            if jump != 0.0 {
                states.as_flattened_mut().iter_mut().for_each(|state| *state -= jump);
                *before = *from;
            }
        }
    }

    /// Advances the states along the parabola of each input, which has begun, to its end after `length_s`
    /// \[s\].
    pub fn advance(&mut self, set: InstructionSet, inputs: &Parabolas, length_s: f64) {
        if self.rates.rows > 0 {
            bank_advance(set, self, inputs, length_s);
            self.inputs.iter_mut().zip(inputs.to.as_flattened()).for_each(|(input, to)| *input = *to);
        }
    }

    /// One sum over ξ of each input `length_s` \[s\] along its parabola, which has begun, for each of
    /// `weights` (set for this bank), added to `sums`: all inputs of the first weights, in rows, then of the
    /// next. The states do not change.
    pub fn read(
        &mut self,
        set: InstructionSet,
        inputs: &Parabolas,
        length_s: f64,
        weights: &mut [BankWeights],
        sums: &mut [Abreast],
    ) {
        if self.rates.rows > 0 {
            bank_read(set, self, inputs, length_s, weights, sums);
        }
    }
}

#[inline(always)]
pub(super) fn bank_advance_kernel(bank: &mut RelaxationBank, inputs: &Parabolas, length_s: f64) {
    let RelaxationBank { rates, states, step, .. } = bank;
    step.set(rates, inputs.straight, length_s);
    let each = inputs.each().zip(inputs.level.as_flattened());
    for (states, ((_, slope, bend), level)) in states.chunks_exact_mut(rates.rows).zip(each) {
        let [change, curve] = [slope * length_s + level, bend * (length_s * length_s)];
        let states = states.as_flattened_mut().iter_mut();
        let gains = step.of_state.as_flattened().iter().zip(step.of_slope.as_flattened());
        if inputs.straight {
            for (state, (g, of_slope)) in states.zip(gains) {
                *state -= g * *state + of_slope * change;
            }
        } else {
            for (state, ((g, of_slope), of_bend)) in states.zip(gains.zip(step.of_bend.as_flattened())) {
                *state -= (g * *state + of_slope * change) + of_bend * curve;
            }
        }
    }
}

#[inline(always)]
pub(super) fn bank_read_kernel(
    bank: &mut RelaxationBank,
    inputs: &Parabolas,
    length_s: f64,
    weights: &mut [BankWeights],
    sums: &mut [Abreast],
) {
    let RelaxationBank { rates, states, reading, .. } = bank;
    let is_ahead = length_s > 0.0;
    if is_ahead {
        reading.set(rates, inputs.straight, length_s);
        // A closure would not be compiled for the instruction set.
        for weights in &mut *weights {
            weights.look_ahead(reading);
        }
    }
    let width = ABREAST * inputs.from.len();
    let sums = sums.as_flattened_mut();
    let each = states.chunks_exact(rates.rows).zip(inputs.each());
    for (input, (states, (from, slope, bend))) in each.enumerate() {
        let [change, curve] = [slope * length_s, bend * (length_s * length_s)];
        let now = from + (change + curve);
        for (weights, sums) in weights.iter().zip(sums.chunks_exact_mut(width)) {
            if weights.is_zero {
                continue;
            }
            let of_states = if is_ahead { &weights.ahead } else { &weights.states };
            let of_states = inner_product_kernel(of_states.as_flattened(), states.as_flattened());
            let Some(sum) = sums.get_mut(input) else { continue };
            *sum += weights.total * now + of_states;
            if is_ahead {
                *sum -= weights.of_slope * change;
                if !inputs.straight {
                    *sum -= weights.of_bend * curve;
                }
            }
        }
    }
}

/// Up to this x the closed form of κ loses digits, and [`OF_BEND`] keeps them.
const SLOW: f64 = 0.25;

/// Coefficients of κ = 1 − x/3 + x²/12 − …: 2 (−1)ᵏ/(k + 2)!.
const OF_BEND: [f64; 12] = [
    1.0,
    -1.0 / 3.0,
    1.0 / 12.0,
    -1.0 / 60.0,
    1.0 / 360.0,
    -1.0 / 2520.0,
    1.0 / 20_160.0,
    -1.0 / 181_440.0,
    1.0 / 1_814_400.0,
    -1.0 / 19_958_400.0,
    1.0 / 239_500_800.0,
    -1.0 / 3_113_510_400.0,
];

/// κ for x ≤ [`SLOW`].
#[inline(always)]
fn slow_bend(x: f64) -> f64 {
    let c = &OF_BEND;
    let x2 = x * x;
    let x4 = x2 * x2;
    // Pairs (Estrin) shorten the dependency chain.
    let low = (c[0] + c[1] * x) + (c[2] + c[3] * x) * x2;
    let middle = (c[4] + c[5] * x) + (c[6] + c[7] * x) * x2;
    let high = (c[8] + c[9] * x) + (c[10] + c[11] * x) * x2;
    low + (middle + high * x4) * x4
}

#[cfg(test)]
mod tests;
