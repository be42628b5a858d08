//! States of resonances behind an input that goes along straight lines.
//!
//! x' = p x + u with u = u₀ + s t has the solution x(t) = x₀ + m (x₀ + u₀/p + s/p²) − s t/p, m = e^(pt) − 1,
//! and what it does when p moves is the derivative of that in p.

use super::readout::Readout;
use hysteron_numeric::{Complex64, InstructionSet, Line, exponentials_less_one};

/// Lengths whose m are worked out together.
const STRETCH: usize = 64;

/// x of each pole and, where asked for, ∂x/∂p.
#[derive(Clone, Debug, Default)]
pub(super) struct Resonances {
    poles: Vec<Complex64>,
    inverses: Vec<Complex64>,
    states: Vec<(Complex64, Complex64)>,
    with_derivatives: bool,
    /// A line further, where they are read.
    ahead: Vec<(Complex64, Complex64)>,
    steps: Exponentials,
    readings: Exponentials,
}

/// m of every pole for a stretch of numbered lengths.
#[derive(Clone, Debug, Default)]
struct Exponentials {
    first: usize,
    lengths_s: Vec<f64>,
    re: Vec<f64>,
    im: Vec<f64>,
}

impl Exponentials {
    /// Place of length `index` within the stretch, which is made anew from there on where it is not in it.
    fn place(
        &mut self,
        set: InstructionSet,
        poles: &[Complex64],
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
        self.re.resize(STRETCH * poles.len(), 0.0);
        self.im.resize(STRETCH * poles.len(), 0.0);
        let rows = self.re.chunks_exact_mut(STRETCH).zip(self.im.chunks_exact_mut(STRETCH));
        for (pole, (re, im)) in poles.iter().zip(rows) {
            exponentials_less_one(set, *pole, &self.lengths_s, re, im);
        }
        0
    }

    fn of(&self, pole: usize, place: usize) -> Complex64 {
        let at = pole * STRETCH + place;
        Complex64::new(
            self.re.get(at).copied().unwrap_or(f64::NAN),
            self.im.get(at).copied().unwrap_or(f64::NAN),
        )
    }
}

impl Resonances {
    /// At rest at 0, with the derivatives that one of `readouts` asks for.
    pub fn reset(&mut self, poles: &[Complex64], readouts: &[&Readout]) {
        self.poles.clear();
        self.poles.extend_from_slice(poles);
        self.inverses.clear();
        self.inverses.extend(poles.iter().map(|pole| pole.inv()));
        self.states.clear();
        self.states.resize(poles.len(), (Complex64::ZERO, Complex64::ZERO));
        let mut factors = readouts.iter().flat_map(|readout| &readout.resonances);
        self.with_derivatives = factors.any(|(_, moved)| *moved != Complex64::ZERO);
        // The poles may be others than last time.
        self.steps.lengths_s.clear();
        self.readings.lengths_s.clear();
    }

    /// Moves the states along the `index`-th line of the input.
    pub fn advance(
        &mut self,
        set: InstructionSet,
        line: Line,
        index: usize,
        length_s: impl Fn(usize) -> f64,
    ) {
        if self.poles.is_empty() {
            return;
        }
        let place = self.steps.place(set, &self.poles, index, length_s);
        for (pole, (state, inverse)) in self.states.iter_mut().zip(&self.inverses).enumerate() {
            *state = at_end(*state, *inverse, self.steps.of(pole, place), line, self.with_derivatives);
        }
    }

    /// Adds their share of the output of this number to the sum of each readout, at the end of a line of the
    /// input; the states stay where they are.
    pub fn read(
        &mut self,
        set: InstructionSet,
        line: Line,
        readouts: &[&Readout],
        (index, since_s): (usize, impl Fn(usize) -> f64),
        sums: &mut [f64],
    ) {
        if self.poles.is_empty() {
            return;
        }
        self.ahead.clone_from(&self.states);
        if line.length_s > 0.0 {
            let place = self.readings.place(set, &self.poles, index, since_s);
            for (pole, (state, inverse)) in self.ahead.iter_mut().zip(&self.inverses).enumerate() {
                *state = at_end(*state, *inverse, self.readings.of(pole, place), line, self.with_derivatives);
            }
        }
        for (readout, sum) in readouts.iter().zip(sums) {
            for ((x, moved), (of_x, of_moved)) in self.ahead.iter().zip(&readout.resonances) {
                *sum += (x * of_x + moved * of_moved).re;
            }
        }
    }
}

/// x and ∂x/∂p at the end of a line.
fn at_end(
    (x, moved): (Complex64, Complex64),
    inverse: Complex64,
    m: Complex64,
    line: Line,
    with_derivative: bool,
) -> (Complex64, Complex64) {
    let (rise, change) = (inverse * line.slope, inverse * (line.slope * line.length_s));
    let from = x + inverse * (rise + line.from);
    let end = x + (m * from - change);
    if !with_derivative {
        return (end, moved);
    }
    let drawn = moved - inverse * inverse * (2.0 * rise + line.from);
    (end, moved + (m * drawn + (m + 1.0) * from * line.length_s + inverse * change))
}
