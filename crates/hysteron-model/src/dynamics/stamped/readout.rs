//! An output as a linear function of the states and of the input.

use super::relaxation_fit::Weights;
use super::resonant_poles::ResonantPole;
use hysteron_numeric::{BankWeights, Complex64};

/// Weights of the states ξ of relaxations, x of resonances, and of the input.
#[derive(Clone, Debug, Default)]
pub(super) struct Readout {
    /// Of ξ at the rates of the fit.
    pub relaxations: Vec<f64>,
    /// Of ξ and ∂ξ/∂λ at the rates λ of real poles: 1/(s − p) = (1/λ) λ/(s + λ).
    pub own: Vec<(f64, f64)>,
    /// Of x, the response of 1/(s − p), and of ∂x/∂p; the real part of the sum counts.
    pub resonances: Vec<(Complex64, Complex64)>,
    /// Of the input.
    pub input: f64,
    /// Of its slope.
    pub slope: f64,
    pub is_zero: bool,
}

fn is_real(pole: &ResonantPole) -> bool {
    pole.place.im == 0.0 && pole.place.re < 0.0
}

/// Rates of the real poles, and the other poles.
pub(super) fn places(poles: &[ResonantPole]) -> (Vec<f64>, Vec<Complex64>) {
    let real = poles.iter().filter(|pole| is_real(pole)).map(|pole| -pole.place.re);
    let others = poles.iter().filter(|pole| !is_real(pole)).map(|pole| pole.place);
    (real.collect(), others.collect())
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
        // x = ξ/λ and ∂x/∂p = −∂x/∂λ = ξ/λ² − (∂ξ/∂λ)/λ.
        let own = |pole: &ResonantPole| {
            let (time, (of_x, of_moved)) = (-1.0 / pole.place.re, of(pole));
            (time * (of_x.re + time * of_moved.re), -time * of_moved.re)
        };
        Self {
            relaxations: weights.relaxations,
            own: poles.iter().filter(|pole| is_real(pole)).map(own).collect(),
            resonances: poles.iter().filter(|pole| !is_real(pole)).map(of).collect(),
            input: weights.direct,
            slope: 0.0,
            is_zero: false,
        }
    }

    /// Derivative in the delay of an output: less its rate, which follows from λ (u − ξ) and p x + u.
    pub fn delayed(&self, rates: &[f64], own_rates: &[f64], poles: &[Complex64]) -> Self {
        let times = |weights: &[f64], rates: &[f64]| -> Vec<f64> {
            weights.iter().zip(rates).map(|(weight, rate)| weight * rate).collect()
        };
        let relaxations = times(&self.relaxations, rates);
        let own: Vec<(f64, f64)> =
            self.own.iter().zip(own_rates).map(|((weight, _), rate)| (weight * rate, 0.0)).collect();
        let residues: f64 = self.resonances.iter().map(|(residue, _)| residue.re).sum();
        let moving = relaxations.iter().chain(own.iter().map(|(weight, _)| weight)).sum::<f64>();
        let resonances = self.resonances.iter().zip(poles);
        Self {
            input: -moving - residues,
            slope: -self.input,
            resonances: resonances.map(|((residue, _), pole)| (-residue * pole, Complex64::ZERO)).collect(),
            relaxations,
            own,
            is_zero: false,
        }
    }

    /// The weights as the banks of relaxations take them, at the rates of the fit and at those of real poles.
    pub fn weigh(&self, fitted: &mut BankWeights, own: &mut BankWeights) {
        fitted.set(self.relaxations.iter().copied(), std::iter::empty());
        own.set(self.own.iter().map(|(weight, _)| *weight), self.own.iter().map(|(_, moved)| *moved));
    }
}
