//! A hysteresis operator: a polynomial and the operators of one family.

use super::number::{DriveSpan, Place, Search};
use super::{HysteresisForm, RuntimeOperator};
use crate::hysteresis::{DriveGrid, HysteresisError, polynomial};
use crate::start::Start;

/// A hysteresis operator, the static model v = Σ_{i≥1} polynomial\[i−1\] uⁱ + Σⱼ weightsⱼ s Hⱼ\[u; θ\] \[µm\]
/// of one [`HysteresisForm`].
#[derive(Clone, Debug, PartialEq)]
pub struct Hysteresis {
    polynomial: Vec<f64>,
    form: HysteresisForm,
    /// As a model file has them: θ itself for most families.
    own_shape: Vec<f64>,
    weights: Vec<f64>,
}

impl Hysteresis {
    /// A checked operator: the coefficients of u, u², … \[µm/V, µm/V², …\], no constant term (the model's one
    /// offset is elsewhere), shape numbers as a model file has them, and weights.
    ///
    /// # Errors
    /// Those of [`Self::validate`].
    pub fn new(
        polynomial: Vec<f64>,
        form: HysteresisForm,
        own_shape: Vec<f64>,
        weights: Vec<f64>,
    ) -> Result<Self, HysteresisError> {
        let model = Self::unchecked(polynomial, form, own_shape, weights);
        model.validate()?;
        Ok(model)
    }

    /// A polynomial without hysteresis: the first family with weights of 0.
    ///
    /// # Errors
    /// Those of [`Self::validate`].
    pub fn without_memory(polynomial: Vec<f64>) -> Result<Self, HysteresisError> {
        let form = HysteresisForm::default();
        let span = DriveSpan { is_straight: true, ..DriveSpan::UNIT };
        let numbers = form.shape_numbers(&span).into_iter().zip(form.example(&span));
        let held = numbers.map(|(number, example)| match number.search {
            Search::Held(value) | Search::HeldUnlessBounded(value, _) => value,
            _ => example,
        });
        Self::new(polynomial, form, held.collect(), vec![0.0; form.columns()])
    }

    /// [`Self::new`], to be checked when it is simulated.
    pub(crate) fn unchecked(
        polynomial: Vec<f64>,
        form: HysteresisForm,
        own_shape: Vec<f64>,
        weights: Vec<f64>,
    ) -> Self {
        Self { polynomial, form, own_shape, weights }
    }

    /// Checks that the polynomial is not empty, every number finite, the shape one of the family, and that
    /// there is one weight per column.
    ///
    /// # Errors
    /// The first [`HysteresisError`] found.
    pub fn validate(&self) -> Result<(), HysteresisError> {
        polynomial::check(&self.polynomial)?;
        self.form.check(&self.own_shape)?;
        let columns = self.form.columns();
        if self.weights.len() != columns {
            return Err(HysteresisError::WeightCount { columns, weights: self.weights.len() });
        }
        match self.weights.iter().position(|w| !w.is_finite()) {
            Some(index) => Err(HysteresisError::ColumnWeight { index, value: self.weights[index] }),
            None => Ok(()),
        }
    }

    /// The family of this operator.
    pub fn form(&self) -> HysteresisForm {
        self.form
    }

    /// Weights in the order of [`HysteresisForm::weight_names`].
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Shape numbers of the columns, in the order of [`HysteresisForm::shape_names`].
    pub fn shape(&self) -> Vec<f64> {
        self.form.family().column_shape(&self.own_shape, &self.weights)
    }

    /// Shape numbers as a model file has them.
    pub fn own_shape(&self) -> &[f64] {
        &self.own_shape
    }

    /// Coefficients of the polynomial l\[u\], from that of u on \[µm/V, µm/V², …\].
    pub fn polynomial(&self) -> &[f64] {
        &self.polynomial
    }

    /// Mutable coefficients of the polynomial l\[u\].
    pub fn polynomial_mut(&mut self) -> &mut Vec<f64> {
        &mut self.polynomial
    }

    /// The anhysteretic part l\[u\] \[µm\] at `u` \[V\].
    pub fn polynomial_at(&self, u: f64) -> f64 {
        polynomial::value(&self.polynomial, u)
    }

