//! What is known before the next record, as independent directions of variance 1.

use nalgebra::DVector;

use crate::IdentifyError;
use crate::sensitivity::{directions, moved};
use hysteron_model::dynamics::{Dynamics, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::model_file::{ModelFile, number_mut};

/// Damping ratio of a resonance that is assumed.
const DAMPING: f64 = 0.05;
/// Standard deviations of the logarithms of its frequency and damping.
const RESONANCE_ERRORS: [f64; 2] = [0.3, 0.7];
/// Creep 1 + k s^−μ that is assumed: k, about the share that has crept after a second, and μ.
const CREEP: [f64; 2] = [0.01, 0.15];
/// Their standard deviations.
const CREEP_ERRORS: [f64; 2] = [0.01, 0.05];
/// Relative standard deviation of a number that the records do not determine.
const UNDETERMINED: f64 = 0.5;

/// Dynamics that the model does not have, assumed for a drive that is to show them: a factor of G(s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Assumed {
    /// Nothing.
    Nothing,
    /// A pair of poles of this frequency \[Hz\].
    Resonance { frequency_hz: f64 },
    /// Creep.
    Creep,
}

impl Assumed {
    fn directions(self) -> usize {
        if self == Self::Nothing { 0 } else { 2 }
    }

    /// Frequency \[Hz\] and damping of the pair of poles, `by` standard deviations off.
    fn pair(self, by: [f64; 2]) -> Option<(f64, f64)> {
        let Self::Resonance { frequency_hz } = self else { return None };
        let off = |i: usize| (by[i] * RESONANCE_ERRORS[i]).exp();
        Some((frequency_hz * off(0), DAMPING * off(1)))
    }

    /// Numerator and denominator of the factor, its numbers `by` standard deviations off.
    fn factor(self, by: [f64; 2]) -> Option<(Vec<Term>, Vec<Term>)> {
        let term = |coefficient, order| Term { coefficient, order };
        match self {
            Self::Nothing => None,
            Self::Resonance { .. } => {
                let (frequency_hz, damping) = self.pair(by)?;
                let omega = std::f64::consts::TAU * frequency_hz;
                let pair = vec![term(1.0, 0.0), term(2.0 * damping / omega, 1.0), term(omega.powi(-2), 2.0)];
                Some((vec![term(1.0, 0.0)], pair))
            }
            Self::Creep => {
                let [k, mu] = [0, 1].map(|i| CREEP[i] + by[i] * CREEP_ERRORS[i]);
                Some((vec![term(k, 0.0), term(1.0, mu)], vec![term(1.0, mu)]))
            }
        }
    }
}

/// A model and the directions in which it is uncertain.
#[derive(Clone, Debug)]
pub(super) struct Prior {
    model: Model,
    names: Vec<String>,
    directions: Vec<DVector<f64>>,
    assumed: Assumed,
}

impl Prior {
    /// Of a model file with the covariance of its numbers; the numbers `undetermined` by its records have
    /// half their value as their standard deviation.
    ///
    /// # Errors
    /// [`IdentifyError::NoCorrelation`], [`IdentifyError::ModelFile`].
    pub(super) fn new(file: &ModelFile, undetermined: &[(String, f64)]) -> Result<Self, IdentifyError> {
        let mut model = file.to_model()?;
        let (mut names, covariance) = file.covariance().ok_or(IdentifyError::NoCorrelation)?;
        let known = names.len();
        let mut along = directions(&covariance);
        let new: Vec<(String, f64)> = undetermined
            .iter()
            .filter(|(name, _)| !names.contains(name))
            .filter_map(|(name, least)| {
                let value = *number_mut(&mut model, name)?;
                Some((name.clone(), (UNDETERMINED * value.abs()).max(*least)))
            })
            .filter(|(_, deviation)| *deviation > 0.0)
            .collect();
        let all = known + new.len();
        along.iter_mut().for_each(|d| *d = d.clone().resize_vertically(all, 0.0));
        for (index, (name, deviation)) in new.into_iter().enumerate() {
            names.push(name);
            along.push(DVector::from_fn(all, |i, _| if i == known + index { deviation } else { 0.0 }));
        }
        Ok(Self { model, names, directions: along, assumed: Assumed::Nothing })
    }

