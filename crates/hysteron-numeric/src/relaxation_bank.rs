//! A bank of relaxations for each of several piecewise linear inputs, advanced together.
//!
//! Between two corners of the input, ξ' = λ (u − ξ) with u = u₀ + s t has the solution ξ(t) = ξ₀ + g (u₀ − ξ₀
//! − s/λ) + s t, g = 1 − e^(−λt): one exponential per relaxation and step, whatever the step's length and the
//! number of inputs. Where λt is small for a whole row of relaxations, a few terms of the series of g are
//! enough.

use super::dispatch::{InstructionSet, bank_advance, bank_read};
use super::elementary::exp_m1;

/// Lengths that differ by less than this share count as equal: the effect of rounding.
const EQUAL: f64 = 1e-8;

/// Inputs side by side in vector code.
pub const ABREAST: usize = 8;

/// One number per input, [`ABREAST`] to a row.
pub type Abreast = [f64; ABREAST];

/// Straight lines of several inputs that begin at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines {
    /// Values at the beginning.
    pub from: Vec<Abreast>,
    /// Slopes \[1/s\].
    pub slope: Vec<Abreast>,
}

/// States ξₖ of ξ' = λₖ (u − ξ) of several inputs u.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RelaxationBank {
    rates: Vec<[f64; LANES]>,
    /// Largest of each row of rates.
    fastest: Vec<f64>,
    /// 1/λₖ.
    times: Vec<[f64; LANES]>,
    /// Input by input.
    states: Vec<[f64; LANES]>,
    step: Gains,
    reading: Gains,
    /// States of one input further along its line, where they are read.
    ahead: Vec<[f64; LANES]>,
}

/// gₖ of one length, kept for the next one of that length.
#[derive(Clone, Debug, PartialEq)]
struct Gains {
    length_s: f64,
    of: Vec<[f64; LANES]>,
}

/// Relaxations in a row: much shorter loops are not vectorised.
const LANES: usize = 32;

impl Default for Gains {
    fn default() -> Self {
        Self { length_s: f64::NAN, of: Vec::new() }
    }
}

impl Gains {
    fn reset(&mut self, rows: usize) {
        self.length_s = f64::NAN;
        self.of.resize(rows, [0.0; LANES]);
    }

    #[inline(always)]
    fn set(&mut self, rates: &[[f64; LANES]], fastest: &[f64], length_s: f64) {
        if (length_s - self.length_s).abs() <= EQUAL * self.length_s {
            return;
        }
        self.length_s = length_s;
        for ((g, rates), fastest) in self.of.iter_mut().zip(rates).zip(fastest) {
            gains(rates, fastest * length_s, length_s, g);
        }
    }
}

/// Weights of a sum over the states of one input.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BankWeights {
    states: Vec<[f64; LANES]>,
    is_zero: bool,
}

impl BankWeights {
    /// Sets the weights of ξₖ. Keeps its buffer.
    pub fn set(&mut self, states: &[f64]) {
        in_lanes(states.iter().copied(), &mut self.states);
        self.is_zero = states.iter().all(|w| *w == 0.0);
    }

    /// True if the sum is 0 whatever the states.
    pub fn is_zero(&self) -> bool {
        self.is_zero
    }
}

impl RelaxationBank {
    /// Sets the rates λₖ > 0 \[rad/s\], best in ascending order, and zero states for this number of inputs.
    /// Keeps its buffers.
    pub fn reset(&mut self, rates: &[f64], inputs: usize) {
        in_lanes(rates.iter().copied(), &mut self.rates);
        self.fastest.clear();
        self.fastest.extend(self.rates.iter().map(|rates| rates.iter().copied().fold(0.0, f64::max)));
        in_lanes(rates.iter().map(|rate| 1.0 / rate), &mut self.times);
        let rows = self.rates.len();
        self.states.clear();
        self.states.resize(rows * inputs, [0.0; LANES]);
        self.ahead.resize(rows, [0.0; LANES]);
        self.step.reset(rows);
        self.reading.reset(rows);
    }

    /// Advances the states along a line of each input, for `length_s` \[s\].
    pub fn advance(&mut self, set: InstructionSet, lines: &Lines, length_s: f64) {
        if !self.rates.is_empty() {
            bank_advance(set, self, lines, length_s);
        }
    }

