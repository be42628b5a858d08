//! Plays whose edges are crossed by thermal activation: loops widen with the rate, and the output creeps.

use crate::ParameterError;
use crate::real::{Real, Scalar};
use crate::series::relaxation;

/// Slopes of a play's output over the range: the Bernstein basis of degree 2.
pub const SLOPES: usize = 3;

/// Integrals of the Bernstein polynomials (1 − x)², 2x(1 − x), x² over `range` from its lower end to p, x =
/// (p − low)/(high − low); straight beyond the ends.
#[inline]
pub fn bernstein_integrals<S: Scalar>([low, high]: [S::Real; 2], p: S) -> [S; SLOPES] {
    let [zero, one, two, three] = [0.0, 1.0, 2.0, 3.0].map(S::Real::of);
    let (nothing, span) = (S::constant(zero), high - low);
    let x = p.shift(-low).scale(one / span);
    let (inner, below, above) = if x.value() < zero {
        (nothing, x, nothing)
    } else if x.value() > one {
        (S::constant(one), nothing, x.shift(-one))
    } else {
        (x, nothing, nothing)
    };
    let square = inner * inner;
    let third = (square * inner).scale(one / three);
    [inner - square + third + below, square - third.scale(two), third + above].map(|b| b.scale(span))
}

/// A weighted sum of plays with thermally activated edges, whose states relax at rest: pᵢ = u − zᵢ, Σᵢ Σ_k
/// slopesᵢₖ B_k(pᵢ) ([`bernstein_integrals`]).
///
/// The states zᵢ are borrowed. A step takes an exponential and one or two logarithms for each play that
/// creeps or slides, none for the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelaxingPlays<'a, T> {
    sigma: T,
    interval_s: T,
    range: [T; 2],
    thresholds: &'a [T],
    slopes: &'a [T],
}

impl<'a, T: Real> RelaxingPlays<'a, T> {
    /// The sum: activation `sigma` and the time between samples positive, ends of the range and thresholds
    /// increasing, [`SLOPES`] slopes a play, play by play.
    ///
    /// # Errors
    /// [`ParameterError`].
    pub fn new(
        (sigma, interval_s): (T, T),
        range: [T; 2],
        thresholds: &'a [T],
        slopes: &'a [T],
    ) -> Result<Self, ParameterError<T>> {
        let positive = |x: T| x.is_finite() && x > T::of(0.0);
        let [low, high] = range;
        if !(positive(sigma) && positive(interval_s) && positive(high - low)) {
            return Err(ParameterError::Sides);
        }
        if slopes.len() != SLOPES * thresholds.len() {
            return Err(ParameterError::Lengths {
                thresholds: SLOPES * thresholds.len(),
                weights: slopes.len(),
            });
        }
        let mut above = T::of(0.0);
        for (index, &value) in thresholds.iter().enumerate() {
            if !(value.is_finite() && value > above) {
                return Err(ParameterError::Threshold { index, value, above });
            }
            above = value;
        }
        match slopes.iter().enumerate().find(|(_, slope)| !slope.is_finite()) {
            Some((index, &value)) => Err(ParameterError::Weight { index, value }),
            None => Ok(Self { sigma, interval_s, range, thresholds, slopes }),
        }
    }

    /// Number of plays.
    pub fn count(&self) -> usize {
        self.thresholds.len()
    }

    /// The move by `du` within this `share` of a sample; a device at rest moves to its first sample at 1 unit
    /// per second.
    #[inline]
    fn step(&self, du: T, share: T, rested: bool) -> RelaxingMove<T> {
        RelaxingMove::new(self.sigma, du, if rested { du.abs() } else { share * self.interval_s })
    }

    /// Their output after a move to `u` by `du` that takes this `share` of a sample; no state changes.
    #[inline]
    pub fn look(&self, states: &[T], u: T, (du, share): (T, T), rested: bool) -> T {
        let step = self.step(du, share, rested);
        let plays = states.iter().zip(self.thresholds).map(|(z, r)| u - step.distance(*r, *z));
        self.sum(plays)
    }

    /// Moves them by a whole sample.
    #[inline]
    pub fn advance(&self, states: &mut [T], du: T, rested: bool) {
        let step = self.step(du, T::of(1.0), rested);
        states.iter_mut().zip(self.thresholds).for_each(|(z, r)| *z = step.distance(*r, *z));
    }

    /// Their output, virgin at `u`.
    pub fn output_at_rest(&self, u: T) -> T {
        self.sum(self.thresholds.iter().map(|_| u))
    }

    #[inline]
    fn sum(&self, plays: impl Iterator<Item = T>) -> T {
        plays.zip(self.slopes.chunks_exact(SLOPES)).fold(T::of(0.0), |sum, (p, slopes)| {
            let parts = bernstein_integrals(self.range, p).into_iter().zip(slopes);
            parts.fold(sum, |sum, (b, slope)| sum + *slope * b)
        })
    }
}

