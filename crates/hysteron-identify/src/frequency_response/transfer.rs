//! A fitted structure as the transfer function that a model file holds.

use std::f64::consts::TAU;

use super::{Core, FrequencyResponse, ResponseFit};
use crate::IdentifyError;
use hysteron_model::dynamics::{Term, TransferFunction};
use hysteron_model::model_file::transfer_function_numbers;
use nalgebra::DMatrix;

/// Largest relative difference between the partial fractions and the expanded polynomials.
const AGREEMENT: f64 = 1e-6;

/// Step of the differences, in standard errors.
const STEP: f64 = 1e-3;

/// Coefficients and orders.
type Polynomial = Vec<(f64, f64)>;

impl ResponseFit {
    /// Transfer function and delay \[s\] of the fit, checked against it at the points of `response`.
    ///
    /// # Errors
    /// [`IdentifyError::NoTransferFunction`] for a loss angle, or where the polynomials of many poles are
    /// ill-conditioned.
    pub fn to_transfer_function(
        &self,
        response: &FrequencyResponse,
    ) -> Result<(TransferFunction, f64), IdentifyError> {
        let refuse = |problem: String| {
            let structure = self.structure.to_string();
            Err(IdentifyError::NoTransferFunction { structure, problem })
        };
        if self.structure.loss_angle {
            return refuse(
                "no causal linear system has a constant non-zero phase without a fall of the magnitude"
                    .to_owned(),
            );
        }
        let delay = self.value("delay");
        let tf = self.expand()?;
        let fitted = self.response_at(&response.frequency_hz);
        let expanded = tf.frequency_response(&response.frequency_hz, delay);
        let worst = fitted.iter().zip(&expanded).map(|(a, b)| (b / a - 1.0).norm()).fold(0.0, f64::max);
        if worst <= AGREEMENT {
            Ok((tf, delay))
        } else {
            refuse(format!(
                "its polynomials in s differ from the fit by {worst:.1e}; fit fewer poles or a narrower band"
            ))
        }
    }

    /// Covariance of the numbers of [`Self::to_transfer_function`] by linear propagation, with their names in
    /// a model file: coefficients and orders, and the delay.
    ///
    /// # Errors
    /// Those of [`TransferFunction::validate`].
    pub fn covariance_of_numbers(&self) -> Result<(Vec<String>, DMatrix<f64>), IdentifyError> {
        let numbers = |fit: &Self| -> Result<(Vec<String>, Vec<f64>), IdentifyError> {
            let (mut names, mut values) = transfer_function_numbers(&fit.expand()?);
            names.push("delay".to_owned());
            values.push(fit.value("delay"));
            Ok((names, values))
        };
        let (names, values) = numbers(self)?;
        let mut jacobian = DMatrix::zeros(values.len(), self.parameters.len());
        for j in 0..self.parameters.len() {
            let step = STEP * self.covariance[(j, j)].sqrt();
            if step > 0.0 {
                let at = |step: f64| {
                    let mut moved = self.clone();
                    moved.parameters[j].value += step;
                    numbers(&moved)
                };
                let (up, down) = (at(step)?.1, at(-step)?.1);
                for (i, (up, down)) in up.iter().zip(&down).enumerate() {
                    jacobian[(i, j)] = (up - down) / (2.0 * step);
                }
            }
        }
        Ok((names, &jacobian * &self.covariance * jacobian.transpose()))
    }

    fn expand(&self) -> Result<TransferFunction, IdentifyError> {
        let exponent = self.value("exponent");
        let (up, down) = ((-exponent).max(0.0), exponent.max(0.0));
        let gain = self.value("gain");
        let (numerator, denominator) = match self.structure.core {
            Core::Constant => (vec![(gain, 0.0)], vec![(1.0, 0.0)]),
            Core::FractionalLag => {
                let (omega, order) = (TAU * self.value("corner_frequency"), self.value("order"));
                let stiffness = omega.powf(order);
                (vec![(gain * stiffness, 0.0)], vec![(stiffness, 0.0), (1.0, order)])
            }
            Core::FractionalOscillator => {
                let omega = TAU * self.value("natural_frequency");
                let (one, two) = (self.value("order1"), self.value("order2"));
                let stiffness = omega.powf(two);
                let damping = 2.0 * self.value("damping") * omega.powf(two - one);
                (vec![(gain * stiffness, 0.0)], vec![(stiffness, 0.0), (damping, one), (1.0, two)])
            }
            Core::Rational { .. } | Core::Modes { .. } => self.polynomials(),
        };
        let terms = |list: Vec<(f64, f64)>, shift: f64| {
            let mut terms: Vec<Term> = list.iter().map(|&(c, order)| Term::new(c, order + shift)).collect();
            terms.sort_by(|a, b| a.order.total_cmp(&b.order));
            terms
        };
        Ok(TransferFunction::new(terms(numerator, up), terms(denominator, down))?)
    }

    /// Numerator and denominator over the product of all poles, monic.
    fn polynomials(&self) -> (Polynomial, Polynomial) {
        // Denominator and numerator of each section, coefficients ascending.
        let mut sections: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
        if let Some(pole) = self.parameter("pole_frequency") {
            let omega = TAU * pole.value;
            sections.push((vec![omega, 1.0], vec![omega * self.value("pole_gain")]));
        }
        for i in 1.. {
            let of = |what: &str| self.parameter(&format!("mode{i}_{what}")).map(|p| p.value);
            let (Some(f), Some(damping), Some(gain)) = (of("frequency"), of("damping"), of("gain")) else {
                break;
            };
            let slope = of("slope").unwrap_or(0.0);
            let omega = TAU * f;
            let denominator = vec![omega * omega, 2.0 * damping * omega, 1.0];
            sections.push((denominator, vec![omega * omega * gain, omega * slope]));
        }
        let product = |skip: Option<usize>| {
            let factors = sections.iter().enumerate().filter(|(i, _)| Some(*i) != skip);
            factors.fold(vec![1.0], |all, (_, (denominator, _))| multiply(&all, denominator))
        };
        let denominator = product(None);
        let mut numerator: Vec<f64> = denominator.iter().map(|c| c * self.value("direct")).collect();
        for (i, (_, own)) in sections.iter().enumerate() {
            for (sum, part) in numerator.iter_mut().zip(multiply(&product(Some(i)), own)) {
                *sum += part;
            }
        }
        let ascending =
            |list: Vec<f64>| list.into_iter().enumerate().map(|(i, c)| (c, i as f64)).collect::<Vec<_>>();
        if self.parameter("direct").is_none() {
            numerator.pop();
        }
        (ascending(numerator), ascending(denominator))
    }
}

fn multiply(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; a.len() + b.len() - 1];
    for (i, a) in a.iter().enumerate() {
        for (j, b) in b.iter().enumerate() {
            product[i + j] += a * b;
        }
    }
    product
}
