//! All plays of the family moved and read side by side: the values by vector code, derivatives by the chain
//! rule.

use hysteron_numeric::{InstructionSet, Pass, run_pass, smooth_minimum};
use hysteron_rt::{Dual, RelaxingMove, SLOPES, Scalar};

/// Number of plays, at equal distances in ln r.
pub(super) const PLAYS: usize = 40;
/// Plays abreast.
const LANES: usize = 8;
type Plays = [f64; PLAYS];

/// A move of the drive without derivatives: [`RelaxingMove`] for all plays.
pub(super) struct Move<'a, S> {
    sigma: S,
    by: f64,
    interval_s: f64,
    thresholds: &'a Plays,
}

impl<'a, S: Scalar<Real = f64>> Move<'a, S> {
    pub(super) fn new(sigma: S, by: f64, interval_s: f64, thresholds: &'a Plays) -> Self {
        Self { sigma, by, interval_s, thresholds }
    }

    /// Moves the plays at the distances `behind`.
    pub(super) fn apply(&self, set: InstructionSet, behind: &mut [S]) {
        let Self { sigma, by, interval_s, thresholds } = *self;
        // With the derivative with respect to σ, the only one of a move.
        let own = Dual::<f64, 1>::variable(sigma.value(), 0);
        let sliding = RelaxingMove::new(own, Dual::constant(by), Dual::constant(interval_s));
        let Some(shrinks) = sliding.shrinks() else {
            behind.iter_mut().for_each(|z| *z = z.shift(by));
            return;
        };
        let mut moved = Moved::default();
        let before = &mut moved.distance;
        before.iter_mut().zip(&*behind).for_each(|(own, z)| *own = z.value());
        let shrinks = [shrinks.value, shrinks.derivative(0)];
        run_pass(set, Slide { moved: &mut moved, by, sigma: sigma.value(), shrinks, thresholds });
        let whole = || RelaxingMove::new(sigma, S::constant(by), S::constant(interval_s));
        let whole = moved.passed.contains(&1.0).then(whole);
        for (i, z) in behind.iter_mut().enumerate() {
            *z = if let Some(whole) = whole.filter(|_| moved.passed[i] != 0.0) {
                whole.distance(thresholds[i], *z)
            } else {
                z.join(sigma, moved.distance[i], [moved.by_distance[i], moved.by_sigma[i]])
            };
        }
    }
}

/// Distances of the plays behind the drive: before a move; after it with their derivatives.
struct Moved {
    distance: Plays,
    by_distance: Plays,
    by_sigma: Plays,
    /// 1 for a play that the drive passes during the move, where the other numbers have no meaning.
    passed: Plays,
}

impl Default for Moved {
    fn default() -> Self {
        Self {
            distance: [0.0; PLAYS],
            by_distance: [0.0; PLAYS],
            by_sigma: [0.0; PLAYS],
            passed: [0.0; PLAYS],
        }
    }
}

/// [`RelaxingMove::distance`] of every play but those that the drive passes.
struct Slide<'a> {
    moved: &'a mut Moved,
    by: f64,
    sigma: f64,
    /// Final r − |z| of a play that slides during the whole move, and its derivative with respect to σ.
    shrinks: [f64; 2],
    thresholds: &'a Plays,
}

impl Pass for Slide<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { moved, by, sigma, shrinks: [shrinks, shrinks_by_sigma], thresholds } = self;
        let size = by.abs();
        for (i, threshold) in thresholds.iter().enumerate() {
            let z = moved.distance[i];
            let side = if (z < 0.0) | ((z == 0.0) & (by < 0.0)) { -1.0 } else { 1.0 };
            let towards = side * by < 0.0;
            let [away, back] = if towards { [0.0, size] } else { [size, 0.0] };
            let (least, by_distance, by_sigma) = smooth_minimum(side * z + away, threshold - shrinks, sigma);
            let left = least - back;
            let is_over = left < 0.0;
            let own = side * (by_sigma - (1.0 - by_distance) * shrinks_by_sigma);
            moved.distance[i] = if is_over { 0.0 } else { side * left };
            moved.by_distance[i] = if is_over { 0.0 } else { by_distance };
            moved.by_sigma[i] = if is_over { 0.0 } else { own };
            moved.passed[i] = if is_over & towards { 1.0 } else { 0.0 };
        }
    }
}

/// Outputs of the plays: of each the integrals of the Bernstein polynomials over the range up to its position.
pub(super) struct Readings<'a, S> {
    range: [f64; 2],
    u: S,
    behind: &'a [S],
}

impl<'a, S: Scalar<Real = f64>> Readings<'a, S> {
    pub(super) fn new(range: [f64; 2], u: S, behind: &'a [S]) -> Self {
        Self { range, u, behind }
    }