    /// Names and values of the numbers beside the polynomial, as a model file has them.
    pub fn numbers(&self) -> Vec<(String, f64)> {
        let value = |place| match place {
            Place::Shape(index) => self.own_shape.get(index),
            Place::Weight(index) => self.weights.get(index),
        };
        let numbers = self.form.model_numbers().into_iter();
        numbers.filter_map(|number| Some((number.name, *value(number.place)?))).collect()
    }

    /// The number of this name beside the polynomial.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.numbers().into_iter().find(|(own, _)| own == name).map(|(_, value)| value)
    }

    /// Its exponent n; 1 for a family without one.
    pub fn exponent(&self) -> f64 {
        let has_exponent = self.form.description().has_exponent();
        self.number("n").filter(|_| has_exponent).unwrap_or(1.0)
    }

    /// The number of this name beside the polynomial.
    pub fn number_mut(&mut self, name: &str) -> Option<&mut f64> {
        match self.form.model_numbers().into_iter().find(|number| number.name == name)?.place {
            Place::Shape(index) => self.own_shape.get_mut(index),
            Place::Weight(index) => self.weights.get_mut(index),
        }
    }

    /// Output v \[µm\] for the voltages `u` \[V\] into `out` (same length). Moves between samples are
    /// monotone ([`crate::record::InterSample::Linear`] and [`crate::record::InterSample::Hold`] alike). The
    /// memory of a [`Start::Remembering`] is in the operator's own scale ([`crate::Memory`]).
    ///
    /// # Errors
    /// Those of [`Self::simulate_every`].
    pub fn simulate(&self, u: &[f64], start: Start<f64>, out: &mut [f64]) -> Result<(), HysteresisError> {
        self.simulate_every(1, u, start, out)
    }

    /// [`Self::simulate`] for a drive `u` given on a time base finer by a factor
    /// ([`crate::record::InterSample::upsample`]): `out[k]` belongs to `u[k * factor]`. A rate-dependent
    /// operator takes the rate from the grid.
    ///
    /// # Errors
    /// Those of [`Self::validate`]; [`HysteresisError::Lengths`]; as [`HysteresisForm::run`];
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
            *slot = self.polynomial_at(u);
        }
        let interval_s = self.form.interval_of(grid)?;
        self.form.family().add_hysteresis(self, interval_s, grid, u, start, out)?;
        match out.iter().position(|v| !v.is_finite()) {
            Some(index) => Err(HysteresisError::Overflow { index: index * factor }),
            None => Ok(()),
        }
    }

    /// Output \[µm\] of an operator at rest at the voltage `rest` \[V\] with a memory (see
    /// [`Start::Remembering`]), `None` where it is virgin there; NaN where the family has no such state.
    pub fn at_rest(&self, rest: f64, memory: Option<f64>) -> f64 {
        self.form.family().at_rest(self, rest, memory)
    }

    /// Memory of an operator, in its own scale, that was virgin at the voltage `virgin` \[V\] and moved
    /// monotonically to `rest`.
    ///
    /// # Errors
    /// As [`Self::validate`]; voltages that are not finite.
    pub fn memory_of_move(&self, virgin: f64, rest: f64) -> Result<f64, HysteresisError> {
        self.form.family().memory_of_move(self, virgin, rest)
    }

    /// Polynomial and operator of the runtime at this sample rate.
    pub fn runtime(&self, sample_rate_hz: f64) -> (Vec<f64>, RuntimeOperator) {
        let mut polynomial = self.polynomial.clone();
        let (family, elements) = (self.form.description(), self.form.elements());
        let operator =
            family.runtime(elements, &mut polynomial, &self.own_shape, &self.weights, sample_rate_hz);
        (polynomial, operator)
    }

    /// The operator whose output is `gain` times that of this one.
    ///
    /// # Errors
    /// Those of [`Self::validate`].
    pub fn scaled(&self, gain: f64) -> Result<Self, HysteresisError> {
        let times_gain = |numbers: &[f64]| numbers.iter().map(|c| gain * c).collect();
        let shape = self.form.description().scaled_shape(&self.own_shape, gain);
        Self::new(times_gain(&self.polynomial), self.form, shape, times_gain(&self.weights))
    }
}
