//! A bank of resonances for each of several piecewise quadratic inputs, advanced together.
//!
//! x' = p x + u with u = u₀ + s t + c t² has the solution x(t) = x₀ + m x₀ + a u₀ + b s + e c, m = e^(pt) −
//! 1, a = m/p, b = (a − t)/p, e = (2b − t²)/p. If requested, derivatives D = ∂x/∂p are carried along: D(t) =
//! D₀ + m D₀ + m' x₀ + a' u₀ + b' s + e' c, with m' = t e^(pt), a' = (m' − a)/p, b' = (a' − b)/p, e' = (2b' −
//! e)/p. Eight numbers per pole and length are needed; they are computed for a stretch of lengths at once and
//! shared by all inputs.

use super::Complex64;
use super::complex_exponential::exponentials_less_one;
use super::dispatch::{InstructionSet, propagators, resonances_advance, resonances_read};
use super::relaxation_bank::{ABREAST, Abreast, Parabolas};

/// Lengths whose propagators are computed together.
const STRETCH: usize = 64;

/// Up to this |pt| the closed forms of e and e' lose digits, and their series keep them.
const SLOW: f64 = 0.25;

/// 1/(k + 3)!, k = 10 … 0: e = 2 t³ Σ (pt)ᵏ/(k + 3)!, e' = ∂e/∂p.
const OF_BEND: [f64; 11] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
];

/// x of every pole and input and, if requested, ∂x/∂p.
#[derive(Clone, Debug, Default)]
pub struct ResonanceBank {
    poles: Vec<Complex64>,
    /// Pole by pole.
    states: Vec<State>,
    propagated: Propagated,
    steps: Stretch,
    readings: Stretch,
}

/// Optional parts of the propagation; x under straight inputs is always there.
#[derive(Clone, Copy, Debug, Default)]
pub struct Propagated {
    /// ∂x/∂p.
    pub derivatives: bool,
    /// The response to bent inputs.
    pub bends: bool,
}

/// x and ∂x/∂p of one pole and a row of inputs, real and imaginary parts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct State {
    x: [Abreast; 2],
    moved: [Abreast; 2],
}

/// Propagators of every pole for a stretch of numbered lengths.
#[derive(Clone, Debug, Default)]
struct Stretch {
    first: usize,
    lengths_s: Vec<f64>,
    of: Vec<Propagators>,
}

/// m, a, b, e, m', a', b', e' of one pole for a stretch of lengths, real parts, then imaginary ones.
#[derive(Clone, Debug)]
pub struct Propagators([[[f64; STRETCH]; 2]; 8]);

/// m, a, b, e and their derivatives of one pole and one length.
type Propagator = [Complex64; 8];

impl Stretch {
    /// Place of length `index` within the stretch, which is recomputed from there on if it lies outside.
    fn place(
        &mut self,
        set: InstructionSet,
        poles: &[Complex64],
        propagated: Propagated,
        index: usize,
        length_s: impl Fn(usize) -> f64,
    ) -> usize {
        let within = index.checked_sub(self.first).filter(|at| *at < self.lengths_s.len());
        if let Some(at) = within {
            return at;
        }
        self.first = index;
        self.lengths_s.clear();
        self.lengths_s.extend((index..index + STRETCH).map(length_s));
        self.of.resize(poles.len(), Propagators([[[0.0; STRETCH]; 2]; 8]));
        for (pole, of) in poles.iter().zip(&mut self.of) {
            let [re, im] = &mut of.0[0];
            exponentials_less_one(set, *pole, &self.lengths_s, re, im);
            propagators(set, *pole, &self.lengths_s, propagated, of);
        }
        0
    }
}

impl Propagators {
    #[inline(always)]
    fn at(&self, place: usize) -> Propagator {
        self.0.each_ref().map(|[re, im]| Complex64::new(re[place % STRETCH], im[place % STRETCH]))
    }
}

