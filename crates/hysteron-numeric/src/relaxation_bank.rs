//! Many relaxations behind one input that goes along straight lines, moved together.
//!
//! Between two corners of the input, ξ' = λ (u − ξ) with u = u₀ + s t has the solution ξ(t) = ξ₀ + g (u₀ − ξ₀
//! − s/λ) + s t, g = 1 − e^(−λt): one exponential function a relaxation and a step, whatever the step's
//! length. Its derivative in λ, D' = −λ D + u − ξ, goes along where it is asked for: D(t) = D₀ − g D₀ + t (1
//! − g) (u₀ − ξ₀ − s/λ) + g s/λ². Where λt is small for a whole row of relaxations, a few terms of the series
//! of g are enough.

use super::dispatch::{InstructionSet, bank_advance, bank_read};
use super::elementary::exp_m1;

/// Lengths that differ by less than this share are taken to be equal: what rounding makes of equal ones.
const EQUAL: f64 = 1e-8;

/// One straight line of an input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Value at its beginning.
    pub from: f64,
    /// Slope \[1/s\].
    pub slope: f64,
    /// How long it is followed \[s\].
    pub length_s: f64,
}

/// States ξₖ of ξ' = λₖ (u − ξ), and ∂ξₖ/∂λₖ.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RelaxationBank {
    rates: Vec<[f64; LANES]>,
    /// Largest of each row of rates.
    fastest: Vec<f64>,
    /// 1/λₖ.
    times: Vec<[f64; LANES]>,
    states: Vec<[f64; LANES]>,
    /// Empty where they are not asked for.
    derivatives: Vec<[f64; LANES]>,
    step: Gains,
    reading: Gains,
    /// States and derivatives a line further, where they are read.
    ahead: [Vec<[f64; LANES]>; 2],
}

/// gₖ of one length, kept for the next one of that length.
#[derive(Clone, Debug, PartialEq)]
struct Gains {
    length_s: f64,
    of: Vec<[f64; LANES]>,
}

/// Relaxations in a row: loops that are much shorter do not become vector code.
const LANES: usize = 32;

impl Default for Gains {
    fn default() -> Self {
        Self { length_s: f64::NAN, of: Vec::new() }
    }
}

impl Gains {
    #[inline(always)]
    fn set(&mut self, (rates, fastest): (&[[f64; LANES]], &[f64]), length_s: f64) {
        if (length_s - self.length_s).abs() <= EQUAL * self.length_s {
            return;
        }
        self.length_s = length_s;
        for ((g, rates), fastest) in self.of.iter_mut().zip(rates).zip(fastest) {
            gains(rates, fastest * length_s, length_s, g);
        }
    }
}

/// Weights of a sum over the states of a bank.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BankWeights {
    states: Vec<[f64; LANES]>,
    derivatives: Vec<[f64; LANES]>,
    is_zero: bool,
}

impl BankWeights {
    /// Takes the weights of ξₖ and of ∂ξₖ/∂λₖ. Keeps its buffers.
    pub fn set(
        &mut self,
        states: impl ExactSizeIterator<Item = f64>,
        derivatives: impl ExactSizeIterator<Item = f64>,
    ) {
        in_lanes(states, &mut self.states);
        in_lanes(derivatives, &mut self.derivatives);
        let is_zero = |weights: &[[f64; LANES]]| weights.as_flattened().iter().all(|w| *w == 0.0);
        if is_zero(&self.derivatives) {
            self.derivatives.clear();
        }
        self.is_zero = self.derivatives.is_empty() && is_zero(&self.states);
    }

    /// Whether the sum is 0 whatever the states.
    pub fn is_zero(&self) -> bool {
        self.is_zero
    }

    /// Whether the derivatives count.
    pub fn asks_for_derivatives(&self) -> bool {
        !self.derivatives.is_empty()
    }
}

impl RelaxationBank {
    /// Takes these rates λₖ > 0 \[rad/s\], best in ascending order, and the states 0, with their derivatives
    /// where asked for. Keeps its buffers.
    pub fn reset(&mut self, rates: &[f64], with_derivatives: bool) {
        in_lanes(rates.iter().copied(), &mut self.rates);
        self.fastest.clear();
        self.fastest.extend(self.rates.iter().map(|rates| rates.iter().copied().fold(0.0, f64::max)));
        in_lanes(rates.iter().map(|rate| 1.0 / rate), &mut self.times);
        in_lanes(rates.iter().map(|_| 0.0), &mut self.states);
        self.derivatives.clear();
        if with_derivatives {
            self.derivatives.clone_from(&self.states);
        }
        let [states, derivatives] = &mut self.ahead;
        states.clone_from(&self.states);
        derivatives.clone_from(&self.derivatives);
        for gains in [&mut self.step, &mut self.reading] {
            gains.length_s = f64::NAN;
            gains.of.clone_from(&self.states);
        }
    }

