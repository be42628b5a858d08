//! A model of a family of columns.

use super::FamilyForm;
use crate::hysteresis::outputs::Columns;
use crate::hysteresis::{DriveGrid, HysteresisError, polynomial};
use crate::start::Start;

/// Static model v = Σ_{i≥1} polynomial\[i−1\] uⁱ + Σⱼ weightsⱼ Hⱼ\[u; shape\] \[µm\] of one [`FamilyForm`].
#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    /// Coefficients of u, u², … \[µm/V, µm/V², …\]; no constant term (the model's one offset is elsewhere).
    pub polynomial: Vec<f64>,
    /// The family.
    pub form: FamilyForm,
    /// Shape numbers, in the order and units of [`FamilyForm::shape_numbers`].
    pub shape: Vec<f64>,
    /// Weights of the columns, in the order and units of [`FamilyForm::weight_numbers`].
    pub weights: Vec<f64>,
}

impl Family {
    /// A checked model.
    ///
    /// # Errors
    /// Those of [`Self::validate`].
    pub fn new(
        polynomial: Vec<f64>,
        form: FamilyForm,
        shape: Vec<f64>,
        weights: Vec<f64>,
    ) -> Result<Self, HysteresisError> {
        let model = Self { polynomial, form, shape, weights };
        model.validate()?;
        Ok(model)
    }

    /// Checks that the polynomial is not empty, every number finite, the shape one of the family, and that
    /// there is one weight per column.
    ///
    /// # Errors
    /// The first [`HysteresisError`] found.
    pub fn validate(&self) -> Result<(), HysteresisError> {
        polynomial::check(&self.polynomial)?;
        self.form.check(&self.shape)?;
        let columns = self.form.columns();
        if self.weights.len() != columns {
            return Err(HysteresisError::WeightCount { columns, weights: self.weights.len() });
        }
        match self.weights.iter().position(|w| !w.is_finite()) {
            Some(index) => Err(HysteresisError::ColumnWeight { index, value: self.weights[index] }),
            None => Ok(()),
        }
    }

    /// v \[µm\] for the voltages `u` \[V\] given on a time base finer by a factor: `out[k]` belongs to `u[k *
    /// factor]`. The memory of a [`Start::Remembering`] is the voltage at which the device was virgin.
    ///
    /// # Errors
    /// Those of [`Self::validate`]; [`HysteresisError::Lengths`]; as [`FamilyForm::run`];
    /// [`HysteresisError::Overflow`] where v is not finite.
    pub fn simulate_every<'a>(
        &self,
        grid: impl Into<DriveGrid<'a>>,
        u: &[f64],
        start: Start<f64>,
        out: &mut [f64],
    ) -> Result<(), HysteresisError> {
        let grid = grid.into();
        let factor = grid.factor;
        self.validate()?;
        if factor == 0 {
            return Err(HysteresisError::Factor);
        }
        let expected = u.len().div_ceil(factor);
        if out.len() != expected {
            return Err(HysteresisError::Lengths { expected, found: out.len() });
        }
        for (slot, &u) in out.iter_mut().zip(u.iter().step_by(factor)) {
            *slot = polynomial::value(&self.polynomial, u);
        }
        self.form.add_weighted((&self.shape, &self.weights), grid, u, start, out)?;
        match out.iter().position(|v| !v.is_finite()) {
            Some(index) => Err(HysteresisError::Overflow { index: index * factor }),
            None => Ok(()),
        }
    }

    /// v \[µm\] at rest at the voltage `rest`, of a device that was virgin at `virgin` \[V\] and moved there
    /// monotonically; NaN where the family has no such state.
    pub fn at_rest(&self, virgin: f64, rest: f64) -> f64 {
        let mut columns = Columns::default();
        let start = Start::Rest { voltage_v: virgin };
        // The one move is without rate, whatever the time.
        let grid = DriveGrid::new(Some(1.0), 1, 1);
        match self.form.run(&self.shape, grid, &[rest], start, None, &mut columns) {
            Ok(()) => {
                let sum: f64 = columns
                    .values
                    .iter()
                    .zip(&self.weights)
                    .map(|(h, w)| w * h.first().copied().unwrap_or(0.0))
                    .sum();
                polynomial::value(&self.polynomial, rest) + sum
            }
            Err(_) => f64::NAN,
        }
    }
}
