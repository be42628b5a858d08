//! Disturbance between a model and the stage it drives, from a measured displacement.

use super::{Model, ModelError};
use crate::real::Real;
use crate::saved::{Tape, saves};

/// Model and measurement combined: displacement = model + disturbance, the disturbance (drift, load,
/// unmodelled creep) a random walk, the measurement noisy.
///
/// The steady Kalman filter of a random walk is one number,
///
/// d ← d + g (y − ŷ − d),  g = (√(q² + 4q) − q)/2,  q = (rms of the disturbance's change in one sample / rms
/// of the noise)²
///
/// (R. E. Kalman, *J. Basic Eng.* 82 (1960) 35–45, doi:10.1115/1.3662552). A measurement that is infinite or
/// not a number is ignored.
#[derive(Debug)]
pub struct Observer<'a, T> {
    model: Model<'a, T>,
    gain: T,
    disturbance: T,
}

/// Estimate of an [`Observer`] after a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observed<T> {
    /// Displacement of the stage.
    pub displacement: T,
    /// Its deviation from the model.
    pub disturbance: T,
}

impl<'a, T: Real> Observer<'a, T> {
    /// The observer with the gain 0 < g ≤ 1.
    ///
    /// # Errors
    /// [`ModelError::Coefficient`] for a gain outside.
    pub fn new(model: Model<'a, T>, gain: T) -> Result<Self, ModelError<T>> {
        if !(gain > T::of(0.0) && gain <= T::of(1.0)) {
            return Err(ModelError::Coefficient);
        }
        Ok(Self { model, gain, disturbance: T::of(0.0) })
    }

    /// The gain from the ratio of rms change of the disturbance in one sample to rms noise.
    pub fn gain_for(change_over_noise: T) -> T {
        let q = change_over_noise * change_over_noise;
        // As 2/(1 + √(1 + 4/q)), which does not cancel.
        T::of(2.0) / (T::of(1.0) + (T::of(1.0) + T::of(4.0) / q).sqrt())
    }

    /// Resets the model to steady state at `voltage`, reached from `virgin`; the disturbance is `measured`
    /// less its displacement.
    ///
    /// # Errors
    /// Those of [`Model::rest_after`]; [`ModelError::Start`].
    pub fn rest_after(&mut self, virgin: T, voltage: T, measured: T) -> Result<(), ModelError<T>> {
        if !measured.is_finite() {
            return Err(ModelError::Start { displacement: measured });
        }
        self.disturbance = measured - self.model.rest_after(virgin, voltage)?;
        Ok(())
    }

    /// Updates by the voltage of this period and the displacement `measured` at its end.
    ///
    /// # Errors
    /// Those of [`Model::step`]; the disturbance is then unchanged.
    #[inline]
    pub fn step(&mut self, voltage: T, measured: T) -> Result<Observed<T>, ModelError<T>> {
        let own = self.model.step(voltage)?;
        let left = measured - own - self.disturbance;
        if left.is_finite() {
            self.disturbance = self.disturbance + self.gain * left;
        }
        Ok(Observed { displacement: own + self.disturbance, disturbance: self.disturbance })
    }

    /// The estimate: displacement of the stage less that of the model.
    pub fn disturbance(&self) -> T {
        self.disturbance
    }

    /// Sets gain and offset of the model, from the next step on: [`Model::trim`].
    ///
    /// # Errors
    /// [`ModelError::Coefficient`]; both are then as they were.
    pub fn trim(&mut self, gain: T, offset: T) -> Result<(), ModelError<T>> {
        self.model.trim(gain, offset)
    }

    /// Everything that it remembers.
    pub(crate) fn each_member(&mut self, tape: &mut Tape<'_>) {
        self.model.each_member(tape);
        tape.number(&mut self.disturbance);
    }
}

saves!(Observer);
