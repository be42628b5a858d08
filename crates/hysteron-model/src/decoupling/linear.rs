//! Linear part of scheduled modes at one level, from held sample to held sample.

use nalgebra::DMatrix;

use super::DecouplingError;
use crate::axes::{ScheduledModes, linear_states};
use hysteron_numeric::Complex64;

/// Largest condition number of the gains at rest.
const WORST_CONDITION: f64 = 1e9;

/// x⁺ = A x + B u + H w, y = C x + D u + D_h w, a step a sample; A as its poles (see [`ScheduledModes`]).
#[derive(Clone, Debug)]
pub(super) struct LinearAxes {
    pub inputs: usize,
    pub outputs: usize,
    modes: usize,
    transition: Vec<f64>,
    /// States × inputs.
    pub input: DMatrix<f64>,
    pub strain_input: DMatrix<f64>,
    /// Outputs × states.
    pub output: DMatrix<f64>,
    pub feedthrough: DMatrix<f64>,
    pub strain_feedthrough: DMatrix<f64>,
}

impl LinearAxes {
    /// At S. The steps of a sample are composed: p → p^j, b → (1 + p + … + p^(j−1)) b.
    pub fn of(model: &ScheduledModes, s: f64) -> Self {
        let (at, n, m, states) = (model.at(s), model.inputs, model.outputs, model.states());
        let mut transition = vec![0.0; states];
        let mut input = DMatrix::from_row_slice(states, n, &model.input);
        let mut strain_input = DMatrix::from_row_slice(states, n, &model.strain_input);
        let composed = |p: Complex64| {
            let mut power = Complex64::ONE;
            let mut sum = Complex64::ZERO;
            for _ in 0..model.steps {
                sum += power;
                power *= p;
            }
            (power, sum)
        };
        for k in 0..model.modes {
            let (power, sum) = composed(Complex64::new(at.transition[2 * k], at.transition[2 * k + 1]));
            (transition[2 * k], transition[2 * k + 1]) = (power.re, power.im);
            for matrix in [&mut input, &mut strain_input] {
                for i in 0..n {
                    let b = Complex64::new(matrix[(2 * k, i)], matrix[(2 * k + 1, i)]) * sum;
                    (matrix[(2 * k, i)], matrix[(2 * k + 1, i)]) = (b.re, b.im);
                }
            }
        }
        for (k, pole) in transition.iter_mut().enumerate().skip(2 * model.modes) {
            let (power, sum) = composed(Complex64::new(at.transition[k], 0.0));
            *pole = power.re;
            for matrix in [&mut input, &mut strain_input] {
                matrix.row_mut(k).scale_mut(sum.re);
            }
        }
        Self {
            inputs: n,
            outputs: m,
            modes: model.modes,
            transition,
            input,
            strain_input,
            output: DMatrix::from_row_slice(m, states, &at.output),
            feedthrough: DMatrix::from_row_slice(m, n, &at.feedthrough),
            strain_feedthrough: DMatrix::from_row_slice(m, n, &model.strain_feedthrough),
        }
    }

    /// A.
    pub fn matrix(&self) -> DMatrix<f64> {
        let states = self.transition.len();
        let mut a = DMatrix::zeros(states, states);
        for k in 0..self.modes {
            let (re, im) = (self.transition[2 * k], self.transition[2 * k + 1]);
            (a[(2 * k, 2 * k)], a[(2 * k + 1, 2 * k + 1)]) = (re, re);
            (a[(2 * k, 2 * k + 1)], a[(2 * k + 1, 2 * k)]) = (-im, im);
        }
        for k in 2 * self.modes..states {
            a[(k, k)] = self.transition[k];
        }
        a
    }

    /// P at z, outputs × inputs, row by row.
    pub fn transfer(&self, z: Complex64) -> Vec<Complex64> {
        let mut response: Vec<Complex64> =
            self.feedthrough.transpose().iter().map(|d| Complex64::new(*d, 0.0)).collect();
        for n in 0..self.inputs {
            let x =
                linear_states(&self.transition, self.modes, z, |k| Complex64::new(self.input[(k, n)], 0.0));
            for m in 0..self.outputs {
                let row = self.output.row(m);
                response[m * self.inputs + n] += row.iter().zip(&x).map(|(c, x)| x * *c).sum::<Complex64>();
            }
        }
        response
    }

    /// Gains at rest, outputs × inputs \[µm/V\].
    pub fn gain(&self) -> DMatrix<f64> {
        let values: Vec<f64> = self.transfer(Complex64::ONE).iter().map(|p| p.re).collect();
        DMatrix::from_row_slice(self.outputs, self.inputs, &values)
    }
}

/// Inputs × outputs: the minimum-norm inputs for a unit of each output.
///
/// # Errors
/// [`DecouplingError::Singular`].
pub(super) fn right_inverse(gain: &DMatrix<f64>) -> Result<DMatrix<f64>, DecouplingError> {
    let values = gain.singular_values();
    let condition = values.max() / values.min();
    if condition.is_nan() || condition > WORST_CONDITION {
        return Err(DecouplingError::Singular { condition });
    }
    gain.clone().pseudo_inverse(0.0).map_err(|_| DecouplingError::Singular { condition })
}
