//! Linear dynamics as real poles, pole pairs and a few taps, one sample at a time.

use core::array::from_fn;

use super::ModelError;
use crate::increment::accumulate;
use crate::real::Real;
use crate::saved::Tape;

/// Real poles updated together in one SIMD vector.
pub const LANES: usize = 4;
/// Most taps of a block.
pub const MOST_TAPS: usize = 8;

/// [`LANES`] real poles aₙ in delta form: xₙ ← xₙ + gₙ (w − xₙ), gₙ = 1 − aₙ. Each state settles at its
/// input, so the weights are shares of the DC gain. An unused lane has gain and weight 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RealPoles<T> {
    /// gₙ = 1 − aₙ, 0 < gₙ < 2.
    pub gain: [T; LANES],
    /// Output weights.
    pub weight: [T; LANES],
}

/// A pair of poles a, a̅ in delta form: ξ ← ξ + g (w − ξ), g = 1 − a, complex; the output is Re(c ξ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolePair<T> {
    /// Re g, Im g.
    pub gain: [T; 2],
    /// Re c, Im c.
    pub weight: [T; 2],
}

/// Values updated by increments, with their Kahan compensation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensated<T, const N: usize> {
    pub(super) value: [T; N],
    pub(super) carry: [T; N],
}

impl<T: Real, const N: usize> Compensated<T, N> {
    /// Zero.
    pub fn zero() -> Self {
        Self { value: [T::of(0.0); N], carry: [T::of(0.0); N] }
    }

    /// The values, without the compensation.
    pub fn value(&self) -> [T; N] {
        self.value
    }

    /// Whether any number is subnormal: slow to compute with.
    pub fn has_subnormal(&self) -> bool {
        self.value.iter().chain(&self.carry).any(|x| x.abs() > T::of(0.0) && x.abs() < T::LEAST_NORMAL)
    }
}

/// Coefficients of a linear block with the response, in the unit delay q,
///
/// H = q^m (Σⱼ tapsⱼ qʲ + q^L [Σₙ wₙ gₙ/(1 − (1 − gₙ) q) + Σ Re-parts of pairs]), L taps, m samples of delay.
///
/// The gain at rest is Σ taps + Σ wₙ + Σ Re c.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sections<'a, T> {
    /// Taps, 1 to [`MOST_TAPS`]: the newest input first.
    pub taps: &'a [T],
    /// Real poles.
    pub real: &'a [RealPoles<T>],
    /// Pole pairs.
    pub pairs: &'a [PolePair<T>],
    /// Gain at rest: steady-state output over a constant input; 1 where creep has no steady state.
    pub rest_gain: T,
}

/// Memory of [`Sections`], the caller's.
#[derive(Debug)]
pub struct SectionsMemory<'a, T> {
    /// One a group of real poles.
    pub real: &'a mut [Compensated<T, LANES>],
    /// One a pair.
    pub pairs: &'a mut [Compensated<T, 2>],
    /// One number a whole sample of delay.
    pub delay: &'a mut [T],
}

/// A linear block with its memory.
#[derive(Debug)]
pub struct Linear<'a, T> {
    sections: Sections<'a, T>,
    memory: SectionsMemory<'a, T>,
    /// Next write position in the delay ring.
    at: usize,
    recent: Recent<T>,
    rest: T,
}

/// The newest inputs, delayed: [`MOST_TAPS`] and the one that drives the poles. A ring buffer: shifting them
/// would make every sample wait for the stores of the one before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Recent<T> {
    ring: [T; RING],
    newest: usize,
}

/// A power of two above [`MOST_TAPS`].
const RING: usize = 16;
const _: () = assert!(RING.is_power_of_two() && RING > MOST_TAPS);

impl<T: Real> Recent<T> {
    fn zero() -> Self {
        Self { ring: [T::of(0.0); RING], newest: 0 }
    }

    #[inline(always)]
    fn push(&mut self, input: T) {
        self.newest = self.newest.wrapping_sub(1) % RING;
        self.ring[self.newest % RING] = input;
    }

    /// The input `samples` before the newest.
    #[inline(always)]
    pub(super) fn before(&self, samples: usize) -> T {
        self.ring[self.newest.wrapping_add(samples) % RING]
    }
}

