//! A family of columns with its weights.

use super::super::{HysteresisError, polynomial};
use super::ColumnKernel;
use crate::start::Start;

/// Static model v = Σ_{i≥1} polynomial\[i−1\] uⁱ + Σⱼ weightsⱼ Hⱼ\[u; shape\] \[µm\] of one family of columns.
///
/// Every turning point of u must be a sample; then the result does not depend on the sample rate.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnModel<K> {
    /// Coefficients of u, u², … \[µm/V, µm/V², …\]; no constant term (the model's one offset is elsewhere).
    pub polynomial: Vec<f64>,
    /// The family and its structure.
    pub kernel: K,
    /// Its shape parameters θ, in the order and units that the family states.
    pub shape: Vec<f64>,
    /// Weights of the columns \[µm per unit of the column\], of any sign.
    pub weights: Vec<f64>,
}

impl<K: ColumnKernel> ColumnModel<K> {
    /// A checked model.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn new(
        polynomial: Vec<f64>,
        kernel: K,
        shape: Vec<f64>,
        weights: Vec<f64>,
    ) -> Result<Self, HysteresisError> {
        let model = Self { polynomial, kernel, shape, weights };
        model.validate()?;
        Ok(model)
    }

    /// Checks that the polynomial is not empty, every number finite, the shape one of the family, and that there is one
    /// weight a column.
    ///
    /// # Errors
    /// The first [`HysteresisError`] found.
    pub fn validate(&self) -> Result<(), HysteresisError> {
        polynomial::check(&self.polynomial)?;
        let expected = self.kernel.shape_names().len();
        if self.shape.len() != expected {
            return Err(HysteresisError::ShapeCount { expected, found: self.shape.len() });
        }
        self.kernel.check(&self.shape)?;
        if self.weights.len() != self.kernel.columns() {
            return Err(HysteresisError::WeightCount {
                columns: self.kernel.columns(),
                weights: self.weights.len(),
            });
        }
        match self.weights.iter().position(|w| !w.is_finite()) {
            Some(index) => Err(HysteresisError::ColumnWeight { index, value: self.weights[index] }),
            None => Ok(()),
        }
    }

    /// The polynomial l\[u\] = Σ polynomial\[i−1\] uⁱ \[µm\] at `u` \[V\].
    pub fn polynomial_at(&self, u: f64) -> f64 {
        polynomial::value(&self.polynomial, u)
    }

    /// v \[µm\] for the voltages `u` \[V\] into `out` (same length); returns the state at the last sample.
    ///
    /// # Errors
    /// As [`Self::validate`] and [`ColumnKernel::simulate_every`].
    pub fn simulate(
        &self,
        u: &[f64],
        start: Start<f64>,
        out: &mut [f64],
    ) -> Result<K::State<f64>, HysteresisError> {
        self.simulate_every(1, u, start, out)
    }

    /// As [`Self::simulate`] for a drive given on a time base finer by `factor`: `out[k]` belongs to `u[k * factor]`.
    ///
    /// # Errors
    /// As [`Self::simulate`].
    pub fn simulate_every(
        &self,
        factor: usize,
        u: &[f64],
        start: Start<f64>,
        out: &mut [f64],
    ) -> Result<K::State<f64>, HysteresisError> {
        self.validate()?;
        if factor == 0 {
            return Err(HysteresisError::Factor);
        }
        let expected = u.len().div_ceil(factor);
        if out.len() != expected {
            return Err(HysteresisError::Lengths { expected, found: out.len() });
        }
        let mut columns = vec![0.0; expected * self.weights.len()];
        let state = self.kernel.simulate_every(&self.shape, factor, u, start, &mut columns)?;
        for (slot, &u) in out.iter_mut().zip(u.iter().step_by(factor)) {
            *slot = self.polynomial_at(u);
        }
        for (column, weight) in columns.chunks(expected.max(1)).zip(&self.weights) {
            for (slot, value) in out.iter_mut().zip(column) {
                *slot += weight * value;
            }
        }
        match out.iter().position(|v| !v.is_finite()) {
            Some(index) => Err(HysteresisError::Overflow { index: index * factor }),
            None => Ok(state),
        }
    }
}
