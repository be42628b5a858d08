//! Families of transfer functions in physical parameters, with exact derivatives.

use std::f64::consts::{FRAC_PI_2, TAU};

use hysteron_rt::{Dual, Scalar};

use super::creep::{Creep, MOST_CREEP_ELEMENTS};
use super::form_parameter::{FormParameter, ParameterKind as Kind};
use super::linearised::{Linearised, Number, Sum};
use super::{DynamicsError, TransferFunction};

/// Most poles of [`Modes::Integer`].
pub const MOST_INTEGER_POLES: usize = 12;
/// Most resonances of [`Modes::Resonances`].
pub const MOST_RESONANCES: usize = 6;

/// Poles of the fast part. With P(f, ζ, α₂, α₁, α₀) = s^α₂ + c₁ s^α₁ + c₀ s^α₀, ω = 2πf, c₀ = ω^(α₂ − α₀),
/// c₁ = 2ζ ω^(α₂ − α₁) (as in [`super::SecondOrder`]):
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Modes {
    /// G = 1.
    None,
    /// Gain 1 at zero frequency, the product of pairs ω²/P(f, ζ, 2, 1, 0) and, where the order is odd, a lag
    /// 1/(1 + T s). The parameters of the second pair are named with `_2`, and so on. Exchanging pairs leaves
    /// G unchanged.
    Integer {
        /// Number of poles, 1 to [`MOST_INTEGER_POLES`].
        order: usize,
    },
    /// Resonances in parallel, Σ w_k ω_k²/(s² + 2ζ_k ω_k s + ω_k²) with Σ w_k = 1, and behind them a lag
    /// 1/(1 + T s) if requested: gain 1 at zero frequency. Unlike the product of [`Modes::Integer`] they have
    /// zeros between them. Shares `share` (w₁), `share_2`, … except the last, which completes the sum to 1; a
    /// share may be negative (a resonance that moves against the others). Exchanging resonances leaves G
    /// unchanged.
    Resonances {
        /// Number of resonances, 1 to [`MOST_RESONANCES`].
        count: usize,
        /// True if there is a lag.
        lag: bool,
    },
    /// c₀ / P(f, ζ, α₂, α₁, 0): gain 1 at zero frequency.
    Fractional,
    /// b / P(f, ζ, α₂, α₁, α₀) with b = |P(2πi·1 Hz)|: |G| = 1 at 1 Hz, since G(0) is infinite unless α₀ = 0.
    FractionalFreeLowest,
    /// w G₁ + (1 − w) G₂, both as [`Modes::Fractional`], in parallel. Share w; the parameters of the second
    /// mode are named with `_2`. Exchanging the modes and w with 1 − w leaves G unchanged.
    TwoFractional,
}

/// A family of transfer functions: fast modes, and creep where requested.
///
/// G = modes · creep. As a [`TransferFunction`]: products of polynomials; terms are sorted, and where orders
/// coincide their coefficients are added (the derivatives stay exact there).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DynamicForm {
    /// Poles of the fast part.
    pub modes: Modes,
    /// The factor for creep.
    pub creep: Creep,
}

