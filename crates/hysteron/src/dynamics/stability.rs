//! Stability by the argument principle, with the orders as they are.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::transfer_function::{highest, lowest};
use super::{Term, TransferFunction};
use crate::numeric::Complex64;

/// Below this fraction of the sum of the terms' magnitudes the denominator counts as zero.
const ZERO: f64 = 1e-11;

/// Verdict of [`stability`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stability {
    /// Every pole on the main sheet lies in the open left half-plane: bounded input, bounded output.
    Stable,
    /// Stable but for a factor s^−order: G(0) is infinite and a constant input makes the output drift as
    /// t^order.
    Integrating {
        /// Order of the integral, > 0.
        order: f64,
    },
    /// A pole lies on the imaginary axis: undamped oscillation.
    Marginal {
        /// Its frequency \[Hz\].
        frequency_hz: f64,
    },
    /// Poles in the right half-plane: the response grows exponentially.
    Unstable {
        /// How many, each of a pair counted.
        poles: usize,
    },
}

impl Stability {
    /// Whether the response to a bounded input stays bounded.
    pub fn is_stable(self) -> bool {
        self == Self::Stable
    }
}

/// Where the poles of G lie, by the winding of its denominator along the imaginary axis (argument principle on
/// the main sheet; Matignon's theorem is the commensurate case, doi:10.1051/proc:1998004).
///
/// Nothing is rounded to a common order, and the steps cannot skip a turn: each is so short that the change of
/// the denominator is bounded by less than its magnitude. A pole closer to the imaginary axis than about 1e-11
/// of its frequency counts as on it. Poles are taken to be those of the denominator (no cancellation with the
/// numerator but common powers of s). Allocates nothing; some 10 µs for article Eq. 13.
pub fn stability(tf: &TransferFunction) -> Stability {
    match zeros_within(&tf.denominator, FRAC_PI_2) {
        Err(omega) => Stability::Marginal { frequency_hz: omega / TAU },
        Ok(poles) if poles > 0 => Stability::Unstable { poles },
        Ok(_) => {
            let order = lowest(&tf.denominator).order - lowest(&tf.numerator).order;
            if order > 0.0 { Stability::Integrating { order } } else { Stability::Stable }
        }
    }
}

/// Number of zeros of Σ a_i s^α_i with |arg s| < `half_angle` ≤ π, s = 0 not counted, or |s| of a zero on one
/// of the two rays.
///
/// With the lowest order divided out, D(0) ≠ 0 and the sector's boundary gives
/// zeros = (α_n · half_angle − change of arg D along the upper ray) / π.
pub(super) fn zeros_within(terms: &[Term], half_angle: f64) -> Result<usize, f64> {
    let (first, last) = (lowest(terms), highest(terms));
    if first.order == last.order {
        return Ok(0);
    }
    let ray = Ray { terms, first, half_angle };
    let (from, to) = ray.interesting(last);
    let mut log_s = from;
    let mut here = ray.at(log_s);
    let mut turned = (here.value / first.coefficient).arg();
    while log_s < to {
        if here.value.norm() <= ZERO * here.magnitude {
            return Err(log_s.exp());
        }
        // |D(log_s + step) − D(log_s)| ≤ slope·step·exp(highest·step) ≤ 0.5·1.65·|D|: zero is out of reach.
        let step = (0.5 * here.value.norm() / here.slope).min(0.5 / (last.order - first.order));
        log_s = (log_s + step).min(to);
        let next = ray.at(log_s);
        turned += (next.value * here.value.conj()).arg();
        here = next;
    }
    let order = last.order - first.order;
    // Beyond `to` the last term rules; what is left to turn is the difference from its direction.
    let leading = Complex64::from_polar(1.0, order * half_angle) * last.coefficient;
    turned -= (here.value * leading.conj()).arg();
    Ok(((order * half_angle - turned) / PI).round().max(0.0) as usize)
}

/// A denominator without its lowest power, along one ray from the origin.
pub(super) struct Ray<'a> {
    pub(super) terms: &'a [Term],
    pub(super) first: Term,
    pub(super) half_angle: f64,
}

/// All three scaled by the same positive number.
struct Point {
    value: Complex64,
    /// Σ |a_i| |s|^α_i.
    magnitude: f64,
    /// Bound of |dD / d ln|s||: Σ |a_i| α_i |s|^α_i.
    slope: f64,
}

impl Ray<'_> {
    fn terms(&self) -> impl Iterator<Item = (f64, f64)> {
        let shift = self.first.order;
        let terms = self.terms.iter().filter(|term| term.coefficient != 0.0);
        terms.map(move |term| (term.coefficient, term.order - shift))
    }

    /// ln |s| from where the lowest term is ten times all others together to where the highest is.
    pub(super) fn interesting(&self, last: Term) -> (f64, f64) {
        let others = self.terms.len() as f64;
        let top = last.order - self.first.order;
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        for (a, order) in self.terms() {
            let size = (10.0 * others * a.abs()).ln();
            if order > 0.0 {
                from = from.min((self.first.coefficient.abs().ln() - size) / order);
            }
            if order < top {
                to = to.max((size - last.coefficient.abs().ln()) / (top - order));
            }
        }
        (from, to.max(from))
    }

    fn at(&self, log_s: f64) -> Point {
        let scale =
            self.terms().map(|(a, order)| a.abs().ln() + order * log_s).fold(f64::NEG_INFINITY, f64::max);
        let mut point = Point { value: Complex64::ZERO, magnitude: 0.0, slope: 0.0 };
        for (a, order) in self.terms() {
            let size = (a.abs().ln() + order * log_s - scale).exp();
            point.value += Complex64::from_polar(size, order * self.half_angle) * a.signum();
            point.magnitude += size;
            point.slope += size * order;
        }
        point
    }
}