    /// This prior with assumed dynamics.
    pub(super) fn assuming(self, assumed: Assumed) -> Self {
        Self { assumed, ..self }
    }

    /// Number of directions.
    pub(super) fn count(&self) -> usize {
        self.directions.len() + self.assumed.directions()
    }

    /// The nominal model.
    ///
    /// # Errors
    /// Those of [`Self::at`].
    pub(super) fn model(&self) -> Result<Model, IdentifyError> {
        self.with_assumed(self.model.clone(), [0.0; 2])
    }

    /// The model `step` standard deviations along direction `k`.
    ///
    /// # Errors
    /// [`IdentifyError::SampledDynamics`] where dynamics are assumed beside an ARX block.
    pub(super) fn at(&self, k: usize, step: f64) -> Result<Model, IdentifyError> {
        match self.directions.get(k) {
            Some(direction) => self.with_assumed(moved(&self.model, &self.names, direction, step), [0.0; 2]),
            None => self.with_assumed(self.model.clone(), self.assumed_at(k, step)),
        }
    }

    /// Frequency \[Hz\] and damping of the resonance that is assumed, `step` standard deviations along
    /// direction `k`; `None` where none is.
    pub(super) fn assumed_resonance(&self, k: usize, step: f64) -> Option<(f64, f64)> {
        self.assumed.pair(self.assumed_at(k, step))
    }

    fn assumed_at(&self, k: usize, step: f64) -> [f64; 2] {
        let mut by = [0.0; 2];
        if let Some(one) = k.checked_sub(self.directions.len()).and_then(|index| by.get_mut(index)) {
            *one = step;
        }
        by
    }

    fn with_assumed(&self, model: Model, by: [f64; 2]) -> Result<Model, IdentifyError> {
        let Some((numerator, denominator)) = self.assumed.factor(by) else { return Ok(model) };
        let g = match &model.dynamics {
            Dynamics::None => TransferFunction { numerator, denominator },
            Dynamics::Integer(g) | Dynamics::Fractional(g) => TransferFunction {
                numerator: product(&g.numerator, &numerator),
                denominator: product(&g.denominator, &denominator),
            },
            Dynamics::Arx(_) => return Err(IdentifyError::SampledDynamics),
        };
        let whole = g.is_integer_order();
        let dynamics = if whole { Dynamics::Integer(g) } else { Dynamics::Fractional(g) };
        Ok(Model { dynamics, ..model })
    }
}

/// Product of two polynomials in real powers of s, terms of equal order joined.
fn product(a: &[Term], b: &[Term]) -> Vec<Term> {
    let mut all: Vec<Term> = a
        .iter()
        .flat_map(|a| {
            b.iter().map(|b| Term { coefficient: a.coefficient * b.coefficient, order: a.order + b.order })
        })
        .collect();
    all.sort_by(|a, b| a.order.total_cmp(&b.order));
    all.dedup_by(|next, kept| {
        let same = (next.order - kept.order).abs() < 1e-9;
        if same {
            kept.coefficient += next.coefficient;
        }
        same
    });
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_of_polynomials_joins_terms_of_equal_order() {
        let term = |coefficient, order| Term { coefficient, order };
        // (1 + 2 s)(3 + s) = 3 + 7 s + 2 s².
        let found = product(&[term(1.0, 0.0), term(2.0, 1.0)], &[term(3.0, 0.0), term(1.0, 1.0)]);
        assert_eq!(found, [term(3.0, 0.0), term(7.0, 1.0), term(2.0, 2.0)]);
    }
}
