//! Poles on the main sheet.

use std::f64::consts::PI;

use super::stability::{Ray, zeros_within};
use super::transfer_function::{highest, lowest};
use super::{DynamicsError, Term, TransferFunction};
use hysteron_numeric::Complex64;

/// Distance from the cut, as a share of π, below which a zero counts as on it.
const HAIR: f64 = 1e-9;

impl TransferFunction {
    /// Poles of G on the main sheet |arg s| < π \[rad/s\], pairs as both members, by descending frequency
    /// |s|.
    ///
    /// A denominator with real orders has finitely many, usually one resonant pair; the rest of its memory is
    /// the branch cut along the negative real axis. Their number is known from the argument principle; they
    /// are found by Newton's method in ln s from starts all over the sheet. With whole orders the negative
    /// real axis belongs to the sheet and all zeros of the polynomial are returned; a factor s^k counts as no
    /// pole, nor does a zero of multiplicity m count more than once. Relative accuracy about 1e-12 for simple
    /// poles.
    ///
    /// Article Eq. 13: −1441.298 ± 1062.396i.
    ///
    /// # Errors
    /// Those of [`TransferFunction::validate`].
    pub fn poles(&self) -> Result<Vec<Complex64>, DynamicsError> {
        self.validate()?;
        let terms = &self.denominator;
        let (first, last) = (lowest(terms), highest(terms));
        if first.order == last.order {
            return Ok(Vec::new());
        }
        let whole = terms.iter().all(|term| (term.order - first.order).fract() == 0.0);
        let count = if whole {
            (last.order - first.order) as usize
        } else {
            // A zero on the cut itself is nongeneric; a hair inside it the count is that of the open sheet.
            zeros_within(terms, PI).or_else(|_| zeros_within(terms, PI * (1.0 - HAIR))).unwrap_or(0)
        };
        Ok(search(terms, count, whole))
    }
}

/// Newton's method from a grid in ln s until `count` zeros are known.
fn search(terms: &[Term], count: usize, whole: bool) -> Vec<Complex64> {
    let (from, to) = Ray::with(terms, PI, |ray| ray.interesting());
    let mut found: Vec<Complex64> = Vec::new();
    // Finer and finer grids; the coarsest nearly always suffices.
    for density in [6, 16, 40] {
        for i in 0..=density {
            for j in 0..=density {
                if found.len() >= count {
                    break;
                }
                let start = Complex64::new(
                    from + (to - from) * (f64::from(i) + 0.5) / (f64::from(density) + 1.0),
                    PI * f64::from(j) / f64::from(density),
                );
                if let Some(log) = newton(terms, start, whole) {
                    insert(&mut found, log);
                }
            }
        }
    }
    let mut poles: Vec<Complex64> = found.into_iter().map(exp).collect();
    poles.sort_by(|a, b| b.norm().total_cmp(&a.norm()).then(b.im.total_cmp(&a.im)));
    poles
}

/// e^w, exactly real on the real axis.
fn exp(w: Complex64) -> Complex64 {
    if w.im.abs() == PI { Complex64::new(-w.re.exp(), 0.0) } else { w.exp() }
}

/// Adds a zero at w = ln s, and its conjugate, unless known.
fn insert(found: &mut Vec<Complex64>, mut log: Complex64) {
    const SAME: f64 = 1e-6;
    if log.im.abs() < 1e-12 {
        log.im = 0.0;
    }
    if (log.im.abs() - PI).abs() < SAME {
        log.im = PI;
    }
    log.im = log.im.abs();
    if found.iter().any(|known| (known - log).norm() < SAME) {
        return;
    }
    found.push(log);
    if log.im != 0.0 && log.im != PI {
        found.push(log.conj());
    }
}

