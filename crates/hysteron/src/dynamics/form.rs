//! Families of transfer functions in the words users think in, with exact derivatives.

use std::f64::consts::{FRAC_PI_2, TAU};

use hysteron_rt::{Dual, Scalar};

use super::linearised::{Linearised, Number, Sum};
use super::{DynamicsError, TransferFunction};

/// Poles of the fast part. With P(f, ζ, α₂, α₁, α₀) = s^α₂ + c₁ s^α₁ + c₀ s^α₀, ω = 2πf, c₀ = ω^(α₂ − α₀),
/// c₁ = 2ζ ω^(α₂ − α₁) (as in [`super::SecondOrder`]):
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Modes {
    /// G = 1.
    None,
    /// Gain 1 at zero frequency, the product of
    /// - order 1: a lag 1/(1 + T s);
    /// - order 2: a pair ω²/P(f, ζ, 2, 1, 0);
    /// - order 3: a pair and a lag;
    /// - order 4: two pairs.
    Integer {
        /// Number of poles, 1 to 4.
        order: usize,
    },
    /// c₀ / P(f, ζ, α₂, α₁, 0): gain 1 at zero frequency.
    Fractional,
    /// b / P(f, ζ, α₂, α₁, α₀) with b = |P(2πi·1 Hz)|: |G| = 1 at 1 Hz, since G(0) is infinite unless α₀ = 0.
    FractionalFreeLowest,
    /// w G₁ + (1 − w) G₂, both as [`Modes::Fractional`], in parallel. Share w; the parameters of the second mode
    /// are named with `_2`. Exchanging the modes and w with 1 − w is the same G.
    TwoFractional,
}

/// A family of transfer functions: fast modes, and creep where asked for.
///
/// G = modes · (1 + k s^−μ). A unit step is followed by 1 + k t^μ/Γ(1 + μ) of what the modes make of it: for the
/// small μ of creep, k is about the share that has crept after one second.
///
/// As a [`TransferFunction`]: products of polynomials, (s^μ + k) over s^μ for the creep; terms are sorted, and where
/// orders coincide their coefficients are added (the derivatives stay exact there).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DynamicForm {
    /// Poles of the fast part.
    pub modes: Modes,
    /// Whether there is a factor 1 + k s^−μ, parameters `creep` (k, in s^−μ: seconds to the power −μ) and
    /// `creep_order` (μ).
    pub creep: bool,
}

/// One parameter of a [`DynamicForm`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FormParameter {
    /// Name, as on the command line.
    pub name: &'static str,
    /// Unit; empty for a number without one.
    pub unit: &'static str,
    /// Whether it is positive and naturally searched on a logarithmic scale.
    pub logarithmic: bool,
    range: Range,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Range {
    Positive,
    NotNegative,
    Finite,
}

const fn scale(name: &'static str, unit: &'static str) -> FormParameter {
    FormParameter { name, unit, logarithmic: true, range: Range::Positive }
}

const fn order(name: &'static str) -> FormParameter {
    FormParameter { name, unit: "", logarithmic: false, range: Range::NotNegative }
}

const fn free(name: &'static str, unit: &'static str, logarithmic: bool) -> FormParameter {
    FormParameter { name, unit, logarithmic, range: Range::Finite }
}

static LAG: [FormParameter; 1] = [scale("lag", "s")];
static FIRST: [FormParameter; 5] = [
    scale("natural_frequency", "Hz"),
    free("damping", "", true),
    order("order2"),
    order("order1"),
    order("order0"),
];
static SECOND: [FormParameter; 5] = [
    scale("natural_frequency_2", "Hz"),
    free("damping_2", "", true),
    order("order2_2"),
    order("order1_2"),
    free("share", "", false),
];
static CREEP: [FormParameter; 2] = [free("creep", "s^-creep_order", false), order("creep_order")];

/// Most parameters of a form: two fractional modes with creep.
const MOST: usize = 11;

