//! A bank of relaxations for each of several piecewise quadratic inputs, advanced together.
//!
//! ξ' = λ (u − ξ) with u = u₀ + s t + c t². The states are η = ξ − u, for which η(t) = η₀ − g η₀ − γ s t − κ c
//! t², x = λt, g = 1 − e⁻ˣ, γ = g/x, κ = 2 (1 − γ)/x: one exponential per relaxation and step, whatever the
//! step's length and the number of inputs. Where x is small for a whole row of relaxations, a few terms of the
//! series of g are enough.

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
}

impl Parabolas {
    /// Zeros for this number of inputs. Keeps its buffers.
    pub fn reset(&mut self, inputs: usize) {
        for row in [&mut self.from, &mut self.slope, &mut self.bend, &mut self.to] {
            row.clear();
            row.resize(inputs.div_ceil(ABREAST), [0.0; ABREAST]);
        }
        self.straight = true;
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

/// λₖ, a row at a time.
#[derive(Clone, Debug, Default, PartialEq)]
struct Rates {
    of: Vec<[f64; LANES]>,
    /// 1/λₖ.
    times: Vec<[f64; LANES]>,
    /// Largest of each row.
    fastest: Vec<f64>,
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

/// Relaxations in a row: much shorter loops are not vectorised.
const LANES: usize = 32;

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
        let per_s = 1.0 / length_s;
        let each = rates.of.iter().zip(&rates.times).zip(&rates.fastest);
        let each = each.zip(&mut self.of_state).zip(&mut self.of_slope).zip(&mut self.of_bend);
        for (((((rates, times), fastest), g), of_slope), of_bend) in each {
            gains(rates, fastest * length_s, length_s, g);
            for i in 0..LANES {
                of_slope[i] = g[i] * (times[i] * per_s);
            }
            if !straight {
                gains_of_bend(rates, times, fastest * length_s, length_s, of_slope, of_bend);
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
        in_lanes(states.iter().copied(), &mut self.states);
        self.ahead.resize(self.states.len(), [0.0; LANES]);
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
        let [mut of_slope, mut of_bend] = [[0.0; LANES]; 2];
        let each = self.states.iter().zip(&mut self.ahead);
        let each = each.zip(&gains.of_state).zip(&gains.of_slope).zip(&gains.of_bend);
        for ((((weights, ahead), g), slope), bend) in each {
            for i in 0..LANES {
                ahead[i] = weights[i] - weights[i] * g[i];
                of_slope[i] += weights[i] * slope[i];
            }
            if gains.bent {
                for i in 0..LANES {
                    of_bend[i] += weights[i] * bend[i];
                }
            }
        }
        (self.of_slope, self.of_bend) = (total(of_slope), total(of_bend));
    }
}

impl RelaxationBank {
    /// Sets the rates λₖ > 0 \[rad/s\], best in ascending order, and rest at 0 for this number of inputs.
    /// Keeps its buffers.
    pub fn reset(&mut self, rates: &[f64], inputs: usize) {
        let Rates { of, times, fastest } = &mut self.rates;
        in_lanes(rates.iter().copied(), of);
        in_lanes(rates.iter().map(|rate| 1.0 / rate), times);
        fastest.clear();
        fastest.extend(of.iter().map(|rates| rates.iter().copied().fold(0.0, f64::max)));
        let rows = of.len();
        self.states.clear();
        self.states.resize(rows * inputs, [0.0; LANES]);
        self.inputs.clear();
        self.inputs.resize(inputs, 0.0);
        self.step.reset(rows);
        self.reading.reset(rows);
    }

    /// Begins the parabola of each input; the inputs may jump there.
    pub fn begin(&mut self, inputs: &Parabolas) {
        let rows = self.rates.of.len();
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
        if !self.rates.of.is_empty() {
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
        if !self.rates.of.is_empty() {
            bank_read(set, self, inputs, length_s, weights, sums);
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
pub(super) fn bank_advance_kernel(bank: &mut RelaxationBank, inputs: &Parabolas, length_s: f64) {
    let RelaxationBank { rates, states, step, .. } = bank;
    step.set(rates, inputs.straight, length_s);
    for (states, (_, slope, bend)) in states.chunks_exact_mut(rates.of.len()).zip(inputs.each()) {
        let [change, curve] = [slope * length_s, bend * (length_s * length_s)];
        let rows = states.iter_mut().zip(&step.of_state).zip(&step.of_slope).zip(&step.of_bend);
        if inputs.straight {
            for (((states, g), of_slope), _) in rows {
                for i in 0..LANES {
                    states[i] -= g[i] * states[i] + of_slope[i] * change;
                }
            }
        } else {
            for (((states, g), of_slope), of_bend) in rows {
                for i in 0..LANES {
                    states[i] -= (g[i] * states[i] + of_slope[i] * change) + of_bend[i] * curve;
                }
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
        weights.iter_mut().for_each(|weights| weights.look_ahead(reading));
    }
    let width = ABREAST * inputs.from.len();
    let sums = sums.as_flattened_mut();
    let each = states.chunks_exact(rates.of.len()).zip(inputs.each());
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

#[inline(always)]
fn total(sums: [f64; LANES]) -> f64 {
    let mut eighths = [0.0; 8];
    for row in sums.chunks_exact(8) {
        eighths.iter_mut().zip(row).for_each(|(sum, of)| *sum += of);
    }
    total_of_eight(eighths)
}

#[inline(always)]
fn total_of_eight([a, b, c, d, e, f, g, h]: [f64; 8]) -> f64 {
    // In halves, as vectors are added.
    ((a + e) + (c + g)) + ((b + f) + (d + h))
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

/// Up to this x the closed form of κ loses digits, and [`OF_BEND`] keeps them.
const SLOW: f64 = 0.25;

/// Coefficients of κ = 1 − x/3 + x²/12 − …, the last one first: 2 (−1)ᵏ/(k + 2)!.
const OF_BEND: [f64; 12] = [
    -1.0 / 3_113_510_400.0,
    1.0 / 239_500_800.0,
    -1.0 / 19_958_400.0,
    1.0 / 1_814_400.0,
    -1.0 / 181_440.0,
    1.0 / 20_160.0,
    -1.0 / 2520.0,
    1.0 / 360.0,
    -1.0 / 60.0,
    1.0 / 12.0,
    -1.0 / 3.0,
    1.0,
];

/// κ of a row of rates, the largest of which gives x = `largest`.
#[inline(always)]
fn gains_of_bend(
    rates: &[f64; LANES],
    times: &[f64; LANES],
    largest: f64,
    length_s: f64,
    of_slope: &[f64; LANES],
    of_bend: &mut [f64; LANES],
) {
    if largest <= SMALL {
        for (of_bend, rate) in of_bend.iter_mut().zip(rates) {
            let x = rate * length_s;
            *of_bend = OF_BEND[6..].iter().fold(0.0, |sum, coefficient| sum * x + coefficient);
        }
        return;
    }
    for (of_bend, rate) in of_bend.iter_mut().zip(rates) {
        let x = rate * length_s;
        *of_bend = OF_BEND.iter().fold(0.0, |sum, coefficient| sum * x + coefficient);
    }
    if largest > SLOW {
        let per_s = 2.0 / length_s;
        for i in 0..LANES {
            let closed = (1.0 - of_slope[i]) * (times[i] * per_s);
            of_bend[i] = if rates[i] * length_s > SLOW { closed } else { of_bend[i] };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference implementation with the library's functions, one relaxation at a time.
    fn oracle(rates: &[f64], states: &mut [f64], [from, slope, bend]: [f64; 3], length_s: f64) {
        for (state, rate) in states.iter_mut().zip(rates) {
            let gain = -(-rate * length_s).exp_m1();
            let x = rate * length_s;
            // x/3 − x²/12 + x³/60 − …
            let series =
                (1..40).fold((0.0, x / 3.0), |(sum, term), k| (sum + term, -term * x / f64::from(k + 3))).0;
            let of_bend = if x < 2.0 { series } else { 1.0 - 2.0 / x + 2.0 * gain / (x * x) };
            *state += gain * (from - *state) + (length_s - gain / rate) * slope;
            *state += bend * length_s * length_s * of_bend;
        }
    }

    fn rates() -> Vec<f64> {
        (0..53).map(|k| 1e-4 * (0.4 * f64::from(k)).exp()).collect()
    }

    /// The second input is the first one, doubled and turned over.
    fn inputs([from, slope, bend]: [f64; 3], length_s: f64) -> Parabolas {
        let mut inputs = Parabolas::default();
        inputs.reset(2);
        for (input, factor) in [1.0, -2.0].into_iter().enumerate() {
            inputs.from[0][input] = factor * from;
            inputs.slope[0][input] = factor * slope;
            inputs.bend[0][input] = factor * bend;
            inputs.to[0][input] = factor * (from + (slope + bend * length_s) * length_s);
        }
        inputs.straight = bend == 0.0;
        inputs
    }

    /// The sums that are the state of one relaxation.
    fn read(
        bank: &mut RelaxationBank,
        set: InstructionSet,
        inputs: &Parabolas,
        length_s: f64,
        which: usize,
    ) -> [f64; 2] {
        let mut weights = BankWeights::default();
        let one: Vec<f64> = (0..rates().len()).map(|k| f64::from(u8::from(k == which))).collect();
        weights.set(&one);
        let mut sums = [[0.0; ABREAST]];
        bank.read(set, inputs, length_s, &mut [weights], &mut sums);
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
                let bend = f64::from(k % 2) * (0.4 - 0.2 * wave) / (length_s * length_s);
                let line = [wave, (0.1 * wave - 0.3) / length_s, bend];
                let both = inputs(line, length_s);
                bank.begin(&both);
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
                let end = inputs([both.to[0][0], 0.0, 0.0], 1.0);
                for (which, (expected, rate)) in states.iter().zip(&rates).enumerate() {
                    let [found, doubled] = read(&mut bank, set, &end, 0.0, which);
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