impl ResonanceBank {
    /// Resets to rest at 0 for this number of inputs. Keeps its buffers.
    pub fn reset(&mut self, poles: &[Complex64], inputs: usize, propagated: Propagated) {
        self.poles.clear();
        self.poles.extend_from_slice(poles);
        self.states.clear();
        self.states.resize(poles.len() * inputs.div_ceil(ABREAST), State::default());
        self.propagated = propagated;
        // The poles may differ from the last ones.
        self.steps.lengths_s.clear();
        self.readings.lengths_s.clear();
    }

    /// Advances the states along the `index`-th parabola of each input; `length_s`: their lengths \[s\].
    pub fn advance(
        &mut self,
        set: InstructionSet,
        inputs: &Parabolas,
        index: usize,
        length_s: impl Fn(usize) -> f64,
    ) {
        if !self.poles.is_empty() {
            let place = self.steps.place(set, &self.poles, self.propagated, index, length_s);
            resonances_advance(set, self, inputs, place);
        }
    }

    /// Adds the weighted sum of x and ∂x/∂p over the poles, its real part, on the parabola of each input,
    /// to `sums`: all inputs of the first weights, in rows, then of the next. `length_s`: times of the
    /// readings since the parabolas began \[s\]. The states do not change.
    pub fn read(
        &mut self,
        set: InstructionSet,
        inputs: &Parabolas,
        (index, length_s): (usize, impl Fn(usize) -> f64),
        weights: &[&[(Complex64, Complex64)]],
        sums: &mut [Abreast],
    ) {
        if !self.poles.is_empty() {
            let place = self.readings.place(set, &self.poles, self.propagated, index, length_s);
            resonances_read(set, self, inputs, place, weights, sums);
        }
    }
}

/// All but m, which is given.
#[inline(always)]
pub(super) fn propagators_kernel(
    pole: Complex64,
    lengths_s: &[f64],
    Propagated { derivatives, bends }: Propagated,
    of: &mut Propagators,
) {
    let [m, a, b, e, m_moved, a_moved, b_moved, e_moved] = &mut of.0;
    let lengths_s: &[f64; STRETCH] = match lengths_s.try_into() {
        Ok(lengths_s) => lengths_s,
        Err(_) => return,
    };
    let inverse = pole.inv();
    let put = |to: &mut [[f64; STRETCH]; 2], k: usize, z: Complex64| (to[0][k], to[1][k]) = (z.re, z.im);
    for k in 0..STRETCH {
        let m = Complex64::new(m[0][k], m[1][k]);
        let first = m * inverse;
        put(a, k, first);
        put(b, k, (first - lengths_s[k]) * inverse);
    }
    if derivatives {
        for k in 0..STRETCH {
            let first = Complex64::new(a[0][k], a[1][k]);
            let second = Complex64::new(b[0][k], b[1][k]);
            let moved = Complex64::new((1.0 + m[0][k]) * lengths_s[k], m[1][k] * lengths_s[k]);
            let first_moved = (moved - first) * inverse;
            put(m_moved, k, moved);
            put(a_moved, k, first_moved);
            put(b_moved, k, (first_moved - second) * inverse);
        }
    }
    if !bends {
        return;
    }
    let fast = SLOW * inverse.norm();
    for k in 0..STRETCH {
        let t = lengths_s[k];
        let x = pole * t;
        // Horner's rule for the series and its derivative.
        let (mut sum, mut slope) = (Complex64::ZERO, Complex64::ZERO);
        for coefficient in OF_BEND {
            slope = slope * x + sum;
            sum = sum * x + coefficient;
        }
        let cube = 2.0 * t * t * t;
        let closed = (2.0 * Complex64::new(b[0][k], b[1][k]) - t * t) * inverse;
        let of_bend = if t > fast { closed } else { cube * sum };
        let closed = (2.0 * Complex64::new(b_moved[0][k], b_moved[1][k]) - of_bend) * inverse;
        put(e, k, of_bend);
        put(e_moved, k, if t > fast { closed } else { cube * t * slope });
    }
}