impl DynamicForm {
    /// The parameters, in the order in which their values are given. Empty modes for an [`Modes::Integer`] order
    /// that does not exist, which the other functions refuse.
    pub fn parameters(&self) -> Vec<FormParameter> {
        self.list().copied().collect()
    }

    /// Number of parameters.
    pub fn parameter_count(&self) -> usize {
        self.list().count()
    }

    /// The transfer function at these parameters.
    ///
    /// # Errors
    /// [`DynamicsError::ParameterCount`]; [`DynamicsError::Parameter`] for a value that is not finite, a frequency
    /// or lag that is not positive, a negative order, or an integer form of an order other than 1 to 4; what
    /// [`TransferFunction::validate`] refuses.
    pub fn transfer_function(&self, p: &[f64]) -> Result<TransferFunction, DynamicsError> {
        let mut tf = TransferFunction { numerator: Vec::new(), denominator: Vec::new() };
        self.write_to(p, &mut tf)?;
        Ok(tf)
    }

    /// [`Self::transfer_function`] into an existing one. Allocates nothing once that held as many terms.
    ///
    /// # Errors
    /// As [`Self::transfer_function`].
    pub fn write_to(&self, p: &[f64], tf: &mut TransferFunction) -> Result<(), DynamicsError> {
        let (numerator, denominator) = self.polynomials(self.check(p)?);
        numerator.store(&mut tf.numerator, |_, _| {});
        denominator.store(&mut tf.denominator, |_, _| {});
        tf.validate()
    }

    /// The transfer function, and the derivatives of its coefficients and orders in each parameter, exact by
    /// forward differentiation of the same code. Allocates nothing once `out` held as many terms.
    ///
    /// # Errors
    /// As [`Self::transfer_function`].
    pub fn linearise(&self, p: &[f64], out: &mut Linearised) -> Result<(), DynamicsError> {
        let mut duals = [Dual::<f64, MOST>::constant(0.0); MOST];
        for (i, (dual, &value)) in duals.iter_mut().zip(self.check(p)?).enumerate() {
            dual.value = value;
            dual.partials[i] = 1.0;
        }
        let (numerator, denominator) = self.polynomials(&duals[..p.len()]);
        out.store(&numerator, &denominator, p.len())
    }