static LAG: [FormParameter; 1] = [FormParameter::new("lag", Kind::Lag)];
static PAIRS: [FormParameter; 2 * MOST_RESONANCES] = [
    FormParameter::new("natural_frequency", Kind::NaturalFrequency(1)),
    FormParameter::new("damping", Kind::Damping(1)),
    FormParameter::new("natural_frequency_2", Kind::NaturalFrequency(2)),
    FormParameter::new("damping_2", Kind::Damping(2)),
    FormParameter::new("natural_frequency_3", Kind::NaturalFrequency(3)),
    FormParameter::new("damping_3", Kind::Damping(3)),
    FormParameter::new("natural_frequency_4", Kind::NaturalFrequency(4)),
    FormParameter::new("damping_4", Kind::Damping(4)),
    FormParameter::new("natural_frequency_5", Kind::NaturalFrequency(5)),
    FormParameter::new("damping_5", Kind::Damping(5)),
    FormParameter::new("natural_frequency_6", Kind::NaturalFrequency(6)),
    FormParameter::new("damping_6", Kind::Damping(6)),
];
static SHARES: [FormParameter; MOST_RESONANCES - 1] = [
    FormParameter::new("share", Kind::Share(1)),
    FormParameter::new("share_2", Kind::Share(2)),
    FormParameter::new("share_3", Kind::Share(3)),
    FormParameter::new("share_4", Kind::Share(4)),
    FormParameter::new("share_5", Kind::Share(5)),
];
static ORDERS: [FormParameter; 3] = [
    FormParameter::new("order2", Kind::HighestOrder(1)),
    FormParameter::new("order1", Kind::MiddleOrder(1)),
    FormParameter::new("order0", Kind::LowestOrder),
];
static SECOND: [FormParameter; 5] = [
    FormParameter::new("natural_frequency_2", Kind::NaturalFrequency(2)),
    FormParameter::new("damping_2", Kind::Damping(2)),
    FormParameter::new("order2_2", Kind::HighestOrder(2)),
    FormParameter::new("order1_2", Kind::MiddleOrder(2)),
    FormParameter::new("share", Kind::Share(1)),
];

/// Room for the derivatives and terms of a form. A form of the first sort has at most 11 parameters and
/// polynomials of 12 terms, one of the second 26 and 45, and two fractional modes with logarithmic creep 135
/// terms.
const SMALL: (usize, usize) = (11, 12);
const LARGE: (usize, usize) = (26, 45);
const LONG: (usize, usize) = (11, 135);

impl DynamicForm {
    /// The parameters, in the order in which their values are given. None for modes or elements beyond the
    /// maximum, which the other functions refuse.
    pub fn parameters(&self) -> Vec<FormParameter> {
        self.list().copied().collect()
    }

    /// The parameter of this name in any form.
    pub fn parameter_named(name: &str) -> Option<FormParameter> {
        let longest = Creep::KelvinVoigt { elements: MOST_CREEP_ELEMENTS };
        let creep = Creep::USUAL.into_iter().chain([longest]).flat_map(Creep::parameters);
        let modes: [&[FormParameter]; 5] = [&LAG, &PAIRS, &SHARES, &ORDERS, &SECOND];
        modes.into_iter().flatten().chain(creep).find(|parameter| parameter.name == name).copied()
    }

    /// Number of parameters.
    pub fn parameter_count(&self) -> usize {
        self.list().count()
    }

    /// The transfer function at these parameters.
    ///
    /// # Errors
    /// [`DynamicsError::ParameterCount`]; [`DynamicsError::Parameter`] for a value that is not finite, a
    /// frequency, lag or time that is not positive, a negative order or Kelvin–Voigt creep, or a form with
    /// more poles, resonances or elements than allowed, or none; what [`TransferFunction::validate`] refuses.
    pub fn transfer_function(&self, p: &[f64]) -> Result<TransferFunction, DynamicsError> {
        let mut tf = TransferFunction { numerator: Vec::new(), denominator: Vec::new() };
        self.write_to(p, &mut tf)?;
        Ok(tf)
    }

    /// [`Self::transfer_function`] into an existing one. Allocates nothing once that held as many terms.
    ///
    /// # Errors
    /// Those of [`Self::transfer_function`].
    pub fn write_to(&self, p: &[f64], tf: &mut TransferFunction) -> Result<(), DynamicsError> {
        let (numerator, denominator) = self.polynomials::<f64, { LONG.1 }>(self.check(p)?);
        numerator.store(&mut tf.numerator, |_, _| {});
        denominator.store(&mut tf.denominator, |_, _| {});
        tf.validate()
    }

