//! An output as a linear function of the states and of the input.

use super::relaxation_fit::Weights;
use super::resonant_poles::ResonantPole;
use hysteron_numeric::Complex64;

/// Weights of the states ξ of relaxations, x of resonances, and of the input.
#[derive(Clone, Debug, Default)]
pub(super) struct Readout {
    /// Of ξ at the rates of the fit.
    pub relaxations: Vec<f64>,
    /// Of x, the response of 1/(s − p), and of ∂x/∂p; the real part of the sum counts.
    pub resonances: Vec<(Complex64, Complex64)>,
    /// Of the input.
    pub input: f64,
    /// Of its slope.
    pub slope: f64,
    pub is_zero: bool,
}

impl Readout {
    /// The output.
    pub fn of_value(weights: Weights, poles: &[ResonantPole]) -> Self {
        Self::new(weights, poles, |pole| (2.0 * pole.residue, Complex64::ZERO))
    }

    /// Its derivative in parameter `which`.
    pub fn of_tangent(weights: Weights, poles: &[ResonantPole], which: usize) -> Self {
        Self::new(weights, poles, |pole| {
            let (place, residue) = pole.tangents[which];
            (2.0 * residue, 2.0 * pole.residue * place)
        })
    }

    /// `of`: factors of x and ∂x/∂p of a pole.
    fn new(
        weights: Weights,
        poles: &[ResonantPole],
        of: impl Fn(&ResonantPole) -> (Complex64, Complex64),
    ) -> Self {
        Self {
            relaxations: weights.relaxations,
            resonances: poles.iter().map(of).collect(),
            input: weights.direct,
            slope: 0.0,
            is_zero: false,
        }
    }

    /// Derivative in the delay of an output: less its rate, which follows from λ (u − ξ) and p x + u.
    pub fn delayed(&self, rates: &[f64], poles: &[Complex64]) -> Self {
        let relaxations: Vec<f64> =
            self.relaxations.iter().zip(rates).map(|(weight, rate)| weight * rate).collect();
        let residues: f64 = self.resonances.iter().map(|(residue, _)| residue.re).sum();
        let resonances = self.resonances.iter().zip(poles);
        Self {
            input: -relaxations.iter().sum::<f64>() - residues,
            slope: -self.input,
            resonances: resonances.map(|((residue, _), pole)| (-residue * pole, Complex64::ZERO)).collect(),
            relaxations,
            is_zero: false,
        }
    }
}
