//! Stability by the argument principle, without rounding the orders.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::transfer_function::{highest, lowest};
use super::{Term, TransferFunction};
use hysteron_numeric::Complex64;

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
        /// Number of unstable poles, both of a pair counted.
        poles: usize,
    },
}

impl Stability {
    /// True if the response to a bounded input stays bounded.
    pub fn is_stable(self) -> bool {
        self == Self::Stable
    }
}

/// Stability of G, by the winding of its denominator along the imaginary axis (argument principle on the main
/// sheet; Matignon's theorem is the commensurate case, doi:10.1051/proc:1998004).
///
/// Nothing is rounded to a common order, and the steps cannot skip a turn: each is so short that the change
/// of the denominator is bounded by less than its magnitude. A pole closer to the imaginary axis than about
/// 1e-11 of its frequency counts as on it. Poles are assumed to be those of the denominator (no cancellation
/// with the numerator but common powers of s). Allocates nothing up to 48 terms; a few µs for article Eq. 13.
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
    let span = highest(terms).order - lowest(terms).order;
    let negative = lowest(terms).coefficient < 0.0;
    let used = terms.iter().filter(|term| term.coefficient != 0.0);
    if span * half_angle < PI * (1.0 - 1e-9)
        && used.into_iter().all(|term| (term.coefficient < 0.0) == negative)
    {
        // All directions lie within less than a half turn: the sum cannot vanish anywhere in the sector.
        return Ok(0);
    }
    let turned = Ray::with(terms, half_angle, |ray| ray.turned())?;
    Ok(((span * half_angle - turned) / PI).round().max(0.0) as usize)
}

/// Terms kept on the stack.
const FEW: usize = 48;

/// A denominator without its lowest power, along one ray from the origin.
pub(super) struct Ray<'a> {
    terms: &'a [Direction],
}

/// One term on the ray: its direction there does not depend on |s|.
#[derive(Clone, Copy, Default)]
pub(super) struct Direction {
    log_coefficient: f64,
    order: f64,
    unit: Complex64,
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
    /// Runs `work` with the ray of a polynomial.
    pub(super) fn with<T>(terms: &[Term], half_angle: f64, work: impl FnOnce(&Ray<'_>) -> T) -> T {
        let shift = lowest(terms).order;
        let directions = terms.iter().filter(|term| term.coefficient != 0.0).map(|term| Direction {
            log_coefficient: term.coefficient.abs().ln(),
            order: term.order - shift,
            unit: Complex64::from_polar(1.0, (term.order - shift) * half_angle) * term.coefficient.signum(),
        });
        if terms.len() > FEW {
            return work(&Ray { terms: &directions.collect::<Vec<_>>() });
        }
        let mut few = [Direction::default(); FEW];
        let mut count = 0;
        for (slot, direction) in few.iter_mut().zip(directions) {
            *slot = direction;
            count += 1;
        }
        work(&Ray { terms: &few[..count] })
    }

    /// ln |s| from where the lowest term is ten times all others together to where the highest is.
    pub(super) fn interesting(&self) -> (f64, f64) {
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        if let [first, .., last] = self.terms {
            let margin = (10.0 * self.terms.len() as f64).ln();
            for term in self.terms {
                if term.order > 0.0 {
                    from = from.min((first.log_coefficient - term.log_coefficient - margin) / term.order);
                }
                if term.order < last.order {
                    let gap = margin + term.log_coefficient - last.log_coefficient;
                    to = to.max(gap / (last.order - term.order));
                }
            }
        }
        (from, to.max(from))
    }

    fn at(&self, log_s: f64) -> Point {
        let size = |term: &Direction| term.log_coefficient + term.order * log_s;
        let scale = self.terms.iter().map(size).fold(f64::NEG_INFINITY, f64::max);
        let mut point = Point { value: Complex64::ZERO, magnitude: 0.0, slope: 0.0 };
        for term in self.terms {
            let size = (size(term) - scale).exp();
            point.value += term.unit * size;
            point.magnitude += size;
            point.slope += size * term.order;
        }
        point
    }

    /// Change of arg D from s = 0 to infinity, or |s| of a zero on the ray.
    fn turned(&self) -> Result<f64, f64> {
        let [first, .., last] = self.terms else { return Ok(0.0) };
        let (from, to) = self.interesting();
        let mut log_s = from;
        let mut here = self.at(log_s);
        let mut turned = (here.value * first.unit.conj()).arg();
        while log_s < to {
            if here.value.norm() <= ZERO * here.magnitude {
                return Err(log_s.exp());
            }
            // |D(log_s + step) − D(log_s)| ≤ slope·step·exp(highest·step) ≤ 0.5·1.65·|D|: zero is out of
            // reach.
            let step = (0.5 * here.value.norm() / here.slope).min(0.5 / last.order);
            log_s = (log_s + step).min(to);
            let next = self.at(log_s);
            turned += (next.value * here.value.conj()).arg();
            here = next;
        }
        // Beyond `to` the last term dominates: the remaining rotation is the difference from its direction.
        Ok(turned - (here.value * last.unit.conj()).arg())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1/(1 + d s + s²): a damping ratio of d/2 is an undamped oscillation up to 1e-11.
    #[test]
    fn a_pole_counts_as_on_the_axis_up_to_1e11_of_the_terms() {
        let of_damping = |d| {
            let terms = [Term::new(1.0, 0.0), Term::new(d, 1.0), Term::new(1.0, 2.0)];
            stability(&TransferFunction::new(vec![Term::new(1.0, 0.0)], terms.to_vec()).unwrap())
        };
        let Stability::Marginal { frequency_hz } = of_damping(1e-11) else {
            panic!("{:?}", of_damping(1e-11));
        };
        assert!((frequency_hz * TAU - 1.0).abs() < 1e-9, "{frequency_hz} Hz");
        assert_eq!(of_damping(8e-11), Stability::Stable);
    }
}