    /// Sums of the outputs with the `shares` of every density, [`SLOPES`] a density.
    pub(super) fn sum(&self, set: InstructionSet, shares: &[Plays], out: &mut [S]) {
        let mut outputs = Outputs { values: [[0.0; PLAYS]; SLOPES], polynomials: [[0.0; PLAYS]; SLOPES] };
        let mut positions = [0.0; PLAYS];
        let plays = positions.iter_mut().zip(self.behind);
        plays.for_each(|(p, z)| *p = self.u.value() - z.value());
        run_pass(set, Integrals { range: self.range, positions: &positions, outputs: &mut outputs });
        let sums = |weights: &Plays, of: &[Plays; SLOPES]| {
            let mut sums = [0.0; SLOPES];
            run_pass(set, Sums { weights, of, sums: &mut sums });
            sums
        };
        for (shares, out) in shares.iter().zip(out.chunks_exact_mut(SLOPES)) {
            let values = sums(shares, &outputs.values);
            out.iter_mut().zip(values).for_each(|(out, value)| *out = S::constant(value));
        }
        for index in 0..S::DERIVATIVES {
            let by_u = self.u.derivative(index);
            let mut moves = [0.0; PLAYS];
            moves.iter_mut().zip(self.behind).for_each(|(own, z)| *own = by_u - z.derivative(index));
            for (shares, out) in shares.iter().zip(out.chunks_exact_mut(SLOPES)) {
                let mut weights = moves;
                weights.iter_mut().zip(shares).for_each(|(weight, share)| *weight *= share);
                let slopes = sums(&weights, &outputs.polynomials).into_iter();
                out.iter_mut().zip(slopes).for_each(|(out, by)| *out = out.with_derivative(index, by));
            }
        }
    }
}

/// The integrals of the Bernstein polynomials up to the position of every play
/// ([`bernstein_integrals`](hysteron_rt::bernstein_integrals)), and the polynomials there.
struct Outputs {
    values: [Plays; SLOPES],
    polynomials: [Plays; SLOPES],
}

/// Computes [`Outputs`].
struct Integrals<'a> {
    range: [f64; 2],
    positions: &'a Plays,
    outputs: &'a mut Outputs,
}

impl Pass for Integrals<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { range: [low, high], positions, outputs: Outputs { values, polynomials } } = self;
        let span = high - low;
        let [scale, third] = [1.0 / span, 1.0 / 3.0];
        for (i, position) in positions.iter().enumerate() {
            let x = (position - low) * scale;
            let below = if x < 0.0 { x } else { 0.0 };
            let above = if x > 1.0 { x - 1.0 } else { 0.0 };
            let inner = x - below - above;
            let (rest, square) = (1.0 - inner, inner * inner);
            let cube = square * inner * third;
            values[0][i] = span * (inner - square + cube + below);
            values[1][i] = span * (square - 2.0 * cube);
            values[2][i] = span * (cube + above);
            polynomials[0][i] = rest * rest;
            polynomials[1][i] = 2.0 * inner * rest;
            polynomials[2][i] = square;
        }
    }
}

/// Weighted sums over the plays, in the same order with every instruction set.
struct Sums<'a> {
    weights: &'a Plays,
    of: &'a [Plays; SLOPES],
    sums: &'a mut [f64; SLOPES],
}

impl Pass for Sums<'_> {
    #[inline(always)]
    fn run(self) {
        for (sum, values) in self.sums.iter_mut().zip(self.of) {
            let mut lanes = [0.0; LANES];
            for first in (0..PLAYS).step_by(LANES) {
                for lane in 0..LANES {
                    lanes[lane] += self.weights[first + lane] * values[first + lane];
                }
            }
            *sum = lanes.iter().sum();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_rt::bernstein_integrals;
    use proptest::prelude::*;

    type Number = Dual<f64, 2>;

    fn close(a: Number, b: Number, scale: f64) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * scale * (1.0 + b.abs());
        near(a.value, b.value) && a.partials.iter().zip(b.partials).all(|(a, b)| near(*a, b))
    }

    proptest! {
        /// Moves and sums of all plays on every instruction set against one play at a time.
        #[test]
        fn plays_abreast_are_single_plays(
            sigma in 0.02..0.4_f64,
            by in prop_oneof![Just(0.0), -6.0..6.0_f64],
            interval_s in prop_oneof![Just(0.0), 1e-5..5.0_f64],
            shares in proptest::collection::vec(-1.0..1.0_f64, PLAYS),
            positions in proptest::collection::vec(-1.2..1.2_f64, PLAYS),
            u in -2.0..12.0_f64,
        ) {
            let thresholds: Plays = std::array::from_fn(|i| 0.015 * 1.15_f64.powi(i as i32));
            let of = |(i, share): (usize, &f64)| Number {
                value: share * thresholds[i],
                partials: [0.3 * share, positions[PLAYS - 1 - i]],
            };
            let behind: Vec<Number> = positions.iter().enumerate().map(of).collect();
            let sigma = Number::variable(sigma, 0);
            let single = RelaxingMove::new(sigma, Number::constant(by), Number::constant(interval_s));
            let shares: [Plays; 1] = [std::array::from_fn(|i| shares[i])];
            for set in InstructionSet::available() {
                let mut moved = behind.clone();
                Move::new(sigma, by, interval_s, &thresholds).apply(set, &mut moved);
                for ((found, z), r) in moved.iter().zip(&behind).zip(thresholds) {
                    let expected = single.distance(r, *z);
                    prop_assert!(close(*found, expected, 10.0), "{found:?} {expected:?}");
                }
                let u = Number::constant(u);
                let mut sums = [Number::constant(0.0); SLOPES];
                Readings::new([0.0, 10.0], u, &moved).sum(set, &shares, &mut sums);
                let mut expected = [Number::constant(0.0); SLOPES];
                for (z, share) in moved.iter().zip(shares[0]) {
                    let outputs = bernstein_integrals([0.0, 10.0], u - *z);
                    expected.iter_mut().zip(outputs).for_each(|(sum, b)| *sum = *sum + b.scale(share));
                }
                prop_assert!(sums.iter().zip(expected).all(|(a, b)| close(*a, b, 100.0)));
            }
        }
    }
}