    /// Moves the states along a line of the input.
    pub fn advance(&mut self, set: InstructionSet, line: Line) {
        bank_advance(set, self, line);
    }

    /// One sum over the states at the end of a line of the input for each of `weights`, added to `sums`; the
    /// states stay where they are.
    pub fn read(&mut self, set: InstructionSet, line: Line, weights: &[BankWeights], sums: &mut [f64]) {
        bank_read(set, self, line, weights, sums);
    }
}

/// So many at a time, 0 in front of the first: what is fast is together.
fn in_lanes(numbers: impl ExactSizeIterator<Item = f64>, into: &mut Vec<[f64; LANES]>) {
    into.clear();
    into.resize(numbers.len().div_ceil(LANES), [0.0; LANES]);
    let places = into.as_flattened_mut();
    let first = places.len() - numbers.len();
    places.iter_mut().skip(first).zip(numbers).for_each(|(place, number)| *place = number);
}

#[inline(always)]
pub(super) fn bank_advance_kernel(bank: &mut RelaxationBank, line: Line) {
    bank.step.set((&bank.rates, &bank.fastest), line.length_s);
    let RelaxationBank { times, states, derivatives, step, .. } = bank;
    for (((slopes, states), g), times) in derivatives.iter_mut().zip(&*states).zip(&step.of).zip(&*times) {
        for (((slope, state), g), time) in slopes.iter_mut().zip(states).zip(g).zip(times) {
            *slope = derivative_at_end(*slope, *state, *g, *time, line);
        }
    }
    for ((states, g), times) in states.iter_mut().zip(&step.of).zip(&*times) {
        for ((state, g), time) in states.iter_mut().zip(g).zip(times) {
            *state = at_end(*state, *g, *time, line);
        }
    }
}

#[inline(always)]
pub(super) fn bank_read_kernel(
    bank: &mut RelaxationBank,
    line: Line,
    weights: &[BankWeights],
    sums: &mut [f64],
) {
    let [states, derivatives] = if line.length_s == 0.0 {
        [&bank.states, &bank.derivatives]
    } else {
        bank.reading.set((&bank.rates, &bank.fastest), line.length_s);
        let [states, derivatives] = &mut bank.ahead;
        let rows = bank.states.iter().zip(&bank.reading.of).zip(&bank.times);
        for (((from, g), times), to) in rows.clone().zip(&mut *states) {
            for i in 0..LANES {
                to[i] = at_end(from[i], g[i], times[i], line);
            }
        }
        for ((((from, g), times), slopes), to) in rows.zip(&bank.derivatives).zip(&mut *derivatives) {
            for i in 0..LANES {
                to[i] = derivative_at_end(slopes[i], from[i], g[i], times[i], line);
            }
        }
        [&*states, &*derivatives]
    };
    for (weights, sum) in weights.iter().zip(sums) {
        if weights.is_zero {
            continue;
        }
        let mut parts = [0.0; LANES];
        let of_states = states.iter().zip(&weights.states);
        for (states, weights) in of_states.chain(derivatives.iter().zip(&weights.derivatives)) {
            for i in 0..LANES {
                parts[i] += weights[i] * states[i];
            }
        }
        *sum += total(parts);
    }
}

/// ξ at the end of a line.
#[inline(always)]
fn at_end(state: f64, gain: f64, time: f64, line: Line) -> f64 {
    state + (gain * (line.from - state - time * line.slope) + line.slope * line.length_s)
}