    /// One sum over the states of each input `length_s` \[s\] along its line for each of `weights`, added to
    /// `sums`: all inputs of the first weights, in rows, then of the next. The states do not change.
    pub fn read(
        &mut self,
        set: InstructionSet,
        lines: &Lines,
        length_s: f64,
        weights: &[BankWeights],
        sums: &mut [Abreast],
    ) {
        if !self.rates.is_empty() {
            bank_read(set, self, lines, length_s, weights, sums);
        }
    }
}

/// [`LANES`] at a time, padded with 0 at the front, so that fast ones are together.
fn in_lanes(numbers: impl ExactSizeIterator<Item = f64>, into: &mut Vec<[f64; LANES]>) {
    into.clear();
    into.resize(numbers.len().div_ceil(LANES), [0.0; LANES]);
    let places = into.as_flattened_mut();
    let first = places.len() - numbers.len();
    places.iter_mut().skip(first).zip(numbers).for_each(|(place, number)| *place = number);
}

#[inline(always)]
pub(super) fn bank_advance_kernel(bank: &mut RelaxationBank, lines: &Lines, length_s: f64) {
    let RelaxationBank { rates, fastest, times, states, step, .. } = bank;
    step.set(rates, fastest, length_s);
    let inputs = lines.from.as_flattened().iter().zip(lines.slope.as_flattened());
    for (states, (from, slope)) in states.chunks_exact_mut(rates.len()).zip(inputs) {
        let change = slope * length_s;
        for ((states, g), times) in states.iter_mut().zip(&step.of).zip(&*times) {
            for i in 0..LANES {
                states[i] += g[i] * (from - states[i] - times[i] * slope) + change;
            }
        }
    }
}

#[inline(always)]
pub(super) fn bank_read_kernel(
    bank: &mut RelaxationBank,
    lines: &Lines,
    length_s: f64,
    weights: &[BankWeights],
    sums: &mut [Abreast],
) {
    let RelaxationBank { rates, fastest, times, states, reading, ahead, .. } = bank;
    if length_s > 0.0 {
        reading.set(rates, fastest, length_s);
    }
    let inputs = lines.from.as_flattened().iter().zip(lines.slope.as_flattened());
    let width = ABREAST * lines.from.len();
    let sums = sums.as_flattened_mut();
    for ((input, states), (from, slope)) in states.chunks_exact(rates.len()).enumerate().zip(inputs) {
        let states = if length_s > 0.0 {
            let change = slope * length_s;
            let rows = states.iter().zip(&reading.of).zip(&*times);
            for (((states, g), times), ahead) in rows.zip(&mut *ahead) {
                for i in 0..LANES {
                    ahead[i] = states[i] + (g[i] * (from - states[i] - times[i] * slope) + change);
                }
            }
            &**ahead
        } else {
            states
        };
        for (weights, sums) in weights.iter().zip(sums.chunks_exact_mut(width)) {
            if weights.is_zero {
                continue;
            }
            let mut parts = [0.0; LANES];
            for (states, weights) in states.iter().zip(&weights.states) {
                for i in 0..LANES {
                    parts[i] += weights[i] * states[i];
                }
            }
            if let Some(sum) = sums.get_mut(input) {
                *sum += total(parts);
            }
        }
    }
}

