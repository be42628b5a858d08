//! Poles with residues, and the derivatives of both.

use std::f64::consts::PI;

use super::super::{DynamicsError, Term, TermTangent, TransferFunction};
use super::Tangents;
use hysteron_numeric::Complex64;

/// Poles within this share of π of the negative real axis are described by relaxations where they cannot be
/// resolved.
const RELAXING: f64 = 0.05;
/// Poles nearer to one another than this share of their size are not resolved: their residues cancel.
const APART: f64 = 0.05;

/// A pair of poles of G, by its member above the real axis: G = … + R/(s − p) + R̄/(s − p̄). A real pole
/// counts as a pair of halves.
#[derive(Clone, Debug)]
pub(super) struct ResonantPole {
    /// p \[rad/s\].
    pub place: Complex64,
    /// R.
    pub residue: Complex64,
    /// Derivatives of p and R in each parameter.
    pub tangents: Vec<(Complex64, Complex64)>,
}

impl ResonantPole {
    /// The pairs of `tf` that oscillate, and its real poles where there is no branch cut.
    ///
    /// # Errors
    /// [`DynamicsError::OutputNotFinite`] for pairs that coincide.
    pub fn of(tf: &TransferFunction, tangents: Tangents<'_>) -> Result<Vec<Self>, DynamicsError> {
        let poles = tf.poles()?;
        let alone =
            |p: &Complex64| poles.iter().filter(|other| (**other - p).norm() < APART * p.norm()).count() == 1;
        let resonates = |p: &Complex64| p.im > 0.0 && p.arg() < PI * (1.0 - RELAXING);
        let relaxes = |p: &Complex64| tf.is_integer_order() && p.im >= 0.0 && alone(p);
        let wanted = poles.iter().filter(|p| resonates(p) || relaxes(p));
        wanted.map(|&p| Self::at(p, tf, tangents)).collect()
    }

    fn at(place: Complex64, tf: &TransferFunction, linearised: Tangents<'_>) -> Result<Self, DynamicsError> {
        let half = if place.im == 0.0 { 0.5 } else { 1.0 };
        let numerator = derivatives(&tf.numerator, place).map(|n| n * half);
        let denominator = derivatives(&tf.denominator, place);
        let residue = numerator[0] / denominator[1];
        let parameters = linearised.map_or(0, |linearised| linearised.parameters());
        let along = |which: usize| {
            let of = |terms: &[Term], tangent: &dyn Fn(usize) -> TermTangent| {
                parameter_derivatives(terms, tangent, place)
            };
            let (Some(linearised), Some(_)) = (linearised, parameters.checked_sub(1)) else {
                return (Complex64::ZERO, Complex64::ZERO);
            };
            let numerator_moves =
                half * of(&tf.numerator, &|term| nth(linearised.numerator_term(term), which))[0];
            let [moves, slope_moves] =
                of(&tf.denominator, &|term| nth(linearised.denominator_term(term), which));
            // D(p) = 0 along the parameter; R = N/D'.
            let place_moves = -moves / denominator[1];
            let residue_moves = (numerator_moves + numerator[1] * place_moves
                - residue * (slope_moves + denominator[2] * place_moves))
                / denominator[1];
            (place_moves, residue_moves)
        };
        let tangents: Vec<_> = (0..parameters).map(along).collect();
        let finite = |z: &Complex64| z.is_finite();
        if finite(&residue) && tangents.iter().all(|(p, r)| finite(p) && finite(r)) {
            Ok(Self { place, residue, tangents })
        } else {
            Err(DynamicsError::OutputNotFinite)
        }
    }

    /// The pair's share of G at s.
    pub fn response(&self, s: Complex64) -> Complex64 {
        pair(s, self.place, |to, r, _| r / to, self.residue, Complex64::ZERO)
    }

    /// The pair's share of the derivative of G at s in a parameter.
    pub fn response_tangent(&self, s: Complex64, which: usize) -> Complex64 {
        let (place, residue) = self.tangents.get(which).copied().unwrap_or_default();
        pair(s, self.place, |to, r, moved| r / to + moved / (to * to), residue, self.residue * place)
    }
}

/// A function of s − p and two numbers, plus the same of their conjugates.
fn pair(
    s: Complex64,
    place: Complex64,
    of: impl Fn(Complex64, Complex64, Complex64) -> Complex64,
    a: Complex64,
    b: Complex64,
) -> Complex64 {
    of(s - place, a, b) + of(s - place.conj(), a.conj(), b.conj())
}

fn nth(tangents: &[TermTangent], which: usize) -> TermTangent {
    tangents.get(which).copied().unwrap_or_default()
}

/// Σ a s^α and its first two derivatives in s.
fn derivatives(terms: &[Term], s: Complex64) -> [Complex64; 3] {
    let log = s.ln();
    let mut sums = [Complex64::ZERO; 3];
    for term in terms {
        let power = (log * term.order).exp() * term.coefficient;
        sums[0] += power;
        sums[1] += power * term.order;
        sums[2] += power * (term.order * (term.order - 1.0));
    }
    [sums[0], sums[1] / s, sums[2] / (s * s)]
}

/// Derivative of Σ a s^α in a parameter, and the derivative of that in s.
fn parameter_derivatives(
    terms: &[Term],
    tangent: &dyn Fn(usize) -> TermTangent,
    s: Complex64,
) -> [Complex64; 2] {
    let log = s.ln();
    let mut sums = [Complex64::ZERO; 2];
    for (index, term) in terms.iter().enumerate() {
        let TermTangent { coefficient, weighted_order } = tangent(index);
        let power = (log * term.order).exp();
        let moves = log * weighted_order + coefficient;
        sums[0] += power * moves;
        sums[1] += power * (moves * term.order + weighted_order);
    }
    [sums[0], sums[1] / s]
}