/// x and ∂x/∂p at the end of a parabola of each input.
#[inline(always)]
fn at_end(state: &State, by: &Propagator, inputs: &Parabolas, row: usize, derivatives: bool) -> State {
    let [m, a, b, e, m_moved, a_moved, b_moved, e_moved] = by;
    let State { x: [re, im], moved: [moved_re, moved_im] } = state;
    let (slope, bend, level) = (&inputs.slope[row], &inputs.bend[row], &inputs.level[row]);
    let mut from = inputs.from[row];
    from.iter_mut().zip(level).for_each(|(from, level)| *from += level);
    let mut end = *state;
    for i in 0..ABREAST {
        end.x[0][i] = re[i] + ((m.re * re[i] - m.im * im[i]) + (a.re * from[i] + b.re * slope[i]));
        end.x[1][i] = im[i] + ((m.re * im[i] + m.im * re[i]) + (a.im * from[i] + b.im * slope[i]));
    }
    if !inputs.straight {
        end.x[0].iter_mut().zip(bend).for_each(|(x, bend)| *x += e.re * bend);
        end.x[1].iter_mut().zip(bend).for_each(|(x, bend)| *x += e.im * bend);
    }
    if derivatives {
        for i in 0..ABREAST {
            let by_state =
                (m.re * moved_re[i] - m.im * moved_im[i]) + (m_moved.re * re[i] - m_moved.im * im[i]);
            let by_input = a_moved.re * from[i] + b_moved.re * slope[i];
            end.moved[0][i] = moved_re[i] + (by_state + by_input);
            let by_state =
                (m.re * moved_im[i] + m.im * moved_re[i]) + (m_moved.re * im[i] + m_moved.im * re[i]);
            let by_input = a_moved.im * from[i] + b_moved.im * slope[i];
            end.moved[1][i] = moved_im[i] + (by_state + by_input);
        }
        if !inputs.straight {
            end.moved[0].iter_mut().zip(bend).for_each(|(x, bend)| *x += e_moved.re * bend);
            end.moved[1].iter_mut().zip(bend).for_each(|(x, bend)| *x += e_moved.im * bend);
        }
    }
    end
}

#[inline(always)]
pub(super) fn resonances_advance_kernel(bank: &mut ResonanceBank, inputs: &Parabolas, place: usize) {
    let rows = inputs.from.len().max(1);
    for (states, of) in bank.states.chunks_exact_mut(rows).zip(&bank.steps.of) {
        let by = of.at(place);
        for (row, state) in states.iter_mut().enumerate() {
            *state = at_end(state, &by, inputs, row, bank.propagated.derivatives);
        }
    }
}