#[inline(always)]
fn total(sums: [f64; LANES]) -> f64 {
    let mut eighths = [0.0; 8];
    for row in sums.chunks_exact(8) {
        eighths.iter_mut().zip(row).for_each(|(sum, of)| *sum += of);
    }
    let [a, b, c, d, e, f, g, h] = eighths;
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

/// Up to this x two more terms of 1 − e⁻ˣ = x − x²/2 + … are enough, and up to the other one six.
const TINY: f64 = 1e-5;
const SMALL: f64 = 0.015_625;

/// g of a row of rates, the largest of which gives x = `largest`.
#[inline(always)]
fn gains(rates: &[f64; LANES], largest: f64, length_s: f64, g: &mut [f64; LANES]) {
    if largest <= TINY {
        for (g, rate) in g.iter_mut().zip(rates) {
            let x = rate * length_s;
            *g = x - x * x * (1.0 / 2.0 - x * (1.0 / 6.0));
        }
    } else if largest <= SMALL {
        for (g, rate) in g.iter_mut().zip(rates) {
            let x = rate * length_s;
            let x2 = x * x;
            let rest = (1.0 / 2.0 - x * (1.0 / 6.0))
                + ((1.0 / 24.0 - x * (1.0 / 120.0)) + (1.0 / 720.0 - x * (1.0 / 5040.0)) * x2) * x2;
            *g = x - x2 * rest;
        }
    } else {
        for (g, rate) in g.iter_mut().zip(rates) {
            *g = -exp_m1(-(rate * length_s));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference implementation with the library's functions, one relaxation at a time.
    fn oracle(rates: &[f64], states: &mut [f64], [from, slope]: [f64; 2], length_s: f64) {
        for (state, rate) in states.iter_mut().zip(rates) {
            let gain = -(-rate * length_s).exp_m1();
            *state += gain * (from - *state) + (length_s - gain / rate) * slope;
        }
    }

    fn rates() -> Vec<f64> {
        (0..53).map(|k| 1e-4 * (0.4 * f64::from(k)).exp()).collect()
    }

    /// The second input is the first one, doubled and turned over.
    fn lines(from: f64, slope: f64) -> Lines {
        let mut lines = Lines { from: vec![[0.0; ABREAST]], slope: vec![[0.0; ABREAST]] };
        (lines.from[0][0], lines.slope[0][0]) = (from, slope);
        (lines.from[0][1], lines.slope[0][1]) = (-2.0 * from, -2.0 * slope);
        lines
    }

    /// The sums that are the state of one relaxation.
    fn read(
        bank: &mut RelaxationBank,
        set: InstructionSet,
        lines: &Lines,
        length_s: f64,
        which: usize,
    ) -> [f64; 2] {
        let mut weights = BankWeights::default();
        let one: Vec<f64> = (0..rates().len()).map(|k| f64::from(u8::from(k == which))).collect();
        weights.set(&one);
        let mut sums = [[0.0; ABREAST]];
        bank.read(set, lines, length_s, &[weights], &mut sums);
        [sums[0][0], sums[0][1]]
    }

    #[test]
    fn steps_of_any_length_and_every_instruction_set_meet_the_library_functions() {
        let rates = rates();
        let mut same: Option<Vec<f64>> = None;
        for set in InstructionSet::available() {
            let mut bank = RelaxationBank::default();
            bank.reset(&rates, 2);
            let mut states = vec![0.0; rates.len()];
            let mut all = Vec::new();
            for k in 0..3000_i32 {
                let wave = (1.7 * f64::from(k)).sin();
                // Lengths over seven decades, some of them repeated.
                let length_s = 10_f64.powf(3.5 * (0.37 * f64::from(k - k % 3)).sin() - 3.0);
                let line = [wave, (0.1 * wave - 0.3) / length_s];
                let both = lines(line[0], line[1]);
                if k % 10 == 0 {
                    let mut ahead = states.clone();
                    oracle(&rates, &mut ahead, line, 0.3 * length_s);
                    for (which, expected) in ahead.iter().enumerate() {
                        let [found, doubled] = read(&mut bank, set, &both, 0.3 * length_s, which);
                        assert!((found - expected).abs() < 1e-13, "{k} {which}: {found} {expected}");
                        assert_eq!(doubled, -2.0 * found);
                    }
                }
                bank.advance(set, &both, length_s);
                oracle(&rates, &mut states, line, length_s);
                for (which, (expected, rate)) in states.iter().zip(&rates).enumerate() {
                    let [found, doubled] = read(&mut bank, set, &both, 0.0, which);
                    assert!((found - expected).abs() < 1e-13, "{k} {rate} {length_s:e}: {found} {expected}");
                    assert_eq!(doubled, -2.0 * found);
                }
                all.extend_from_slice(bank.states.as_flattened());
            }
            assert!(same.as_ref().is_none_or(|same| *same == all), "{set:?} rounds differently");
            same = Some(all);
        }
    }

    #[test]
    fn gains_keep_their_digits_however_small() {
        for k in 0..4000_i32 {
            let x = 10_f64.powf(-18.0 + 0.005 * f64::from(k));
            let mut g = [0.0; LANES];
            gains(&[x; LANES], x, 1.0, &mut g);
            let expected = -(-x).exp_m1();
            assert!((g[0] / expected - 1.0).abs() < 4.0 * f64::EPSILON, "{x:e}: {:e}", g[0]);
        }
    }
}