/// One linear move of the drive of plays with thermally activated edges.
///
/// A play of half-width r lags the drive u by the distance z, with
///
/// ż = u̇ − sign(z) v₀ exp((|z| − r)/σ),  v₀ = 1 per second,
///
/// where an ideal play stands still for |z| < r and moves at any speed at |z| = r (kinetics after H. Eyring,
/// *J. Chem. Phys.* 4 (1936) 283, doi:10.1063/1.1749836; plays after Prandtl and Ishlinskii). σ → 0 is the
/// ideal play. Along a linear move q = exp((r − |z|)/σ) obeys a linear equation, q̇ = (v₀ − sign(z) u̇ q)/σ,
/// so that a move of any length is exact.
#[derive(Clone, Copy, Debug)]
pub struct RelaxingMove<S: Scalar> {
    sigma: S,
    /// Change of the drive, and its size.
    by: S,
    size: S,
    /// Seconds of the move.
    interval_s: S,
    /// Final r − |z| of a play that slides during the whole move; `None` for an instantaneous move.
    shrinks: Option<S>,
}

impl<S: Scalar> RelaxingMove<S> {
    /// A move of the drive by `by` within `interval_s` ≥ 0; `sigma` > 0 in the unit of the drive.
    #[inline]
    pub fn new(sigma: S, by: S, interval_s: S) -> Self {
        let size = if by.value() < S::Real::of(0.0) { -by } else { by };
        let takes_time = interval_s.value() > S::Real::of(0.0);
        let shrinks = takes_time.then(|| shrinkage(sigma, size / interval_s, interval_s));
        Self { sigma, by, size, interval_s, shrinks }
    }

    /// Final r − |z| of a play that slides during the whole move; `None` for an instantaneous one.
    #[inline]
    pub fn shrinks(&self) -> Option<S> {
        self.shrinks
    }

    /// The distance z of a play of half-width `threshold` after the move.
    #[inline]
    pub fn distance(&self, threshold: S::Real, z: S) -> S {
        let zero = S::Real::of(0.0);
        let Some(shrinks) = self.shrinks else { return z + self.by };
        let behind = z.value() < zero || (z.value() == zero && self.by.value() < zero);
        let side = |x: S| if behind { -x } else { x };
        let (distance, towards) = (side(z), side(self.by).value() < zero);
        let limit = (-shrinks).shift(threshold);
        if !towards {
            return side(not_negative(soft_least(self.sigma, distance + self.size, limit)));
        }
        let left = soft_least(self.sigma, distance, limit) - self.size;
        if left.value() >= zero {
            return side(left);
        }
        -side(self.beyond(threshold, distance))
    }

    /// The distance, on the other side, of a play that the drive passes during the move.
    fn beyond(&self, threshold: S::Real, distance: S) -> S {
        let speed = self.size / self.interval_s;
        // |u̇| t = σ ln((1 + d)/(exp(−|z|/σ) + d)) at z = 0, d = v₀ exp(−r/σ)/|u̇|.
        let equals = (speed.ln() * self.sigma).shift(threshold);
        let d = (-(equals / self.sigma)).exp();
        let passed = (d.ln_1p() * self.sigma + soft_least(self.sigma, distance, equals)) / speed;
        let left_s = not_negative(self.interval_s - passed);
        if left_s.value() <= S::Real::of(0.0) {
            return S::constant(S::Real::of(0.0));
        }
        let limit = (-shrinkage(self.sigma, speed, left_s)).shift(threshold);
        not_negative(soft_least(self.sigma, speed * left_s, limit))
    }
}

/// σ ln(v₀/σ ∫ exp(−|u̇| t/σ) dt) over so many seconds.
#[inline]
fn shrinkage<S: Scalar>(sigma: S, speed: S, seconds: S) -> S {
    let (_, reach) = relaxation(speed / sigma, seconds);
    (reach / sigma).ln() * sigma
}

/// Smooth minimum −σ ln(exp(−a/σ) + exp(−b/σ)), below the lesser by up to σ ln 2.
#[inline]
fn soft_least<S: Scalar>(sigma: S, a: S, b: S) -> S {
    let (less, more) = if a.value() < b.value() { (a, b) } else { (b, a) };
    let apart = (more - less) / sigma;
    // Beyond that the second term is lost in rounding.
    if apart.value() > S::Real::of(38.0) { less } else { less - (-apart).exp().ln_1p() * sigma }
}

#[inline]
fn not_negative<S: Scalar>(x: S) -> S {
    if x.value() < S::Real::of(0.0) { S::constant(S::Real::of(0.0)) } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed forms of ∫ (1 − x)², ∫ 2x(1 − x), ∫ x² over a range of 3; straight with the slope at the end beyond it.
    #[test]
    fn integrals_of_the_bernstein_polynomials() {
        let [low, span] = [-1.0, 3.0];
        for x in [-0.5_f64, 0.0, 0.25, 0.7, 1.0, 1.5] {
            let inner = x.clamp(0.0, 1.0);
            let [square, cube] = [inner * inner, inner * inner * inner];
            let [below, above] = [x.min(0.0), (x - 1.0).max(0.0)];
            let wanted = [inner - square + cube / 3.0 + below, square - 2.0 / 3.0 * cube, cube / 3.0 + above];
            let found = bernstein_integrals([low, low + span], low + span * x);
            for (found, wanted) in found.into_iter().zip(wanted) {
                assert!((found - span * wanted).abs() < 1e-15, "{x}: {found} {}", span * wanted);
            }
        }
    }
}