#[inline(always)]
pub(super) fn resonances_read_kernel(
    bank: &ResonanceBank,
    inputs: &Parabolas,
    place: usize,
    weights: &[&[(Complex64, Complex64)]],
    sums: &mut [Abreast],
) {
    let rows = inputs.from.len().max(1);
    for (pole, (states, of)) in bank.states.chunks_exact(rows).zip(&bank.readings.of).enumerate() {
        let by = of.at(place);
        for (row, state) in states.iter().enumerate() {
            let State { x, moved } = at_end(state, &by, inputs, row, bank.propagated.derivatives);
            for (weights, sums) in weights.iter().zip(sums.chunks_exact_mut(rows)) {
                let (Some((of_x, of_moved)), Some(sum)) = (weights.get(pole), sums.get_mut(row)) else {
                    continue;
                };
                for i in 0..ABREAST {
                    sum[i] += of_x.re * x[0][i] - of_x.im * x[1][i];
                }
                if bank.propagated.derivatives {
                    for i in 0..ABREAST {
                        sum[i] += of_moved.re * moved[0][i] - of_moved.im * moved[1][i];
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x and ∂x/∂p at the end of a parabola by Taylor's series in t, in parts short enough for it.
    fn oracle(
        pole: Complex64,
        state: &mut [Complex64; 2],
        [mut from, mut slope, bend]: [f64; 3],
        length_s: f64,
    ) {
        let parts = (pole.norm() * length_s).ceil().max(1.0);
        let step = length_s / parts;
        for _ in 0..parts as usize {
            // Derivatives of order k in t, times step^k/k!.
            let (mut x, mut moved) = (state[0], state[1]);
            let mut input = [from * step, slope * step * step, bend * step * step * step];
            for k in 1..30 {
                let next = (x * pole * step + input[0]) / f64::from(k);
                moved = (moved * pole + x) * step / f64::from(k);
                x = next;
                state[0] += x;
                state[1] += moved;
                input = [input[1], input[2], 0.0];
            }
            from += (slope + bend * step) * step;
            slope += 2.0 * bend * step;
        }
    }

    #[test]
    fn steps_of_any_length_and_every_instruction_set_meet_the_series() {
        let poles = [Complex64::new(-0.3, 2.0), Complex64::new(-1.0, 0.0), Complex64::new(-0.02, 0.4)];
        // Every state in its turn.
        let weights: Vec<Vec<(Complex64, Complex64)>> = (0..12)
            .map(|which| {
                let mut weights = vec![(Complex64::ZERO, Complex64::ZERO); poles.len()];
                // Re (−i z) = Im z.
                let one = if which % 2 == 0 { Complex64::ONE } else { -Complex64::I };
                let of = &mut weights[which / 4];
                if which % 4 < 2 {
                    of.0 = one
                } else {
                    of.1 = one
                }
                weights
            })
            .collect();
        let weights: Vec<&[_]> = weights.iter().map(Vec::as_slice).collect();
        let mut same: Option<Vec<f64>> = None;
        for set in InstructionSet::available() {
            let mut bank = ResonanceBank::default();
            // The last of nine inputs, alone in its row.
            bank.reset(&poles, 9, Propagated { derivatives: true, bends: true });
            let mut inputs = Parabolas::default();
            inputs.reset(9);
            let mut states = [[Complex64::ZERO; 2]; 3];
            let mut all = Vec::new();
            let length_s = |k: usize| 10_f64.powf(2.0 * (0.37 * k as f64).sin() - 1.5);
            for k in 0..500 {
                let wave = (1.7 * k as f64).sin();
                let bend = (k % 2) as f64 * (0.4 - 0.2 * wave);
                let line = [wave, 0.1 * wave - 0.3, bend];
                (inputs.from[1][0], inputs.slope[1][0], inputs.bend[1][0]) = (line[0], line[1], line[2]);
                inputs.straight = bend == 0.0;
                let since_s = |k: usize| 0.3 * length_s(k);
                let mut sums = vec![[0.0; ABREAST]; 2 * weights.len()];
                bank.read(set, &inputs, (k, since_s), &weights, &mut sums);
                let mut ahead = states;
                for (pole, (ahead, state)) in poles.iter().zip(ahead.iter_mut().zip(&mut states)) {
                    oracle(*pole, ahead, line, since_s(k));
                    oracle(*pole, state, line, length_s(k));
                }
                let expected = ahead.as_flattened().iter().flat_map(|z| [z.re, z.im]);
                let found: Vec<f64> = sums.chunks_exact(2).map(|rows| rows[1][0]).collect();
                for (which, (found, expected)) in found.iter().zip(expected).enumerate() {
                    assert!((found - expected).abs() < 1e-11, "{k} {which}: {found} {expected}");
                }
                bank.advance(set, &inputs, k, length_s);
                all.extend(found);
            }
            assert!(same.as_ref().is_none_or(|same| *same == all), "{set:?} rounds differently");
            same = Some(all);
        }
    }

    #[test]
    fn a_long_rest_leaves_no_subnormal_number_behind() {
        let mut bank = ResonanceBank::default();
        bank.reset(&[Complex64::new(-0.3, 2.0)], 1, Propagated { derivatives: true, bends: false });
        let mut inputs = Parabolas::default();
        inputs.reset(1);
        inputs.begin_at(&[[1.0; ABREAST]]);
        bank.advance(InstructionSet::detected(), &inputs, 0, |_| 1.0);
        inputs.begin_at(&[[0.0; ABREAST]]);
        for k in 1..5000 {
            bank.advance(InstructionSet::detected(), &inputs, k, |_| 1.0);
        }
        let State { x, moved } = bank.states[0];
        assert!(
            [x, moved].as_flattened().as_flattened().iter().all(|part| part.is_normal()),
            "{x:?} {moved:?}"
        );
    }
}
