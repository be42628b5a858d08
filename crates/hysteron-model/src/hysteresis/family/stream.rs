//! A model of any family, sample by sample.

use super::Hysteresis;
use super::operators::Mover;
use crate::hysteresis::{HysteresisError, polynomial};

/// A [`Hysteresis`] with its memory: voltage \[V\] in, v \[µm\] out, what
/// [`Hysteresis::simulate_every`] gives for a whole record.
#[derive(Clone, Debug)]
pub struct FamilyStream {
    mover: Box<dyn Mover>,
    polynomial: Vec<f64>,
    weights: Vec<f64>,
    row: Vec<f64>,
}

impl FamilyStream {
    /// The model, virgin at 0 V; `interval_s`: seconds between samples, for a rate-dependent family.
    ///
    /// # Errors
    /// Those of [`Hysteresis::validate`]; [`HysteresisError::Interval`].
    pub fn new(model: &Hysteresis, interval_s: Option<f64>) -> Result<Self, HysteresisError> {
        model.validate()?;
        let mover = model.form().mover(&model.shape(), interval_s, 0.0)?;
        let weights: Vec<f64> = model.weights().iter().map(|w| model.form().sign() * w).collect();
        let row = vec![0.0; weights.len()];
        Ok(Self { mover, polynomial: model.polynomial().to_vec(), weights, row })
    }

    /// Resets the model to virgin at `voltage`; returns v there.
    pub fn rest_at(&mut self, voltage: f64) -> f64 {
        self.mover.rest_at(voltage, &mut self.row);
        self.output(voltage)
    }

    /// Moves monotonically to `voltage`; returns v there.
    ///
    /// # Errors
    /// [`HysteresisError::Drive`] for a voltage that is not finite; [`HysteresisError::Overflow`]; as the
    /// family's own move.
    pub fn step(&mut self, voltage: f64) -> Result<f64, HysteresisError> {
        if !voltage.is_finite() {
            return Err(HysteresisError::Drive { index: 0 });
        }
        self.mover.step(voltage, &mut self.row)?;
        let v = self.output(voltage);
        if v.is_finite() { Ok(v) } else { Err(HysteresisError::Overflow { index: 0 }) }
    }

    fn output(&self, voltage: f64) -> f64 {
        let memory: f64 = self.weights.iter().zip(&self.row).map(|(w, h)| w * h).sum();
        polynomial::value(&self.polynomial, voltage) + memory
    }
}
