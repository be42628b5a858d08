//! Transfer functions with real orders, article Eq. 6.

use std::f64::consts::TAU;
use std::fmt;

use super::{DynamicsError, Term};
use hysteron_numeric::Complex64;

/// G(s) = Σ b s^β / Σ a s^α, terms in ascending order (article Eq. 6), any number of them, orders real ≥ 0
/// and not necessarily commensurate. s in rad/s, on the main sheet |arg s| ≤ π.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    /// Numerator terms, ascending order.
    pub numerator: Vec<Term>,
    /// Denominator terms, ascending order.
    pub denominator: Vec<Term>,
}

impl TransferFunction {
    /// A checked transfer function.
    ///
    /// # Errors
    /// Those of [`TransferFunction::validate`].
    pub fn new(numerator: Vec<Term>, denominator: Vec<Term>) -> Result<Self, DynamicsError> {
        let tf = Self { numerator, denominator };
        tf.validate()?;
        Ok(tf)
    }

    /// The article's identified stage, Eq. 13: 5.2589e6 / (s^2.0384 + 3081 s^1.0523 + 5.4955e6).
    pub fn article_eq13() -> Self {
        Self {
            numerator: vec![Term::new(5.2589e6, 0.0)],
            denominator: vec![Term::new(5.4955e6, 0.0), Term::new(3081.0, 1.0523), Term::new(1.0, 2.0384)],
        }
    }

    /// Checks the terms: finite coefficients, at least one of them non-zero in each polynomial, orders
    /// finite, ≥ 0 and strictly ascending. Allocates nothing.
    ///
    /// # Errors
    /// [`DynamicsError::NoTerms`], [`DynamicsError::Coefficient`], [`DynamicsError::Order`],
    /// [`DynamicsError::NotAscending`].
    pub fn validate(&self) -> Result<(), DynamicsError> {
        for (part, terms) in [("numerator", &self.numerator), ("denominator", &self.denominator)] {
            let mut before = None;
            for (index, term) in terms.iter().enumerate() {
                if !term.coefficient.is_finite() {
                    return Err(DynamicsError::Coefficient { part, index, value: term.coefficient });
                }
                if !(term.order.is_finite() && term.order >= 0.0) {
                    return Err(DynamicsError::Order { part, index, order: term.order });
                }
                match before {
                    Some(before) if term.order <= before => {
                        return Err(DynamicsError::NotAscending { part, index, order: term.order, before });
                    }
                    _ => before = Some(term.order),
                }
            }
            if terms.iter().all(|term| term.coefficient == 0.0) {
                return Err(DynamicsError::NoTerms { part });
            }
        }
        Ok(())
    }

    /// True if every order is a whole number.
    pub fn is_integer_order(&self) -> bool {
        self.numerator.iter().chain(&self.denominator).all(|term| term.order.fract() == 0.0)
    }

    /// True if the highest numerator order does not exceed the highest denominator order.
    pub fn is_proper(&self) -> bool {
        highest(&self.numerator).order <= highest(&self.denominator).order
    }

    /// G(s) at a complex s \[rad/s\] on the main sheet. At s = 0 the limit along the positive axis.
    pub fn response_at(&self, s: Complex64) -> Complex64 {
        if s == Complex64::ZERO {
            return self.dc_gain().into();
        }
        let log = s.ln();
        polynomial(&self.numerator, log) / polynomial(&self.denominator, log)
    }

    /// G(2πi f) e^(−2πi f τ) at frequencies f \[Hz\] with a pure delay τ \[s\].
    pub fn frequency_response(&self, frequencies_hz: &[f64], delay_s: f64) -> Vec<Complex64> {
        let at = |&f: &f64| {
            self.response_at(Complex64::new(0.0, TAU * f)) * Complex64::from_polar(1.0, -TAU * f * delay_s)
        };
        frequencies_hz.iter().map(at).collect()
    }

    /// G(0): 0, finite or infinite, by the lowest terms.
    pub fn dc_gain(&self) -> f64 {
        let (b, a) = (lowest(&self.numerator), lowest(&self.denominator));
        limit(b, a, b.order < a.order, b.order > a.order)
    }

    /// G(0) over |G(2πi f)| at a frequency \[Hz\].
    pub fn dc_gain_over(&self, frequency_hz: f64) -> f64 {
        self.dc_gain() / self.response_at(Complex64::new(0.0, TAU * frequency_hz)).norm()
    }

    /// G(∞) along the positive real axis: 0, finite or infinite, by the highest terms.
    pub fn high_frequency_gain(&self) -> f64 {
        let (b, a) = (highest(&self.numerator), highest(&self.denominator));
        limit(b, a, b.order > a.order, b.order < a.order)
    }

    pub(super) fn infinite_dc_gain(&self) -> DynamicsError {
        DynamicsError::InfiniteDcGain {
            numerator: lowest(&self.numerator).order,
            denominator: lowest(&self.denominator).order,
        }
    }

    pub(super) fn require_proper(&self) -> Result<(), DynamicsError> {
        if self.is_proper() {
            return Ok(());
        }
        let numerator = highest(&self.numerator).order;
        Err(DynamicsError::Improper { numerator, denominator: highest(&self.denominator).order })
    }
}

fn limit(b: Term, a: Term, infinite: bool, zero: bool) -> f64 {
    let ratio = b.coefficient / a.coefficient;
    if infinite {
        ratio.signum() * f64::INFINITY
    } else if zero {
        0.0
    } else {
        ratio
    }
}

/// Σ coefficient · exp(order · log_s).
pub(super) fn polynomial(terms: &[Term], log_s: Complex64) -> Complex64 {
    let value = |term: &Term| {
        Complex64::from_polar(term.coefficient * (term.order * log_s.re).exp(), term.order * log_s.im)
    };
    terms.iter().map(value).sum()
}