/// ∂ξ/∂λ there.
#[inline(always)]
fn derivative_at_end(derivative: f64, state: f64, gain: f64, time: f64, line: Line) -> f64 {
    let rise = time * line.slope;
    let moved = line.length_s * (1.0 - gain) * (line.from - state - rise) + gain * (rise * time);
    derivative + (moved - gain * derivative)
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

    /// The same with the library's functions, one relaxation at a time; beside each state its derivative.
    fn oracle(rates: &[f64], states: &mut [(f64, f64)], line: Line) {
        let Line { from, slope, length_s } = line;
        for ((state, derivative), rate) in states.iter_mut().zip(rates) {
            let x = rate * length_s;
            let gain = -(-x).exp_m1();
            // ∂/∂λ of e^(−λt) ξ + g u + (t − g/λ) s; what multiplies s is t² x f(x), f = (g/x − e⁻ˣ)/x.
            let f = if x < 1e-2 {
                0.5 - x / 3.0 + x * x / 8.0 - x.powi(3) / 30.0 + x.powi(4) / 144.0 - x.powi(5) / 840.0
            } else {
                (gain / x - (-x).exp()) / x
            };
            *derivative =
                (-x).exp() * (*derivative + length_s * (from - *state)) + length_s * length_s * f * slope;
            *state += gain * (from - *state) + (length_s - gain / rate) * slope;
        }
    }

    fn rates() -> Vec<f64> {
        (0..53).map(|k| 1e-4 * (0.4 * f64::from(k)).exp()).collect()
    }

    /// The sum that is the state or the derivative of one relaxation.
    fn picked(count: usize, which: usize, derivative: bool) -> BankWeights {
        let mut weights = BankWeights::default();
        let one = move |on: bool| (0..count).map(move |k| f64::from(u8::from(on && k == which)));
        weights.set(one(!derivative), one(derivative));
        weights
    }

    fn read(bank: &mut RelaxationBank, set: InstructionSet, line: Line, weights: BankWeights) -> f64 {
        let mut sums = [0.0];
        bank.read(set, line, &[weights], &mut sums);
        sums[0]
    }

    /// Without what fills the first row up.
    fn now(states: &[[f64; LANES]]) -> &[f64] {
        let states = states.as_flattened();
        &states[states.len() - rates().len()..]
    }

    #[test]
    fn steps_of_any_length_and_every_instruction_set_meet_the_library_functions() {
        let rates = rates();
        let count = rates.len();
        let mut same: Option<Vec<f64>> = None;
        for set in InstructionSet::available() {
            let mut bank = RelaxationBank::default();
            bank.reset(&rates, true);
            let mut states = vec![(0.0, 0.0); count];
            let mut all = Vec::new();
            for k in 0..3000_i32 {
                let wave = (1.7 * f64::from(k)).sin();
                // Lengths over seven decades, some of them repeated.
                let length_s = 10_f64.powf(3.5 * (0.37 * f64::from(k - k % 3)).sin() - 3.0);
                let line = Line { from: wave, slope: (0.1 * wave - 0.3) / length_s, length_s };
                if k % 10 == 0 {
                    let mut ahead = states.clone();
                    let part = Line { length_s: 0.3 * length_s, ..line };
                    oracle(&rates, &mut ahead, part);
                    for (which, (expected, derivative)) in ahead.iter().enumerate() {
                        let found = read(&mut bank, set, part, picked(count, which, false));
                        assert!((found - expected).abs() < 1e-13, "{k} {which}: {found} {expected}");
                        let found = read(&mut bank, set, part, picked(count, which, true));
                        let error = rates[which] * (found - derivative).abs();
                        assert!(error < 1e-12, "{k} {which}: {found} {derivative}");
                        let still = Line { length_s: 0.0, ..line };
                        let found = read(&mut bank, set, still, picked(count, which, false));
                        assert_eq!(found, now(&bank.states)[which]);
                    }
                }
                bank.advance(set, line);
                oracle(&rates, &mut states, line);
                let now = now(&bank.states).iter().zip(now(&bank.derivatives));
                for (((a, a_slope), (b, b_slope)), rate) in now.zip(&states).zip(&rates) {
                    assert!((a - b).abs() < 1e-13, "{k} {rate} {length_s:e}: {a} {b}");
                    let error = rate * (a_slope - b_slope).abs();
                    assert!(error < 1e-12, "{k} {rate} {length_s:e}: {a_slope} {b_slope}");
                }
                all.extend_from_slice(bank.states.as_flattened());
                all.extend_from_slice(bank.derivatives.as_flattened());
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

    #[test]
    fn a_line_of_no_length_changes_nothing() {
        let mut bank = RelaxationBank::default();
        bank.reset(&rates(), false);
        let set = InstructionSet::detected();
        bank.advance(set, Line { from: 1.0, slope: 2.0, length_s: 0.5 });
        let before = bank.states.clone();
        bank.advance(set, Line { from: 3.0, slope: 0.0, length_s: 0.0 });
        assert_eq!(bank.states, before);
    }
}