impl<'a, T: Real> Linear<'a, T> {
    /// The block, at rest at 0.
    ///
    /// # Errors
    /// [`ModelError::Memory`] where the memory does not fit the sections, [`ModelError::Taps`],
    /// [`ModelError::Coefficient`] where one is not finite.
    pub fn new(sections: Sections<'a, T>, memory: SectionsMemory<'a, T>) -> Result<Self, ModelError<T>> {
        let taps = sections.taps.len();
        if taps == 0 || taps > MOST_TAPS {
            return Err(ModelError::Taps { found: taps });
        }
        for (expected, found) in
            [(sections.real.len(), memory.real.len()), (sections.pairs.len(), memory.pairs.len())]
        {
            if expected != found {
                return Err(ModelError::Memory { expected, found });
            }
        }
        let finite = |numbers: &[T]| numbers.iter().all(|x| x.is_finite());
        let sound = finite(sections.taps)
            && sections.rest_gain.is_finite()
            && sections.real.iter().all(|p| finite(&p.gain) && finite(&p.weight))
            && sections.pairs.iter().all(|p| finite(&p.gain) && finite(&p.weight));
        if !sound {
            return Err(ModelError::Coefficient);
        }
        let zero = T::of(0.0);
        let mut block = Self { sections, memory, at: 0, recent: Recent::zero(), rest: zero };
        block.rest_at(zero);
        Ok(block)
    }

    /// Resets to steady state at the constant input `input`.
    pub fn rest_at(&mut self, input: T) {
        self.rest = input;
        self.at = 0;
        self.recent = Recent::zero();
        self.memory.delay.fill(T::of(0.0));
        self.memory.real.fill(Compensated::zero());
        self.memory.pairs.fill(Compensated::zero());
    }

    /// Its members.
    pub(super) fn each_member(&mut self, tape: &mut Tape<'_>) {
        for state in self.memory.real.iter_mut() {
            tape.numbers(&mut state.value);
            tape.numbers(&mut state.carry);
        }
        for state in self.memory.pairs.iter_mut() {
            tape.numbers(&mut state.value);
            tape.numbers(&mut state.carry);
        }
        tape.numbers(self.memory.delay);
        tape.index(&mut self.at, self.memory.delay.len());
        tape.numbers(&mut self.recent.ring);
        tape.index(&mut self.recent.newest, RING);
        tape.number(&mut self.rest);
    }

    /// Steady-state output for the input of [`Self::rest_at`].
    pub fn output_at_rest(&self) -> T {
        self.sections.rest_gain * self.rest
    }

    /// Output after the input `w`, which must be finite, in a constant number of operations.
    #[inline]
    pub fn step(&mut self, w: T) -> T {
        // States decay towards a level far below any signal instead of through the subnormal numbers.
        let mut newest = w - self.rest + T::FLOOR;
        if let Some(slot) = self.memory.delay.get_mut(self.at) {
            core::mem::swap(slot, &mut newest);
            self.at += 1;
            if self.at >= self.memory.delay.len() {
                self.at = 0;
            }
        }
        self.recent.push(newest);
        let mut sum = self.sections.rest_gain * self.rest;
        for (samples, tap) in self.sections.taps.iter().enumerate() {
            sum = sum + *tap * self.recent.before(samples);
        }
        let drive = self.recent.before(self.sections.taps.len());
        let mut sums = [T::of(0.0); LANES];
        for (poles, state) in self.sections.real.iter().zip(self.memory.real.iter_mut()) {
            // Each operation on all lanes at once, so that it is vectorised.
            let (x, carry) = (state.value, state.carry);
            let delta: [T; LANES] = from_fn(|i| poles.gain[i] * (drive - x[i]) + carry[i]);
            let moved: [T; LANES] = from_fn(|i| x[i] + delta[i]);
            state.carry = from_fn(|i| delta[i] - (moved[i] - x[i]));
            state.value = moved;
            sums = from_fn(|i| sums[i] + poles.weight[i] * moved[i]);
        }
        // In halves of the vector.
        let [a, b, c, d] = sums;
        sum = sum + ((a + c) + (b + d));
        for (pair, state) in self.sections.pairs.iter().zip(self.memory.pairs.iter_mut()) {
            let ([g_re, g_im], [c_re, c_im]) = (pair.gain, pair.weight);
            let ([re, im], [carry_re, carry_im]) = (&mut state.value, &mut state.carry);
            let (left_re, left_im) = (drive - *re, T::FLOOR - *im);
            accumulate(re, carry_re, g_re * left_re - g_im * left_im);
            accumulate(im, carry_im, g_re * left_im + g_im * left_re);
            sum = sum + (c_re * *re - c_im * *im);
        }
        sum
    }

    /// Coefficients of the block.
    pub fn sections(&self) -> &Sections<'a, T> {
        &self.sections
    }

    /// The input at rest, and the newest inputs counted from there.
    #[inline(always)]
    pub(super) fn inputs(&self) -> (T, &Recent<T>) {
        (self.rest, &self.recent)
    }

    /// Memory of the block.
    pub fn memory(&self) -> &SectionsMemory<'a, T> {
        &self.memory
    }
}