/// Position of the first term that is not zero; one past the end where there is none.
pub(super) fn lowest_index(terms: &[Term]) -> usize {
    terms.iter().position(|term| term.coefficient != 0.0).unwrap_or(terms.len())
}

/// Position of the last term that is not zero; one past the end where there is none.
pub(super) fn highest_index(terms: &[Term]) -> usize {
    terms.iter().rposition(|term| term.coefficient != 0.0).unwrap_or(terms.len())
}

/// First term that is not zero; a zero term where there is none.
pub(super) fn lowest(terms: &[Term]) -> Term {
    terms.get(lowest_index(terms)).copied().unwrap_or(Term::new(0.0, 0.0))
}

/// Last term that is not zero; a zero term where there is none.
pub(super) fn highest(terms: &[Term]) -> Term {
    terms.get(highest_index(terms)).copied().unwrap_or(Term::new(0.0, 0.0))
}

/// The form of article Eq. 13, highest order first, numbers to five significant digits (`{:.9}`: nine).
impl fmt::Display for TransferFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = f.precision().unwrap_or(5);
        let (numerator, denominator) = (print(&self.numerator, digits), print(&self.denominator, digits));
        let brackets = |text: &str| if text.contains(' ') { format!("({text})") } else { text.to_owned() };
        write!(f, "{} / {}", brackets(&numerator), brackets(&denominator))
    }
}

fn print(terms: &[Term], digits: usize) -> String {
    let mut text = String::new();
    for term in terms.iter().rev().filter(|term| term.coefficient != 0.0) {
        let negative = term.coefficient < 0.0;
        text.push_str(match (text.is_empty(), negative) {
            (true, false) => "",
            (true, true) => "-",
            (false, false) => " + ",
            (false, true) => " - ",
        });
        let coefficient = number(term.coefficient.abs(), digits);
        if term.order == 0.0 {
            text.push_str(&coefficient);
            continue;
        }
        if coefficient != "1" {
            text.push_str(&coefficient);
            text.push(' ');
        }
        text.push('s');
        let order = number(term.order, digits);
        if order != "1" {
            text.push('^');
            text.push_str(&order);
        }
    }
    if text.is_empty() { "0".to_owned() } else { text }
}

/// A positive number to this many significant digits, without trailing zeros; a power of ten from 1e5 up and
/// below 1e-3.
fn number(value: f64, digits: usize) -> String {
    let scientific = format!("{value:.*e}", digits.saturating_sub(1));
    let Some((mantissa, exponent)) = scientific.split_once('e') else { return scientific };
    let trim = |text: &str| {
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text.to_owned()
        }
    };
    match exponent.parse::<i32>() {
        Ok(exponent @ -3..=4) => {
            let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
            trim(&format!("{value:.decimals$}"))
        }
        _ => format!("{}e{exponent}", trim(mantissa)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prints_as_the_article_does() {
        let eq13 = TransferFunction::article_eq13();
        assert_eq!(eq13.to_string(), "5.2589e6 / (s^2.0384 + 3081 s^1.0523 + 5.4955e6)");
        let lead = TransferFunction::new(
            vec![Term::new(-0.00012, 0.0), Term::new(2.0, 1.0)],
            vec![Term::new(1.0, 0.0), Term::new(-12.5, 0.5)],
        );
        assert_eq!(lead.unwrap().to_string(), "(2 s - 1.2e-4) / (-12.5 s^0.5 + 1)");
    }

    #[test]
    fn refuses_what_is_not_a_transfer_function() {
        let one = || vec![Term::new(1.0, 0.0)];
        let new = TransferFunction::new;
        assert!(matches!(new(vec![], one()), Err(DynamicsError::NoTerms { part: "numerator" })));
        assert!(matches!(new(one(), vec![Term::new(0.0, 1.0)]), Err(DynamicsError::NoTerms { .. })));
        assert!(matches!(new(one(), vec![Term::new(1.0, -0.5)]), Err(DynamicsError::Order { .. })));
        assert!(matches!(new(one(), vec![Term::new(f64::NAN, 0.0)]), Err(DynamicsError::Coefficient { .. })));
        let repeated = vec![Term::new(1.0, 0.5), Term::new(2.0, 0.5)];
        assert!(matches!(new(one(), repeated), Err(DynamicsError::NotAscending { index: 1, .. })));
    }

    #[test]
    fn integer_response_is_the_rational_function() {
        // (2 + s) / (5 + 3 s + s²) at s = 1 + 2i: (3 + 2i) / (5 + 10i) = 0.28 − 0.16i... by hand:
        // s² = −3 + 4i, denominator 5 + 3 + 6i − 3 + 4i = 5 + 10i, quotient (3 + 2i)(5 − 10i)/125.
        let tf = TransferFunction::new(
            vec![Term::new(2.0, 0.0), Term::new(1.0, 1.0)],
            vec![Term::new(5.0, 0.0), Term::new(3.0, 1.0), Term::new(1.0, 2.0)],
        )
        .unwrap();
        let g = tf.response_at(Complex64::new(1.0, 2.0));
        assert!((g - Complex64::new(35.0 / 125.0, -20.0 / 125.0)).norm() < 1e-15);
        assert_eq!(tf.dc_gain(), 0.4);
        assert_eq!(tf.high_frequency_gain(), 0.0);
        assert!(tf.is_integer_order() && !TransferFunction::article_eq13().is_integer_order());
        // e^(−iωτ) of one period is 1; of a quarter −i.
        let quarter = tf.frequency_response(&[2.0], 0.125)[0];
        let plain = tf.frequency_response(&[2.0], 0.5)[0];
        assert!((quarter - plain * Complex64::new(0.0, -1.0)).norm() < 1e-15);
    }
}