    /// The transfer function, and the derivatives of its coefficients and orders in each parameter, exact by
    /// forward differentiation of the same code. Allocates nothing once `out` held as many terms.
    ///
    /// # Errors
    /// Those of [`Self::transfer_function`].
    pub fn linearise(&self, p: &[f64], out: &mut Linearised) -> Result<(), DynamicsError> {
        self.check(p)?;
        let fits = |(parameters, terms): (usize, usize)| p.len() <= parameters && self.most_terms() <= terms;
        if fits(SMALL) {
            self.differentiate::<{ SMALL.0 }, { SMALL.1 }>(p, out)
        } else if fits(LARGE) {
            self.differentiate::<{ LARGE.0 }, { LARGE.1 }>(p, out)
        } else {
            self.differentiate::<{ LONG.0 }, { LONG.1 }>(p, out)
        }
    }

    fn differentiate<const P: usize, const T: usize>(
        &self,
        p: &[f64],
        out: &mut Linearised,
    ) -> Result<(), DynamicsError> {
        let duals: [Dual<f64, P>; P] =
            std::array::from_fn(|i| p.get(i).map_or(Dual::constant(0.0), |&value| Dual::variable(value, i)));
        let (numerator, denominator) = self.polynomials::<_, T>(&duals[..p.len()]);
        out.store(&numerator, &denominator, p.len())
    }

    /// Bound of the number of terms of either polynomial, before orders that happen to coincide are merged.
    fn most_terms(&self) -> usize {
        let (above, below) = match self.modes {
            Modes::None => (1, 1),
            Modes::Integer { order } => (1, order + 1),
            Modes::Resonances { count, lag } => (2 * count - 1, 2 * count + 1 + usize::from(lag)),
            Modes::Fractional | Modes::FractionalFreeLowest => (1, 3),
            Modes::TwoFractional => (6, 9),
        };
        let (creep_above, creep_below) = self.creep.terms();
        let whole =
            !matches!(self.modes, Modes::Fractional | Modes::FractionalFreeLowest | Modes::TwoFractional)
                && self.creep.has_whole_orders();
        // Degrees add up, where other orders give a term for each pair.
        let terms = |x: usize, y: usize| if whole { x + y - 1 } else { x * y };
        terms(above, creep_above).max(terms(below, creep_below))
    }