    fn list(&self) -> impl Iterator<Item = &'static FormParameter> {
        let (first, second): (&'static [FormParameter], &'static [FormParameter]) = match self.modes {
            Modes::None => (&[], &[]),
            Modes::Integer { order: 1 } => (&LAG, &[]),
            Modes::Integer { order: 2 } => (&FIRST[..2], &[]),
            Modes::Integer { order: 3 } => (&FIRST[..2], &LAG),
            Modes::Integer { order: 4 } => (&FIRST[..2], &SECOND[..2]),
            Modes::Integer { .. } => (&[], &[]),
            Modes::Fractional => (&FIRST[..4], &[]),
            Modes::FractionalFreeLowest => (&FIRST, &[]),
            Modes::TwoFractional => (&FIRST[..4], &SECOND),
        };
        let creep: &'static [FormParameter] = if self.creep { &CREEP } else { &[] };
        first.iter().chain(second).chain(creep)
    }

    fn check<'a>(&self, p: &'a [f64]) -> Result<&'a [f64], DynamicsError> {
        if let Modes::Integer { order } = self.modes
            && !(1..=4).contains(&order)
        {
            let value = order as f64;
            return Err(DynamicsError::Parameter { name: "order", value, allowed: "1, 2, 3 or 4" });
        }
        let expected = self.parameter_count();
        if p.len() != expected {
            return Err(DynamicsError::ParameterCount { expected, found: p.len() });
        }
        for (parameter, &value) in self.list().zip(p) {
            let (allowed, inside) = match parameter.range {
                Range::Positive => ("positive and finite", value > 0.0),
                Range::NotNegative => ("a finite number ≥ 0", value >= 0.0),
                Range::Finite => ("a finite number", true),
            };
            if !(inside && value.is_finite()) {
                return Err(DynamicsError::Parameter { name: parameter.name, value, allowed });
            }
        }
        Ok(p)
    }

    /// Numerator and denominator, before merging; once for numbers with and without derivatives.
    fn polynomials<S: Number>(&self, p: &[S]) -> (Sum<S>, Sum<S>) {
        let one = S::constant(1.0);
        let unit = Sum::constant(one);
        let (numerator, denominator) = match (self.modes, p) {
            (Modes::Integer { order: 1 }, &[lag, ..]) => (unit, first_order(lag)),
            (Modes::Integer { order: 2 }, &[f, zeta, ..]) => over(whole_pair(f, zeta)),
            (Modes::Integer { order: 3 }, &[f, zeta, lag, ..]) => {
                over(whole_pair(f, zeta).times(&first_order(lag)))
            }
            (Modes::Integer { order: 4 }, &[f, zeta, f2, zeta2, ..]) => {
                over(whole_pair(f, zeta).times(&whole_pair(f2, zeta2)))
            }
            (Modes::Fractional, &[f, zeta, a2, a1, ..]) => over(pair(f, zeta, a2, a1, S::constant(0.0))),
            (Modes::FractionalFreeLowest, &[f, zeta, a2, a1, a0, ..]) => {
                let denominator = pair(f, zeta, a2, a1, a0);
                (Sum::constant(magnitude_at_1_hz(&denominator)), denominator)
            }
            (Modes::TwoFractional, &[f, zeta, a2, a1, f2, zeta2, b2, b1, share, ..]) => {
                let (n, d) = over(pair(f, zeta, a2, a1, S::constant(0.0)));
                let (n2, d2) = over(pair(f2, zeta2, b2, b1, S::constant(0.0)));
                let first = Sum::constant(share).times(&n).times(&d2);
                let second = Sum::constant(one - share).times(&n2).times(&d);
                (first.plus(&second), d.times(&d2))
            }
            _ => (unit, unit),
        };
        match p {
            &[.., creep, order] if self.creep => {
                let power = Sum::of([(one, order)]);
                (numerator.times(&power.plus(&Sum::constant(creep))), denominator.times(&power))
            }
            _ => (numerator, denominator),
        }
    }
}

/// D(0)/D, for D with a constant first term.
fn over<S: Number>(denominator: Sum<S>) -> (Sum<S>, Sum<S>) {
    let constant = denominator.terms().first().map_or(S::constant(1.0), |&(c, _)| c);
    (Sum::constant(constant), denominator)
}

/// 1 + T s.
fn first_order<S: Number>(lag: S) -> Sum<S> {
    let one = S::constant(1.0);
    Sum::of([(one, S::constant(0.0)), (lag, one)])
}

fn whole_pair<S: Number>(natural_frequency_hz: S, damping: S) -> Sum<S> {
    pair(natural_frequency_hz, damping, S::constant(2.0), S::constant(1.0), S::constant(0.0))
}

/// P(f, ζ, α₂, α₁, α₀), lowest order first.
fn pair<S: Number>(natural_frequency_hz: S, damping: S, a2: S, a1: S, a0: S) -> Sum<S> {
    let omega = natural_frequency_hz.scale(TAU);
    let c0 = omega.powf(a2 - a0);
    let c1 = damping.scale(2.0) * omega.powf(a2 - a1);
    Sum::of([(c0, a0), (c1, a1), (S::constant(1.0), a2)])
}

/// |Σ c s^α| at s = 2πi·1 Hz, where s^α = (2π)^α (cos απ/2 + i sin απ/2).
fn magnitude_at_1_hz<S: Number>(polynomial: &Sum<S>) -> S {
    let (mut re, mut im) = (S::constant(0.0), S::constant(0.0));
    for &(coefficient, order) in polynomial.terms() {
        let size = coefficient * S::constant(TAU).powf(order);
        let angle = order.scale(FRAC_PI_2);
        re = re + size * angle.cos();
        im = im + size * angle.sin();
    }
    (re * re + im * im).sqrt()
}