/// A zero of Σ a e^(α w) near `start` with |Im w| ≤ π (whole orders: any, brought back).
fn newton(terms: &[Term], start: Complex64, whole: bool) -> Option<Complex64> {
    let mut w = start;
    for _ in 0..60 {
        let (mut value, mut slope) = (Complex64::ZERO, Complex64::ZERO);
        let scale = terms
            .iter()
            .filter(|term| term.coefficient != 0.0)
            .map(|term| term.coefficient.abs().ln() + term.order * w.re)
            .fold(f64::NEG_INFINITY, f64::max);
        for term in terms.iter().filter(|term| term.coefficient != 0.0) {
            let size = (term.coefficient.abs().ln() + term.order * w.re - scale).exp();
            let x = Complex64::from_polar(size, term.order * w.im) * term.coefficient.signum();
            value += x;
            slope += x * term.order;
        }
        let step = value / slope;
        if !step.is_finite() {
            return None;
        }
        // Long steps leave the region where the start made sense.
        let length = step.norm();
        w -= if length > 1.0 { step / length } else { step };
        if length < 1e-14 * (1.0 + w.norm()) || (length < 1e-9 && value.norm() < 1e-14) {
            if whole {
                w.im = (w.im + PI).rem_euclid(2.0 * PI) - PI;
            }
            // The cut itself belongs to the sheet only with whole orders; a zero on it is found to rounding.
            let edge = if whole { PI + 1e-6 } else { PI * (1.0 - HAIR) };
            return (w.im.abs() < edge).then_some(w);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn poles(terms: &[(f64, f64)]) -> Vec<Complex64> {
        let denominator = terms.iter().map(|&(a, order)| Term::new(a, order)).collect();
        TransferFunction::new(vec![Term::new(1.0, 0.0)], denominator).unwrap().poles().unwrap()
    }

    #[test]
    fn the_article_plant_has_one_pair() {
        let poles = TransferFunction::article_eq13().poles().unwrap();
        assert_eq!(poles.len(), 2);
        assert!((poles[0] - Complex64::new(-1441.298, 1062.396)).norm() < 1e-3, "{poles:?}");
        assert_eq!(poles[1], poles[0].conj());
    }

    #[test]
    fn whole_orders_give_the_zeros_of_the_polynomial() {
        // (s + 2)(s + 30)(s² + 2 s + 101), and s² times it.
        let product = [(6060.0, 0.0), (3352.0, 1.0), (225.0, 2.0), (34.0, 3.0), (1.0, 4.0)];
        let expected = [
            Complex64::new(-30.0, 0.0),
            Complex64::new(-1.0, 10.0),
            Complex64::new(-1.0, -10.0),
            Complex64::new(-2.0, 0.0),
        ];
        for shift in [0.0, 2.0] {
            let terms: Vec<_> = product.iter().map(|&(a, order)| (a, order + shift)).collect();
            let found = poles(&terms);
            assert_eq!(found.len(), 4, "{found:?}");
            for (a, b) in found.iter().zip(expected) {
                assert!((a - b).norm() < 1e-9, "{found:?}");
            }
        }
    }

    #[test]
    fn a_lag_on_the_cut_does_not_hide_the_resonance() {
        // (s + 0.3)(s^1.8 + 10 s^0.9 + 400): the lag's zero lies on the cut.
        let found = poles(&[(120.0, 0.0), (3.0, 0.9), (400.0, 1.0), (0.3, 1.8), (10.0, 1.9), (1.0, 2.8)]);
        let alone = poles(&[(400.0, 0.0), (10.0, 0.9), (1.0, 1.8)]);
        assert_eq!((found.len(), alone.len()), (2, 2), "{found:?}");
        assert!((found[0] - alone[0]).norm() < 1e-9 * alone[0].norm(), "{found:?} {alone:?}");
    }

    #[test]
    fn a_half_order_lag_has_no_pole_and_its_unstable_mirror_one() {
        // √s + 3 has no zero on the main sheet (its square root would be −3); √s − 3 has s = 9.
        assert_eq!(poles(&[(3.0, 0.0), (1.0, 0.5)]), []);
        let unstable = poles(&[(-3.0, 0.0), (1.0, 0.5)]);
        assert_eq!(unstable.len(), 1);
        assert!((unstable[0] - 9.0).norm() < 1e-10);
    }
}