    fn list(&self) -> impl Iterator<Item = &'static FormParameter> {
        let pairs = |count: usize| PAIRS.get(..2 * count).unwrap_or(&[]);
        let lag = |there: bool| if there { &LAG[..] } else { &[] };
        let modes: [&'static [FormParameter]; 3] = match self.modes {
            Modes::None => [&[], &[], &[]],
            Modes::Integer { order } if order > MOST_INTEGER_POLES => [&[], &[], &[]],
            Modes::Integer { order } => [pairs(order / 2), &[], lag(order % 2 == 1)],
            Modes::Resonances { count, lag: there } => {
                let shares = SHARES.get(..count.saturating_sub(1)).unwrap_or(&[]);
                [pairs(count), shares, lag(there && (1..=MOST_RESONANCES).contains(&count))]
            }
            Modes::Fractional => [pairs(1), &ORDERS[..2], &[]],
            Modes::FractionalFreeLowest => [pairs(1), &ORDERS, &[]],
            Modes::TwoFractional => [pairs(1), &ORDERS[..2], &SECOND],
        };
        modes.into_iter().chain([self.creep.parameters()]).flatten()
    }

    fn check<'a>(&self, p: &'a [f64]) -> Result<&'a [f64], DynamicsError> {
        let counts = [
            match self.modes {
                Modes::Integer { order } => Some(("order", order, MOST_INTEGER_POLES, "1 to 12")),
                Modes::Resonances { count, .. } => {
                    Some(("number of resonances", count, MOST_RESONANCES, "1 to 6"))
                }
                _ => None,
            },
            match self.creep {
                Creep::KelvinVoigt { elements } => {
                    Some(("number of creep elements", elements, MOST_CREEP_ELEMENTS, "1 to 4"))
                }
                _ => None,
            },
        ];
        for (name, count, most, allowed) in counts.into_iter().flatten() {
            if !(1..=most).contains(&count) {
                return Err(DynamicsError::Parameter { name, value: count as f64, allowed });
            }
        }
        let expected = self.parameter_count();
        if p.len() != expected {
            return Err(DynamicsError::ParameterCount { expected, found: p.len() });
        }
        for (parameter, &value) in self.list().zip(p) {
            let refused = |allowed| DynamicsError::Parameter { name: parameter.name, value, allowed };
            parameter.check(value).map_err(refused)?;
        }
        Ok(p)
    }

    /// Numerator and denominator, before merging; once for numbers with and without derivatives.
    fn polynomials<S: Number, const T: usize>(&self, p: &[S]) -> (Sum<S, T>, Sum<S, T>) {
        let one = S::constant(1.0);
        let unit = || Sum::constant(one);
        let (numerator, denominator) = match (self.modes, p) {
            (Modes::Integer { order }, p) => {
                let (pairs, rest) = p.split_at((2 * (order / 2)).min(p.len()));
                let lag = rest.first().filter(|_| order % 2 == 1);
                let lag = lag.map_or_else(unit, |&lag| Sum::whole([one, lag]));
                let product = pairs.chunks_exact(2).fold(unit(), |d, p| d.times(&whole_pair(p[0], p[1])));
                over(product.times(&lag))
            }
            (Modes::Resonances { count, lag }, p) => {
                let (pairs, rest) = p.split_at((2 * count).min(p.len()));
                let (shares, rest) = rest.split_at(count.saturating_sub(1).min(rest.len()));
                let last = shares.iter().fold(one, |left, &share| left - share);
                let mut sum: Option<(Sum<S, T>, Sum<S, T>)> = None;
                for (p, &share) in pairs.chunks_exact(2).zip(shares.iter().chain([&last])) {
                    let (n, d) = over(whole_pair(p[0], p[1]));
                    let mode = (Sum::constant(share).times(&n), d);
                    sum = Some(sum.map_or(mode, |sum| Sum::add_fractions(&sum, &mode)));
                }
                let (n, d) = sum.unwrap_or((unit(), unit()));
                let lag = rest.first().filter(|_| lag);
                (n, lag.map_or(d, |&lag| d.times(&Sum::whole([one, lag]))))
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
            _ => (unit(), unit()),
        };
        if self.creep == Creep::None {
            return (numerator, denominator);
        }
        let own = p.len() - self.creep.parameters().len();
        let (n, d) = self.creep.polynomials(&p[own..]);
        (numerator.times(&n), denominator.times(&d))
    }
}

/// D(0)/D, for D with a constant first term.
fn over<S: Number, const T: usize>(denominator: Sum<S, T>) -> (Sum<S, T>, Sum<S, T>) {
    let constant = denominator.first().unwrap_or(S::constant(1.0));
    (Sum::constant(constant), denominator)
}

/// s² + 2ζω s + ω².
fn whole_pair<S: Number, const T: usize>(natural_frequency_hz: S, damping: S) -> Sum<S, T> {
    let omega = natural_frequency_hz.scale(TAU);
    Sum::whole([omega * omega, damping.scale(2.0) * omega, S::constant(1.0)])
}

/// P(f, ζ, α₂, α₁, α₀), lowest order first.
fn pair<S: Number, const T: usize>(natural_frequency_hz: S, damping: S, a2: S, a1: S, a0: S) -> Sum<S, T> {
    let omega = natural_frequency_hz.scale(TAU);
    let c0 = omega.powf(a2 - a0);
    let c1 = damping.scale(2.0) * omega.powf(a2 - a1);
    Sum::of([(c0, a0), (c1, a1), (S::constant(1.0), a2)])
}

/// |Σ c s^α| at s = 2πi·1 Hz, where s^α = (2π)^α (cos απ/2 + i sin απ/2).
fn magnitude_at_1_hz<S: Number, const T: usize>(polynomial: &Sum<S, T>) -> S {
    let (mut re, mut im) = (S::constant(0.0), S::constant(0.0));
    for (coefficient, order) in polynomial.terms() {
        let size = coefficient * S::constant(TAU).powf(order);
        let angle = order.scale(FRAC_PI_2);
        re = re + size * angle.cos();
        im = im + size * angle.sin();
    }
    (re * re + im * im).sqrt()
}
