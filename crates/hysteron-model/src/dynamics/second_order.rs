//! The form of article Eq. 13 in physical parameters: gain, natural frequency, damping.

use std::f64::consts::TAU;
use std::fmt;

use super::{DynamicsError, Term, TransferFunction};

/// G(s) = b / (s^α₂ + c₁ s^α₁ + c₀ s^α₀), α₀ < α₁ < α₂ (article Eq. 13 has α₀ = 0), with
///
/// - gain K = b / c₀ (for α₀ = 0 the gain at zero frequency; else |G| → K ω^−α₀),
/// - natural frequency ω_n = c₀^(1/(α₂ − α₀)): where |s^α₂| = |c₀ s^α₀| on the imaginary axis,
/// - damping ζ = c₁ / (2 ω_n^(α₂ − α₁)): there |c₁ s^α₁| = 2ζ |s^α₂|.
///
/// With α = 2, 1, 0 these are the usual ones. Fractional orders add damping where α₂ < 2 and remove it
/// where α₂ > 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondOrder {
    /// K = b / c₀ (output unit per input unit, times (rad/s)^α₀).
    pub gain: f64,
    /// ω_n / 2π \[Hz\].
    pub natural_frequency_hz: f64,
    /// ζ, without unit; any sign (negative: usually unstable).
    pub damping: f64,
    /// Highest order α₂.
    pub alpha2: f64,
    /// Middle order α₁.
    pub alpha1: f64,
    /// Lowest order α₀, usually 0.
    pub alpha0: f64,
}

impl SecondOrder {
    /// The transfer function b / (s^α₂ + c₁ s^α₁ + c₀ s^α₀).
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] for a natural frequency that is not positive or a value that is not
    /// finite; what [`TransferFunction::validate`] refuses (orders not ascending).
    pub fn to_transfer_function(&self) -> Result<TransferFunction, DynamicsError> {
        let mut tf = TransferFunction {
            numerator: vec![Term::new(0.0, 0.0)],
            denominator: vec![Term::new(0.0, 0.0); 3],
        };
        self.write_to(&mut tf)?;
        Ok(tf)
    }

    /// [`SecondOrder::to_transfer_function`] into an existing one; allocates nothing if that has one
    /// numerator and three denominator terms.
    ///
    /// # Errors
    /// Those of [`SecondOrder::to_transfer_function`].
    pub fn write_to(&self, tf: &mut TransferFunction) -> Result<(), DynamicsError> {
        if !(self.natural_frequency_hz.is_finite() && self.natural_frequency_hz > 0.0) {
            let value = self.natural_frequency_hz;
            return Err(DynamicsError::Parameter {
                name: "natural_frequency_hz",
                value,
                allowed: "positive",
            });
        }
        let omega = TAU * self.natural_frequency_hz;
        let c0 = omega.powf(self.alpha2 - self.alpha0);
        let c1 = 2.0 * self.damping * omega.powf(self.alpha2 - self.alpha1);
        let lowest_first =
            [Term::new(c0, self.alpha0), Term::new(c1, self.alpha1), Term::new(1.0, self.alpha2)];
        tf.numerator.clear();
        tf.numerator.push(Term::new(self.gain * c0, 0.0));
        tf.denominator.clear();
        tf.denominator.extend(lowest_first);
        tf.validate()
    }
}

impl TransferFunction {
    /// Gain, natural frequency and damping of a transfer function of the form of article Eq. 13 (any leading
    /// coefficient; it is divided out).
    ///
    /// # Errors
    /// [`DynamicsError::NotSecondOrder`] for another form.
    pub fn second_order(&self) -> Result<SecondOrder, DynamicsError> {
        let refuse = || DynamicsError::NotSecondOrder { form: self.to_string() };
        let ([numerator], [c0, c1, c2]) = (self.numerator.as_slice(), self.denominator.as_slice()) else {
            return Err(refuse());
        };
        let stiffness = c0.coefficient / c2.coefficient;
        if numerator.order != 0.0 || !(stiffness.is_finite() && stiffness > 0.0) {
            return Err(refuse());
        }
        let omega = stiffness.powf(1.0 / (c2.order - c0.order));
        Ok(SecondOrder {
            gain: numerator.coefficient / c0.coefficient,
            natural_frequency_hz: omega / TAU,
            damping: c1.coefficient / c2.coefficient / (2.0 * omega.powf(c2.order - c1.order)),
            alpha2: c2.order,
            alpha1: c1.order,
            alpha0: c0.order,
        })
    }
}

impl fmt::Display for SecondOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { gain, natural_frequency_hz, damping, alpha2, alpha1, alpha0 } = self;
        write!(f, "gain {gain:.5}, natural frequency {natural_frequency_hz:.5} Hz, damping {damping:.5}, ")?;
        write!(f, "orders {alpha2:.5}, {alpha1:.5}, {alpha0:.5}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_orders_give_the_textbook_form() {
        let standard = SecondOrder {
            gain: 3.0,
            natural_frequency_hz: 50.0 / TAU,
            damping: 0.1,
            alpha2: 2.0,
            alpha1: 1.0,
            alpha0: 0.0,
        };
        let tf = standard.to_transfer_function().unwrap();
        let expected = [(2500.0, 0.0), (10.0, 1.0), (1.0, 2.0)];
        for (term, (coefficient, order)) in tf.denominator.iter().zip(expected) {
            assert!((term.coefficient / coefficient - 1.0).abs() < 1e-14 && term.order == order);
        }
        assert!((tf.numerator[0].coefficient / 7500.0 - 1.0).abs() < 1e-14);
    }

    #[test]
    fn both_ways_agree_on_the_article() {
        let eq13 = TransferFunction::article_eq13();
        let words = eq13.second_order().unwrap();
        assert!((words.gain - 5.2589 / 5.4955).abs() < 1e-15);
        // ω_n^α₂ = c₀ and 2ζ ω_n^(α₂ − α₁) = c₁ by definition.
        let omega = TAU * words.natural_frequency_hz;
        assert!((omega.powf(2.0384) / 5.4955e6 - 1.0).abs() < 1e-13);
        let back = words.to_transfer_function().unwrap();
        for (a, b) in back.denominator.iter().zip(&eq13.denominator) {
            assert!((a.coefficient / b.coefficient - 1.0).abs() < 1e-13);
        }
        assert!(
            TransferFunction::new(vec![Term::new(1.0, 1.0)], eq13.denominator)
                .unwrap()
                .second_order()
                .is_err()
        );
    }
}
